"""What `gmr fleet` sums up, in Polars, NumPy and SciPy: what the bench `fleet` compares with.

    python baseline.py LOGS COEFFICIENTS.toml [--lean] [--robots N]

LOGS holds Parquet files robot=…/day=…/….parquet of a TurtleBot3 Burger (time_s, wheel1_rad_s, wheel2_rad_s, power_w, mass_kg,
cmd_v_m_s), one run each. Every run is read, filtered and summed up; then Eq. 18 is solved from the sums of all runs, and each robot's
coefficients near those given. Prints JSON: rows, seconds by part, the coefficients, and how many runs were summed.

The sums are those of `gmr gram --coeffs`: Eq. 18 as corrected and as printed, the signed model of rows in which no wheel can be clamped,
Jᵀ J and Jᵀ e of the signed model near the coefficients; way, energy, histograms. With --lean only Eq. 18 as corrected and Jᵀ J, Jᵀ e.

As in fit_speed/reference.py every step is the fastest found: Polars reads a file on all cores, `sosfilt` takes all signals in one call,
work is done in blocks that stay in the cache, and products are summed by BLAS.
"""

import argparse
import json
import pathlib
import resource
import time
import tomllib

import numpy as np
import polars as pl
from scipy.optimize import nnls
from scipy.signal import butter, sosfilt, sosfilt_zi, zpk2sos

WHEEL_RADIUS, TRACK, GYRATION_RADIUS = 0.033, 0.160, 0.064
DEAD_BAND = 0.02
BLOCK = 1 << 13
COLUMNS = ["time_s", "wheel1_rad_s", "wheel2_rad_s", "power_w", "mass_kg", "cmd_v_m_s"]
POWERS = np.array([0, 1, 2, 0, 0, 2, 0, 1, 0, 1, 1, 2, 0, 1, 1])
POWERS_PUBLISHED = np.array([0, 1, 2, 0, 0, 1, 0, 1, 0, 1, 1, 2, 0, 1, 1])
INVERSE = np.array([[0.5, 0.5], [-1 / TRACK, 1 / TRACK]]) * WHEEL_RADIUS
MATRIX = INVERSE.T @ np.diag([1, GYRATION_RADIUS**2]) @ INVERSE


def filtered(signals, period, cutoff_hz):
    """Speeds, accelerations and power behind the filter's settling: the Butterworth filter's real pole comes last."""
    _, poles, gain = butter(5, cutoff_hz, fs=1 / period, output="zpk")
    real = np.abs(poles.imag) < 1e-12
    pole = poles[real].real[0]
    pairs = zpk2sos([-1] * 4, poles[~real], gain * 2 / (1 - pole))
    first = np.array([[(1 - pole) / 2, (1 - pole) / 2, 0, 1, -pole, 0]])
    rate = 2 * np.tan(np.pi * cutoff_hz * period) / period
    before, _ = sosfilt(pairs, signals, zi=sosfilt_zi(pairs)[:, None, :] * signals[:, :1])
    after, _ = sosfilt(first, before, zi=sosfilt_zi(first)[:, None, :] * signals[:, :1])
    settled = int(np.ceil(2 / (cutoff_hz * period)))
    return after[:2, settled:], rate * (before[:2, settled:] - after[:2, settled:]), after[2, settled:], settled


def along(speed, acceleration):
    """Of each wheel along its motion, 0 within the dead band: |w|, h a, h K, and h itself."""
    h = np.sign(speed) * (np.abs(speed) > DEAD_BAND)
    return h * speed, h * acceleration, h * (MATRIX @ acceleration), h


def total(a, b):
    return np.einsum("ij,ij->j", a, b)


def eq18(w, a, k, mass, gate):
    """The 15 products of Eq. 18 times their powers of the mass: 15 × rows."""
    ga, gk = (a, k) if gate == "signed" else (a + np.abs(a), k + np.abs(k))
    out = np.empty((15, w.shape[1]))
    out[0:3] = np.count_nonzero(w, axis=0) if gate == "signed" else w.shape[0]
    out[3] = total(w, w)
    out[4] = total(ga, a)
    out[5] = total(gk, k)
    if gate == "published":
        out[4] += total(a, a)
        out[5] += total(k, k)
    out[6:8] = w.sum(axis=0)
    out[8:10] = ga.sum(axis=0)
    out[10:12] = gk.sum(axis=0)
    out[12] = total(ga, w)
    out[13] = total(gk, w)
    out[14] = total(ga, gk)
    powers = POWERS_PUBLISHED if gate == "published" else POWERS
    return out * (mass**powers)[:, None]


def near(theta, w, a, k, mass, power):
    """Slopes of the signed model in its parameters, and what it leaves: rows in which some wheel draws power."""
    a0, a1, g2, g3, g4, loss = theta
    moves = w > 0
    torque = ((a0 + a1 * mass) + g2 * w + g3 * a + g4 * mass * k) * moves
    own = torque * (w + loss * torque)
    draws = (own >= 0) & moves
    by = (w + 2 * loss * torque) * draws
    slope = np.empty((7, w.shape[1]))
    slope[0] = by.sum(axis=0)
    slope[1] = mass * slope[0]
    slope[2] = total(by, w)
    slope[3] = total(by, a)
    slope[4] = mass * total(by, k)
    slope[5] = total(torque * torque, draws)
    slope[6] = power - total(own, draws)
    return slope[:, draws.any(axis=0)]


