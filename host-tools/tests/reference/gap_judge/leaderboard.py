"""`gmr gap` and its rivals on the same sets of the second judge, as a table:  python leaderboard.py --gmr PATH [--seeds 0 1] [--free 10] [--json]

Judged by verdicts.py. A method that names several effects names them together; the false discovery rate is the share of all names that are
not true (a twin of the truth in a tie counts as one), F1 that of the names. Trees are judged by the axes that they split on.
"""

import argparse
import json
import os
import sys
import tempfile
from multiprocessing import Pool
from pathlib import Path

import numpy as np

import batch
import rivals
import sets
from effects import DICTIONARY
from robots import ROBOTS
from verdicts import judge, twins

OURS = "gmr gap"


def one(task):
    with tempfile.TemporaryDirectory(prefix="rivals_") as name:
        folder = Path(name)
        truth = sets.make(folder, task["robot"], task["seed"], task["effect"], task["size"], task["kind"], task["memory"])
        robot = "burger" if task["robot"] == "servo" else "robot.toml"
        clean = sorted(str(path.relative_to(folder)) for path in (folder / "clean").glob("*.csv"))
        field = sorted(str(path.relative_to(folder)) for path in (folder / "field").glob("*.csv"))
        fit, _ = batch.call([task["gmr"], "fit", "--robot", robot, "--out", "base.toml", *clean], folder)
        done, _ = batch.call([task["gmr"], "gap", "--robot", robot, "--json", "--coeffs", "base.toml", *field], folder)
        if fit.returncode or done.returncode:
            return {**task, "error": (fit.stderr + done.stderr)[-400:]}
        answer = json.loads(done.stdout)
        base = ROBOTS[task["robot"]]
        shape = {"radius": base.radius, "track": base.track, "gyration": base.gyration, "static": base.static}
        answers = rivals.judge(folder, task["gmr"], robot, shape)
        answers[OURS] = {"named": [e["id"] for e in answer["effects"]], "ties": answer["ambiguous_with"],
                         "verdict": answer["verdict"], "closed": answer["gap_closed"] or 0.0}
        return {**{k: task[k] for k in ("robot", "seed", "effect", "size", "kind")}, "reached": truth["reached"], "answers": answers}


def tasks(a):
    for seed in range(*a.seeds):
        rng = np.random.default_rng([seed, 11])
        kind, memory = ("white", "ar", "heavy", "hetero")[seed % 4], float(rng.choice([0.6, 0.75, 0.9, 0.95]))
        for robot in ROBOTS:
            for effect in DICTIONARY:
                if not a.names or effect in a.names:
                    yield {"robot": robot, "seed": seed, "effect": (effect,), "size": a.size, "kind": kind, "memory": memory, "gmr": a.gmr}
    for seed in range(1000, 1000 + a.free):
        yield {"robot": list(ROBOTS)[seed % 2], "seed": seed, "effect": (), "size": 0.0, "kind": ("white", "ar", "heavy", "hetero")[seed % 4],
               "memory": 0.75, "gmr": a.gmr}


def verdict(line, answer):
    named = answer["named"]
    return judge({"effect": line["effect"], "named": named, "ties": answer.get("ties", []),
                  "verdict": answer.get("verdict", "named" if named else "none")})


def row(lines, method):
    known, free = [l for l in lines if l["effect"]], [l for l in lines if not l["effect"]]
    judged = [verdict(l, l["answers"][method]) for l in known]
    hits = names = 0
    for l in lines:
        answer = l["answers"][method]
        everything = set(answer["named"]) | set(answer.get("ties", []))
        hits += len(everything & set(l["effect"]))
        names += len({n for n in everything if n in l["effect"] or not any(twins(n, t) for t in l["effect"])})
    share = lambda *what: 100.0 * sum(j in what for j in judged) / max(len(judged), 1)
    precision, recall = hits / max(names, 1), hits / max(len(known), 1)
    return {"method": method, "sets": len(known), "right": share("right", "twins"), "in_set": share("right", "twins", "tie", "extra"),
            "wrong": share("WRONG"), "false_discovery": 100.0 * (1.0 - precision) if names else 0.0,
            "f1": 2.0 * precision * recall / max(precision + recall, 1e-12),
            "alarms": 100.0 * sum(bool(l["answers"][method]["named"]) or l["answers"][method].get("verdict") == "unexplained" for l in free) / max(len(free), 1),
            "closed": float(np.median([l["answers"][method]["closed"] for l in known])) if known else float("nan")}


def tree_row(lines):
    known = [l for l in lines if l["effect"]]
    found, wanted, said = 0, 0, 0
    for l in known:
        axes, truth = set(l["answers"]["boosted trees"]["axes"]), rivals.SHOWS[l["effect"][0]]
        found, wanted, said = found + len(axes & truth), wanted + len(truth), said + len(axes)
    precision, recall = found / max(said, 1), found / max(wanted, 1)
    return {"method": "boosted trees", "axes_f1": 2.0 * precision * recall / max(precision + recall, 1e-12),
            "closed": float(np.median([l["answers"]["boosted trees"]["closed"] for l in known]))}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gmr", required=True)
    parser.add_argument("--seeds", nargs=2, type=int, default=[0, 1])
    parser.add_argument("--size", type=float, default=1.0)
    parser.add_argument("--free", type=int, default=10)
    parser.add_argument("--names", nargs="*")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", action="store_true")
    a = parser.parse_args()
    a.gmr = os.path.abspath(a.gmr)
    lines = []
    with Pool(a.jobs) as pool:
        for count, line in enumerate(pool.imap_unordered(one, list(tasks(a))), 1):
            lines.append(line)
            if count % 10 == 0:
                print(f"{count} sets", file=sys.stderr, flush=True)
    failed = [l for l in lines if "error" in l]
    lines = [l for l in lines if "error" not in l and (not l["effect"] or l["reached"][0] >= 0.45)]
    rows, tree = [row(lines, method) for method in (OURS, "stepwise BIC", "STLSQ (pysindy)")], tree_row(lines)
    if a.json:
        print(json.dumps({"rows": [*rows, tree], "failed": len(failed), "lines": lines}))
        return
    free = sum(not l["effect"] for l in lines)
    print(f"The second judge's sets: {rows[0]['sets']} with one effect of size {a.size}, {free} without, seeds {a.seeds[0]} to {a.seeds[1] - 1}")
    print(f"{'method':18}{'right':>8}{'in set':>8}{'wrong':>8}{'false names':>13}{'F1':>6}{'alarms':>8}{'closed, locked runs':>21}")
    for r in rows:
        print(f"{r['method']:18}{r['right']:7.0f}%{r['in_set']:7.0f}%{r['wrong']:7.0f}%{r['false_discovery']:12.0f}%{r['f1']:6.2f}{r['alarms']:7.0f}%{100 * r['closed']:20.0f}%")
    print(f"{tree['method']:18}{'–':>8}{'–':>8}{'–':>8}{'–':>13}{'–':>6}{'–':>8}{100 * tree['closed']:20.0f}%   F1 of the axes {tree['axes_f1']:.2f}")
    print("closed: gmr gap's of the gap above its noise floor, the others' of the mean square, which holds the noise")
    if failed:
        print(f"{len(failed)} sets failed: {failed[0]['error'].strip().splitlines()[-1]}")


if __name__ == "__main__":
    main()
