"""Mass and energy on robots that are not ours, by kind of driving and by sensors: one table.

    python bench.py --gmr PATH --work FOLDER [--seed 1] [--sets 1] [--jobs 2] [--json]

Called by `cargo xtask bench kinds`. Two MuJoCo robots and the second simulator (tests/reference/gap_judge), none of which shares a formula with
gmr: fitted to a mixed drive of the empty and of the full robot, then driven in six kinds at three masses between, each seen by six sensor
chains. Windows of 25 s in which the robot moves for 30 % of the time at least. Drives are kept in the folder; logs are not.
"""

import argparse
import json
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "robots"))

import chains
import kinds
import recursive
import tables
import truth
from gmr import Gmr

TRAIN_S, TEST_S, WINDOW_S = 120.0, 75.0, 25
SHARES = (0.2, 0.5, 0.8)
# Masses for the slope of the true power differ by this share.
APART = 0.02
# A window counts where the robot moves for this share of it.
MOVING = 0.3
PAPER, OURS, RECURSIVE = "paper", "ours", "recursive"


def test_drives(robot, seed, work):
    """(kind, mass, drive, the same of a slightly heavier robot)."""
    for number, kind in enumerate(kinds.KINDS):
        for place, share in enumerate(SHARES):
            mass = round(robot.empty + share * (robot.full - robot.empty), 3)
            reference = kinds.reference(robot, kind, TEST_S, np.random.default_rng([seed, number, place]))
            name = f"{kind}_{mass:g}"
            pair = [truth.drive(robot, m, reference, work / f"{name}{more}.npz") for m, more in ((mass, ""), (mass * (1.0 + APART), "_more"))]
            yield kind, mass, *pair


def training(robot, seed, work):
    for number, mass in enumerate((robot.empty, robot.full)):
        reference = kinds.reference(robot, "mixed", TRAIN_S, np.random.default_rng([seed, 100, number]))
        yield mass, truth.drive(robot, mass, reference, work / f"train_{mass:g}.npz")



def moves(robot, drive):
    """Share of each second in which a wheel turns."""
    turns = np.abs(np.diff(drive.angle, axis=0, prepend=0.0)).max(axis=1) * kinds.RATE_HZ > robot.dead_band
    return turns[: len(turns) // kinds.RATE_HZ * kinds.RATE_HZ].reshape(-1, kinds.RATE_HZ).mean(axis=1)


def one(task):
    """All of one robot behind one chain: rows of figures, one a window and method, and one an energy."""
    program, robot, chain, seed, work = task
    gmr, work = Gmr(program), work / robot.name.replace(" ", "-") / str(seed)
    rng = np.random.default_rng([seed, chains.CHAINS.index(chain), len(robot.name)])
    rows, energies = [], []
    with tempfile.TemporaryDirectory(prefix="kinds_") as name:
        folder = Path(name)
        description = truth.robot_file(robot, folder)
        train = []
        for mass, drive in training(robot, seed, work):
            train.append((mass, chains.log(folder / f"train_{mass:g}.csv", chain, robot, drive, mass, rng)))
        logs = [path for _, path in train]
        gmr.fit(description, folder / "ours.toml", logs)
        gmr.fit(description, folder / "paper.toml", logs, "--model", "eq18-published")
        weights = recursive.fit(robot, train)
        for kind, mass, drive, heavier in test_drives(robot, seed, work):
            log = chains.log(folder / "test.csv", chain, robot, drive, mass, rng)
            share = moves(robot, drive)
            slope = (heavier.power - drive.power) / (APART * mass)
            labels = {"robot": robot.name, "chain": chain.name, "kind": kind, "truth": mass}
            answers = {}
            for method, options in ((OURS, ()), (PAPER, ("--payload", "roots"))):
                answers[method] = gmr.estimate(description, folder / f"{method}.toml", log, "--window", WINDOW_S, *options)
            counted = [w for w in answers[OURS]["windows"]
                       if share[int(w["t0_s"]) : int(np.ceil(w["t1_s"]))].sum() >= MOVING * WINDOW_S]
            ends = [w["t1_s"] for w in counted]
            for method, answer in answers.items():
                for w in answer["windows"]:
                    if w["t1_s"] in ends:
                        rows.append({**labels, "method": method, "mass": w["mass_kg"], "low": w["low_kg"], "high": w["high_kg"]})
            for found, half in recursive.masses(robot, weights, log, ends, WINDOW_S):
                rows.append({**labels, "method": RECURSIVE, "mass": found, "low": found - half, "high": found + half})
            for end in ends:
                part = slope[int((end - WINDOW_S) * kinds.RATE_HZ) : int(end * kinds.RATE_HZ)]
                rows.append({**labels, "method": "bound", "mass": mass + 1.0 / np.sqrt(chains.information(chain, robot, part)), "low": None,
                             "high": None})
            plan = truth.plan(robot, drive, folder / "plan.csv")
            report = gmr.json("predict", "--robot", description, "--coeffs", folder / "ours.toml", "--plan", plan, "--mass", f"{mass:g}")
            joules = float(np.sum(drive.power if robot.regenerative else np.maximum(drive.power, 0.0))) / kinds.RATE_HZ
            energies.append({**labels, "energy": report["driving_j"], "low": report["low_j"], "high": report["high_j"], "joules": joules})
    return rows, energies


def say(text):
    print(text, file=sys.stderr, flush=True)


def prepare(task):
    """Drives what is not there yet."""
    robot, seed, work = task
    work = work / robot.name.replace(" ", "-") / str(seed)
    return len(list(training(robot, seed, work))) + len(list(test_drives(robot, seed, work)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gmr", required=True)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=1, help="the first")
    parser.add_argument("--sets", type=int, default=1, help="so many seeds")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="robots, or robot/chain, with this in their names")
    parser.add_argument("--json", type=Path, help="the single figures too, into this file")
    a = parser.parse_args()
    seeds = range(a.seed, a.seed + a.sets)
    tasks = [(a.gmr, robot, chain, seed, a.work) for seed in seeds for robot in truth.ROBOTS for chain in chains.CHAINS
             if a.only in f"{robot.name}/{chain.name}"]
    rows, energies = [], []
    with ProcessPoolExecutor(a.jobs) as pool:
        driven = dict.fromkeys((robot, seed, work) for _, robot, _, seed, work in tasks)
        for (robot, seed, _), count in zip(driven, pool.map(prepare, driven)):
            say(f"{robot.name}, seed {seed}: {count} drives")
        for (_, robot, chain, seed, _), (found, joules) in zip(tasks, pool.map(one, tasks)):
            say(f"{robot.name}, {chain.name}, seed {seed}: {sum(row['method'] == OURS for row in found)} windows")
            rows += found
            energies += joules
    if a.json:
        a.json.write_text(json.dumps({"rows": rows, "energies": energies}))
    print(tables.text(rows, energies, seeds))


if __name__ == "__main__":
    main()
