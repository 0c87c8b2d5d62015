"""How often the 95 % interval of a named effect's size holds the true one, on the own plant:

    python gap_sizes.py --gmr PATH [--seeds 20] [--json] [--jobs 2]

Six clean and eight field runs of 60 s at 20 Hz of a gear-motor robot, with an effect of a size drawn anew in every set; noise of every run by its
seed. The truth is what `gmr simulate --effect` was told, in the unit of the world that `gmr gap` answers in. Intervals are ± 1.96 std_err.
"""

import argparse
import json
import random
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from gmr import Gmr

GRAVITY = 9.806_65
# Half the plant's wheelbase, m: the lever of a turn's scrub.
LEVER_M = 0.08
CLEAN_KG = ("1", "2", "3", "4", "5", "6")
FIELD_KG = ("1.2", "5.6", "2.4", "4.1", "3.3", "1.8", "5.0", "2.9")

# Effect, what is appended to its size, range of sizes, truth in the unit of the answer for a size.
EFFECTS = (
    ("grade", ":along=travel", (0.015, 0.05), lambda size: size),
    ("wheel-drag", ":wheel=1", (0.02, 0.06), lambda size: size),
    ("turning-scrub", "", (0.03, 0.08), lambda size: size * GRAVITY * LEVER_M),
    ("rolling-resistance-change", "", (0.008, 0.025), lambda size: size),
    ("sensor-gain", "", (0.08, 0.2), lambda size: size),
    # The answer is what readings have to be multiplied by, less one.
    ("speed-scale", ":side=left", (0.05, 0.12), lambda size: -size / (1.0 + size)),
    ("payload-mislabel", "", (0.4, 1.0), lambda size: size),
    ("sensor-delay", "", (0.08, 0.25), lambda size: size),
)


def drive(gmr, out, place, mass, seed, *more):
    gmr.json("simulate", "--plant", "gearmotor", "--sensors", "servo", "--rate", 20, "--power-noise", 0.05, "--duration", 60,
             "--profile", "test" if place % 2 else "training", "--mass", mass, "--seed", seed, *more, "--out", out)


def one(task):
    gmr, effect, seed = task
    name, more, (low, high), truth = effect
    size = random.Random(f"{name} {seed}").uniform(low, high)
    with tempfile.TemporaryDirectory(prefix="gap_sizes_") as folder:
        clean = [Path(folder) / f"clean_{k}.csv" for k in range(len(CLEAN_KG))]
        field = [Path(folder) / f"field_{k}.csv" for k in range(len(FIELD_KG))]
        for k, mass in enumerate(CLEAN_KG):
            drive(gmr, clean[k], k, mass, 1000 * seed + k)
        for k, mass in enumerate(FIELD_KG):
            drive(gmr, field[k], k, mass, 1000 * seed + 500 + k, "--effect", f"{name}={size:.5f}{more}")
        base = Path(folder) / "base.toml"
        gmr.json("fit", "--out", base, *clean)
        answer = gmr.json("gap", "--coeffs", base, *field, folder=folder)
    found = [e for e in answer["effects"] if e["id"] == name]
    if answer["verdict"] != "named" or not found:
        return {"effect": name, "seed": seed, "named": False}
    physical = found[0]["physical"] or {"value": found[0]["coefficient"], "std_err": found[0]["std_err"], "unit": found[0]["unit"]}
    return {"effect": name, "seed": seed, "named": True, "size": size, "truth": truth(size), **physical}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gmr", required=True)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", action="store_true")
    a = parser.parse_args()
    gmr = Gmr(a.gmr)
    tasks = [(gmr, effect, seed) for seed in range(1, a.seeds + 1) for effect in EFFECTS]
    rows = []
    with ThreadPoolExecutor(a.jobs) as pool:
        for row in pool.map(one, tasks):
            rows.append(row)
            if len(rows) % 20 == 0:
                print(f"{len(rows)} of {len(tasks)} sets", file=sys.stderr, flush=True)
    if a.json:
        print(json.dumps(rows, indent=2))
        return
    print(f"{'effect':28} {'named':>8} {'held':>8}   error in standard errors, root mean square;  mean error")
    total = held_all = 0
    for name, *_ in EFFECTS:
        own = [row for row in rows if row["effect"] == name]
        named = [row for row in own if row["named"]]
        z = [(row["value"] - row["truth"]) / row["std_err"] for row in named]
        held = sum(abs(value) <= 1.96 for value in z)
        total, held_all = total + len(z), held_all + held
        rms = (sum(value * value for value in z) / len(z)) ** 0.5 if z else float("nan")
        share = 100 * sum(row["value"] / row["truth"] - 1 for row in named) / len(named) if named else float("nan")
        print(f"{name:28} {len(named):3} of {len(own):2} {held:3} of {len(z):2}   {rms:5.2f}   {share:+6.1f} %")
    print(f"{'in all':28} {'':8} {held_all:3} of {total:3}  {100 * held_all / max(total, 1):.1f} %")


if __name__ == "__main__":
    main()
