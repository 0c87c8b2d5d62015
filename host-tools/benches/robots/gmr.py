"""The command `gmr`, called as a user calls it."""

import csv
import json
import subprocess
from pathlib import Path


# Benches count what every fit gives, that of a fit which nobody should use as well.
FORCED = ("fit", "estimate", "gap")


class Failed(Exception):
    """gmr ended with an error: its last line."""


class Gmr:
    def __init__(self, program):
        self.program = str(Path(program).resolve())

    def json(self, *arguments, folder=None):
        """What it answers, run in a folder, into which it may write what nobody named."""
        force = ["--force"] if arguments[0] in FORCED else []
        done = subprocess.run([self.program, *map(str, arguments), *force, "--json"], capture_output=True, text=True, cwd=folder)
        if done.returncode:
            raise Failed(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"exit code {done.returncode}")
        return json.loads(done.stdout)

    def fit(self, robot, out, logs, *more):
        return self.json("fit", "--robot", robot, "--out", out, *more, *logs)

    def estimate(self, robot, coefficients, log, *more):
        return self.json("estimate", "--robot", robot, "--coeffs", coefficients, *more, log)

    def compare(self, robot, train, test=(), *more):
        tests = ["--test", *test] if test else []
        return self.json("compare", "--robot", robot, "--train", *train, *tests, *more)


def shifted(log, folder, seconds):
    """A copy of a log whose clock runs `seconds` ahead: other blocks are held out."""
    folder.mkdir(parents=True, exist_ok=True)
    out = folder / Path(log).name
    with open(log, newline="") as read, open(out, "w", newline="") as write:
        rows, copy = csv.reader(read), csv.writer(write, lineterminator="\n")
        header = next(rows)
        copy.writerow(header)
        time = header.index("time_s")
        for row in rows:
            row[time] = f"{float(row[time]) + seconds:.4f}"
            copy.writerow(row)
    return out
