"""Other ways to find what a model lacks, on the logs and the base that `gmr gap` has: a sparse regression (pysindy's STLSQ), a stepwise
search by BIC, and boosted trees on the residual.

They get what `gmr gap` gets: the fit of the clean runs, each field run's predicted power (`gmr estimate --power`), and a library of the same
effects as columns, written here anew from the effects' meaning. Rows are behind a low-pass filter, ten a second; each third run (by mass) is
held out, and says how far the gap closes. Trees know no names: what they are judged by is whether the axes that they split on are those on
which the effect shows.
"""

import csv
import subprocess
import tomllib
import warnings
from pathlib import Path

import numpy as np
from scipy.signal import butter, lfilter

CUTOFF_HZ, KEEP = 2.0, 2
# Axes that a localisation can name, and those on which an effect shows.
AXES = ("speed", "turn", "acceleration", "mass", "time", "power", "left", "right", "other")
SHOWS = {
    "grade": {"mass", "speed"}, "winding-temperature": {"power", "time", "other"}, "windage": {"speed"}, "stribeck": {"speed"},
    "viscous-change": {"speed"}, "lubricant-warm-up": {"speed", "time"}, "rolling-resistance-change": {"speed", "mass"},
    "surface-switch": {"speed", "mass", "time"}, "payload-offset": {"left", "right", "turn", "mass"}, "wheel-drag": {"left", "right"},
    "turning-scrub": {"turn"}, "gear-load-loss": {"power", "acceleration"}, "supply-sag": {"power"},
    "regeneration": {"acceleration", "power"}, "payload-mislabel": {"mass", "acceleration"}, "static-step": {"time", "speed"},
    "compute-load": {"other"}, "sensor-gain": {"power"}, "sensor-offset": {"speed"}, "sensor-delay": {"acceleration"},
    "speed-scale": {"left", "right", "power"},
}


class Run:
    """A field run: residual, features, and a column for each effect."""

    def __init__(self, log, predicted, parameters, shape):
        with open(log, newline="") as file:
            rows = list(csv.DictReader(file))
        data = {name: np.array([float(row[name] or "nan") for row in rows]) for name in rows[0]}
        self.time = data["time_s"]
        dt = float(np.median(np.diff(self.time)))
        b, a = butter(2, min(CUTOFF_HZ * 2.0 * dt, 0.9))

        def smooth(values):
            return lfilter(b, a, values - values[0]) + values[0]

        self.mass = data["mass_kg"]
        wheels = np.stack([smooth(data[f"wheel{k}_rad_s"]) for k in (1, 2)])
        speed_up = np.gradient(wheels, dt, axis=1)
        # Both behind the filter of the fit: what one of them alone has passed would look like a delay.
        measured, wanted = (np.interp(self.time, predicted[:, 0], predicted[:, k]) for k in (1, 2))
        self.residual = smooth(measured - wanted)
        self.power = smooth(wanted)
        forward, turn = wheels.mean(axis=0), wheels[1] - wheels[0]
        self.features = np.stack([forward, turn, speed_up.mean(axis=0), self.mass, self.time, self.power, wheels[0], wheels[1],
                                  data.get("cpu_percent", np.zeros_like(forward))], axis=1)
        self.library = library(wheels, speed_up, self, parameters, shape, data)
        start = int(2.0 / dt)
        rows = slice(start, None, KEEP)
        self.residual, self.features = self.residual[rows], self.features[rows]
        self.library = {name: np.nan_to_num(column[rows]) for name, column in self.library.items()}


def library(w, a, run, p, shape, data):
    """The effects' columns, W per unit: torques by the base's parameters."""
    sign = np.tanh(w / 0.1)
    m, t = run.mass, run.time
    common, apart = a.mean(axis=0), a[1] - a[0]
    half = 0.5 * m * shape["radius"] ** 2
    turn = 0.5 * m * (shape["gyration"] * 2.0 * shape["radius"] / shape["track"]) ** 2 * 0.5
    inertial = np.stack([half * common - 0.5 * turn * apart, half * common + 0.5 * turn * apart])
    torque = sign * (p["coulomb"] + m * p["rolling"]) + p["viscous"] * w + p["rotor_inertia"] * a + p["inertia_gain"] * inertial
    rims = np.abs(w).sum(axis=0)
    forward, spin = w.mean(axis=0), np.abs(w[1] - w[0])
    heading = np.cumsum((w[1] - w[0]) * shape["radius"] / shape["track"]) * np.median(np.diff(t))
    moving = (np.abs(w).max(axis=0) > 0.05).astype(float)
    total = np.abs(run.power)
    heat = np.cumsum((torque ** 2).sum(axis=0)) / np.arange(1, len(t) + 1)
    late = np.gradient(run.power, np.median(np.diff(t)))
    slope = w * (torque + w * p["viscous"])
    columns = {
        "grade": [m * forward, m * forward * np.cos(heading), m * forward * np.sin(heading)],
        "winding-temperature": [(torque ** 2).sum(axis=0) * (1.0 - np.exp(-t / 20.0)), (torque ** 2).sum(axis=0) * heat],
        "windage": [(np.abs(w) ** 3).sum(axis=0)],
        "stribeck": [(np.abs(w) * np.exp(-((w / width) ** 2))).sum(axis=0) for width in (0.3, 1.0)],
        "viscous-change": [(w ** 2).sum(axis=0)],
        "lubricant-warm-up": [(w ** 2).sum(axis=0) * np.exp(-t / 20.0)],
        "rolling-resistance-change": [m * rims],
        "surface-switch": [m * rims * (t > 0.5 * t[-1])],
        "payload-offset": [m * (np.abs(w[0]) - np.abs(w[1]))],
        "wheel-drag": [np.abs(w[0]), np.abs(w[1])],
        "turning-scrub": [spin, m * spin],
        "gear-load-loss": [(torque * np.abs(torque) * w).sum(axis=0)],
        "supply-sag": [total ** 2],
        "regeneration": [np.minimum(torque * w, 0.0).sum(axis=0)],
        "payload-mislabel": [forward * common + 0.1 * rims],
        "static-step": [moving, (t > 0.5 * t[-1]).astype(float)],
        "compute-load": [data.get("cpu_percent", np.zeros_like(t))],
        "sensor-gain": [run.power],
        "sensor-offset": [np.ones_like(t)],
        "sensor-delay": [-late],
        "speed-scale": [slope[0], slope[1]],
    }
    return {f"{name}/{k}": column for name, own in columns.items() for k, column in enumerate(own)}


