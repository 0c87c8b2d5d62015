"""What the robots' sensors make of a simulated drive: encoder ticks, and a power sensor that averages over its interval."""

import csv
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from simulate import CONTROL_S

# Memory of half of the current's noise, a sample of 5 ms: 50 ms, as amplifiers and switching leave it.
KEEP = 0.9


@dataclass
class Faults:
    """What a sensor may get wrong."""
    gain: float = 1.0
    offset_w: float = 0.0
    delay_s: float = 0.0
    # Battery's resistance, Ω: the sensor knows the current and takes the voltage for what it is without load.
    battery: float = 0.0
    extra_w: object = None   # power at every 5 ms of something else on board


def noise(kind, plant, power, rng):
    """Noise of the current, A, one value a sample of 5 ms, of the plant's size.

    `memory`: white, and half as much with a memory. `white`: that without memory. `heavy-tailed`: Student's t of 3. `heteroscedastic`: four times
    as much at the drive's greatest power as at none.
    """
    size, count = plant.current_noise, len(power)
    if kind == "heavy-tailed":
        return size * rng.standard_t(3, count) / np.sqrt(3.0)
    white = rng.normal(0.0, size, count)
    if kind == "white":
        return white
    if kind == "heteroscedastic":
        return white * (1.0 + 3.0 * np.abs(power) / np.max(np.abs(power)))
    slow = lfilter([1.0], [1.0, -KEEP], rng.normal(0.0, size * np.sqrt(1 - KEEP ** 2), count))
    return white + 0.5 * slow


def log(path, plant, record, mass, rng, rate_hz=200, clamped=True, faults=None, kind="memory"):
    """Writes time, wheel speeds, power and mass; the same drive can be logged at several rates.

    Noise of the current of a kind, then the sensor's step. Speeds are differences of ticks.
    """
    f = faults or Faults()
    volts = plant.drive.supply
    power = record.power[:, 1 if clamped else 0]
    power = power if f.extra_w is None else power + f.extra_w
    if f.battery:
        power = volts * 2.0 * power / (volts + np.sqrt(np.maximum(volts ** 2 - 4.0 * f.battery * power, 0.0)))
    late = round(f.delay_s / CONTROL_S)
    power = np.concatenate([np.full(late, power[0]), power[:len(power) - late]]) if late else power
    every = round(1.0 / (rate_hz * CONTROL_S))
    amps = (f.gain * power + f.offset_w) / volts + noise(kind, plant, power, rng)
    amps = amps[: len(power) // every * every].reshape(-1, every).mean(axis=1)
    measured = np.round(amps / plant.current_step) * plant.current_step * volts
    turn = 2 * np.pi / plant.ticks
    ticks = np.floor(record.angle / turn)[every - 1 :: every]
    speeds = np.diff(ticks, axis=0, prepend=0.0) * turn * rate_hz
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["time_s", "wheel1_rad_s", "wheel2_rad_s", "power_w", "mass_kg"])
        for k, (speed, watts) in enumerate(zip(speeds, measured)):
            out.writerow([f"{(k + 1) / rate_hz:.3f}", f"{speed[0]:.5f}", f"{speed[1]:.5f}", f"{watts:.4f}", f"{mass:g}"])
