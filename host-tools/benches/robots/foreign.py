"""Drives of the simulator in tests/reference/gap_judge, with known masses: 20 Hz, six styles of driving, autocorrelated noise.

    python foreign.py JUDGE ROBOT SEED FOLDER SHARE...

Writes train_<mass>_<style>.csv of the empty and the full robot, and test_<mass>.csv for each share of the way between.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, sys.argv[1])

import sets
from drives import STYLES, reference
from robots import BRISK_TOML, ROBOTS

NOISE, MEMORY = "ar", 0.6
TRAIN_S, TEST_S = 40.0, 90.0


def main():
    name, seed, folder = sys.argv[2], int(sys.argv[3]), Path(sys.argv[4])
    robot = ROBOTS[name]
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng([seed, 77])

    def run(mass, style, seconds, path):
        runs = [(mass, style, reference(robot, style, rng, seconds))]
        sets.write(path, robot, sets.scene(robot, runs, 0, seed, (), (), 0), NOISE, MEMORY, rng)

    for mass in (robot.empty, robot.full):
        for style in STYLES[:5]:
            run(mass, style, TRAIN_S, folder / f"train_{mass:g}_{style}.csv")
    for k, share in enumerate(map(float, sys.argv[5:])):
        mass = round(robot.empty + share * (robot.full - robot.empty), 2)
        run(mass, ("stop-and-go", "arcs", "to-and-fro")[(k + seed) % 3], TEST_S, folder / f"test_{mass:g}.csv")
    if name == "brisk":
        (folder / "robot.toml").write_text(BRISK_TOML)


if __name__ == "__main__":
    main()
