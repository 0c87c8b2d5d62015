#!/usr/bin/env python3
"""Writes the reference numbers of `reference.rs` into the folder `reference`.

    python3 -m venv venv && venv/bin/pip install numpy scipy
    venv/bin/python model-core/tests/reference.py

Made with Python 3.11, NumPy 2.4, SciPy 1.17. Nothing here is taken from model-core: the filter is scipy.signal's, Eq. 18
is written with the paper's matrices, the mass is found by scipy.optimize.
"""

from pathlib import Path

import numpy as np
from scipy import optimize, signal

FOLDER = Path(__file__).parent / "reference"


def write(name, header, rows):
    lines = [",".join(header)]
    lines += [",".join(repr(float(value)) for value in row) for row in rows]
    (FOLDER / name).write_text("\n".join(lines) + "\n", encoding="ascii")


def filtered(cutoff, rate, x):
    """Fifth-order Butterworth of x and the Tustin derivative of the result, both as if x[0] had been there for ever."""
    zeros, poles, gain = signal.butter(5, cutoff, fs=rate, output="zpk")
    value = signal.zpk2sos(zeros, poles, gain)
    # d/dt is 2/T (z - 1)/(z + 1), which takes one of the five zeros at -1.
    derivative = signal.zpk2sos(np.append(zeros[1:], 1.0), poles, gain * 2.0 * rate)
    out = []
    for sos in (value, derivative):
        y, _ = signal.sosfilt(sos, x, zi=signal.sosfilt_zi(sos) * x[0])
        out.append(y)
    return out


def filter_reference():
    columns = []
    for cutoff, rate in ((2.0, 200.0), (5.0, 50.0)):
        time = np.arange(1200) / rate
        x = 3.0 + signal.chirp(time, 0.1, time[-1], 0.3 * rate / 2)
        x = x + 4.0 * (time > 0.3 * time[-1]) - 7.0 * (time > 0.6 * time[-1])
        columns += [x, *filtered(cutoff, rate, x)]
    header = [f"{name}_{setting}" for setting in ("2hz_200hz", "5hz_50hz") for name in ("input", "value", "derivative")]
    write("filter.csv", header, np.transpose(columns))


def eq18(w, a, matrix, published):
    """The 15 sums of Eq. 18 at 1 kg, with the paper's delta^i (selects wheel i) and Psi^i = delta^i w / w_i."""
    sums = np.zeros(15)
    for i in range(len(w)):
        delta = np.zeros((len(w), len(w)))
        delta[i, i] = 1.0
        psi = delta @ w / w[i]
        torque = a @ matrix @ psi
        power = a @ matrix @ delta @ w
        s, r, h = np.sign(a[i] * w[i]), np.sign(power), np.sign(w[i])
        more = 2.0 if published else 1.0
        sums += [
            1, 1, 1, w[i] ** 2, (more + s) * a[i] ** 2, (more + r) * torque**2, abs(w[i]), abs(w[i]),
            (1 + s) * h * a[i], (1 + s) * h * a[i], (1 + r) * h * torque, (1 + r) * h * torque,
            (1 + s) * a[i] * w[i], (1 + r) * power, (1 + s) * (1 + r) * torque * a[i],
        ]
    return sums


def eq18_reference(rng):
    radius, track, gyration = 0.033, 0.16, 0.064
    to_twist = np.array([[radius / 2, radius / 2], [-radius / track, radius / track]])
    matrix = to_twist.T @ np.diag([1.0, gyration**2]) @ to_twist
    rows = []
    for _ in range(40):
        w, a = rng.uniform(-7, 7, 2), rng.uniform(-20, 20, 2)
        rows.append([*w, *a, *eq18(w, a, matrix, False), *eq18(w, a, matrix, True)])
    names = [f"{form}{j}" for form in ("corrected", "published") for j in range(15)]
    write("eq18.csv", ["w1", "w2", "a1", "a2", *names], rows)


def window_reference(rng):
    """Twelve windows of 40 samples with P = a d^2 + b d + c; d is sought within 2.5 kg."""
    samples, masses = [], []
    for window in range(12):
        a, b, c = rng.uniform(0, 0.02, 40), rng.uniform(0, 0.3, 40) + 0.06, rng.uniform(0, 2, 40)
        truth = rng.uniform(-2.3, 2.3)
        power = a * truth**2 + b * truth + c + rng.normal(0, 0.05, 40)

        def squares(d):
            return np.sum((a * d**2 + b * d + c - power) ** 2)

        def slope(d):
            return np.sum(2 * (2 * a * d + b) * (a * d**2 + b * d + c - power))

        # The minimum by its value, then to the last digit by its slope.
        coarse = optimize.minimize_scalar(squares, bounds=(-2.5, 2.5), method="bounded").x
        found = optimize.brentq(slope, coarse - 0.01, coarse + 0.01, xtol=1e-15)
        samples += [[window, *row] for row in zip(a, b, c, power)]
        masses.append([window, found])
    write("window_samples.csv", ["window", "a", "b", "c", "power"], samples)
    write("window_masses.csv", ["window", "d"], masses)


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    generator = np.random.default_rng(20)
    filter_reference()
    eq18_reference(generator)
    window_reference(generator)
