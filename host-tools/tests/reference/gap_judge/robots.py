"""Two robots: what is inside them, and what their robot.toml tells gmr.

`servo`  a TurtleBot3 with XL430-like servos: high gear, little power, 12 V.
`brisk`  a 9 kg base with two gear motors of ratio 27: fast, 5 to 20 W, total power with 6 W of electronics.
"""

from typing import NamedTuple


class Robot(NamedTuple):
    radius: float  # wheel, m
    track: float  # m
    gyration: float  # m
    empty: float  # kg
    full: float  # kg
    v_max: float  # m/s
    a_max: float  # m/s²
    yaw_max: float  # rad/s
    yaw_acc: float  # rad/s²
    resistance: float  # winding, Ω
    inductance: float  # H
    kt: float  # N·m/A = V·s/rad
    rotor: float  # kg·m²
    coulomb: float  # at the rotor, N·m
    viscous: float  # at the rotor, N·m·s/rad
    gear: float  # ratio
    loss_drive: float  # share of the transmitted torque that the gear takes when the motor drives
    loss_back: float  # the same when the wheel drives the motor
    wheel_inertia: float  # kg·m²
    rolling: float  # coefficient of rolling resistance
    volts: float  # supply, V
    bandwidth: float  # of the speed controller, rad/s
    static: float  # W, in the logs
    noise: float  # standard deviation of the power sensor, W


ROBOTS = {
    "servo": Robot(
        radius=0.033, track=0.160, gyration=0.064, empty=1.0, full=6.0,
        v_max=0.22, a_max=0.8, yaw_max=2.0, yaw_acc=8.0,
        resistance=8.0, inductance=1.2e-3, kt=7.2e-3, rotor=1.1e-7, coulomb=2.2e-4, viscous=1.6e-7,
        gear=258.5, loss_drive=0.42, loss_back=0.45, wheel_inertia=1.5e-5, rolling=0.030,
        volts=12.0, bandwidth=25.0, static=0.0, noise=0.06,
    ),
    "brisk": Robot(
        radius=0.060, track=0.34, gyration=0.13, empty=9.0, full=21.0,
        v_max=1.0, a_max=0.9, yaw_max=2.4, yaw_acc=5.0,
        resistance=1.4, inductance=0.8e-3, kt=0.019, rotor=9e-6, coulomb=2.4e-3, viscous=3.0e-6,
        gear=27.0, loss_drive=0.28, loss_back=0.25, wheel_inertia=4e-4, rolling=0.018,
        volts=18.0, bandwidth=30.0, static=6.0, noise=0.45,
    ),
}

BRISK_TOML = """name = "judge's brisk robot"
kinematics = "differential"
wheel_radius_m = 0.060
track_m = 0.34
gyration_radius_m = 0.13
mass_no_load_kg = 9.0
mass_full_load_kg = 21.0
static_power_w = 6.0
mape_floor_w = 0.5
regeneration = false
"""
