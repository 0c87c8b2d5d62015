"""The robot's physics: currents, torques, friction with sticking, gears that lose more one way than the other.

One run is integrated at 2 kHz. Every effect acts here as a cause; its neutral value does nothing. NumPy is enough; with
numba the loop takes hundredths of a second instead of seconds.
"""

from typing import NamedTuple

import numpy as np

from drives import STEP

try:
    from numba import njit
except ImportError:  # slow, but the same figures

    def njit(**_):
        return lambda function: function


GRAVITY = 9.81
COPPER = 0.0039  # 1/K


class World(NamedTuple):
    """Causes that stay as they are during a run."""

    slope: float = 0.0  # rad
    slope_heading: float = 0.0  # rad, direction of the ascent
    slope_ahead: float = 0.0  # rad, always uphill along the nose (a ramp driven one way)
    hot: float = 0.0  # K above the cold winding at the start
    heat_resistance: float = 0.0  # K/W
    heat_time: float = 60.0  # s
    fan: float = 0.0  # N·m·s² at the rotor
    stribeck: float = 0.0  # N·m at the wheel
    stribeck_speed: float = 1.0  # rad/s
    viscous_factor: float = 1.0
    cold_grease: float = 0.0  # N·m·s at the rotor, more at the start
    warm_time: float = 30.0  # s
    load_left: float = 0.0  # share of the weight moved to the left
    drag_left: float = 0.0  # N·m at the wheel
    drag_right: float = 0.0
    scrub: float = 0.0  # N·m against yaw
    scrub_per_kg: float = 0.0
    gear_growth: float = 0.0  # further share of loss per N·m transmitted
    returned: float = 0.0  # share of braking power that comes back
    scale_left: float = 1.0  # encoder reads true speed times this
    scale_right: float = 1.0
    root_loss: float = 0.0  # N·m (rad/s)^-1/2 at the wheel
    eccentric: float = 0.0  # N·m at the wheel, over a turn
    caster: float = 0.0  # N, until the caster has swivelled
    caster_way: float = 0.1  # m
    switching: float = 0.0  # V, lost in the bridge at every ampere
    rough: float = 0.0  # N·m per m/s: rolling loss of soft ground that grows with speed and load


