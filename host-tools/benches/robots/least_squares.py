"""An independent least squares of the signed torque model's form, in NumPy and SciPy: what `gmr fit` is judged by.

    python least_squares.py COEFFICIENTS.toml LOG.csv ... [--starts 50]

Reads the robot and the filter from what `gmr fit` wrote, and from there shares nothing with it: SciPy's Butterworth filter, plain
sum of squares over all rows, trust-region steps from random starts. The form is that of the coefficients: terms that they lack are
left out here, too.
"""

import argparse
import json
import tomllib
from dataclasses import dataclass

import numba
import numpy as np
from scipy.optimize import least_squares
from scipy.signal import butter, sosfilt, sosfilt_zi, zpk2sos

STARTS = 50
# Rows that take part; more are thinned out behind the filter.
MOST_ROWS = 20_000


@dataclass
class Rows:
    """Behind the filter; wheels by side or one by one. Shapes (n, wheels) but for power, mass, turn and true slip."""
    speed: np.ndarray
    acceleration: np.ndarray
    inertial: np.ndarray     # torque per kilogram at the wheel, N·m/kg
    direction: np.ndarray
    power: np.ndarray
    mass: np.ndarray
    lateral: np.ndarray      # −1 left, +1 right
    slip: "Slip"
    true_slip: np.ndarray    # what the wheels turn more than the gyro says, rad/s by side; NaN without a gyro


class Slip:
    """The turn's state s, −1 to 1:  s ← (c λ s + T Δ) / (c λ + T √((c v)² + Δ² + r²)), r being the dead band where it is 0; for c = 0 the sign
    of the turn Δ."""

    def __init__(self, difference, mean, period, starts, dead_band):
        self.parts = (difference, mean, dead_band, period, starts)
        self.sign = np.where(np.abs(difference) > dead_band, np.sign(difference), 0.0)
        self.kept, self.keep = {}, None

    def at(self, c, relaxation, rest):
        if c == 0.0:
            return self.sign
        key = (c, relaxation, rest)
        if key not in self.kept:
            if len(self.kept) > 8:
                self.kept.clear()
            self.kept[key] = self.walk(c, c * relaxation, rest)
        return self.kept[key]

    def walk(self, c, e, rest):
        difference, mean, dead_band, period, starts = self.parts
        ease = 1.0 / (e + period * np.sqrt((c * mean) ** 2 + difference ** 2 + (rest or dead_band) ** 2))
        out = steps(e, period * difference, ease, starts)
        return out if self.keep is None else out[self.keep]


@numba.njit
def steps(e, push, ease, starts):
    """s of every row: each from the one before, none from before a start."""
    out = np.empty(len(push))
    s = 0.0
    for k in range(len(push)):
        if starts[k]:
            s = 0.0
        s = (e * s + push[k]) * ease[k]
        out[k] = s
    return out


def low_pass(cutoff_hz, period):
    """Butterworth of fifth order, and the derivative of its output: a zero at −1 becomes one at +1."""
    zeros, poles, gain = butter(5, cutoff_hz, fs=1.0 / period, output="zpk")
    rest = np.append(zeros[:-1], 1.0)
    return zpk2sos(zeros, poles, gain), zpk2sos(rest, poles, gain * 2.0 / period)


def settled(sos, x):
    return sosfilt(sos, x, axis=0, zi=sosfilt_zi(sos)[:, :, None] * x[0] if x.ndim > 1 else sosfilt_zi(sos) * x[0])[0]


