"""Six sensor chains: what a log holds of a true drive."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from kinds import RATE_HZ


@dataclass(frozen=True)
class Chain:
    name: str
    speed: str               # exact, servo, ticks or register
    noise: str               # none, white, heavy-tailed or correlated
    every: int = 1           # samples of 5 ms in one of the log


CHAINS = (
    Chain("exact", "exact", "none"),
    Chain("servo", "servo", "white"),
    Chain("ticks, 200 Hz", "ticks", "white"),
    Chain("register, 20 Hz", "register", "white", 10),
    Chain("heavy-tailed", "ticks", "heavy-tailed"),
    Chain("correlated", "ticks", "correlated"),
)
# A servo's own speed: the mean of so many differences of its ticks.
SERVO_MEAN = 10
# Memory of the correlated noise, a sample of 5 ms: a quarter of a second.
KEEP = np.exp(-0.005 / 0.25)


def noise(kind, count, rng):
    """Of unit variance, a value every 5 ms."""
    if kind == "none":
        return np.zeros(count)
    if kind == "heavy-tailed":
        return rng.standard_t(3, count) / np.sqrt(3.0)
    white = rng.standard_normal(count)
    if kind == "white":
        return white
    return lfilter([np.sqrt(1.0 - KEEP**2)], [1.0, -KEEP], white)


def information(chain, robot, slope):
    """Fisher's about the mass from the power alone, 1/kg², `slope` being ∂P/∂m every 5 ms in W/kg; infinite without noise."""
    if chain.noise == "none":
        return np.inf
    variance = robot.power_noise**2
    if chain.noise == "correlated":
        # By frequency: the spectrum of the noise, and what the sensor's step adds.
        found = np.fft.rfft(slope)
        turn = np.linspace(0.0, np.pi, len(found))
        spectrum = variance * (1.0 - KEEP**2) / np.abs(1.0 - KEEP * np.exp(-1j * turn)) ** 2 + robot.power_step**2 / 12.0
        return float(2.0 * np.sum(np.abs(found) ** 2 / spectrum) / len(slope))
    # Student's t with 3 degrees of freedom tells twice what normal noise of its variance does.
    per_sample = 2.0 if chain.noise == "heavy-tailed" else 1.0
    return float(per_sample * np.sum(slope**2) / (variance + robot.power_step**2 / 12.0))


def log(path, chain, robot, drive, mass, rng):
    """Writes time, wheel speeds, power and mass."""
    every, period = chain.every, chain.every / RATE_HZ
    count = len(drive.power) // every * every
    power = drive.power + robot.power_noise * noise(chain.noise, len(drive.power), rng)
    power = power[:count].reshape(-1, every).mean(axis=1)
    if chain.noise != "none":
        power = np.round(power / robot.power_step) * robot.power_step
    angle = drive.angle if chain.speed == "exact" else np.floor(drive.angle * robot.ticks / (2.0 * np.pi)) * 2.0 * np.pi / robot.ticks
    moved = np.diff(angle, axis=0, prepend=0.0) * RATE_HZ
    if chain.speed == "servo":
        moved = lfilter(np.full(SERVO_MEAN, 1.0 / SERVO_MEAN), [1.0], moved, axis=0)
    if chain.speed == "register":
        # The register is read at the sample's end, its value a mean over 50 ms.
        moved = moved[:count].reshape(-1, every, 2).mean(axis=1)
        moved = np.round(moved / robot.register) * robot.register
    time = period * np.arange(1, len(power) + 1)
    rows = np.column_stack([time, moved[: len(power)], power, np.full(len(power), mass)])
    np.savetxt(path, rows, delimiter=",", header="time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg", comments="",
               fmt=["%.3f", "%.6f", "%.6f", "%.5f", "%g"])
    return path
