"""Causes that `gmr gap`'s dictionary lacks, as physics of the MuJoCo robots: to be left without a name.

As in `gap_effects.py`: `common` draws alike in all runs of a set, `own` for each run; `size` is about 1.
"""

from dataclasses import replace

import numpy as np

from simulate import CONTROL_S


def torque(s, size):
    """N·m, of the size of most effects."""
    return 0.6 * size * s.plant.drive.coulomb


def worn_tyres(s, size, common, own):
    s.ground = replace(s.ground, slide=0.9 / (1.0 + 0.5 * size), roll=1.0 / (1.0 + 0.3 * size))


def one_way_drag(s, size, common, own):
    most = torque(s, size)
    s.changes.brake = lambda side, angle, speed, load, now: most if speed > 0.0 else 0.0


def eccentric_wheel(s, size, common, own):
    most, wheel, phase = 2.0 * torque(s, size), int(common.random() < 0.5), own.uniform(0.0, 2.0 * np.pi)
    s.changes.brake = lambda side, angle, speed, load, now: most * np.sin(angle + phase) if side == wheel else 0.0


def supply_dips(s, size, common, own):
    # The sensor takes the voltage for what it usually is: while it dips, the same power takes more current.
    gain = np.ones(round(s.seconds / CONTROL_S))
    for begin in own.uniform(0.0, s.seconds, 4):
        at = round(begin / CONTROL_S)
        gain[at:at + round(3.0 / CONTROL_S)] = 1.0 + 0.25 * size
    s.faults.gain = gain


def soft_ground(s, size, common, own):
    # A wheel sinks in more under more weight, and climbs out less at speed.
    top = s.plant.speed
    most = torque(s, size) * (s.mass / s.plant.full) ** 1.5
    s.changes.brake = lambda side, angle, speed, load, now: most * np.sign(speed) * np.sqrt(abs(speed) / top)


def cogging(s, size, common, own):
    most = 2.0 * torque(s, size)
    s.changes.brake = lambda side, angle, speed, load, now: most * np.sin(14.0 * angle)


def resonance(s, size, common, own):
    most, at, wide = 2.0 * torque(s, size), common.uniform(0.3, 0.8) * s.plant.speed, 0.08 * s.plant.speed
    s.changes.brake = lambda side, angle, speed, load, now: most * np.sign(speed) * np.exp(-(((abs(speed) - at) / wide) ** 2))


def bursts(s, size, common, own):
    power = np.zeros(round(s.seconds / CONTROL_S))
    for begin in own.uniform(0.0, s.seconds, 8):
        at = round(begin / CONTROL_S)
        power[at:at + round(own.uniform(0.2, 0.8) / CONTROL_S)] = 0.8 * size * s.plant.usual
    s.faults.extra_w = power


def swinging_load(s, size, common, own):
    most, turns, phase = 1.5 * torque(s, size), 2.0 * np.pi / common.uniform(0.8, 1.6), own.uniform(0.0, 2.0 * np.pi)
    s.changes.brake = lambda side, angle, speed, load, now: most * np.sin(turns * now + phase)


def slipping_belt(s, size, common, own):
    # Beyond what the belt holds, a share of the load is rubbed away.
    wheel, holds = int(common.random() < 0.5), 1.5 * s.plant.drive.coulomb
    share = 0.15 * size
    s.changes.brake = lambda side, angle, speed, load, now: (
        share * max(abs(load) - holds, 0.0) * np.sign(speed) if side == wheel else 0.0)


FOREIGN = {f.__name__.replace("_", "-"): f for f in (
    worn_tyres, one_way_drag, eccentric_wheel, supply_dips, soft_ground, cogging, resonance, bursts, swinging_load, slipping_belt)}
ONLY_LOGGED = {"supply-dips", "bursts"}
# Listed effects that a cause is made of: a worn tyre slides more easily and rolls more easily, and nothing else here.
KIN = {"worn-tyres": {"turning-scrub", "rolling-resistance-change"}}
