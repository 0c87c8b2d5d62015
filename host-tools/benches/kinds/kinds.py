"""References of wheel speeds in six kinds of driving: (n, 2) rad/s at 200 Hz."""

import numpy as np

import drives

RATE_HZ = drives.RATE_HZ


def legs(kind, rng):
    """Endless (share of the greatest speed of each wheel, ramp in s, hold in s)."""
    sign = lambda: rng.choice([-1.0, 1.0])
    while True:
        if kind == "jerky":
            speed, turn, ramp, hold = rng.uniform(-1.0, 1.0), sign() * rng.uniform(0.0, 0.1), 0.15, rng.uniform(0.2, 0.8)
        elif kind == "dashes":
            speed, turn, ramp, hold = rng.choice([0.1, 0.95]), 0.0, 0.45, rng.uniform(0.5, 2.0)
        elif kind == "shunting":
            speed, turn, ramp, hold = sign() * rng.uniform(0.4, 0.95), 0.0, rng.uniform(0.5, 1.0), rng.uniform(0.5, 2.0)
        elif kind == "crawl":
            speed, turn, ramp, hold = rng.uniform(0.04, 0.16), sign() * rng.uniform(0.0, 0.02), 0.5, rng.uniform(1.0, 4.0)
        elif kind == "stop-and-go":
            speed, turn = rng.choice([0.0, 1.0]) * rng.uniform(0.3, 0.95), 0.0
            ramp, hold = rng.uniform(0.3, 0.8), rng.uniform(0.5, 2.5)
        else:
            raise ValueError(kind)
        yield np.clip(np.array([speed - turn, speed + turn]), -0.95, 0.95), ramp, hold


KINDS = ("mixed", "stop-and-go", "shunting", "dashes", "crawl", "jerky")


def reference(plant, kind, seconds, rng):
    """`plant` has the greatest `speed` (rad/s) and `acceleration` (rad/s²) of a wheel."""
    if kind == "mixed":
        return drives.reference(plant, seconds, rng)
    count = int(seconds * RATE_HZ)
    out = np.zeros((count, 2))
    at, now = RATE_HZ, np.zeros(2)
    for share, ramp_s, hold_s in legs(kind, rng):
        goal = plant.speed * share
        # No harder than its drives can.
        ramp = max(int(max(ramp_s, np.abs(goal - now).max() / plant.acceleration) * RATE_HZ), 1)
        steps = np.arange(1, ramp + 1)[:, None] / ramp
        piece = np.vstack([now + (goal - now) * steps, np.repeat(goal[None], int(hold_s * RATE_HZ), axis=0)])[: count - at]
        out[at : at + len(piece)] = piece
        at, now = at + len(piece), goal
        if at >= count:
            return out
