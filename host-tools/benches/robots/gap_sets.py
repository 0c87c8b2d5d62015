"""Sets for the gap workflow on the MuJoCo robots: six clean runs, ten in the field with an effect or none; and gmr's answer.

    python gap_sets.py OUT.jsonl --gmr PATH --work FOLDER [--free 100] [--free-other 25] [--robots …] [--effects … | --foreign]
                       [--seeds 1 6] [--jobs 2]

One line of JSON a set, as tests/reference/gap_judge/tally.py reads it. Sets without effect draw their drives from those of all
seeds and get sensor noise of their own, some of another kind.
"""

import argparse
import json
import shutil
import time
from multiprocessing import Pool
from pathlib import Path

import numpy as np

import drives
import generate
import sensors
import simulate
import gap_foreign
from gap_effects import EFFECTS, ONLY_LOGGED, Scene
from gap_foreign import FOREIGN
from gmr import Failed, Gmr
from plants import PLANTS, Load, xml

CLEAN, FIELD, RUN_S, RATE_HZ = 6, 10, 45.0, 20
# Of the sensor's noise; the first where nothing else is said.
KINDS = ("memory", "white", "heavy-tailed", "heteroscedastic")
CLEAN_SHARES = (0.0, 1.0, 0.5, 0.0, 1.0, 0.3)


def scene(plant, seed, place, clean):
    rng = np.random.default_rng([seed, place, int(clean), 1])
    share = CLEAN_SHARES[place] if clean else (place + rng.random()) / FIELD
    mass = round(plant.empty + share * (plant.full - plant.empty), 2)
    return Scene(plant, mass, RUN_S, Load(mass - plant.empty, box=0.3 * plant.length), noted=mass)


def affected(plant, seed, place, effect):
    """A field run's scene with an effect; None for none."""
    s = scene(plant, seed, place, False)
    if effect:
        # Sets of an effect stay as they are, whatever else there is.
        number = sorted(EFFECTS).index(effect) if effect in EFFECTS else 100 + sorted(FOREIGN).index(effect)
        common = np.random.default_rng([seed, number, 2])
        size = common.uniform(0.6, 1.6)
        (EFFECTS | FOREIGN)[effect](s, size, common, np.random.default_rng([seed, number, place, 3]))
    return s


def driven(records, plant, seed, place, clean, effect):
    """The simulated drive, from the folder of records where it is there."""
    bare = None if effect in ONLY_LOGGED | gap_foreign.ONLY_LOGGED else effect
    path = records / f"{plant.name}_{seed}_{'clean' if clean else 'field'}{place}_{bare or 'none'}.npz"
    if path.exists():
        kept = np.load(path)
        return simulate.Record(kept["time"], kept["angle"], kept["power"], None, None, {})
    s = scene(plant, seed, place, True) if clean else affected(plant, seed, place, bare)
    reference = drives.reference(plant, RUN_S, np.random.default_rng([seed, place, int(clean), 4]))
    model = xml(plant, s.load, s.ground, slope=s.slope, slope_heading=s.heading)
    record = simulate.run(plant, model, reference, s.changes)
    records.mkdir(parents=True, exist_ok=True)
    np.savez(path, time=record.time, angle=record.angle, power=record.power)
    return record


def write(folder, records, plant, seed, effect, number, kind=KINDS[0], seeds=(1, 6)):
    """clean/*.csv, field/*.csv; `number` parts the noise of sets that share drives."""
    for name, count in (("clean", CLEAN), ("field", FIELD)):
        (folder / name).mkdir(parents=True)
        for place in range(count):
            clean = name == "clean"
            rng = np.random.default_rng([seed, number, place, int(clean), 5])
            # Sets without effect: any drive of any seed.
            of = seed if clean or effect else int(rng.integers(*seeds))
            at = place if clean or effect else int(rng.integers(FIELD))
            s = scene(plant, of, at, True) if clean else affected(plant, of, at, effect)
            record = driven(records, plant, of, at, clean, effect)
            sensors.log(folder / name / f"{place:02}.csv", plant, record, s.noted, rng, RATE_HZ, faults=s.faults, kind=kind)


def run(task):
    gmr, work, robot, seed, effect, number, kind, seeds = task
    plant = PLANTS[robot]
    folder = work / "sets" / f"{robot}_{effect or 'free'}_{seed}_{number}"
    shutil.rmtree(folder, ignore_errors=True)
    line = {"robot": robot, "seed": seed, "effect": [effect] if effect else [], "size": 1.0, "reached": [1.0], "magnitude": [], "variant": 0,
            "kind": kind, "memory": 0.9, "mode": "mujoco", "number": number}
    try:
        write(folder, work / "records", plant, seed, effect, number, kind, seeds)
        toml = f"{generate.LOGGED[robot][-1]}.toml"
        generate.robot_file(folder, toml[:-5], plant)
        base = folder / "base.toml"
        gmr.fit(folder / toml, base, sorted((folder / "clean").glob("*.csv")))
        logs = sorted((folder / "field").glob("*.csv"))
        start = time.time()
        answer = gmr.json("gap", "--robot", folder / toml, "--coeffs", base, *logs, folder=folder)
        effects = answer["effects"]
        return {**line, "verdict": answer["verdict"], "named": [e["id"] for e in effects],
                "ties": answer["ambiguous_with"], "rivals": answer["rivals"],
                "coefficients": [[e["id"], e["coefficient"], e["std_err"]] for e in effects],
                "closed": answer["gap_closed"], "before": answer["gap_before_w"], "after": answer["gap_after_w"],
                "floor": answer["noise_floor_w"], "outcome": [], "seconds": time.time() - start}
    except Failed as error:
        return {**line, "error": str(error)}
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--gmr", required=True)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--free", type=int, default=100, help="sets without effect, a robot")
    parser.add_argument("--free-other", type=int, default=25, help="the same in each other kind of noise")
    parser.add_argument("--robots", nargs="+", default=list(PLANTS))
    parser.add_argument("--effects", nargs="+", default=list(EFFECTS))
    parser.add_argument("--foreign", action="store_true", help="causes that the dictionary lacks in the place of effects")
    parser.add_argument("--seeds", nargs=2, type=int, default=[1, 6])
    parser.add_argument("--jobs", type=int, default=2)
    a = parser.parse_args()
    gmr, work = Gmr(a.gmr), a.work.resolve()
    a.effects = list(FOREIGN) if a.foreign else a.effects
    first, end = a.seeds
    count = end - first
    todo = []
    for robot in a.robots:
        for seed in range(first, end):
            todo += [(gmr, work, robot, seed, effect, 0, KINDS[0], a.seeds) for effect in a.effects]
            # Before others need them: the drives without effect.
            todo.insert(0, (gmr, work, robot, seed, None, 0, KINDS[0], a.seeds))
        kinds = [KINDS[0]] * max(a.free - count, 0) + [kind for kind in KINDS[1:] for _ in range(a.free_other)]
        todo += [(gmr, work, robot, first + k % count, None, k, kind, a.seeds) for k, kind in enumerate(kinds, count)]
    with Pool(a.jobs) as pool, open(a.out, "w") as out:
        for line in pool.imap_unordered(run, todo):
            out.write(json.dumps(line) + "\n")
            out.flush()


if __name__ == "__main__":
    main()
