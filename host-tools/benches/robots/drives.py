"""References of wheel speeds: slow and fast, straight, curves of several radii, spins, stops, firm starts."""

import numpy as np

RATE_HZ = 200


def reference(plant, seconds, rng, kind="mixed"):
    """(n, 2) wheel speeds, rad/s, at 200 Hz: segments of 1.5 to 6 s joined by ramps."""
    top = plant.speed
    n = int(seconds * RATE_HZ)
    out = np.zeros((n, 2))
    at = RATE_HZ             # a second of standing first
    now = np.zeros(2)
    while at < n:
        goal = segment(top, rng, kind)
        firmness = plant.acceleration * rng.uniform(0.25, 1.0)
        ramp = max(int(np.abs(goal - now).max() / firmness * RATE_HZ), 1)
        hold = int(rng.uniform(1.0, 4.5) * RATE_HZ)
        steps = np.arange(1, ramp + 1)[:, None] / ramp
        piece = np.vstack([now + (goal - now) * steps, np.repeat(goal[None], hold, axis=0)])[: n - at]
        out[at : at + len(piece)] = piece
        at += len(piece)
        now = goal
    return out


def segment(top, rng, kind):
    draw = rng.random()
    v = top * rng.uniform(0.25, 0.95)
    if draw < 0.12:
        return np.zeros(2)
    if draw < 0.42:
        return np.array([v, v]) * (1 if rng.random() < 0.85 else -0.7)
    if draw < 0.55:
        spin = top * rng.uniform(0.15, 0.5) * rng.choice([-1, 1])
        return np.array([-spin, spin])
    inner = v * (1.0 - rng.choice([0.1, 0.25, 0.5, 0.8]) * rng.uniform(0.6, 1.2))
    pair = np.array([inner, v])
    return pair if rng.random() < 0.5 else pair[::-1].copy()
