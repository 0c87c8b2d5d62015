"""`gmr fit` in NumPy and SciPy: what the benchmark `fit_speed` compares with.

    python reference.py LOG.csv CUTOFF_HZ {eq18,signed}

Reads a log (columns in this order: time_s, wheel1_rad_s, wheel2_rad_s, power_w) of a TurtleBot3 Burger of 1 kg, filters
it, and fits Eq. 18 by non-negative least squares over all rows, or the signed torque model over every k-th row as `gmr`
does. Prints the coefficients as JSON.

Every step is the fastest found in NumPy and SciPy: `loadtxt` reads four times as fast as `fromstring`, the log is worked
on in blocks that stay in the cache (twice as fast as in one piece), `sosfilt` takes all channels in one call, and the Gram
matrix is summed by BLAS. Standard errors, noise and verdicts, which `gmr` adds, are left out.
"""

import json
import sys
import warnings

import numpy as np
from scipy.optimize import least_squares, nnls
from scipy.signal import butter, sosfilt, sosfilt_zi, zpk2sos

MASS = 1.0
WHEEL_RADIUS, TRACK, GYRATION_RADIUS = 0.033, 0.160, 0.064
DEAD_BAND = 0.02
STORE_ROWS = 1 << 18
BLOCK = 1 << 15
MASS_POWERS = np.array([0, 1, 2, 0, 0, 2, 0, 1, 0, 1, 1, 2, 0, 1, 1])


def blocks(path):
    """The log in pieces: step in time (s), and speeds and power (3 × rows)."""
    period = last = None
    with open(path) as log:
        log.readline()
        while True:
            with warnings.catch_warnings(action="ignore"):  # the end of the file
                table = np.loadtxt(log, delimiter=",", max_rows=BLOCK, ndmin=2)
            if table.size == 0:
                return
            steps = np.diff(table[:, 0], prepend=table[0, 0] - (period or 1) if last is None else last)
            if period is None:
                period = np.median(steps[1:4096])
                steps[0] = period
            if not np.isfinite(table).all() or steps.min() <= 0 or steps.max() > 3 * period:
                raise SystemExit(f"{path}: NaN, a gap or time that does not increase")
            last = table[-1, 0]
            yield period, np.ascontiguousarray(table[:, 1:].T)


def conditioned(pieces, cutoff_hz):
    """Filtered speeds, their derivatives and filtered power, piece by piece, behind the filter's settling.

    The Butterworth filter's real pole comes last: the difference of its input and output is the derivative.
    """
    pairs = None
    for period, signals in pieces:
        if pairs is None:
            _, poles, gain = butter(5, cutoff_hz, fs=1 / period, output="zpk")
            real = np.abs(poles.imag) < 1e-12
            pole = poles[real].real[0]
            pairs = zpk2sos([-1] * 4, poles[~real], gain * 2 / (1 - pole))
            first = np.array([[(1 - pole) / 2, (1 - pole) / 2, 0, 1, -pole, 0]])
            rate = 2 * np.tan(np.pi * cutoff_hz * period) / period
            state = sosfilt_zi(pairs)[:, None, :] * signals[:, :1]
            last_state = sosfilt_zi(first)[:, None, :] * signals[:, :1]
            unsettled = int(np.ceil(2 / (cutoff_hz * period)))
        before, state = sosfilt(pairs, signals, zi=state)
        after, last_state = sosfilt(first, before, zi=last_state)
        skipped = min(unsettled, after.shape[1])
        unsettled -= skipped
        before, after = before[:, skipped:], after[:, skipped:]
        yield after[:2], rate * (before[:2] - after[:2]), after[2]


def wheels(speed, acceleration):
    """Speed, acceleration, inertial torque per kilogram and direction of each wheel; 0 within the dead band."""
    inverse = np.array([[0.5, 0.5], [-1 / TRACK, 1 / TRACK]]) * WHEEL_RADIUS
    matrix = inverse.T @ np.diag([1, GYRATION_RADIUS**2]) @ inverse
    moves = np.abs(speed) > DEAD_BAND
    torque = matrix @ acceleration
    return speed * moves, acceleration * moves, torque * moves, np.sign(speed) * moves


def products(speed, acceleration, torque, direction, gated):
    """The 15 products of Eq. 18 (corrected, or ungated), summed over the wheels: 15 × rows."""
    w, a, k, h = speed, acceleration, torque, direction
    s = 1 + np.sign(a * w) if gated else 1.0
    r = 1 + np.sign(k * w) if gated else 1.0
    sa, rk = s * a, r * k
    out = np.empty((15, w.shape[1]))
    out[0:3] = w.shape[0] if gated else np.abs(h).sum(axis=0)
    out[3] = np.einsum("ij,ij->j", w, w)
    out[4] = np.einsum("ij,ij->j", sa, a)
    out[5] = np.einsum("ij,ij->j", rk, k)
    out[6:8] = np.einsum("ij,ij->j", h, w)
    out[8:10] = np.einsum("ij,ij->j", h, sa)
    out[10:12] = np.einsum("ij,ij->j", h, rk)
    out[12] = np.einsum("ij,ij->j", sa, w)
    out[13] = np.einsum("ij,ij->j", rk, w)
    out[14] = np.einsum("ij,ij->j", sa, rk)
    return out * (MASS**MASS_POWERS)[:, None]