def run(path, theta, cutoff_hz, lean, spent):
    """The sums of a run."""
    started = time.perf_counter()
    table = pl.read_parquet(path, columns=COLUMNS)
    t, w1, w2, p, m, command = (table[name].to_numpy() for name in COLUMNS)
    read = time.perf_counter()
    spent["reading_s"] += read - started
    steps = np.diff(t)
    period = float(np.median(steps[:4096]))
    if not np.isfinite(p).all() or steps.min() <= 0 or steps.max() > 3 * period or np.ptp(m) != 0:
        raise SystemExit(f"{path}: NaN, a gap, time that does not increase, or several masses")
    mass = float(m[0])
    sums = {"rows": len(t)}
    if not lean:
        forward, turn = INVERSE @ np.vstack([w1[1:], w2[1:]])
        moves = np.maximum(np.abs(w1[1:]), np.abs(w2[1:])) > DEAD_BAND
        sums["energy_j"] = p[1:] @ steps
        sums["distance_m"] = np.abs(forward) @ steps
        sums["moving_s"] = moves @ steps
        sums["fastest"] = max(np.abs(w1).max(), np.abs(w2).max())
        sums["commanded"] = [(forward * command[1:]) @ steps, (command[1:] ** 2) @ steps]
        for name, value, width in (("speeds", forward, 0.22 / 23), ("turns", turn, 2.84 / 23)):
            bins = np.minimum(np.abs(value) / width, 23).astype(np.int64)
            sums[name] = np.bincount(bins, weights=steps, minlength=24)
    speed, acceleration, power, settled = filtered(np.vstack([w1, w2, p]), period, cutoff_hz)
    done = time.perf_counter()
    spent["filter_s"] += done - read
    grams = {"eq18": np.zeros((16, 16)), "published": np.zeros((16, 16)), "signed": np.zeros((16, 16)), "local": np.zeros((7, 7))}
    free = -np.inf
    for at in range(0, power.size, BLOCK):
        here = slice(at, at + BLOCK)
        w, a, k, h = along(speed[:, here], acceleration[:, here])
        own = power[here]
        for name, gate in [("eq18", "corrected")] if lean else [("eq18", "corrected"), ("published", "published")]:
            rows = np.vstack([eq18(w, a, k, mass, gate), own])
            grams[name] += rows @ rows.T
        if not lean:
            times = t[settled:][here]
            clamps = ((a < 0) | (k < 0)).any(axis=0)
            until = np.maximum.accumulate(np.where(clamps, times + 2 / cutoff_hz, free))
            free = until[-1]
            kept = times >= until
            rows = np.vstack([eq18(w[:, kept], a[:, kept], k[:, kept], mass, "signed"), own[kept]])
            grams["signed"] += rows @ rows.T
        rows = near(theta, w, a, k, mass, own)
        grams["local"] += rows @ rows.T
    spent["sums_s"] += time.perf_counter() - done
    return sums | grams


def solve_eq18(gram):
    """Eq. 18's coefficients, all at least 0."""
    scale = np.sqrt(np.diag(gram))
    scale[scale == 0] = 1
    values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
    root = np.sqrt(values.clip(min=0))[:, None] * vectors.T
    beta, _ = nnls(root[:, :15], root[:, 15])
    return beta * scale[15] / scale[:15]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("logs", type=pathlib.Path)
    parser.add_argument("coefficients", type=pathlib.Path)
    parser.add_argument("--lean", action="store_true")
    parser.add_argument("--robots", type=int, help="only the first so many")
    arguments = parser.parse_args()
    fitted = tomllib.loads(arguments.coefficients.read_text())
    theta = list(fitted["parameters"].values())[:6]
    cutoff_hz = fitted["robot"]["filter_cutoff_hz"]
    spent = {"reading_s": 0.0, "filter_s": 0.0, "sums_s": 0.0}
    started, processor = time.perf_counter(), time.process_time()
    robots = {}
    for folder in sorted(arguments.logs.glob("robot=*"))[: arguments.robots]:
        files = sorted(folder.glob("**/*.parquet"))
        robots[folder.name] = [run(path, theta, cutoff_hz, arguments.lean, spent) for path in files]
    solving = time.perf_counter()
    runs = [one for of_robot in robots.values() for one in of_robot]
    beta = solve_eq18(sum(one["eq18"] for one in runs))
    bases = {}
    for name, of_robot in robots.items():
        local = sum(one["local"] for one in of_robot)
        scale = np.sqrt(np.diag(local)[:6])
        bases[name] = (np.linalg.pinv(local[:6, :6] / np.outer(scale, scale), rcond=1e-9) @ (local[:6, 6] / scale) / scale).tolist()
    spent["solving_s"] = time.perf_counter() - solving
    print(
        json.dumps({
            "rows": sum(one["rows"] for one in runs),
            "runs": len(runs),
            "seconds": time.perf_counter() - started,
            "cpu_s": time.process_time() - processor,
            "spent": spent,
            "eq18": beta.tolist(),
            "local_score": (sum(one["local"] for one in runs)[:6, 6]).tolist(),
            "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3,
        })
    )


if __name__ == "__main__":
    main()
