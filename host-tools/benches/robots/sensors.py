"""What the robots' sensors make of a simulated drive: encoder ticks, and a power sensor that averages over its interval."""

import csv

import numpy as np

from simulate import CONTROL_S


def log(path, plant, record, mass, rng, rate_hz=200, clamped=True, delay=0, more=()):
    """Writes time, wheel speeds, power and mass; the same drive can be logged at several rates.

    Noise of the current: white, and as much again with a memory of 50 ms, as amplifiers and switching leave it; then the
    sensor's step. Speeds are differences of ticks.
    """
    power = record.power[:, 1 if clamped else 0]
    n = len(power)
    every = round(1.0 / (rate_hz * CONTROL_S))
    white = rng.normal(0.0, plant.current_noise, n)
    memory, keep = np.zeros(n), 0.9
    drive = rng.normal(0.0, plant.current_noise * np.sqrt(1 - keep ** 2), n)
    for k in range(1, n):
        memory[k] = keep * memory[k - 1] + drive[k]
    volts = plant.drive.supply
    amps = (power / volts + white + 0.5 * memory)[: n // every * every].reshape(-1, every).mean(axis=1)
    measured = np.round(amps / plant.current_step) * plant.current_step * volts
    if delay:
        measured = np.concatenate([np.full(delay, measured[0]), measured[:-delay]])
    turn = 2 * np.pi / plant.ticks
    ticks = np.floor(record.angle / turn)[every - 1 :: every]
    before = np.vstack([np.zeros((1, 2)), ticks[:-1]])
    speeds = (ticks - before) * turn * rate_hz
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["time_s", "wheel1_rad_s", "wheel2_rad_s", "power_w", "mass_kg", *(name for name, _ in more)])
        columns = [values[every - 1 :: every] for _, values in more]
        for k in range(len(measured)):
            extra = [f"{c[k]:.5f}" for c in columns]
            out.writerow([f"{(k + 1) / rate_hz:.3f}", f"{speeds[k, 0]:.5f}", f"{speeds[k, 1]:.5f}", f"{measured[k]:.4f}", f"{mass:g}", *extra])
