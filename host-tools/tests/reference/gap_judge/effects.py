"""Effects as causes: what each changes in a run, for a magnitude in its own unit.

An effect is a function of (scene, magnitude): it edits the scene of one run before the run is integrated, or what the
sensors tell afterwards. `scene.rng` is drawn anew, and alike, for every magnitude. LIMITS is the greatest magnitude that
is still physical, GUESS where the search for a size starts (as a share of the limit).
"""

from dataclasses import dataclass, field

import numpy as np

from drives import STEP
from plant import World
from sensors import PERIOD, averaged


@dataclass
class Scene:
    robot: object
    mass: float  # true
    noted: float  # in the log
    wheels: np.ndarray
    place: int  # of the run in its set
    rng: np.random.Generator
    variant: int  # the same for all runs of a set
    common: np.random.Generator  # draws the same in all runs of a set
    world: World = field(default_factory=World)
    rolling: np.ndarray = None
    extra: np.ndarray = None
    pull: np.ndarray = None
    wind: np.ndarray = None
    static: np.ndarray = None  # W at every step beyond the robot's own
    columns: dict = field(default_factory=dict)  # name -> at 20 Hz
    after: list = field(default_factory=list)  # power at every step -> power at every step
    temperatures: bool = False
    pitch: bool = False
    detail: dict = field(default_factory=dict)

    def __post_init__(self):
        count = len(self.wheels)
        self.time = np.arange(count) * STEP
        self.rolling = np.full(count, self.robot.rolling)
        self.extra, self.static = np.zeros(count), np.zeros(count)
        self.pull, self.wind = np.zeros((count, 2)), np.zeros((count, 2))

    def set(self, **values):
        self.world = self.world._replace(**values)

    @property
    def moving(self):
        return np.abs(self.wheels).sum(axis=1) > 0.05


def coulomb(s):
    """Coulomb torque at the wheel, N·m: a measure for torques."""
    return s.robot.gear * s.robot.coulomb


def grade(s, x):
    heading = s.common.uniform(-np.pi, np.pi)
    # 0: a tilted plane without, 1: with the pitch in the log; 2: uphill whichever way the nose points.
    if s.variant % 3 == 2:
        s.set(slope_ahead=x)
    else:
        s.set(slope=x, slope_heading=heading)
        s.pitch = s.variant % 3 == 1


def winding_temperature(s, x):
    # 0, 1: warms while it drives (1 with temperatures in the log); 2: was hot from the start.
    if s.variant % 3 == 2:
        s.set(hot=x, heat_time=1e5)
    else:
        s.set(heat_resistance=x / s.detail.setdefault("heat_w", heat(s)), heat_time=s.common.uniform(15.0, 60.0))
        s.temperatures = s.variant % 3 == 1


def heat(s):
    """Usual copper loss of a motor, W, so that the magnitude is a temperature."""
    torque = coulomb(s) + s.robot.rolling * s.mass * 9.81 * s.robot.radius / 2.0
    return (1.6 * torque / (s.robot.gear * s.robot.kt)) ** 2 * s.robot.resistance


def windage(s, x):
    s.set(fan=x)


def stribeck(s, x):
    s.set(stribeck=x, stribeck_speed=s.common.uniform(0.08, 0.25) * s.robot.v_max / s.robot.radius)


def viscous_change(s, x):
    s.set(viscous_factor=1.0 + x)


def lubricant_warm_up(s, x):
    s.set(cold_grease=x * s.robot.viscous, warm_time=s.common.uniform(10.0, 30.0))


def rolling_resistance_change(s, x):
    s.rolling += x


def surface_switch(s, x):
    at = s.rng.uniform(12.0, 48.0)
    if s.variant % 3 == 1:
        at = s.common.uniform(15.0, 45.0)  # the same in all runs
    if s.variant % 3 == 2 and s.place % 3 == 2:
        return  # some runs stay on the old floor
    s.detail["at_s"] = at
    s.rolling += x * (s.time >= at)


def payload_offset(s, x):
    s.set(load_left=x if s.variant % 2 else -x)


def wheel_drag(s, x):
    s.set(**{"drag_left" if s.variant % 2 else "drag_right": x})


def turning_scrub(s, x):
    s.set(**({"scrub_per_kg": x / (s.robot.empty + s.robot.full) * 2.0} if s.variant % 2 else {"scrub": x}))