def read(folder, gmr, robot, shape):
    with open(folder / "base.toml", "rb") as file:
        parameters = tomllib.load(file)["parameters"]
    runs = []
    for log in sorted((folder / "field").glob("*.csv")):
        out = folder / "rival_power.csv"
        subprocess.run([gmr, "estimate", "--robot", robot, "--coeffs", "base.toml", "--power", out.name, "--force", str(log.relative_to(folder))],
                       cwd=folder, capture_output=True, check=True)
        predicted = np.genfromtxt(out, delimiter=",", names=True)
        known = np.isfinite(predicted["told_w"])
        runs.append(Run(log, np.stack([predicted[name][known] for name in ("time_s", "measured_w", "told_w")], axis=1), parameters, shape))
    order = np.argsort([run.mass[0] for run in runs])
    locked = {int(place) for place in order[1::3]}
    return [run for k, run in enumerate(runs) if k not in locked], [run for k, run in enumerate(runs) if k in locked]


def stacked(runs, names):
    return np.stack([np.concatenate([run.library[name] for run in runs]) for name in names], axis=1)


def residual(runs):
    return np.concatenate([run.residual for run in runs])


def closed(open_runs, locked, names):
    """Share of the mean square that a refit of these columns closes on the held-out runs."""
    if not names:
        return 0.0
    coefficients, *_ = np.linalg.lstsq(stacked(open_runs, names), residual(open_runs), rcond=None)
    before = residual(locked)
    return float(1.0 - np.mean((before - stacked(locked, names) @ coefficients) ** 2) / np.mean(before ** 2))


def usable(runs):
    names = list(runs[0].library)
    columns = stacked(runs, names)
    return [name for name, size in zip(names, np.sqrt((columns ** 2).mean(axis=0))) if size > 1e-12]


def bic(columns, y):
    if columns.shape[1] == 0:
        left = y
    else:
        left = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
    return len(y) * np.log(np.mean(left ** 2)) + columns.shape[1] * np.log(len(y))


def stepwise(runs, most=5):
    """Forward selection by BIC, rows taken for independent: as textbooks have it."""
    names, y, chosen = usable(runs), residual(runs), []
    best = bic(np.zeros((len(y), 0)), y)
    while len(chosen) < most:
        tried = [(bic(stacked(runs, [*chosen, name]), y), name) for name in names if name not in chosen]
        value, name = min(tried)
        if value >= best:
            break
        best = value
        chosen.append(name)
    return chosen


def sparse(runs):
    """STLSQ of pysindy on scaled columns, the threshold by BIC."""
    from pysindy.optimizers import STLSQ
    names, y = usable(runs), residual(runs)
    x = stacked(runs, names)
    scale = np.sqrt((x ** 2).mean(axis=0))
    spread = y.std()
    best = (bic(np.zeros((len(y), 0)), y), [])
    for threshold in (0.02, 0.05, 0.1, 0.2, 0.4, 0.8):
        with warnings.catch_warnings():
            # A threshold that leaves nothing is one of those that are tried.
            warnings.simplefilter("ignore")
            found = STLSQ(threshold=threshold, alpha=0.05, max_iter=30).fit(x / scale, (y / spread)[:, None])
        chosen = [name for name, value in zip(names, np.ravel(found.coef_)) if value != 0.0]
        best = min(best, (bic(stacked(runs, chosen) if chosen else np.zeros((len(y), 0)), y), chosen))
    return best[1]


def trees(open_runs, locked, seed=0):
    """Axes by permutation on the held-out runs, and the share that the trees close there."""
    from sklearn.ensemble import HistGradientBoostingRegressor
    from sklearn.inspection import permutation_importance
    x, y = np.concatenate([run.features for run in open_runs]), residual(open_runs)
    model = HistGradientBoostingRegressor(max_iter=150, max_depth=4, learning_rate=0.1, random_state=seed).fit(x, y)
    held, truth = np.concatenate([run.features for run in locked]), residual(locked)
    found = permutation_importance(model, held, truth, n_repeats=3, random_state=seed, scoring="neg_mean_squared_error")
    sizes = found.importances_mean / np.mean(truth ** 2)
    axes = [axis for axis, size in sorted(zip(AXES, sizes), key=lambda pair: -pair[1]) if size > 0.1]
    return axes, float(1.0 - np.mean((truth - model.predict(held)) ** 2) / np.mean(truth ** 2))


def judge(folder, gmr, robot, shape):
    """What each rival says of a set."""
    folder = Path(folder)
    open_runs, locked = read(folder, gmr, robot, shape)
    answers = {}
    for name, method in (("stepwise BIC", stepwise), ("STLSQ (pysindy)", sparse)):
        chosen = method(open_runs)
        ids = list(dict.fromkeys(column.split("/")[0] for column in chosen))
        answers[name] = {"named": ids, "closed": closed(open_runs, locked, chosen)}
    axes, share = trees(open_runs, locked)
    answers["boosted trees"] = {"axes": axes, "closed": share}
    return answers
