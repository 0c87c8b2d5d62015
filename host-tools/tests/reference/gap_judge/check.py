"""Checks of the judge itself, by hand calculation:  python check.py"""

import numpy as np

import sets
from drives import STEP
from effects import ALL
from plant import World, integrate
from robots import ROBOTS
from sensors import noise


def steady(robot, mass, w, world=World(), rolling=None):
    """Power after some seconds of straight driving at w rad/s."""
    count = int(6.0 / STEP)
    ramp = np.minimum(np.arange(count) * STEP * w, w)
    zero = np.zeros(count)
    power, angles, _ = integrate(robot, world, mass, np.stack([ramp, ramp], axis=1),
                                 zero + (robot.rolling if rolling is None else rolling), zero, np.zeros((count, 2)), np.zeros((count, 2)))
    return power[-100:].mean(), (angles[-1] - angles[-101]) / (100 * STEP)


def by_hand(robot, mass, w, force=0.0):
    """Torque at the wheel, current, power: no integration."""
    load = 0.5 * robot.radius * (robot.rolling * mass * 9.81 + force)
    torque = load * (1.0 + robot.loss_drive) + robot.gear * robot.coulomb + robot.gear**2 * robot.viscous * w
    ampere = torque / (robot.gear * robot.kt)
    return 2.0 * (robot.kt * robot.gear * w * ampere + robot.resistance * ampere**2)


for name, robot in ROBOTS.items():
    for mass in (robot.empty, robot.full):
        w = 0.7 * robot.v_max / robot.radius
        power, speed = steady(robot, mass, w)
        assert np.allclose(speed, w, rtol=0.02), (name, speed, w)
        assert abs(power / by_hand(robot, mass, speed[0]) - 1.0) < 0.01, (name, power, by_hand(robot, mass, speed[0]))
        uphill, speed = steady(robot, mass, w, World(slope_ahead=0.02))
        hand = by_hand(robot, mass, speed[0], mass * 9.81 * np.sin(0.02))
        assert abs(uphill / hand - 1.0) < 0.01, (name, uphill, hand)
    # Without magnitude no effect changes anything.
    runs = sets.plan(robot, 5, 4, True)
    before = sets.powers(robot, runs, 5, (), (), 0)
    for effect in ALL:
        for variant in range(4):
            assert np.allclose(before, sets.powers(robot, runs, 5, (effect,), (0.0,), variant), rtol=0.0, atol=1e-9), (name, effect, variant)
    for kind in ("white", "ar", "heavy", "hetero"):
        values = noise(kind, 0.3, np.abs(np.sin(np.arange(200000) / 40.0)), np.random.default_rng(1), 0.9)
        assert abs(values.std() / 0.3 - 1.0) < 0.05, (kind, values.std())
print("the judge's plant agrees with the hand")