def gear_load_loss(s, x):
    s.set(gear_growth=x)


def supply_sag(s, x):
    """The sensor counts amperes and takes the battery's volts without load for granted."""
    volts, other = s.robot.volts, s.robot.static

    def sagged(power):
        whole = np.maximum(power + other, 0.0)
        return volts * (volts - np.sqrt(np.maximum(volts**2 - 4.0 * x * whole, 0.0))) / (2.0 * x) - other if x > 0 else power

    s.after.append(sagged)


def regeneration(s, x):
    s.set(returned=x)


def payload_mislabel(s, x):
    wrong = {0: {4}, 1: {1, 5, 9}, 2: {0, 3, 4, 8, 10, 11}}[s.variant % 3]
    if s.place in wrong:
        # Into the range, so that neither mass is absurd.
        up = s.mass + x <= s.robot.full
        s.mass = s.mass + x if up else max(s.mass - x, 0.8 * s.robot.empty)


def static_step(s, x):
    if s.variant % 4 == 0:
        s.detail["at_s"] = s.rng.uniform(12.0, 48.0)
        s.static += x * (s.time >= s.detail["at_s"])
    elif s.variant % 4 == 1:
        s.static += x * (np.cumsum(s.moving) > 0)
    elif s.variant % 4 == 2:
        s.static += x * s.moving
    elif s.place % 3:  # some runs only
        s.detail["at_s"] = s.rng.uniform(12.0, 48.0)
        s.static += x * (s.time >= s.detail["at_s"])


def compute_load(s, x):
    load = piecewise(s, 1.5, 8.0, lambda: s.rng.uniform(5.0, 95.0))
    s.static += x * load / 100.0
    s.columns["cpu_percent"] = np.clip(averaged(load) + s.rng.normal(0.0, 2.0, len(averaged(load))), 0.0, 100.0)


def sensor_gain(s, x):
    static = s.robot.static
    s.after.append(lambda power: (1.0 + x) * (power + static) - static)


def sensor_offset(s, x):
    s.after.append(lambda power: power + x)


def sensor_delay(s, x):
    late = int(round(x / STEP))
    s.after.append(lambda power: np.concatenate([np.full(late, power[0]), power[: len(power) - late]]))


def speed_scale(s, x):
    if s.variant % 3 == 2:
        s.set(scale_left=1.0 + x, scale_right=1.0 + x)
    else:
        s.set(**{"scale_left" if s.variant % 3 else "scale_right": 1.0 + x})


# What the dictionary does not have.


def piecewise(s, shortest, longest, draw):
    out = np.empty(len(s.time))
    at = 0
    while at < len(out):
        to = at + int(s.rng.uniform(shortest, longest) / STEP)
        out[at:to] = draw()
        at = to
    return out


def rattle(s, x):
    """Bursts of shaking while it moves: a loose load on bumps."""
    on = piecewise(s, 0.4, 2.5, lambda: float(s.rng.random() < 0.25)) * s.moving
    beat = np.sin(2.0 * np.pi * s.rng.uniform(3.0, 8.0) * s.time + s.rng.uniform(0, 6))
    s.pull += (x * on * beat)[:, None]