def read(logs, robot, masses, delay=0.0, with_gyro=False):
    """Rows of all logs behind the robot's filter, each log from its settled start."""
    kinematics = np.array(robot["kinematics"])
    gyration = robot["gyration_radius_m"]
    matrix = kinematics.T @ np.diag([1.0] * (len(kinematics) - 1) + [gyration ** 2]) @ kinematics
    lateral = np.sign(kinematics[-1])
    parts = []
    for log, mass in zip(logs, masses):
        with open(log) as file:
            names = file.readline().strip().split(",")
        values = np.genfromtxt(log, delimiter=",", skip_header=1)
        column = {n: values[:, k] for k, n in enumerate(names)}
        raw = np.column_stack([column[f"wheel{k + 1}_rad_s"] for k in range(kinematics.shape[1])])
        fine = np.isfinite(raw).all(axis=1) & np.isfinite(column["power_w"])
        turn = column.get(YAW_RATE, np.full(len(fine), np.nan))
        if with_gyro:
            fine &= np.isfinite(turn)
        time, raw, power = column["time_s"][fine], raw[fine], column["power_w"][fine] - robot.get("static_power_w", 0.0)
        turn = turn[fine]
        if delay:
            # The power is late: speeds of then.
            raw = np.column_stack([np.interp(time - delay, time, wheel) for wheel in raw.T])
            turn = np.interp(time - delay, time, turn)
        period = float(np.median(np.diff(time)))
        value, slope = low_pass(robot["filter_cutoff_hz"], period)
        wait = int(np.ceil(2.0 / (robot["filter_cutoff_hz"] * period)))
        if len(time) <= wait:
            continue
        own = column["mass_kg"][fine] if "mass_kg" in column else np.full(len(time), mass)
        starts = np.zeros(len(time), bool)
        starts[0] = True
        parts.append((settled(value, raw), settled(slope, raw), settled(value, power), own, starts, np.arange(len(time)) >= wait, period,
                      settled(value, turn)))
    speed, acceleration, power, mass, starts, use, _, turn = (
        None if k == 6 else np.concatenate([p[k] for p in parts]) for k in range(8))
    band = robot["speed_dead_band_rad_s"]
    rest = np.abs(speed) <= band
    inertial = acceleration @ matrix.T
    direction = np.sign(speed)
    side = [speed[:, lateral == s].mean(axis=1) for s in (-1.0, 1.0)]
    # Wheel speeds that differ by d turn a robot that does not slip by d Σ|ω row| / 2.
    true_slip = side[1] - side[0] - turn * 2.0 / np.abs(kinematics[-1]).sum()
    slip = Slip(side[1] - side[0], np.abs(side[0] + side[1]) / 2.0, parts[0][6], starts, band)
    keep = np.flatnonzero(use)[:: max(1, int(np.ceil(use.sum() / MOST_ROWS)))]
    slip.keep, slip.sign = keep, slip.sign[keep]
    for array in (acceleration, inertial, direction, speed):
        array[rest] = 0.0
    return Rows(speed[keep], acceleration[keep], inertial[keep], direction[keep], power[keep], mass[keep], lateral, slip,
                true_slip[keep])


# Name of a coefficient: scale of a random start.
SCALES = {
    "coulomb": 1.0, "rolling": 0.02, "viscous": 0.2, "rotor_inertia": 0.5, "inertia_gain": 1.0, "winding_loss": 0.03, "scrub": 0.5,
    "imbalance": 0.3, "half_slip": 0.1, "relaxation": 1.0, "rest": 0.05, "true_slip": 0.3, "gear_loss": 0.1,
    "bridge_drop": 0.1,
}
# What the file calls otherwise.
NAMES = {"slip_relaxation_rad": "relaxation", "slip_rest_rad_s": "rest", "power_delay_s": "delay_s", "true_slip_s_rad": "true_slip"}
# Not fitted here: taken as `gmr fit` found it.
DELAY = "delay_s"
# Share of the friction that passes the gear: none or all, whichever fits better.
FRICTION = "wheel_friction_share"
# Turn rate by a gyro, counter-clockwise, rad/s.
YAW_RATE = "yaw_rate_rad_s"


