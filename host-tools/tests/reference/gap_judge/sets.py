"""Sets of runs: six clean ones for the fit, twelve in the field, with one effect of a wanted size or none."""

import json
from pathlib import Path

import numpy as np

from drives import STYLES, reference
from effects import ALL, Scene, limit
from plant import integrate
from robots import BRISK_TOML, ROBOTS
from sensors import PERIOD, averaged, noise, speeds

FIELD, CLEAN = 12, 6


def plan(robot, seed, count, field):
    """Masses over the range, styles mixed, a reference each."""
    rng = np.random.default_rng([seed, int(field)])
    shares = (np.arange(count) + rng.uniform(0, 1, count)) / count
    if not field:
        shares = np.array([0.0, 1.0, 0.5, 0.0, 1.0, 0.3])[:count]
    masses = robot.empty + (robot.full - robot.empty) * rng.permutation(shares)
    styles = [STYLES[k % len(STYLES)] for k in range(count)]
    rng.shuffle(styles)
    return [(float(round(m, 2)), s, reference(robot, s, rng)) for m, s in zip(masses, styles)]


def scene(robot, runs, place, seed, effect, magnitude, variant):
    mass, _, wheels = runs[place]
    s = Scene(robot, mass, mass, wheels, place, np.random.default_rng([seed, 7, place]), variant,
              np.random.default_rng([seed, 8]))
    for name, x in zip(effect, magnitude):
        ALL[name][0](s, x)
    return s


def drive(s):
    """Power at every step (W, the robot's static power not included), and what else the integration gives."""
    power, angles, hot = integrate(s.robot, s.world, s.mass, s.wheels, s.rolling, s.extra, s.pull, s.wind)
    power = power + s.static
    for change in s.after:
        power = change(power)
    return power, angles, hot


def powers(robot, runs, seed, effect, magnitude, variant):
    return np.stack([averaged(drive(scene(robot, runs, k, seed, effect, magnitude, variant))[0]) for k in range(len(runs))])


def calibrate(robot, runs, seed, name, size, variant):
    """The magnitude whose RMS over all field runs is `size` times the noise; or the physical limit. And the size reached."""
    before = powers(robot, runs, seed, (), (), variant)
    most = limit(name, robot)
    wanted = size * robot.noise

    def rms(x):
        return float(np.sqrt(np.mean((powers(robot, runs, seed, (name,), (x,), variant) - before) ** 2)))

    low, high = 0.0, most
    x = 0.15 * most
    for _ in range(7):
        got = rms(x)
        if abs(got / wanted - 1.0) < 0.05:
            return x, got / robot.noise
        if got < wanted:
            if x >= most:
                return x, got / robot.noise
            low = x
        else:
            high = x
        linear = x * wanted / max(got, 1e-12)
        x = min(linear if low < linear < high or high == most else 0.5 * (low + high), most)
    return x, rms(x) / robot.noise


def write(path, robot, s, kind, memory, rng):
    power, angles, hot = drive(s)
    clean = averaged(power)
    measured = clean + noise(kind, robot.noise, clean, rng, memory) + robot.static
    logged = speeds(angles, (s.world.scale_left, s.world.scale_right))
    time = PERIOD * np.arange(len(measured))
    columns = {"time_s": time, "wheel1_rad_s": logged[:, 0], "wheel2_rad_s": logged[:, 1], "power_w": measured,
               "mass_kg": np.full(len(time), s.noted)}
    if s.temperatures:
        for i in (0, 1):
            warm = 25.0 + averaged(hot)[:, i]
            columns[f"motor{i + 1}_temp_c"] = np.round(warm)
    if s.pitch:
        body = averaged(angles)
        heading = robot.radius / robot.track * (body[:, 1] - body[:, 0])
        climb = s.world.slope * np.cos(heading - s.world.slope_heading) + s.world.slope_ahead
        columns["pitch_rad"] = climb + rng.normal(0.0, 0.003, len(climb))
    columns.update(s.columns)
    table = np.column_stack(list(columns.values()))
    formats = ["%.2f"] + ["%.5f"] * (table.shape[1] - 1)
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt=formats)


def make(folder, robot_name, seed, effect=(), size=0.0, kind="ar", memory=0.9, clean=True, known=None, scatter=0.0):
    """Writes a set: clean/*.csv, field/*.csv, robot.toml, truth.json. `effect` is a tuple of names; `known` their magnitudes
    and sizes from an earlier search; `scatter` by what share rolling resistance differs from run to run."""
    robot = ROBOTS[robot_name]
    folder = Path(folder)
    (folder / "field").mkdir(parents=True, exist_ok=True)
    if robot_name == "brisk":
        (folder / "robot.toml").write_text(BRISK_TOML)
    variant = int(np.random.default_rng([seed, 3]).integers(12))
    runs = plan(robot, seed, FIELD, True)
    magnitude, reached = [], []
    for place, name in enumerate(effect):
        x, got = known[place] if known else calibrate(robot, runs, seed, name, size, variant)
        magnitude.append(x)
        reached.append(got)
    details = []
    for place in range(FIELD):
        s = scene(robot, runs, place, seed, effect, magnitude, variant)
        s.rolling *= 1.0 + scatter * np.random.default_rng([seed, 9, place]).normal()
        write(folder / "field" / f"f{place:02}.csv", robot, s, kind, memory, np.random.default_rng([seed, 5, place]))
        details.append({"mass": s.mass, "noted": s.noted, "style": runs[place][1], **s.detail})
    if clean:
        (folder / "clean").mkdir(exist_ok=True)
        before = plan(robot, seed, CLEAN, False)
        for place in range(CLEAN):
            s = scene(robot, before, place, seed, (), (), 0)
            s.rolling *= 1.0 + scatter * np.random.default_rng([seed, 10, place]).normal()
            write(folder / "clean" / f"c{place}.csv", robot, s, kind, memory, np.random.default_rng([seed, 6, place]))
    truth = {"robot": robot_name, "seed": seed, "effect": list(effect), "size": size, "reached": reached,
             "magnitude": magnitude, "variant": variant, "noise": kind, "memory": memory, "runs": details}
    (folder / "truth.json").write_text(json.dumps(truth, indent=1))
    return truth
