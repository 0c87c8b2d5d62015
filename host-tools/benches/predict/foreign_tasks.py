"""Drives of the second simulator as tasks: its logs' speeds are the plan, their measured power the truth."""

import random
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import formula

HERE = Path(__file__).resolve().parent
JUDGE = HERE.parent.parent / "tests" / "reference" / "gap_judge"
# Its drives take a minute each to simulate.
ROBOT = "servo"
SEEDS = (1, 2, 3, 4)
SHARES = (0.1, 0.25, 0.4, 0.6, 0.75, 0.9)
MASS_STD = 0.03


def one(gmr, work, name, seed):
    if not list(work.glob("test_*.csv")):
        work.mkdir(parents=True, exist_ok=True)
        script = HERE.parent / "robots" / "foreign.py"
        subprocess.run([sys.executable, script, JUDGE, name, str(seed), work, *map(str, SHARES)], check=True)
    robot = work / "robot.toml" if (work / "robot.toml").exists() else "burger"
    fit, train = work / "fit.toml", sorted(work.glob("train_*.csv"))
    gmr.fit(robot, fit, train)

    def predict(log, *mass):
        return gmr.json("predict", "--robot", robot, "--coeffs", fit, "--plan", log, *mass)

    of_train = [predict(log, "--mass", log.stem.split("_")[1]) for log in train]
    friction = formula.tuned([(report, report["measured_j"]) for report in of_train])
    rng = random.Random(seed)
    tasks = []
    for log in sorted(work.glob("test_*.csv")):
        told = float(log.stem.split("_")[1]) * (1.0 + rng.gauss(0.0, MASS_STD))
        reach = 1.96 * MASS_STD * told
        report = predict(log, "--mass", f"{told:.4f}", "--mass-interval", f"{told - reach:.4f},{told + reach:.4f}")
        static = (report["static_power_w"] or 0.0) * report["duration_s"]
        tasks.append(formula.task(without(report, static), report["measured_j"] - static, friction))
    return tasks


def without(report, static):
    """The same without static energy, which is known here and would dilute the errors."""
    return {**report, **{key: report[key] - static for key in ("energy_j", "low_j", "high_j", "rmf_j")}}


def rows(gmr, work, jobs):
    with ThreadPoolExecutor(jobs) as pool:
        parts = list(pool.map(lambda seed: one(gmr, work / ROBOT / str(seed), ROBOT, seed), SEEDS))
    yield f"second simulator, {ROBOT}", [task for part in parts for task in part]
