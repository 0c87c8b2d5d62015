"""Training and test drives with known masses on three kinds of plants: our own, the one in tests/reference/gap_judge, and MuJoCo's."""

import subprocess
import sys
from pathlib import Path

TEST_SHARES = (0.1, 0.25, 0.4, 0.6, 0.75, 0.9)


def own(gmr, folder, plant, seed):
    """`gmr simulate`: its power is Σ max(0, τw + κτ²), the signed model's own formula."""
    folder.mkdir(parents=True, exist_ok=True)

    def simulate(profile, seconds, mass, number, out):
        subprocess.run([gmr.program, "simulate", "--plant", plant, "--sensors", "servo" if plant == "servo" else "exact", "--rate",
                        "200" if plant == "servo" else "100", "--profile", profile, "--duration", str(seconds), "--mass", mass,
                        "--seed", str(number), "--out", str(out)], check=True, capture_output=True)
        return out

    train = [simulate("training", 200, "1@0,6@100", seed, folder / "train.csv")]
    tests = []
    for share in TEST_SHARES:
        mass = 1.0 + 5.0 * share
        tests.append((mass, simulate("test", 100, f"{mass:g}@0", 1000 + seed, folder / f"test_{mass:g}.csv")))
    return "burger", train, tests


def foreign(folder, judge, name, seed):
    """gap_judge's simulator. In a process of its own: its modules have the names of ours."""
    script = Path(__file__).resolve().with_name("foreign.py")
    subprocess.run([sys.executable, script, judge, name, str(seed), folder, *map(str, TEST_SHARES)], check=True)
    toml = folder / "robot.toml"
    return toml if toml.exists() else "burger", sorted(folder.glob("train_*.csv")), by_mass(folder.glob("test_*.csv"))


def mujoco(folder, logged, name, rate):
    """Logs that generate.py wrote."""
    place = folder / logged / name / str(rate)
    return folder / f"{logged}.toml", sorted(place.glob("train_*.csv")), by_mass(place.glob("test_*.csv"))


def by_mass(logs):
    """(mass, log) of names that end in the mass."""
    return sorted((float(log.stem.split("_")[1]), log) for log in logs)
