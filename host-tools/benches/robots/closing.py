"""A simulator that lacks an effect, closed: find it with `gmr gap --sim`, write it into the model, drive the model again.

    python closing.py --gmr PATH --work FOLDER [--seeds 2] [--robots …] [--effects …]

The simulator is a MuJoCo robot of plants.py without the effect and without any noise; the logs are of the same robot with it, behind its
sensors. Both drive the same references. What `gmr gap --sim … --export mjcf` says is written into the MJCF text, element by element, and
the extended model drives the references of the locked runs again: the gap is measured less simulated power there, both behind the
same low-pass filter.
"""

import argparse
import csv
import json
import shutil
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.signal import butter, lfilter

import drives
import gap_sets
import generate
import sensors
import simulate
from gmr import Failed, Gmr
from plants import GRAVITY, PLANTS, xml

EFFECTS = ("wheel-drag", "viscous-change", "rolling-resistance-change", "grade", "turning-scrub", "payload-offset")
# As gap's runs: behind a filter of 1 Hz, a second after the start.
CUTOFF_HZ, SETTLE_S = 1.0, 2.0
SIDES = {"left": "left", "right": "right"}


def write(path, record, mass):
    """The simulator's own log: true speeds and power at the rate of the robot's logs."""
    every = round(1.0 / (gap_sets.RATE_HZ * simulate.CONTROL_S))
    angle = record.angle[every - 1 :: every]
    speeds = np.diff(angle, axis=0, prepend=0.0) * gap_sets.RATE_HZ
    power = record.power[:, 1][: len(angle) * every].reshape(-1, every).mean(axis=1)
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["time_s", "wheel1_rad_s", "wheel2_rad_s", "sim_power_w", "mass_kg"])
        for k, (speed, watts) in enumerate(zip(speeds, power)):
            out.writerow([f"{(k + 1) / gap_sets.RATE_HZ:.3f}", f"{speed[0]:.6f}", f"{speed[1]:.6f}", f"{watts:.6f}", f"{mass:g}"])
    return power


def extended(text, changes):
    """The model with the changes written in. Those that no element has are returned."""
    model = ElementTree.fromstring(text)
    left_out = []
    joints = {joint.get("name"): joint for joint in model.iter("joint")}
    pairs = [pair for pair in model.find("contact") if pair.get("geom1") in ("left", "right", "left2", "right2")]

    def add(element, attribute, value, place=None):
        numbers = [float(number) for number in element.get(attribute, "0").split()]
        numbers[place or 0] += value
        element.set(attribute, " ".join(f"{number:.9g}" for number in numbers))

    for change in changes:
        element, value = change["element"], change["value"]
        if element in ("joint/@frictionloss", "joint/@damping"):
            own = [side for side in SIDES if side in change["part"]] or list(SIDES)
            for side in own:
                add(joints[side], element.split("@")[1], value)
        elif element in ("geom/@friction[1]", "geom/@friction[2]"):
            # A pair has two directions of sliding and of rolling.
            for pair in pairs:
                for place in (2,) if element.endswith("[1]") else (3, 4):
                    add(pair, "friction", value, place)
        elif element == "option/@gravity":
            found = change["part"].split("towards ")
            heading = np.radians(float(found[1].split("°")[0])) if len(found) > 1 else 0.0
            down = -GRAVITY * np.array([np.sin(value) * np.cos(heading), np.sin(value) * np.sin(heading), np.cos(value)])
            model.find("option").set("gravity", " ".join(f"{number:.9g}" for number in down))
        elif element == "body/inertial/@pos[1]":
            payload = [body for body in model.iter("body") if body.get("name") is None]
            for body in payload:
                add(body, "pos", value, 1)
        else:
            left_out.append(change["effect"])
    return ElementTree.tostring(model, encoding="unicode"), left_out


def filtered(power):
    b, a = butter(2, CUTOFF_HZ / (0.5 * gap_sets.RATE_HZ))
    return lfilter(b, a, power - power[0])[int(SETTLE_S * gap_sets.RATE_HZ):] + power[0]


def measured(path):
    with open(path, newline="") as file:
        return np.array([float(row["power_w"]) for row in csv.DictReader(file)])


def close(gmr, work, plant, seed, effect):
    folder = work / "closing" / f"{plant.name}_{effect}_{seed}"
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "sim").mkdir(parents=True)
    gap_sets.write(folder, work / "records", plant, seed, effect, 0)
    simulated = {}
    for place in range(gap_sets.FIELD):
        record = gap_sets.driven(work / "records", plant, seed, place, False, None)
        mass = gap_sets.scene(plant, seed, place, False).noted
        simulated[place] = write(folder / "sim" / f"{place:02}.csv", record, mass)
    logged = generate.LOGGED[plant.name][-1]
    generate.robot_file(folder, logged, plant)
    logs, sims = (sorted((folder / name).glob("*.csv")) for name in ("field", "sim"))
    answer = gmr.json("gap", "--robot", folder / f"{logged}.toml", "--export", "mjcf", "--export-file", folder / "changes.xml",
                      "--profile", folder / "profile.csv", *logs, "--sim", *sims)
    locked = [place for place in range(gap_sets.FIELD) if any(f"{place:02}.csv" in run for run in answer["confirm_runs"])]
    before, after, left_out = [], [], []
    for place in locked:
        scene = gap_sets.scene(plant, seed, place, False)
        text, left_out = extended(xml(plant, scene.load, scene.ground), answer["changes"]["changes"])
        reference = drives.reference(plant, gap_sets.RUN_S, np.random.default_rng([seed, place, 0, 4]))
        again = write(folder / "again.csv", simulate.run(plant, text, reference), scene.noted)
        truth = measured(folder / "field" / f"{place:02}.csv")
        before.append(filtered(truth) - filtered(simulated[place]))
        after.append(filtered(truth) - filtered(again))
    rms = [float(np.sqrt(np.mean(np.concatenate(runs) ** 2))) for runs in (before, after)]
    return {"robot": plant.name, "seed": seed, "effect": effect, "verdict": answer["verdict"], "named": [e["id"] for e in answer["effects"]],
            "ties": answer["ambiguous_with"], "changes": answer["changes"]["changes"], "not_written": left_out,
            "before_w": rms[0], "after_w": rms[1]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gmr", required=True)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--robots", nargs="+", default=["two-wheeled"])
    parser.add_argument("--effects", nargs="+", default=EFFECTS)
    parser.add_argument("--json", action="store_true")
    a = parser.parse_args()
    lines = []
    if not a.json:
        print(f"{'robot':13} {'hidden effect':26} {'named':34} {'gap, W':>16}")
    for robot in a.robots:
        for effect in a.effects:
            for seed in range(1, 1 + a.seeds):
                try:
                    line = close(Gmr(a.gmr), a.work.resolve(), PLANTS[robot], seed, effect)
                except Failed as error:
                    line = {"robot": robot, "seed": seed, "effect": effect, "error": str(error)}
                lines.append(line)
                if not a.json:
                    named = line.get("error") or " + ".join(line["named"]) or line["verdict"]
                    ties = f" (or {', '.join(line['ties'])})" if line.get("ties") else ""
                    gap = "" if "error" in line else f"{line['before_w']:.3f} → {line['after_w']:.3f}"
                    print(f"{robot:13} {effect:26} {named + ties:34} {gap:>16}", flush=True)
    if a.json:
        print(json.dumps({"sets": lines}, indent=1))


if __name__ == "__main__":
    main()
