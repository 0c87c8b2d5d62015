"""Reference numbers for tests/suite/baselines_reference.rs and the unit tests of quann and network.

    python3 -m venv venv && venv/bin/pip install numpy scipy scikit-learn && venv/bin/python make.py

writes log.csv and reference.json beside this file. Nothing here is taken from the Rust code: kinematics and motors are worked
out in drive.py, least squares are NumPy's and SciPy's, what learns recursively there is a batch here.
"""

import json
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares, lsq_linear

import drive
import friction
import learned

HERE = Path(__file__).parent
MEMORY_S, SEGMENT_S = 60.0, 10.0


def gates(rate, speed):
    return [np.where(rate > 0, rate, 0) * speed, np.where(rate < 0, rate, 0) * speed]


def regressions(c):
    """Columns of each regression, by its equation."""
    one = np.ones_like(c["v"])
    sin = np.sin(c["pitch_rad"])
    motion = [one, c["v"], *gates(c["dv"], c["v"]), c["omega"], *gates(c["domega"], c["omega"])]
    commands = [(c["cmd_v"] + arm * c["cmd_omega"]) / drive.RADIUS for arm in (-drive.TRACK / 2, drive.TRACK / 2)]
    x = [*commands, c["wl"], c["wr"]]
    sides = np.abs(drive.RADIUS * c["wl"]) + np.abs(drive.RADIUS * c["wr"])
    return {
        "mei": [one, abs(c["v"])],
        "jaiem": [one, abs(c["v"]), c["v"] ** 2],
        "parasuraman": [one, abs(c["v"]), c["mass_kg"]],
        "leng": [*motion, *gates(sin, c["v"])],
        "linear": [*motion, c["mass_kg"]],
        # 1 kg is the Burger's mass without payload.
        "effati": [sides, drive.G * drive.TRACK / 2 * abs(c["omega"])],
        "liu-linear": [one, *map(abs, x)],
        "liu-polynomial": [one, *map(abs, x), *(x[i] * x[j] for i in range(4) for j in range(i, 4))],
    }


def longitudinal(c):
    climb = c["dv"] + drive.G * np.sin(c["pitch_rad"])
    return np.column_stack([np.ones_like(c["v"]), abs(c["v"]) * np.cos(c["pitch_rad"]), climb * c["v"]])


def skid(c):
    left, right = drive.RADIUS * c["wl"], drive.RADIUS * c["wr"]
    return np.column_stack([np.ones_like(left), abs(left) + abs(right), abs(right - left)])


def recursive(x, y, time):
    """What exponentially weighted least squares of all rows before a row predict for it, solved anew at each row.

    All training rows weigh alike and together no more than a memory; from row to row of the drive all that is known loses
    exp(-dt/memory). A weight of 1e-6 at 0 holds what nothing tells.
    """
    n = drive.TRAINING
    training_s = 3 * (drive.ROWS - 1) * drive.PERIOD_S
    start = min(1.0, MEMORY_S / training_s)
    predicted = []
    for row in range(n, len(y)):
        last = time[max(row - 1, n)]
        kept = start * np.exp(-(last - time[n]) / MEMORY_S)
        weight = np.concatenate([np.full(n, kept), np.exp(-(last - time[n:row]) / MEMORY_S)])
        root = np.sqrt(weight)
        held = np.sqrt(kept * 1e-6) * np.eye(3)
        rows, powers = np.vstack([x[:row] * root[:, None], held]), np.append(y[:row] * root, np.zeros(3))
        theta = np.linalg.lstsq(rows, powers, rcond=None)[0]
        predicted.append(x[row] @ theta)
    return predicted


def bayesian(x, y, time, run):
    """The posterior mean in closed form, (S⁻¹ + XᵀX/s²)⁻¹ (S⁻¹ mu + Xᵀy/s²), and what it predicts for the next row.

    The prior is the spread of one estimate a segment of 10 s, each drawn to the estimate of all by a hundredth of the mean
    information of a segment and 1e-6.
    """
    n = drive.TRAINING
    pooled = np.linalg.lstsq(x[:n], y[:n], rcond=None)[0]
    parts = [np.flatnonzero((run[:n] == r) & (np.floor(time[:n] / SEGMENT_S) == s)) for r in range(3) for s in range(3)]
    pull = 0.01 * x[:n].T @ x[:n] / len(parts) + 1e-6 * np.eye(3)
    drawn = [np.linalg.solve(pull + x[p].T @ x[p], pull @ pooled + x[p].T @ y[p]) for p in parts]
    squares = sum(((y[p] - x[p] @ theta) ** 2).sum() for p, theta in zip(parts, drawn))
    variance = squares / (n - 3 * len(parts))
    mean, precision = np.mean(drawn, axis=0), np.linalg.inv(np.cov(np.array(drawn).T))
    predicted = []
    for row in range(n, len(y)):
        seen, power = x[n:row], y[n:row]
        theta = np.linalg.solve(precision + seen.T @ seen / variance, precision @ mean + seen.T @ power / variance)
        predicted.append(x[row] @ theta)
    return mean.tolist(), predicted