@njit(cache=True)
def integrate(robot, world, mass, wheels, rolling, extra, pull, wind):
    """Power (W, the drives'), wheel angles (rad), winding temperatures (K over cold) at every step.

    rolling: coefficient at every step; extra: Coulomb torque added at every step, N·m; pull: torque at every step and wheel;
    wind: force at every step in the world's x and y, N.
    """
    count = wheels.shape[0]
    power = np.zeros(count)
    angles = np.zeros((count, 2))
    hot = np.zeros((count, 2))
    r, gear, kt = robot.radius, robot.gear, robot.kt
    turn = r / robot.track
    own = robot.rotor * gear * gear + robot.wheel_inertia
    sum_part = mass * r * r / 4.0
    yaw_inertia = mass * robot.gyration ** 2
    yaw_part = yaw_inertia * turn * turn
    on, off = own + sum_part + yaw_part, sum_part - yaw_part
    determinant = on * on - off * off
    inv_on, inv_off = on / determinant, -off / determinant
    gain = robot.bandwidth * (on + abs(off)) * robot.resistance / (gear * kt)
    reset = robot.bandwidth / 4.0
    keep = np.exp(-STEP * robot.resistance / robot.inductance)
    speed, current, integral = np.zeros(2), np.zeros(2), np.zeros(2)
    theta, temperature, acceleration = np.zeros(2), np.array([world.hot, world.hot]), np.zeros(2)
    sent, friction, free, bound, drive = np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2)
    rolled = np.zeros(2)
    heading, way, direction = 0.0, 1.0, 0.0
    share = np.array([0.5 + world.load_left, 0.5 - world.load_left])
    drag = np.array([world.drag_left, world.drag_right])
    scale = np.array([world.scale_left, world.scale_right])
    for k in range(count):
        time = k * STEP
        v = r * (speed[0] + speed[1]) / 2.0
        yaw = turn * (speed[1] - speed[0])
        heading += yaw * STEP
        # Forces on the body along its nose, moment about its vertical axis.
        climb = world.slope * np.cos(heading - world.slope_heading) + world.slope_ahead
        force = -mass * GRAVITY * np.sin(climb) + wind[k, 0] * np.cos(heading) + wind[k, 1] * np.sin(heading)
        if world.caster > 0.0:
            if abs(v) > 0.01 * r:
                if direction * v < 0.0:
                    way = 0.0
                direction = np.sign(v)
            way += abs(v) * STEP
            force -= world.caster * np.exp(-way / world.caster_way) * np.tanh(v / (0.02 * r))
        moment = -(world.scrub + world.scrub_per_kg * mass) * np.tanh(yaw / 0.03)
        grease = robot.viscous * world.viscous_factor + world.cold_grease * np.exp(-time / world.warm_time)
        total = 0.0
        for i in range(2):
            wish = wheels[k, i]
            error = wish - speed[i] * scale[i]
            integral[i] += reset * error * STEP
            if wish == 0.0:
                integral[i] -= integral[i] * STEP / 0.2
            resistance = robot.resistance * (1.0 + COPPER * temperature[i])
            rotor = gear * speed[i]
            volts = kt * gear * wish + gain * (error + integral[i])
            if wish == 0.0 and abs(speed[i]) < 0.02:
                volts = 0.0
            volts = min(max(volts, -robot.volts), robot.volts)
            settled = (volts - kt * rotor) / resistance
            current[i] = settled + (current[i] - settled) * keep
            heat = current[i] * current[i] * resistance
            temperature[i] += STEP * (heat * world.heat_resistance + world.hot - temperature[i]) / world.heat_time
            electric = volts * current[i] + world.switching * abs(current[i])
            total += electric if electric > 0.0 else world.returned * electric
            # At the wheel.
            side = -1.0 if i == 0 else 1.0
            drive[i] = gear * (kt * current[i] - grease * rotor - world.fan * rotor * abs(rotor))
            outer = force * r / 2.0 + side * moment * turn + pull[k, i] - world.eccentric * np.sin(theta[i]) * np.tanh(speed[i] / 0.05)
            outer -= world.root_loss * np.sign(speed[i]) * np.sqrt(abs(speed[i]))
            outer -= world.rough * mass * speed[i] * r * r
            drive[i] += outer
            lost = robot.loss_drive if sent[i] * speed[i] >= 0.0 else robot.loss_back
            lost += world.gear_growth * abs(sent[i]) * (1.0 if sent[i] * speed[i] >= 0.0 else 0.5)
            rolled[i] = rolling[k] * mass * GRAVITY * share[i] * r + drag[i] + extra[k]
            bound[i] = gear * robot.coulomb + min(lost, 0.9) * abs(sent[i]) + rolled[i]
            bound[i] += world.stribeck * np.exp(-((speed[i] / world.stribeck_speed) ** 2))
            friction[i] = 0.0
        for i in range(2):
            free[i] = speed[i] + STEP * (inv_on * drive[i] + inv_off * drive[1 - i])
        # Friction takes what it can without turning the wheel round: a few sweeps for both wheels.
        for _ in range(3):
            for i in range(2):
                wanted = (free[i] / STEP - inv_off * friction[1 - i]) / inv_on
                friction[i] = min(max(wanted, -bound[i]), bound[i])
        for i in range(2):
            new = free[i] - STEP * (inv_on * friction[i] + inv_off * friction[1 - i])
            acceleration[i] = (new - speed[i]) / STEP
            speed[i] = new
            theta[i] += new * STEP
            angles[k, i] = theta[i]
            hot[k, i] = temperature[i]
        for i in range(2):
            part = friction[i] / bound[i] if bound[i] > 0.0 else 0.0
            side = -1.0 if i == 0 else 1.0
            load = (on - robot.rotor * gear * gear) * acceleration[i] + off * acceleration[1 - i]
            load += rolled[i] * part - force * r / 2.0 - side * moment * turn - pull[k, i]
            sent[i] += (load - sent[i]) * 0.2
        power[k] = total
    return power, angles, hot
