"""Effects as physics of the MuJoCo robots, under the names of `gmr gap`'s dictionary.

An effect edits the scene of one run. `common` draws alike in all runs of a set, `own` for each run; `size` is about 1.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from plants import Ground, Load
from sensors import Faults
from simulate import CONTROL_S, Changes

COPPER = 0.0039              # 1/K


@dataclass
class Scene:
    plant: object
    mass: float
    seconds: float
    load: Load
    noted: float = 0.0       # the mass in the log
    ground: Ground = field(default_factory=Ground)
    changes: Changes = field(default_factory=Changes)
    faults: Faults = field(default_factory=Faults)
    slope: float = 0.0
    heading: float = 0.0


def grade(s, size, common, own):
    s.slope, s.heading = 0.03 * size, common.uniform(-np.pi, np.pi)


def wheel_drag(s, size, common, own):
    torque = 0.6 * size * s.plant.drive.coulomb
    s.changes.drag = (torque, 0.0) if common.random() < 0.5 else (0.0, torque)


def rolling_resistance_change(s, size, common, own):
    s.ground = replace(s.ground, roll=1.0 + 0.8 * size)


def surface_switch(s, size, common, own):
    s.changes.ground_at = [(own.uniform(0.2, 0.8) * s.seconds, 1.0, 1.0 + 1.5 * size)]


def payload_offset(s, size, common, own):
    s.load = replace(s.load, left=(1 if common.random() < 0.5 else -1) * 0.25 * size * s.plant.track)


def turning_scrub(s, size, common, own):
    # Skid-steered: other tyres or floor, with more grip. Two wheels: broad tyres that turn in place.
    s.ground = replace(s.ground, slide=0.9 * (1.0 + 0.35 * size)) if s.plant.base else replace(s.ground, spin=1.0 + 9.0 * size)


def winding_temperature(s, size, common, own):
    kelvin, seconds = 50.0 * size, common.uniform(10.0, 40.0)
    s.changes.resistance = lambda t: 1.0 + COPPER * kelvin * (1.0 - np.exp(-t / seconds))


def viscous_change(s, size, common, own):
    s.changes.viscous = 1.0 + 2.0 * size


def gear_load_loss(s, size, common, own):
    s.changes.loss = 1.0 + 1.0 * size


def supply_sag(s, size, common, own):
    d = s.plant.drive
    s.faults.battery = 0.12 * size * d.supply ** 2 / (4.0 * s.plant.usual)


def sensor_gain(s, size, common, own):
    s.faults.gain = 1.0 + 0.12 * size * (1 if common.random() < 0.5 else -1)


def sensor_offset(s, size, common, own):
    s.faults.offset_w = 0.15 * size * s.plant.usual


def sensor_delay(s, size, common, own):
    s.faults.delay_s = 0.12 * size


def static_step(s, size, common, own):
    step = np.zeros(round(s.seconds / CONTROL_S))
    step[round(own.uniform(0.2, 0.8) * len(step)):] = 0.3 * size * s.plant.usual
    s.faults.extra_w = step


def payload_mislabel(s, size, common, own):
    if own.random() < 0.4:
        s.noted = s.mass + 0.25 * size * (s.plant.full - s.plant.empty) * (1 if s.mass < 0.5 * (s.plant.full + s.plant.empty) else -1)


EFFECTS = {f.__name__.replace("_", "-"): f for f in (
    grade, wheel_drag, rolling_resistance_change, surface_switch, payload_offset, turning_scrub, winding_temperature,
    viscous_change, gear_load_loss, supply_sag, sensor_gain, sensor_offset, sensor_delay, static_step, payload_mislabel)}
# These leave the drive as it is: only what is logged differs.
ONLY_LOGGED = {"supply-sag", "sensor-gain", "sensor-offset", "sensor-delay", "static-step", "payload-mislabel"}
