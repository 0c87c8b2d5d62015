"""Energy of tasks that nobody has driven yet: ours with its interval, beside Open-RMF's formula.

    python bench.py --gmr PATH --data ../shared/data --work FOLDER [--tasks 200] [--jobs 2]

Called by `cargo xtask bench predict`. Three parts: tasks on our own plant, which shares the form of the wheel's power with the model;
drives of the simulator in tests/reference/gap_judge, which shares nothing with it; trips of measured robots, each held out in turn.
The table goes to standard output, progress to standard error.
"""

import argparse
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "robots"))

import foreign_tasks
import measured_trips
import own_tasks
from gmr import Gmr


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gmr", required=True)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--tasks", type=int, default=200)
    parser.add_argument("--jobs", type=int, default=2)
    a = parser.parse_args()
    gmr = Gmr(a.gmr)
    a.work.mkdir(parents=True, exist_ok=True)
    print("Energy of tasks that nobody has driven yet. ours: gmr predict, from a fit of the empty and the full robot. RMF: Open-RMF's formula\n"
          "(rmf_battery) on the same motion: of the fit by gmr export rmf; tuned, its one friction fitted to the training drives; stock, 0.22.\n"
          "Errors of a task's energy in percent of the truth: mean of their sizes; in brackets the mean with its sign.\n")
    print(f"{'tasks':<34}{'number':>7}{'95 % holds':>12}{'ours':>16}{'RMF of fit':>18}{'RMF tuned':>18}{'RMF stock':>18}")
    for part in (own_tasks.rows(gmr, a.work / "own", a.tasks, a.jobs), foreign_tasks.rows(gmr, a.work / "foreign", a.jobs),
                 measured_trips.rows(gmr, a.data, a.work / "measured")):
        for name, tasks in part:
            print(line(name, tasks), flush=True)
    print("\nOwn plant and second simulator: driving energy alone, mass known to 3 % (one standard deviation), told with that interval. Husky:\n"
          "whole runs held out in three folds, their power computed from currents; the runs' speeds are taken as planned. TurtleBot3: total energy,\n"
          "standing included; no speeds were logged, so spins are where the power says so, at the 0.81 rad/s that its makers state.\n"
          "The second simulator's other robot, brisk, is left out: its drives take long to simulate.")


def line(name, tasks):
    held = sum(t["low"] <= t["truth"] <= t["high"] for t in tasks)
    text = f"{name:<34}{len(tasks):>7}{100 * held / len(tasks):>10.1f} %"
    for key in ("ours", "rmf", "tuned", "stock"):
        errors = [100 * (t[key] / t["truth"] - 1) for t in tasks]
        sizes = sum(map(abs, errors)) / len(errors)
        text += f"{sizes:>9.1f} [{sum(errors) / len(errors):+.1f}]".rjust(16 if key == "ours" else 18)
    return text


if __name__ == "__main__":
    main()
