"""Logs of the MuJoCo robots: two training masses, six test masses between them, on five grounds and loads.

    python generate.py FOLDER [--only two-wheeled] [--check]

FOLDER/<robot>/<set>/<rate>/train_*.csv, test_*.csv; <robot>.toml beside them. A set is a seed with its ground and its place of
the payload; the same seed gives the same logs. --check prints energy balance, pitch and contact forces.
"""

import argparse
from multiprocessing import Pool
from pathlib import Path

import numpy as np

import drives
import sensors
import simulate
from plants import PLANTS, Ground, Load, xml

TRAIN_S, TEST_S = 100.0, 60.0
# Of the way from the empty robot to the full one.
TEST_SHARES = (0.1, 0.25, 0.4, 0.6, 0.75, 0.9)
SETS = {
    "hard-1": (1, Ground(), 0.0),
    "hard-2": (2, Ground(), 0.0),
    "off-centre": (3, Ground(), 0.12),
    "soft": (4, Ground(roll=2.5, stiff_s=0.04), 0.0),
    "slippery": (5, Ground(slide=0.35), 0.0),
}
# What the power sensor sees: braking clamped at each bridge, or returned to the battery.
LOGGED = {"two-wheeled": ("two-wheeled",), "skid-steered": ("skid-steered", "skid-steered-clamped")}
RATES_HZ = (200, 20)

TOML = """# {name} in MuJoCo: plants.py.
name = "{name} (MuJoCo)"
kinematics = "{kinematics}"
{wheels}wheel_radius_m = {radius}
track_m = {track}
gyration_radius_m = {gyration}
mass_no_load_kg = {empty}
mass_full_load_kg = {full}
mape_floor_w = {floor}
regeneration = {regeneration}
speed_dead_band_rad_s = {dead_band}
"""


def robot_file(folder, logged, plant):
    skid = plant.base > 0.0
    # A skid-steered robot's track is what a spin on the spot shows: wider than between its wheels, because they slide.
    text = TOML.format(
        name=logged, kinematics="skid-steer" if skid else "differential", wheels="wheels = 2\n" if skid else "",
        radius=plant.radius, track=1.04 if skid else plant.track, gyration=round(0.4 * plant.track, 3), empty=plant.empty,
        full=plant.full, floor=5.0 if skid else 0.1, dead_band=0.05 if skid else 0.02,
        regeneration=str(logged == "skid-steered").lower())
    (folder / f"{logged}.toml").write_text(text)


def jobs():
    for plant in PLANTS.values():
        masses = [("train", plant.empty), ("train", plant.full)]
        masses += [("test", round(plant.empty + s * (plant.full - plant.empty), 2)) for s in TEST_SHARES]
        for name in SETS:
            for k, (use, mass) in enumerate(masses):
                yield plant.name, name, k, use, mass


def make(job):
    folder, check, (robot, name, k, use, mass) = job
    plant = PLANTS[robot]
    seed, ground, offset = SETS[name]
    rng = np.random.default_rng([seed, k, len(robot)])
    reference = drives.reference(plant, TRAIN_S if use == "train" else TEST_S, rng)
    # The same place in all drives of a set: a rack or an arm, not a thrown bag.
    load = Load(mass - plant.empty, ahead=offset * plant.length, left=0.5 * offset * plant.length, box=0.3 * plant.length)
    record = simulate.run(plant, xml(plant, load, ground), reference, check=check)
    for logged in LOGGED[robot]:
        for rate in RATES_HZ:
            path = folder / logged / name / f"{rate}" / f"{use}_{mass:g}.csv"
            path.parent.mkdir(parents=True, exist_ok=True)
            sensors.log(path, plant, record, mass, np.random.default_rng([seed, k, rate]), rate, clamped=logged != "skid-steered")
    c = record.checks
    return "" if not check else (
        f"{robot:13} {name:10} {mass:6.1f} kg: energy {100 * c['energy_balance']:.3f} %, |pitch| {np.abs(record.pitch).max():.4f}, "
        f"contacts {c['contact_force_min'] / c['weight']:.2f} to {c['contact_force_max'] / c['weight']:.2f} of the weight")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    a = parser.parse_args()
    todo = [(a.folder, a.check, job) for job in jobs() if a.only in (None, job[0])]
    a.folder.mkdir(parents=True, exist_ok=True)
    for plant in PLANTS.values():
        for logged in LOGGED[plant.name]:
            robot_file(a.folder, logged, plant)
    with Pool(a.jobs) as pool:
        for line in pool.imap(make, todo):
            if line:
                print(line, flush=True)
    if a.only is None:
        (a.folder / "complete").touch()


if __name__ == "__main__":
    main()
