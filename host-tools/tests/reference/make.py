"""Reference numbers for tests/suite/reference.rs, by SciPy: filter, non-negative and nonlinear least squares.

    python3 -m venv venv && venv/bin/pip install numpy scipy && venv/bin/python make.py

writes log.csv and reference.json beside this file. Nothing here is taken from the Rust code: the filter is
scipy.signal's, the equations are Eq. 18 and the signed torque model, the kinematics is worked out by hand.
"""

import json
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares, nnls
from scipy.signal import butter, sosfilt, sosfilt_zi, zpk2sos

HERE = Path(__file__).parent
RATE, CUTOFF = 20.0, 3.0
RADIUS, TRACK, GYRATION, DEAD_BAND = 0.033, 0.16, 0.06, 0.02
# a0, a1, g2, g3, g4, kappa.
TRUTH = np.array([0.05, 0.008, 0.007, 0.0065, 1.6, 2.5])
MASSES = [1.0, 3.0, 6.0]
ROWS = 260
# Some 16 mW are left of it behind the filter: far above what the filter itself mixes up, far below the power.
NOISE_W = 0.03


def inertial(a):
    """K = M'' a: wheel torque per kilogram, from the kinetic energy of v = r (wl + wr)/2 and omega = r (wr - wl)/b."""
    v = RADIUS * (a[:, 0] + a[:, 1]) / 2
    omega = RADIUS * (a[:, 1] - a[:, 0]) / TRACK
    forward, turning = RADIUS / 2 * v, GYRATION**2 * RADIUS / TRACK * omega
    return np.stack([forward - turning, forward + turning], axis=1)


def direction(w):
    return np.where(np.abs(w) > DEAD_BAND, np.sign(w), 0.0)


def wheel_power(theta, w, a, m):
    a0, a1, g2, g3, g4, kappa = theta
    m = m[:, None]
    tau = (a0 + a1 * m) * direction(w) + g2 * w + g3 * a + g4 * m * inertial(a)
    return tau * w + kappa * tau**2


def power(theta, w, a, m):
    return np.maximum(wheel_power(theta, w, a, m), 0).sum(axis=1)


def tones(t, run):
    """Speeds and accelerations of both wheels: slow tones, another phase in every run, the second run in reverse.

    No wheel turns round and none is clamped: there the filter smears what the model has sharp, which is not noise.
    """
    wheels = [[(1.5, 0.9, 0.0), (0.9, 2.3, 0.4), (0.4, 4.1, 0.9)], [(1.3, 0.7, 0.5), (1.0, 1.9, 1.1), (0.4, 3.7, 2.0)]]
    sign = -1 if run == 1 else 1
    w = [sign * (3.2 + sum(s * np.sin(r * t + p + run) for s, r, p in wheel)) for wheel in wheels]
    a = [sign * sum(s * r * np.cos(r * t + p + run) for s, r, p in wheel) for wheel in wheels]
    return np.stack(w, axis=1), np.stack(a, axis=1)


def make_log():
    rng = np.random.default_rng(20)
    lines = ["time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg,run"]
    for run, mass in enumerate(MASSES):
        t = np.arange(ROWS) / RATE
        w, a = tones(t, run)
        p = power(TRUTH, w, a, np.full(ROWS, mass)) + rng.normal(0, NOISE_W, ROWS)
        lines += [f"{t[i]:.2f},{w[i, 0]:.6f},{w[i, 1]:.6f},{p[i]:.6f},{mass:g},{run}" for i in range(ROWS)]
    (HERE / "log.csv").write_text("\n".join(lines) + "\n")


def filtered(x, sos, gain):
    """As if the first value had been there for ever."""
    y, _ = sosfilt(sos, x, zi=sosfilt_zi(sos) * x[0]) if gain else sosfilt(sos, x - x[0], zi=0 * sosfilt_zi(sos))
    return y


def main():
    make_log()
    log = np.genfromtxt(HERE / "log.csv", delimiter=",", skip_header=1)
    low = butter(5, CUTOFF, fs=RATE, output="sos")
    # The derivative of the output by the trapezium rule: one zero at -1 becomes one at 1.
    z, p, k = butter(5, CUTOFF, fs=RATE, output="zpk")
    slope = zpk2sos(np.append(z[:4], 1.0), p, k * 2 * RATE)
    settling = int(np.ceil(2 * RATE / CUTOFF))
    w, a, power_w, mass = [], [], [], []
    for run in range(len(MASSES)):
        rows = log[log[:, 5] == run]
        speeds = [filtered(rows[:, i], low, True) for i in (1, 2)]
        rates = [filtered(rows[:, i], slope, False) for i in (1, 2)]
        w.append(np.stack(speeds, axis=1)[settling:])
        a.append(np.stack(rates, axis=1)[settling:])
        power_w.append(filtered(rows[:, 3], low, True)[settling:])
        mass.append(rows[settling:, 4])
    w, a, power_w, mass = map(np.concatenate, (w, a, power_w, mass))

    assert (np.abs(w) > DEAD_BAND).all()
    # Eq. 18, corrected: products summed over the wheels.
    k_ = inertial(a)
    m, h = mass[:, None], direction(w)
    gs, gr = 1 + np.sign(a * w), 1 + np.sign(k_ * w)
    one = np.ones_like(w)
    columns = [one, one * m, one * m**2, w**2, gs * a**2, gr * k_**2 * m**2, h * w, h * w * m, gs * h * a, gs * h * a * m,
               gr * h * k_ * m, gr * h * k_ * m**2, gs * a * w, gr * k_ * w * m, gs * gr * k_ * a * m]
    x = np.stack([column.sum(axis=1) for column in columns], axis=1)
    size = np.sqrt((x**2).mean(axis=0))
    scaled, residual = nnls(x / size, power_w)

    fit = least_squares(lambda theta: power(theta, w, a, mass) - power_w, TRUTH, bounds=(0, np.inf), x_scale=TRUTH,
                        xtol=1e-15, ftol=1e-15, gtol=1e-15)
    # Huber's limit of 4 standard deviations touches no row: its fit is the least-squares fit.
    driven = (wheel_power(fit.x, w, a, mass) >= 0).any(axis=1)
    sizes = np.abs(fit.fun[driven])
    assert sizes.max() < 4 * 1.4826 * np.median(sizes), (sizes.max(), np.median(sizes))

    shown = [0, 1, 100, 245, 246, 400, len(power_w) - 1]
    reference = {
        "filtered_rows": len(power_w),
        "filtered": [[i, *w[i], *a[i], power_w[i]] for i in shown],
        "nnls": (scaled / size).tolist(),
        "nnls_rmse_w": residual / np.sqrt(len(power_w)),
        "least_squares": fit.x.tolist(),
        "least_squares_rmse_w": float(np.sqrt((fit.fun**2).mean())),
    }
    (HERE / "reference.json").write_text(json.dumps(reference, indent=1) + "\n")
    print(json.dumps(reference, indent=1), driven.mean(), sizes.max() / (1.4826 * np.median(sizes)), np.linalg.cond(x / size))


main()
