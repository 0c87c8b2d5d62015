"""The mass nobody told: two training masses, six between them, windows of 25 s; power with the mass that was found."""

import numpy as np

from gmr import Failed

WINDOW_S = 25
METHODS = (
    ("signed", ("--model", "signed"), ()),
    ("eq18-published, roots", ("--model", "eq18-published"), ("--payload", "roots")),
)
# A window counts where the robot moves for this share of it.
MOVING = 0.8


def moving_share(log, dead_band):
    """Share of each second in which a wheel turns."""
    with open(log) as file:
        names = file.readline().strip().split(",")
    values = np.genfromtxt(log, delimiter=",", skip_header=1)
    wheels = [k for k, n in enumerate(names) if n.startswith("wheel") and n.endswith("_rad_s")]
    turns = np.abs(values[:, wheels]).max(axis=1) > dead_band
    second = np.floor(values[:, names.index("time_s")] - 1e-9).astype(int).clip(0)
    return np.bincount(second, turns) / np.maximum(np.bincount(second), 1)


def set_of(gmr, robot, train, tests, work, dead_band=0.02):
    """One row a method; tests: (mass, log)."""
    work.mkdir(parents=True, exist_ok=True)
    return {name: method(gmr, robot, train, tests, work / f"{k}.toml", fit, estimate, dead_band)
            for k, (name, fit, estimate) in enumerate(METHODS)}


def method(gmr, robot, train, tests, out, fit_options, estimate_options, dead_band):
    try:
        fit = gmr.fit(robot, out, train, *fit_options)
    except Failed as error:
        return {"error": str(error)}
    errors, inside, unknown, r2 = [], [], 0, []
    for mass, log in tests:
        answer = gmr.estimate(robot, out, log, "--window", WINDOW_S, *estimate_options)
        share = moving_share(log, dead_band)
        if answer["r2"] is not None:
            r2.append(answer["r2"])
        for w in answer["windows"]:
            if share[int(w["t0_s"]):int(np.ceil(w["t1_s"]))].sum() < MOVING * WINDOW_S:
                continue
            if w.get("mass_kg") is None:
                unknown += 1
                continue
            errors.append(100.0 * (w["mass_kg"] / mass - 1.0))
            low, high = w.get("low_kg"), w.get("high_kg")
            inside.append(low is not None and low - 1e-9 <= mass <= high + 1e-9)
    return {"errors_percent": errors, "inside": inside, "unknown": unknown, "r2": r2, "training_r2": fit["r2"]}


def summary(parts):
    """Over sets: mean and worst error (%), bias, coverage (%), mean R², windows."""
    parts = [p for p in parts if "error" not in p]
    errors = np.array([e for p in parts for e in p["errors_percent"]])
    if not len(errors):
        return None
    return {
        "mean_percent": float(np.abs(errors).mean()), "worst_percent": float(np.abs(errors).max()),
        "bias_percent": float(errors.mean()), "inside_percent": 100.0 * float(np.mean([i for p in parts for i in p["inside"]])),
        "r2": float(np.mean([r for p in parts for r in p["r2"]])), "windows": len(errors),
        "unknown": int(sum(p["unknown"] for p in parts)),
    }
