"""What makes a set hard beside its effect: a wrong robot.toml, floors that scatter, other rates, few runs, long ones.

    python hard.py RESULT.jsonl        # of batch.py --hard: a line a condition
"""

import json
import sys
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

import drives
import effects
import sensors
import sets
from verdicts import judge

BURGER = Path(__file__).resolve().parents[3] / "robots/burger.toml"
# What stands in robot.toml, as a share of what is true.
WRONG = {"radius +3 %": ("wheel_radius_m", 1.03), "radius -3 %": ("wheel_radius_m", 0.97),
         "track +10 %": ("track_m", 1.1), "track -10 %": ("track_m", 0.9)}
PERIODS = {"10 Hz": 0.1, "50 Hz": 0.02}
KEPT = {"4 field runs": ("field", 4), "3 clean runs": ("clean", 3)}
SCATTER = {"rolling scatters by 5 %": 0.05}
LASTING = {"ten-minute runs": 600.0}
# Each has the period by its own name.
MODULES = (effects, sensors, sets)
CONDITIONS = [*WRONG, *SCATTER, *PERIODS, *KEPT]


@contextmanager
def sampled(condition):
    """Sensors of the condition's rate, drives of its length."""
    usual, usually = sensors.PERIOD, drives.SECONDS
    drives.SECONDS = LASTING.get(condition, usually)
    for module in MODULES:
        module.PERIOD = PERIODS.get(condition, usual)
    try:
        yield
    finally:
        drives.SECONDS = usually
        for module in MODULES:
            module.PERIOD = usual


def apply(condition, folder, robot):
    """Takes runs away, or writes a wrong robot.toml; the robot to name."""
    if condition in KEPT:
        kind, count = KEPT[condition]
        for path in sorted((folder / kind).glob("*.csv"))[count:]:
            path.unlink()
    if condition not in WRONG:
        return robot
    key, factor = WRONG[condition]
    text = (BURGER if robot == "burger" else folder / robot).read_text()
    lines = []
    for line in text.splitlines():
        if line.startswith(f"{key} ="):
            line = f"{key} = {factor * float(line.split('=')[1].split('#')[0]):.6f}"
        lines.append(line)
    (folder / "wrong.toml").write_text("\n".join(lines) + "\n")
    return "wrong.toml"


def main():
    lines = [json.loads(line) for line in open(sys.argv[1])]
    for condition in dict.fromkeys(line["hard"] for line in lines):
        some = [line for line in lines if line["hard"] == condition]
        count = Counter("error" if "error" in line else judge(line) for line in some)
        print(f"{condition:<24} {len(some):3} sets: " + ", ".join(f"{what} {n}" for what, n in count.most_common()))
    for line in lines:
        if "error" in line:
            print(f"failed: {line['hard']}, {line['effect']}: {line['error'].strip()}")
        elif judge(line) in ("WRONG", "false-tie", "extra", "alarm"):
            print(f"{judge(line)}: {line['hard']}, {line['robot']} {line['effect']} {line['size']}: {line['named']} {line['ties']}")


if __name__ == "__main__":
    main()