def known_dynamics(c):
    """Jaramillo's constants R/Kt², c0, c1, b, J and g with bounds at 0; standard errors from the Jacobian."""
    k = drive.inertial(c["al"], c["ar"], drive.RADIUS, drive.TRACK, drive.GYRATION)

    def power(theta):
        heat, coulomb, rolling, viscous, rotor, load = theta
        total = 0.0
        for w, a, k_ in ((c["wl"], c["al"], k[0]), (c["wr"], c["ar"], k[1])):
            torque = (coulomb + rolling * c["mass_kg"]) * np.sign(w) + viscous * w + rotor * a + load * c["mass_kg"] * k_
            total = total + drive.motor(torque, w, heat, 1.0)
        return total

    coulomb, rolling, viscous, resistance, constant = drive.SMOOTH
    truth = np.array([resistance / constant**2, coulomb, rolling, viscous, drive.ROTOR, drive.LOAD])
    # From elsewhere than the truth, and every constant in units of its own size.
    fit = least_squares(lambda theta: power(theta) - c["level_w"], 1.5 * truth, bounds=(0, np.inf), x_scale=truth, xtol=1e-15,
                        ftol=1e-15, gtol=1e-15, max_nfev=10000)
    covariance = np.linalg.inv(fit.jac.T @ fit.jac) * (fit.fun**2).sum() / (len(fit.fun) - len(truth))
    return {"constants": fit.x.tolist(), "standard_errors": np.sqrt(np.diag(covariance)).tolist(),
            "rmse_w": float(np.sqrt((fit.fun**2).mean())), "truth": truth.tolist()}


def physics(c, radius, track, gyration):
    """Columns of the physics-based models."""
    (v, omega), (dv, domega) = drive.body(c["wl"], c["wr"], radius, track), drive.body(c["al"], c["ar"], radius, track)
    w = np.stack([c["wl"], c["wr"]])
    k = np.stack(drive.inertial(c["al"], c["ar"], radius, track, gyration))
    return [np.where(v * dv > 0, v * dv, 0), np.where(omega * domega > 0, omega * domega, 0), abs(w).sum(axis=0),
            (w**2).sum(axis=0), (w != 0).sum(axis=0), (k * np.sign(w)).sum(axis=0),
            (k**2).sum(axis=0), abs(w[1] - w[0]), 2 * (omega != 0), drive.G * v * np.sin(c["pitch_rad"])]


def bounded(columns, y):
    """Least squares with every constant at least 0, by an active set; and the condition of the columns of unit size."""
    x = np.column_stack(columns)
    size = np.sqrt((x**2).mean(axis=0))
    fit = lsq_linear(x / size, y, bounds=(0, np.inf), method="bvls", tol=1e-15)
    print("condition", np.linalg.cond(x / size), "at the bound:", np.flatnonzero(fit.active_mask), fit.x)
    return (fit.x / size).tolist()


def main():
    log = drive.make()
    with (HERE / "log.csv").open("w") as file:
        print(",".join(drive.COLUMNS), file=file)
        for row in log:
            print(",".join(f"{value:g}" if value == int(value) else f"{value:.6f}" for value in row), file=file)
    c = dict(zip(drive.COLUMNS, log.T))
    c["v"], c["omega"] = drive.body(c["wl"], c["wr"], drive.RADIUS, drive.TRACK)
    c["dv"], c["domega"] = drive.body(c["al"], c["ar"], drive.RADIUS, drive.TRACK)
    known, road = slice(0, drive.TRAINING), c["road_w"]
    training = {name: column[known] for name, column in c.items()}
    reference = {"regressions": {}}
    for name, columns in regressions(c).items():
        x = np.column_stack(columns)
        found = np.linalg.lstsq(x[known], road[known], rcond=None)[0]
        size = np.sqrt((x[known] ** 2).mean(axis=0))
        print(name, "condition", np.linalg.cond(x[known] / size))
        reference["regressions"][name] = {"coefficients": found.tolist(), "predicted": (x[drive.TRAINING:] @ found).tolist()}
    reference["sadrpour-rls"] = recursive(longitudinal(c), road, c["time_s"])
    reference["pentzer"] = recursive(skid(c), road, c["time_s"])
    mean, predicted = bayesian(longitudinal(c), road, c["time_s"], c["run"])
    reference["sadrpour-bayes"] = {"prior_mean": mean, "predicted": predicted}
    reference["jaramillo"] = known_dynamics(training)
    burger = physics(training, drive.RADIUS, drive.TRACK, drive.GYRATION)
    reference["wahab"] = bounded(burger[:7], training["physics_w"])
    reference["touzout"] = bounded(burger[:4], training["physics_w"])
    husky = physics(training, drive.SKID_RADIUS, drive.SKID_TRACK, drive.SKID_GYRATION)
    reference["dogru"] = bounded(husky, training["skid_w"])
    reference["lugre"] = friction.reference()
    reference["process"] = learned.process()
    reference["network"] = learned.network()
    reference["perceptron_r2"] = learned.perceptron(log)
    print("perceptron", reference["perceptron_r2"], reference["jaramillo"])
    text = ",\n".join(f"{json.dumps(name)}: {json.dumps(value)}" for name, value in reference.items())
    (HERE / "reference.json").write_text("{" + text + "}\n")


main()
