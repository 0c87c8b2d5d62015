"""The gap workflow on two floors of a measured Husky: what it names between them, and within each.

    python floors.py --gmr PATH --data ../shared/data [--halves 29] [--json] [--jobs 2]

Between floors the floor's own effects are the truth: rolling resistance, or how a skid-steered robot's wheels scrub on it. Within a floor,
odd against even runs and random halves, nothing has changed: a name is false. Power is computed from measured currents.
"""

import argparse
import json
import random
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from gmr import Failed, Gmr

FLOORS = ("flooring", "sandy_loam")
MASS_KG = 75
# What another floor is: a share of the rolling resistance, a torque of the turn, or load on the gear that goes with both.
OF_A_FLOOR = ("rolling-resistance-change", "turning-scrub")


def pairs(data, halves):
    """(name, truth, base runs, field runs)."""
    runs = {floor: sorted((data / "husky-currents").resolve().glob(f"{floor}_*.csv")) for floor in FLOORS}
    first, second = FLOORS
    yield f"{first} to {second}", OF_A_FLOOR, runs[first], runs[second]
    yield f"{second} to {first}", OF_A_FLOOR, runs[second], runs[first]
    for floor, logs in runs.items():
        yield f"{floor}, even and odd runs", (), logs[::2], logs[1::2]
        for seed in range(halves):
            order = random.Random(f"{floor} {seed}").sample(logs, len(logs))
            yield f"{floor}, halves {seed}", (), sorted(order[::2]), sorted(order[1::2])


def ask(gmr, folder, base, field):
    """Names of one effect, names of a tie, and the verdict."""
    coefficients = Path(folder) / "base.toml"
    gmr.fit("husky", coefficients, base, "--mass", MASS_KG)
    answer = gmr.json("gap", "--robot", "husky", "--coeffs", coefficients, "--mass", MASS_KG, *field, folder=folder)
    names = [effect["id"] for effect in answer["effects"]]
    return {"verdict": answer["verdict"], "names": names, "tied": answer["ambiguous_with"],
            **{key: answer[key] for key in ("gap_before_w", "gap_after_w", "noise_floor_w")}}


def judge(truth, found):
    """A single name is wrong where nothing changed, or another thing did; of a tie only that the truth is in it."""
    everything = {*found["names"], *found["tied"]}
    if not everything:
        return "no name"
    if found["verdict"] == "ambiguous":
        return "in the tie" if everything & {*truth} else "false tie"
    return "right" if {*found["names"]} <= {*truth} else "wrong"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gmr", required=True)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--halves", type=int, default=29)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", action="store_true")
    a = parser.parse_args()
    gmr = Gmr(a.gmr)

    def one(pair):
        name, truth, base, field = pair
        with tempfile.TemporaryDirectory(prefix="floors_") as folder:
            try:
                found = ask(gmr, folder, base, field)
            except Failed as error:
                found = {"error": str(error)}
        print(name, file=sys.stderr, flush=True)
        return {"pair": name, "judged": "failed" if "error" in found else judge(truth, found), **found}

    with ThreadPoolExecutor(a.jobs) as pool:
        rows = list(pool.map(one, pairs(a.data, a.halves)))
    if a.json:
        print(json.dumps(rows, indent=2))
        return
    for row in rows:
        if "error" in row:
            print(f"{row['pair']:28} failed: {row['error']}")
            continue
        gap = f"{row['gap_before_w']:5.1f} -> {row['gap_after_w']:5.1f} W (floor {row['noise_floor_w']:5.1f})"
        print(f"{row['pair']:28} {row['judged']:10} {row['verdict']:12} {gap}  {', '.join(row['names'])}"
              + (f"; or {', '.join(row['tied'])}" if row["tied"] else ""))

if __name__ == "__main__":
    main()
