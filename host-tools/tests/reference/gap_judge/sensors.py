"""What the log holds of a run: encoder ticks, averaged power with noise, further columns."""

import numpy as np

from drives import STEP

PERIOD = 0.05  # s: 20 Hz
TICKS = 4096  # a turn
NOISES = ["white", "ar", "heavy", "hetero"]


def coloured(rng, count, memory, draw):
    """Autoregressive noise of unit variance."""
    out = np.empty(count)
    shocks = draw(count) * np.sqrt(1.0 - memory**2)
    now = draw(1)[0]
    for k in range(count):
        now = memory * now + shocks[k]
        out[k] = now
    return out


def noise(kind, std, power, rng, memory):
    """Noise of the power sensor, W; its standard deviation is `std` whatever its kind (over the run for `hetero`)."""
    count = len(power)
    if kind == "white":
        return std * rng.standard_normal(count)
    if kind == "ar":
        return std * coloured(rng, count, memory, rng.standard_normal)
    if kind == "heavy":
        return std * coloured(rng, count, 0.6, lambda n: rng.standard_t(3, n) / np.sqrt(3.0))
    shape = 0.5 + np.abs(power) / max(np.mean(np.abs(power)), 1e-9)
    shape /= np.sqrt(np.mean(shape**2))
    return std * shape * coloured(rng, count, 0.6, rng.standard_normal)


def averaged(values):
    """Mean over each sample period."""
    many = int(round(PERIOD / STEP))
    count = len(values) // many
    return values[: count * many].reshape(count, many, *values.shape[1:]).mean(axis=1)


def speeds(angles, scales):
    """From encoder ticks, one difference a period."""
    many = int(round(PERIOD / STEP))
    ticks = np.floor(angles[many - 1 :: many] * np.asarray(scales) * TICKS / (2.0 * np.pi))
    return np.diff(ticks, axis=0, prepend=np.zeros((1, 2))) * 2.0 * np.pi / TICKS / PERIOD
