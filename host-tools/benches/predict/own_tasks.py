"""Tasks on our own plant: random legs at random masses, planned as the speeds that the plant is then told to drive."""

import csv
import random
from concurrent.futures import ThreadPoolExecutor

import formula

FITS = 10
MASS_STD = 0.03
SPEED, TURN, RAMP, TURN_RAMP = 0.22, 2.0, 0.4, 4.0


def profile(rng):
    """Legs of straights, curves, spins and stops, joined by ramps: rows of time, speed, turn rate."""
    rows, now = [(0.0, 0.0, 0.0)], (0.0, 0.0)
    for _ in range(rng.randint(6, 16)):
        kind = rng.random()
        v = rng.uniform(0.2, 0.95) * SPEED * (1 if rng.random() < 0.85 else -0.7)
        goal = (v, 0.0) if kind < 0.5 else (0.6 * v, rng.uniform(-0.4, 0.4) * TURN) if kind < 0.7 else \
            (0.0, rng.choice((-1, 1)) * rng.uniform(0.2, 0.6) * TURN) if kind < 0.85 else (0.0, 0.0)
        ramp = max(abs(goal[0] - now[0]) / RAMP, abs(goal[1] - now[1]) / TURN_RAMP, 0.05)
        rows.append((rows[-1][0] + ramp, *goal))
        rows.append((rows[-1][0] + rng.uniform(2.0, 12.0), *goal))
        now = goal
    rows.append((rows[-1][0] + 0.8, 0.0, 0.0))
    rows.append((rows[-1][0] + 1.0, 0.0, 0.0))
    return rows


def energy(log):
    """∫ of the true power, J."""
    with open(log, newline="") as text:
        rows = [(float(row["time_s"]), float(row["true_power_w"])) for row in csv.DictReader(text)]
    return sum((b[0] - a[0]) * 0.5 * (a[1] + b[1]) for a, b in zip(rows, rows[1:]))


def simulate(gmr, out, *arguments):
    if not out.exists():
        gmr.json("simulate", "--plant", "servo", "--truth", "--out", out, *arguments)
    return out


def one_fit(gmr, work, seed, count):
    work.mkdir(parents=True, exist_ok=True)
    sensors = ("--sensors", "servo", "--rate", 200, "--duration", 100)
    train = [simulate(gmr, work / f"train_{mass}.csv", *sensors, "--mass", mass, "--seed", seed) for mass in (1, 6)]
    fit = work / "fit.toml"
    gmr.fit("burger", fit, train)
    training = [(gmr.json("predict", "--coeffs", fit, "--plan", log, "--mass", mass), energy(log)) for log, mass in zip(train, (1, 6))]
    friction = formula.tuned(training)
    rng = random.Random(seed)
    tasks = []
    for k in range(count):
        plan, mass = work / f"plan_{k}.csv", rng.uniform(1.2, 5.8)
        told = mass * (1.0 + rng.gauss(0.0, MASS_STD))
        with open(plan, "w") as text:
            text.write("time_s,v_m_s,omega_rad_s\n")
            rows = profile(rng)
            text.writelines(f"{t:.3f},{v:.4f},{w:.4f}\n" for t, v, w in rows)
        log = simulate(gmr, work / f"task_{k}.csv", "--sensors", "exact", "--rate", 100, "--duration", f"{rows[-1][0]:.2f}", "--profile", plan,
                       "--mass", f"{mass:.4f}", "--seed", 1000 * seed + k)
        reach = 1.96 * MASS_STD * told
        report = gmr.json("predict", "--coeffs", fit, "--plan", plan, "--mass", f"{told:.4f}", "--mass-interval", f"{told - reach:.4f},{told + reach:.4f}")
        tasks.append(formula.task(report, energy(log), friction))
    return tasks


def rows(gmr, work, count, jobs):
    with ThreadPoolExecutor(jobs) as pool:
        parts = list(pool.map(lambda seed: one_fit(gmr, work / str(seed), seed, count // FITS), range(1, FITS + 1)))
    return [("own plant, servo", [task for part in parts for task in part])]