def fit_eq18(pieces):
    """Coefficients of the corrected Eq. 18, all at least 0, and their mean squared error."""
    gram = np.zeros((16, 16))
    count = 0
    for speed, acceleration, power in pieces:
        rows = np.vstack([products(*wheels(speed, acceleration), gated=True), power])
        gram += rows @ rows.T
        count += power.size
    # A square root of the Gram matrix in place of all rows: columns scaled to unit length, dependent ones tolerated.
    scale = np.sqrt(np.diag(gram))
    scale[scale == 0] = 1
    values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
    root = np.sqrt(values.clip(min=0))[:, None] * vectors.T
    beta, _ = nnls(root[:, :15], root[:, 15])
    beta *= scale[15] / scale[:15]
    error = np.append(-beta, 1)
    return beta, error @ gram @ error / count


def expand(parameters):
    """The 15 coefficients that the signed torque model's six parameters make (without scrub, which this robot has not)."""
    a0, a1, g2, g3, g4, k = parameters
    lift = 1 + 2 * k * g2
    return np.array([
        k * a0 * a0, 2 * k * a0 * a1, k * a1 * a1, g2 * (1 + k * g2), k * g3 * g3, k * g4 * g4, a0 * lift, a1 * lift,
        2 * k * a0 * g3, 2 * k * a1 * g3, 2 * k * a0 * g4, 2 * k * a1 * g4, g3 * lift, g4 * lift, 2 * k * g3 * g4,
    ])  # fmt: skip


def torques(parameters, motion):
    """Torque of each wheel, N·m."""
    a0, a1, g2, g3, g4, _ = parameters
    w, a, k, h = motion
    return (a0 + a1 * MASS) * h + g2 * w + g3 * a + g4 * MASS * k


def thinned(pieces):
    """Every k-th row, k the least power of two with which at most `STORE_ROWS` remain."""
    stride, count, kept = 1, 0, []
    for speed, acceleration, power in pieces:
        kept.append(np.vstack([speed, acceleration, power])[:, -count % stride :: stride].copy())
        count += power.size
        while -(-count // stride) > STORE_ROWS:
            stride *= 2
            kept = [np.hstack(kept)[:, ::2].copy()]
    store = np.hstack(kept)
    return store[:2], store[2:4], store[4]


def solve_signed(motion, power, weights, starts):
    """The six parameters that are best for weighted rows: least squares on a square root of their Gram matrix."""
    rows = np.vstack([products(*motion, gated=False), power]) * np.sqrt(weights)
    values, vectors = np.linalg.eigh(rows @ rows.T)
    root = np.sqrt(values.clip(min=0))[:, None] * vectors.T

    def residual(parameters):
        return root[:, :15] @ expand(parameters) - root[:, 15]

    options = {"bounds": (0, np.inf), "x_scale": "jac", "xtol": 1e-12, "ftol": 1e-12, "gtol": 1e-12}
    fits = [least_squares(residual, start, **options) for start in starts]
    return min(fits, key=lambda fit: fit.cost).x


def fit_signed(pieces):
    """The six parameters by Huber's rule over the wheels that are not clamped, and their weighted mean squared error."""
    speed, acceleration, power = thinned(pieces)
    motion = wheels(speed, acceleration)
    w, a, _, h = motion
    brakes = (a * h < -0.1 * np.sqrt(np.mean(a**2))).any(axis=0)
    moves = (h != 0).any(axis=0)
    typical = 0.5 * np.mean(power[moves]) / np.mean(np.abs(w).sum(axis=0)[moves])
    starts = [[typical, typical, 0.1 * typical, 1e-3, 1.0, loss] for loss in (0.1, 1.0, 10.0)]
    parameters = solve_signed(motion, power, ~brakes, starts)
    for _ in range(40):
        torque = torques(parameters, motion)
        drawn = torque * (w + parameters[5] * torque)
        drives = drawn >= 0
        residual = np.abs(power - (drawn * drives).sum(axis=0))
        active = (drives & (h != 0)).any(axis=0)
        limit = 4 * 1.4826 * np.median(residual[active])
        weights = active * np.minimum(1, limit / residual.clip(min=1e-300))
        last = parameters
        parameters = solve_signed([signal * drives for signal in motion], power, weights, [parameters])
        if np.all(np.abs(parameters - last) <= 1e-4 * np.abs(parameters)):
            break
    return parameters, np.average(residual**2, weights=weights)


def main():
    path, cutoff_hz, model = sys.argv[1], float(sys.argv[2]), sys.argv[3]
    fit = {"eq18": fit_eq18, "signed": fit_signed}[model]
    coefficients, cost = fit(conditioned(blocks(path), cutoff_hz))
    print(json.dumps({"coefficients": list(coefficients), "cost_w2": cost}))


if __name__ == "__main__":
    main()
