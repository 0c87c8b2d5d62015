"""The drive that the baselines learn from, and its power: motors simulated forward from torque to current to voltage.

A Burger on slow tones, forwards and backwards, in four runs of half a minute with a payload each; and the same wheel speeds
under a skid steer.
"""

import numpy as np

G = 9.80665
PERIOD_S, RUNS, ROWS = 0.25, 4, 120
MASSES_KG = [1.0, 3.0, 5.0, 2.0]
# The first three runs train, the last is predicted.
TRAINING = 3 * ROWS
# The built-in robot `burger`.
RADIUS, TRACK, GYRATION = 0.033, 0.160, 0.064
# The built-in robot `husky`: effective track.
SKID_RADIUS, SKID_TRACK, SKID_GYRATION = 0.165, 1.07, 0.21
# Of road_w, level_w, physics_w and skid_w.
NOISE_W = [0.02, 0.001, 0.02, 0.1]

COLUMNS = ["time_s", "run", "wl", "wr", "al", "ar", "pitch_rad", "mass_kg", "cmd_v", "cmd_omega", "road_w", "level_w",
           "physics_w", "skid_w"]


def body(left, right, radius, track):
    """v and omega of the body, by the definition of rolling."""
    return radius * (left + right) / 2, radius * (right - left) / track


def inertial(al, ar, radius, track, gyration):
    """K: torque of the left and the right wheel per kilogram, by Lagrange from the kinetic energy ½ m (v² + k² omega²)."""
    dv, domega = body(al, ar, radius, track)
    forward, turning = radius / 2 * dv, gyration**2 * radius / track * domega
    return forward - turning, forward + turning


def motor(torque, speed, resistance, constant):
    """V i of a DC motor whose braking power is lost; `constant` is that of torque and of back EMF behind the gear."""
    current = torque / constant
    voltage = resistance * current + constant * speed
    return np.maximum(voltage * current, 0.0)


# Coulomb, rolling and viscous friction, and resistance and constant of the motors: for a road, where weight brakes the
# wheels, and with so little friction for level ground that inertia does.
ROUGH = (0.02, 0.006, 2e-3, 2.0, 0.6)
SMOOTH = (0.002, 0.0005, 2e-4, 2.0, 0.1)
ROTOR, LOAD = 8e-4, 1.3


def burger(w, a, pitch, mass, robot):
    """Electrical power of both motors, against inertia, friction, and weight on the slope."""
    coulomb, rolling, viscous, resistance, constant = robot
    power = 0.0
    for speed, acceleration, k in zip(w, a, inertial(*a, RADIUS, TRACK, GYRATION)):
        friction = (coulomb + rolling * mass) * np.sign(speed) + viscous * speed
        torque = friction + ROTOR * acceleration + LOAD * mass * k + mass * G * np.sin(pitch) * RADIUS / 2
        power = power + motor(torque, speed, resistance, constant)
    return power


def outside(w, a, radius, track, gyration, mass, inertia, traction, pitch, scrub):
    """Kinetic energy where it grows, resistance and weight, and the heat of windings whose currents follow friction, inertia
    and scrub."""
    (v, omega), (dv, domega) = body(*w, radius, track), body(*a, radius, track)
    power = np.maximum(mass * v * dv, 0) + np.maximum(inertia * omega * domega, 0) + mass * G * v * np.sin(pitch)
    for speed, k, side in zip(w, inertial(*a, radius, track, gyration), (-1, 1)):
        drag = scrub * side * np.sign(omega)
        current = 0.3 * np.sign(speed) + 6.0 * k
        power = power + traction * np.abs(speed) + 0.02 * speed**2 + drag * speed + 1.5 * current**2
        power = power + 0.8 * (scrub * omega != 0)
    return power


def tones(t, run, tones_):
    value = sum(size * np.sin(rate * t + phase + 1.7 * run) for size, rate, phase in tones_)
    slope = sum(size * rate * np.cos(rate * t + phase + 1.7 * run) for size, rate, phase in tones_)
    return value, slope


def make():
    """The log's columns, as they are written: what learns from them sees the same digits."""
    rng = np.random.default_rng(5)
    parts = []
    for run, mass in enumerate(MASSES_KG):
        t = PERIOD_S * np.arange(ROWS)
        left, al = tones(t, run, [(2.6, 0.61, 0.0), (1.6, 1.43, 0.4), (0.8, 2.9, 0.9)])
        right, ar = tones(t, run, [(2.4, 0.53, 0.5), (1.5, 1.21, 1.1), (0.9, 2.3, 2.0)])
        if run == 1:
            # Straight on for a while, or heat of friction and of scrub were one constant.
            right[ROWS // 2 :], ar[ROWS // 2 :] = left[ROWS // 2 :], al[ROWS // 2 :]
        pitch = 0.12 * np.sin(0.37 * t + run)
        w, a = (left, right), (al, ar)
        v, omega = body(left, right, RADIUS, TRACK)
        powers = [
            burger(w, a, pitch, mass, ROUGH),
            burger(w, a, 0 * pitch, mass, SMOOTH),
            outside(w, a, RADIUS, TRACK, GYRATION, 8.0, 0.1, 0.06, 0 * pitch, 0.0),
            outside(w, a, SKID_RADIUS, SKID_TRACK, SKID_GYRATION, 40.0, 8.0, 1.5, pitch, 2.0),
        ]
        noise = rng.normal(0, NOISE_W, (ROWS, 4)).T
        command = [v + 0.01 * np.sin(1.9 * t), omega + 0.15 * np.sin(2.7 * t + 1)]
        parts.append([t, 0 * t + run, *w, *a, pitch, 0 * t + mass, *command, *(np.array(powers) + noise)])
    rows = np.concatenate([np.array(part).T for part in parts])
    return np.round(rows, 6)
