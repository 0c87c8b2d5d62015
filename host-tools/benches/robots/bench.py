"""Our model and the others on robots that are not ours: one table.

    python bench.py --gmr PATH --data ../shared/data --work FOLDER [--json] [--every-model] [--jobs 2]

Called by `cargo xtask bench robots`. Simulated robots with known masses (our own plant, which shares the model's formula; a second
simulator; MuJoCo), and measured ones. Progress goes to standard error, the table or JSON to standard output.
"""

import argparse
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import generate
import masses
import measured
import simulated
import table
from gmr import Gmr

HERE = Path(__file__).resolve().parent
JUDGE = HERE.parent.parent / "tests" / "reference" / "gap_judge"
OWN_SEEDS = (1, 2, 3)
FOREIGN_SEEDS = (1, 2, 3)


def say(text):
    print(text, file=sys.stderr, flush=True)


def plants(gmr, work, only):
    """Groups of (name, what has to be said, sets as callables that write and return robot, training and test logs, dead band)."""
    for plant in ("servo", "table3"):
        yield f"own plant, {plant}", "shares the model's formula", [
            (lambda p=plant, s=seed: simulated.own(gmr, work / "own" / p / str(s), p, s)) for seed in OWN_SEEDS], 0.02
    for name in ("servo", "brisk"):
        yield f"gap_judge, {name}, 20 Hz", "foreign simulator", [
            (lambda n=name, s=seed: simulated.foreign(work / "foreign" / n / str(s), JUDGE, n, s)) for seed in FOREIGN_SEEDS], 0.02
    for logged in ("two-wheeled", "skid-steered", "skid-steered-clamped"):
        for rate in generate.RATES_HZ:
            yield f"MuJoCo, {logged}, {rate} Hz", "foreign simulator", [
                (lambda l=logged, n=name, r=rate: simulated.mujoco(work / "mujoco", l, n, r)) for name in generate.SETS
            ], 0.02 if logged == "two-wheeled" else 0.05


def mass_rows(gmr, work, only, jobs):
    rows = []
    for name, note, sets, dead_band in plants(gmr, work, only):
        if only and only not in name:
            continue
        say(name)

        def one(numbered):
            k, make = numbered
            robot, train, tests = make()
            return masses.set_of(gmr, robot, train, tests, work / "fits" / name.replace(", ", "-").replace(" ", "-") / str(k), dead_band)

        with ThreadPoolExecutor(jobs) as pool:
            parts = list(pool.map(one, enumerate(sets)))
        methods = {m: masses.summary([p[m] for p in parts]) for m in parts[0]}
        rows.append({"name": name, "note": note, "sets": len(parts), "methods": methods,
                     "failed": [p[m]["error"] for p in parts for m in p if "error" in p[m]]})
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gmr", required=True)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="only plants and data sets with this in their names")
    parser.add_argument("--every-model", action="store_true", help="all models on measured robots, the networks included")
    parser.add_argument("--json", action="store_true")
    a = parser.parse_args()
    gmr = Gmr(a.gmr)
    logs = a.work / "mujoco"
    if not (logs / "complete").exists():
        say("drives the MuJoCo robots")
        subprocess.run([sys.executable, HERE / "generate.py", logs, "--jobs", str(a.jobs)], check=True)
    result = {
        "masses": mass_rows(gmr, a.work, a.only, a.jobs),
        "measured": measured.rows(gmr, a.data, a.work / "measured", a.only, a.every_model, say),
    }
    print(json.dumps(result, indent=2) if a.json else table.text(result))


if __name__ == "__main__":
    main()