def gusts(s, x):
    """Wind from one side of the world, as a random process."""
    heading = s.common.uniform(-np.pi, np.pi)
    steps = s.rng.standard_normal(len(s.time) // 100 + 1)
    now, slow = 0.0, np.empty(len(steps))
    memory = np.exp(-0.05 / 3.0)
    for k, step in enumerate(steps):
        now = memory * now + np.sqrt(1 - memory**2) * step
        slow[k] = now
    force = x * np.maximum(np.repeat(slow, 100)[: len(s.time)], 0.0)
    s.wind += -force[:, None] * np.array([np.cos(heading), np.sin(heading)])


def arm(s, x):
    """An arm on board moves periodically."""
    period = s.common.uniform(4.0, 9.0)
    s.static += x * (np.sin(2.0 * np.pi * s.time / period + s.rng.uniform(0, 6)) > 0.3)


def battery_static(s, x):
    """Electronics behind a linear regulator: their power follows the battery's falling voltage, run after run."""
    s.static += x * (1.0 - (s.place + s.time / 60.0) / 6.0)


def eccentric_wheel(s, x):
    s.set(eccentric=x)


def caster(s, x):
    s.set(caster=x)


def deflation(s, x):
    """The tyres lose air in steps, from run to run."""
    s.rolling += x * [0, 0, 0, 0.5, 0.5, 0.5, 0.5, 1, 1, 1.6, 1.6, 1.6][s.place % 12]


def root_loss(s, x):
    s.set(root_loss=x)


def bearing(s, x):
    """A bearing that binds now and then."""
    s.extra += x * piecewise(s, 0.5, 6.0, lambda: float(s.rng.random() < 0.35))


def bridge(s, x):
    """The bridge loses volts times amperes."""
    s.set(switching=x)


def wrapping(s, x):
    """Something winds up on the axle: drag grows with the way."""
    s.extra += x * np.cumsum(np.abs(s.wheels).sum(axis=1)) * STEP / (120.0 * s.robot.v_max / s.robot.radius)


def soft_ground(s, x):
    s.set(rough=x)


def fridge(s, x):
    """A cooler or heater that switches at random times, whatever the robot does."""
    s.static += x * piecewise(s, 5.0, 20.0, lambda: float(s.rng.random() < 0.4))


def hardest(r):
    """Torque that a gear passes when the loaded robot speeds up as hard as it may, N·m."""
    return 0.5 * r.full * (9.81 * r.rolling + r.a_max) * r.radius


# id -> (cause, greatest magnitude by robot or for both); magnitudes in SI, temperatures in K, factors as such.
DICTIONARY = {
    "grade": (grade, 0.15),
    "winding-temperature": (winding_temperature, 120.0),
    "windage": (windage, lambda r: 6.0 * r.coulomb / (r.gear * r.v_max / r.radius) ** 2),
    "stribeck": (stribeck, lambda r: 1.5 * r.gear * r.coulomb),
    "viscous-change": (viscous_change, 8.0),
    "lubricant-warm-up": (lubricant_warm_up, 15.0),
    "rolling-resistance-change": (rolling_resistance_change, 0.12),
    "surface-switch": (surface_switch, 0.15),
    "payload-offset": (payload_offset, 0.35),
    "wheel-drag": (wheel_drag, lambda r: 6.0 * r.gear * r.coulomb),
    "turning-scrub": (turning_scrub, lambda r: 0.6 * r.full * 9.81 * r.track / 4.0),
    "gear-load-loss": (gear_load_loss, lambda r: 0.5 / hardest(r)),
    "supply-sag": (supply_sag, lambda r: 3.0 if r.volts < 15.0 else 1.2),
    "regeneration": (regeneration, 0.95),
    "payload-mislabel": (payload_mislabel, lambda r: 0.9 * (r.full - r.empty)),
    "static-step": (static_step, 5.0),
    "compute-load": (compute_load, 8.0),
    "sensor-gain": (sensor_gain, 0.6),
    "sensor-offset": (sensor_offset, 3.0),
    "sensor-delay": (sensor_delay, 0.5),
    "speed-scale": (speed_scale, 0.3),
}
FOREIGN = {
    "rattle": (rattle, lambda r: 8.0 * r.gear * r.coulomb),
    "gusts": (gusts, lambda r: 0.3 * r.full * 9.81),
    "arm": (arm, 5.0),
    "battery-static": (battery_static, 3.0),
    "eccentric-wheel": (eccentric_wheel, lambda r: 3.0 * r.gear * r.coulomb),
    "caster": (caster, lambda r: 0.3 * r.full * 9.81),
    "deflation": (deflation, 0.1),
    "root-loss": (root_loss, lambda r: 3.0 * r.gear * r.coulomb),
    "bearing": (bearing, lambda r: 4.0 * r.gear * r.coulomb),
    "bridge": (bridge, 6.0),
    "wrapping": (wrapping, lambda r: 4.0 * r.gear * r.coulomb),
    "soft-ground": (soft_ground, 40.0),
    "fridge": (fridge, 5.0),
}
ALL = {**DICTIONARY, **FOREIGN}

# Names that would not be wrong for a foreign effect: it is the named one that grows, or comes and goes.
KIN = {
    "deflation": {"rolling-resistance-change", "surface-switch"},
    "battery-static": {"static-step", "sensor-offset"},
    "fridge": {"static-step"},
    "arm": {"static-step"},
}


def limit(name, robot):
    most = ALL[name][1]
    return most(robot) if callable(most) else most