def model(q, rows, regenerates):
    """Power, W, of coefficients by name."""
    g = q.get
    turn = rows.slip.at(g("half_slip", 0.0), g("relaxation", 0.0), g("rest", 0.0))
    if "true_slip" in q:
        turn = turn + q["true_slip"] * rows.true_slip
    moving = rows.direction != 0.0
    m = rows.mass[:, None]
    load = m * (g("rolling", 0.0) * rows.direction + g("inertia_gain", 0.0) * rows.inertial
                + g("scrub", 0.0) * turn[:, None] * rows.lateral * moving)
    friction = (g("coulomb", 0.0) + g("imbalance", 0.0) * rows.lateral) * rows.direction + g("viscous", 0.0) * rows.speed
    passed = g(FRICTION, 0.0) * friction + load
    torque = (friction + g("rotor_inertia", 0.0) * rows.acceleration + load
              + g("gear_loss", 0.0) * np.abs(passed) * rows.direction)
    power = torque * rows.speed + g("winding_loss", 0.0) * torque ** 2 + g("bridge_drop", 0.0) * np.abs(torque)
    if not regenerates:
        power = np.maximum(power, 0.0)
    return power.sum(axis=1)


def solve(rows, names, regenerates, starts, seed=0):
    """The least cost of many starts and of both places of friction (sum of squares, W²), and where."""
    shares = (0.0, 1.0) if "gear_loss" in names else (0.0,)
    return min((descend(rows, names, regenerates, starts, seed, share) for share in shares), key=lambda end: end[0])


def descend(rows, names, regenerates, starts, seed, share):
    """The same where this share of the friction passes the gear."""
    rng = np.random.default_rng(seed)
    scale = np.array([SCALES[n] for n in names])
    low = np.array([-np.inf if n == "imbalance" else 0.0 for n in names])

    def residual(x):
        return model(dict(zip(names, x * scale)) | {FRICTION: share}, rows, regenerates) - rows.power

    best = None
    for _ in range(starts):
        x = np.exp(rng.normal(0.0, 1.0, len(names)))
        found = least_squares(residual, x, bounds=(low, np.inf), x_scale="jac", max_nfev=200)
        if best is None or found.cost < best.cost:
            best = found
    return 2.0 * best.cost, dict(zip(names, (best.x * scale).tolist())) | ({FRICTION: share} if share else {})


def written(coefficients):
    """The file as `gmr fit` wrote it, and its values by name, wherever in it they stand."""
    with open(coefficients, "rb") as file:
        document = tomllib.load(file)
    values = dict(document["parameters"])
    for section in document.values():
        if isinstance(section, dict):
            named = {NAMES.get(k, k): v for k, v in section.items()}
            values |= {k: v for k, v in named.items() if k in SCALES or k == DELAY}
    return document, values


def beside(fit, coefficients, logs, starts=STARTS):
    """R² of the fit's parameters and of the best of many starts, on the same rows."""
    document, values = written(coefficients)
    delay = values.pop(DELAY, 0.0)
    unknown = values.keys() - SCALES.keys() - {FRICTION}
    if unknown:
        return {"error": f"no independent form has {', '.join(sorted(unknown))}"}
    masses = document["fit"]["masses_kg"]
    masses = masses if len(masses) == len(logs) else [masses[0]] * len(logs)
    robot = document["robot"]
    rows = read(logs, robot, masses, delay, "true_slip" in values)
    total = float(np.sum((rows.power - rows.power.mean()) ** 2))
    own = float(np.sum((model(values, rows, robot["regeneration"]) - rows.power) ** 2))
    cost, best = solve(rows, [name for name in values if name != FRICTION], robot["regeneration"], starts)
    return {
        "r2_told": fit["r2"] if fit else None, "r2_fit": 1.0 - own / total, "r2_independent": 1.0 - cost / total,
        "cost_above_best": own / cost - 1.0, "fit": values, "independent": best, "starts": starts, "rows": len(rows.power),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("coefficients")
    parser.add_argument("logs", nargs="+")
    parser.add_argument("--starts", type=int, default=STARTS)
    a = parser.parse_args()
    print(json.dumps(beside(None, a.coefficients, a.logs, a.starts), indent=2))


if __name__ == "__main__":
    main()
