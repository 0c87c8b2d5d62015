"""Makes sets, lets gmr judge them, keeps what it said: one line of JSON a set.

    python batch.py OUT.jsonl --gmr PATH [--kind effects|free|foreign|pairs] [--robots servo brisk] [--sizes 0.5 1 2]
                    [--seeds 0 4] [--names …] [--mode coeffs|alone|lost] [--jobs 2] [--keep FOLDER] [--minutes M]
                    [--count N] [--known EARLIER.jsonl …] [--hard [CONDITION …]]

`coeffs`: with base.toml of six clean runs; `alone`: no coefficients; `lost`: base.toml, but the clean runs are gone.
Sets that were answered wrongly are kept in --keep. The order is shuffled by the first seed, so that the first --count of them, and what is
done after --minutes, are a fair sample.
Earlier results spare the search for the magnitudes. `--hard`: each set has one condition of hard.py, by turns;
those that are named, or all but the ten-minute runs.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from itertools import combinations
from multiprocessing import Pool
from pathlib import Path

import numpy as np

import hard
import sets
from effects import DICTIONARY, FOREIGN, limit
from robots import ROBOTS
from sensors import NOISES
from verdicts import judge


def tasks(a):
    for seed in range(*a.seeds):
        for robot in a.robots:
            rng = np.random.default_rng([seed, 11])
            kind = a.noise or NOISES[seed % len(NOISES)]
            memory = float(rng.choice([0.6, 0.75, 0.9, 0.95]))
            if a.kind == "free":
                names = [()]
            elif a.kind == "pairs":
                every = list(combinations(DICTIONARY, 2))
                names = [every[k] for k in rng.choice(len(every), 12, replace=False)]
            else:
                names = [(n,) for n in (DICTIONARY if a.kind == "effects" else FOREIGN) if not a.names or n in a.names]
            for name in names:
                for size in a.sizes if name else [0.0]:
                    yield {"robot": robot, "seed": seed, "effect": name, "size": size, "kind": kind, "memory": memory,
                           "mode": a.mode, "gmr": a.gmr, "keep": a.keep}


def call(arguments, folder):
    start = time.time()
    done = subprocess.run(arguments, cwd=folder, capture_output=True, text=True)
    return done, time.time() - start


def run(t):
    folder = Path(tempfile.mkdtemp(prefix="judge_"))
    try:
        with hard.sampled(t["hard"]):
            truth = sets.make(folder, t["robot"], t["seed"], t["effect"], t["size"], t["kind"], t["memory"],
                              clean=t["mode"] != "alone", known=t["known"], scatter=hard.SCATTER.get(t["hard"], 0.0))
        robot = hard.apply(t["hard"], folder, "burger" if t["robot"] == "servo" else "robot.toml")
        logs = sorted(str(p.relative_to(folder)) for p in (folder / "field").glob("*.csv"))
        command = [t["gmr"], "gap", "--robot", robot, "--json"]
        if t["mode"] != "alone":
            clean = sorted(str(p.relative_to(folder)) for p in (folder / "clean").glob("*.csv"))
            fit, _ = call([t["gmr"], "fit", "--robot", robot, "--out", "base.toml", *clean], folder)
            if fit.returncode:
                return {**t, "error": fit.stderr}
            if t["mode"] == "lost":
                text = (folder / "base.toml").read_text()
                lines = [line for line in text.splitlines() if not line.startswith("logs")]
                (folder / "base.toml").write_text("\n".join(lines) + "\n")
                shutil.rmtree(folder / "clean")
            command += ["--coeffs", "base.toml"]
        return answered(t, truth, folder, [*command, *logs])
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def answered(t, truth, folder, command):
    """One line: what gmr said of the set."""
    done, seconds = call(command, folder)
    try:
        answer = json.loads(done.stdout)
    except ValueError:
        return {**t, "error": done.stderr[-400:]}
    (folder / "answer.json").write_text(done.stdout)
    (folder / "command.txt").write_text(" ".join(["gmr", *command[1:]]) + "\n")
    line = {k: t[k] for k in ("robot", "seed", "effect", "size", "kind", "memory", "mode", "hard")}
    line.update(reached=truth["reached"], magnitude=truth["magnitude"], variant=truth["variant"], seconds=seconds,
                verdict=answer["verdict"], named=[e["id"] for e in answer["effects"]],
                coefficients=[[e["id"], e["coefficient"], e["std_err"]] for e in answer["effects"]],
                details=[e["detail"] for e in answer["effects"]],
                rivals=answer["rivals"], ties=answer["ambiguous_with"], closed=answer["gap_closed"], before=answer["gap_before_w"],
                after=answer["gap_after_w"], floor=answer["noise_floor_w"],
                outcome=[[r["structure"], r["allowed"], r["outcome"]] for r in answer["rounds"]])
    if answer["rounds"]:
        # One that cannot be has no gain.
        some = [c for c in answer["rounds"][0]["candidates"] if c["gain"] is not None]
        best = sorted(some, key=lambda c: -c["gain"])[:6]
        line["best"] = [[c["id"], round(c["gain"], 1), c["status"]] for c in best]
    line["judged"] = judge(line)
    if t["keep"] and line["judged"] in ("WRONG", "alarm", "extra", "missed-name"):
        label = "+".join(t["effect"]) or "free"
        place = Path(t["keep"]) / f"{t['mode']}_{t['robot']}_{label}_{t['size']}_{t['seed']}"
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(folder, place)
    return line


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("--gmr", required=True)
    parser.add_argument("--kind", choices=["effects", "free", "foreign", "pairs"], default="effects")
    parser.add_argument("--robots", nargs="+", default=["servo", "brisk"])
    parser.add_argument("--sizes", nargs="+", type=float, default=[0.5, 1.0, 2.0])
    parser.add_argument("--seeds", nargs=2, type=int, default=[0, 4])
    parser.add_argument("--names", nargs="*")
    parser.add_argument("--noise", choices=NOISES)
    parser.add_argument("--mode", choices=["coeffs", "alone", "lost"], default="coeffs")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep")
    parser.add_argument("--known", nargs="*", default=[])
    parser.add_argument("--minutes", type=float)
    parser.add_argument("--hard", nargs="*", choices=[*hard.CONDITIONS, *hard.LASTING])
    parser.add_argument("--count", type=int, help="no more sets than so many")
    a = parser.parse_args()
    a.gmr = os.path.abspath(a.gmr)
    known = {}
    for name in a.known:
        for line in map(json.loads, open(name)):
            for effect, x, got in zip(line.get("effect", []), line.get("magnitude", []), line.get("reached", [])):
                if x <= limit(effect, ROBOTS[line["robot"]]):
                    known[line["robot"], line["seed"], effect, line["size"]] = (x, got)
    todo = list(tasks(a))
    todo = [todo[k] for k in np.random.default_rng(a.seeds[0]).permutation(len(todo))[: a.count]]
    conditions = a.hard or hard.CONDITIONS
    for place, t in enumerate(todo):
        t["hard"] = None if a.hard is None else conditions[place % len(conditions)]
        found = [known.get((t["robot"], t["seed"], name, t["size"])) for name in t["effect"]]
        t["known"] = found if all(found) else None
    start = time.time()
    with Pool(a.jobs) as pool, open(a.out, "a") as out:
        for count, line in enumerate(pool.imap_unordered(run, todo), 1):
            out.write(json.dumps(line) + "\n")
            out.flush()
            if a.minutes and time.time() - start > 60.0 * a.minutes:
                pool.terminate()
                break
            if count % 20 == 0:
                print(f"{count} of {len(todo)} sets, {time.time() - start:.0f} s", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
