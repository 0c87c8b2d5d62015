"""Trips of measured robots, held out: a Husky on two floors, a TurtleBot3 that spins."""

import csv
from statistics import median

import formula

FOLDS = 3
MASS = 75
# A TurtleBot3's wheels in a spin at 0.81 rad/s: half of 0.16 m over 0.033 m.
SPIN_RAD_S = 0.81 * 0.08 / 0.033
# Between the power of standing with torque and that of a spin, W: data/SOURCES.md.
SPINS_ABOVE_W = 10.3


def rows(gmr, data, work):
    if not data.is_dir():
        return
    work.mkdir(parents=True, exist_ok=True)
    for floor in ("flooring", "sandy_loam"):
        yield f"Husky, {floor}", husky(gmr, sorted((data / "husky-currents").glob(f"{floor}_*.csv")), work / f"{floor}.toml")
    yield "TurtleBot3, spins", turtlebot(gmr, data / "turtlebot3", work)


def husky(gmr, logs, fit):
    tasks = []

    def predict(log):
        report = gmr.json("predict", "--robot", "husky", "--coeffs", fit, "--plan", log, "--mass", MASS)
        return report, report["measured_j"]

    for k in range(FOLDS):
        test = logs[k::FOLDS]
        train = [log for log in logs if log not in test]
        # A plan has no gyro to tell true slip by.
        gmr.fit("husky", fit, train, "--mass", MASS, "--no-gyro")
        friction = formula.tuned([predict(log) for log in train])
        tasks += [formula.task(*predict(log), friction) for log in test]
    return tasks


def turtlebot(gmr, data, work):
    """Fitted to one log, predicted on the others."""
    first, *others = [drive(data / f"{name}.csv", work / f"{name}.csv") for name in
                      ("spin_baseline_1", "spin_baseline_2", "spin_camera_switched_1")]
    fit = work / "spins.toml"

    def robot(static):
        path = work / f"robot_{static:.3f}.toml"
        path.write_text('name = "TurtleBot3"\nkinematics = "differential"\nwheel_radius_m = 0.033\ntrack_m = 0.16\ngyration_radius_m = 0.064\n'
                        f"mass_no_load_kg = 1\nmass_full_load_kg = 6\nstatic_power_w = {static:.3f}\n")
        return path

    gmr.fit(robot(first[1]), fit, [first[0]], "--mass", 1)
    tasks = []
    for log, static in others:
        report = gmr.json("predict", "--robot", robot(static), "--coeffs", fit, "--plan", log, "--mass", 1)
        tasks.append(formula.task(report, report["measured_j"], 0.0))
    return tasks


def drive(log, out):
    """Means over 0.1 s from the first spin on, wheel speeds by whether the power is a spin's. Gives the log and the power of standing."""
    bins = {}
    with open(log, newline="") as text:
        for row in csv.DictReader(text):
            bins.setdefault(int(10 * float(row["time_s"])), []).append(float(row["power_w"]))
    power = [sum(found) / len(found) for _, found in sorted(bins.items())]
    smooth = [sum(power[max(0, k - 5):k + 6]) / len(power[max(0, k - 5):k + 6]) for k in range(len(power))]
    start = next(k for k, watts in enumerate(smooth) if watts > SPINS_ABOVE_W)
    standing = median(watts for watts, mean in zip(power[start:], smooth[start:]) if mean <= SPINS_ABOVE_W)
    with open(out, "w") as text:
        text.write("time_s,wheel1_rad_s,wheel2_rad_s,power_w\n")
        for k in range(start, len(power)):
            speed = SPIN_RAD_S if smooth[k] > SPINS_ABOVE_W else 0.0
            text.write(f"{(k - start) / 10:.1f},{-speed:.4f},{speed:.4f},{power[k]:.4f}\n")
    return out, standing
