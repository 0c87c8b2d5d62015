"""A gigabyte of the same drive in every format: fitted to the same coefficients, at what rate, and in how much memory.

    python bench.py --gmr PATH --work FOLDER [--mb 1000]

Called by `cargo xtask bench logs`. Each log is written, fitted, and removed before the next; the same rows as CSV are what its coefficients are held
against. Progress goes to standard error, the table to standard output. Ends with 1 where a log took more memory than `MOST_MB` or its coefficients
differ by more than `SAME`.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import writers

# What reading may take, MB.
MOST_MB = 300.0
# Of a coefficient: times are rounded to a nanosecond by some formats, and every further digit is that rounding's.
SAME = 1e-6
ROBOT = """\
name = "TurtleBot3 Burger"
kinematics = "differential"
wheel_radius_m = 0.033
track_m = 0.160
gyration_radius_m = 0.064
mass_no_load_kg = 1.0
mass_full_load_kg = 6.0
filter_cutoff_hz = 1.0
"""
PX4 = '[topics]\npower = "drive_power:power_w"\nmass = "payload:mass_kg"\n'
SIMULATE = "simulate --rate 200 --sensors servo --mass 1@0,6@60 --seed 7 --duration 120 --out"


def say(text):
    print(text, file=sys.stderr, flush=True)


def fitted(gmr, robot, log):
    """The fit's report, seconds of processor, and the greatest memory in MB."""
    out = log.with_name("coefficients.toml")
    # A file: nobody has to read while the command runs.
    with tempfile.TemporaryFile() as report:
        running = subprocess.Popen([gmr, "fit", "--robot", robot, "--out", out, "--force", "--json", log], stdout=report, stderr=subprocess.PIPE)
        said = running.stderr.read().decode()
        _, status, usage = os.wait4(running.pid, 0)
        if os.waitstatus_to_exitcode(status) != 0:
            sys.exit(f"gmr fit {log.name}: {said}")
        report.seek(0)
        return json.load(report), usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024 / 1e6


def coefficients(report):
    return {entry["name"]: entry["value"] for entry in report["parameters"]}


def difference(found, expected):
    assert found.keys() == expected.keys(), (found, expected)
    return max(abs(found[name] - value) / abs(value) for name, value in expected.items() if value)


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--gmr", type=pathlib.Path, required=True)
    options.add_argument("--work", type=pathlib.Path, required=True)
    options.add_argument("--mb", type=float, default=1000.0)
    options.add_argument("--only")
    options = options.parse_args()
    work = options.work
    work.mkdir(parents=True, exist_ok=True)
    (work / "robot.toml").write_text(ROBOT)
    (work / "px4.toml").write_text(ROBOT + PX4)
    simulated = work / "drive.csv"
    subprocess.run([options.gmr, *SIMULATE.split(), simulated, "--force"], check=True, stdout=subprocess.DEVNULL)
    drive = writers.Drive(simulated)
    print(f"A simulated drive of 120 s at 200 Hz (1 and 6 kg), repeated to {options.mb:.0f} MB in each format; gmr fit of the whole log")
    print("s: of processor, reading and fitting, on all cores together")
    print("coefficients: the greatest relative difference from those of the same rows as CSV\n")
    print(f"{'format':<10}{'rows':>10}{'MB':>7}{'s':>8}{'MB/s':>8}{'memory, MB':>12}{'coefficients':>14}")
    worst_mb, worst_difference = 0.0, 0.0
    for name, (file, write) in writers.WRITERS.items():
        if options.only not in (None, name):
            continue
        log = work / file
        say(f"{name}: writing")
        rows = write(drive, log, options.mb * 1e6)
        mb = log.stat().st_size / 1e6
        report, processor, memory = fitted(options.gmr, work / ("px4.toml" if name == "ULog" else "robot.toml"), log)
        assert report["rows"] == rows, (report["rows"], rows)
        log.unlink()
        same = "–"
        if name != "CSV":
            text = work / "same.csv"
            writers.csv(drive, text, rows=rows)
            expected, *_ = fitted(options.gmr, work / "robot.toml", text)
            text.unlink()
            apart = difference(coefficients(report), coefficients(expected))
            worst_difference = max(worst_difference, apart)
            same = f"{apart:.1e}"
        worst_mb = max(worst_mb, memory)
        print(f"{name:<10}{rows:>10}{mb:>7.0f}{processor:>8.1f}{mb / processor:>8.1f}{memory:>12.0f}{same:>14}", flush=True)
    held = worst_mb <= MOST_MB and worst_difference <= SAME
    print(f"\n{worst_mb:.0f} MB at most (goal: {MOST_MB:.0f}); coefficients within {worst_difference:.1e} (goal: {SAME:.0e})")
    sys.exit(0 if held else 1)


if __name__ == "__main__":
    main()
