"""Power on measured robots: blocks of 5 s and whole runs held out, every model on the same split."""

import shutil
from pathlib import Path

import least_squares
from gmr import Failed, shifted

BLOCK_S = 5.0
FOLDS = 3

# Name, robot, logs (below the data folder), options, what has to be said of it.
SETS = (
    ("Husky, flooring", "husky", "husky-currents/flooring_*.csv", ("--mass", "75"), "power computed from currents"),
    ("Husky, sandy loam", "husky", "husky-currents/sandy_loam_*.csv", ("--mass", "75"), "power computed from currents"),
    ("Warthog", "warthog", "warthog/drive.csv", ("--mass", "470"), "one run of 52 s"),
)
MODELS = ("signed", "eq18-published", "linear", "mlp", "pentzer", "sadrpour-rls", "sadrpour-bayes", "yao")


def rows(gmr, data, work, only, every_model, say):
    """One dictionary a data set; `None` where the data are not there."""
    if not data.is_dir():
        return None
    return [one(gmr, work / name.replace(", ", "-").replace(" ", "-"), name, robot, sorted(data.glob(logs)), options, note, every_model, say)
            for name, robot, logs, options, note in SETS if only in name]


def one(gmr, work, name, robot, logs, options, note, every_model, say):
    say(name)
    work.mkdir(parents=True, exist_ok=True)
    more = list(options) if every_model else [*options, "--models", ",".join(MODELS)]
    blocks, runs = [], []
    for k in range(FOLDS):
        copies = [shifted(log, work / f"shift{k}", k * BLOCK_S) for log in logs]
        blocks.append(scores(gmr, robot, copies, (), [*more, "--block", BLOCK_S]))
        shutil.rmtree(work / f"shift{k}")
        if len(logs) >= FOLDS:
            test = logs[k::FOLDS]
            runs.append(scores(gmr, robot, [log for log in logs if log not in test], test, [*more, "--adapt"]))
    result = {"name": name, "note": note, "blocks": blocks, "runs": runs}
    result["training"] = training(gmr, work, robot, logs, options)
    return result


def scores(gmr, robot, train, test, more):
    try:
        answer = gmr.compare(robot, train, test, *more)
    except Failed as error:
        return {"error": str(error)}
    return {m["name"]: {k: m.get(k) for k in ("r2", "mass", "horizon", "horizon_s", "rmse_w")} for m in answer["models"]}


def training(gmr, work, robot, logs, options):
    """R² of the fit on all its logs, beside an independent least squares of the same form."""
    coefficients = work / "fit.toml"
    try:
        fit = gmr.fit(robot, coefficients, logs, "--starts", str(least_squares.STARTS), *options)
    except Failed as error:
        return {"error": str(error)}
    return {**least_squares.beside(fit, coefficients, logs), "restarts": fit["restarts"]}
