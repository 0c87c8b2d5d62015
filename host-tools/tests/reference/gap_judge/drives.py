"""Speed references of six styles: forward speed and turn rate, limited in acceleration."""

import numpy as np

STEP = 5e-4  # s, of the integration
SECONDS = 60.0  # of a drive; hard.py has longer ones


def limited(target, rate):
    """Follows a target at no more than `rate` a second."""
    out = np.empty_like(target)
    now = 0.0
    most = rate * STEP
    # Targets are piecewise constant: one ramp per piece.
    edges = np.flatnonzero(np.diff(target)) + 1
    for piece in np.split(np.arange(len(target)), edges):
        goal = target[piece[0]]
        ramp = now + np.sign(goal - now) * most * np.arange(1, len(piece) + 1)
        reached = np.minimum(ramp, goal) if goal >= now else np.maximum(ramp, goal)
        out[piece] = reached
        now = reached[-1]
    return out


def pieces(rng, style):
    """Endless (seconds, share of v_max, share of yaw_max)."""
    sign = lambda p=0.5: 1.0 if rng.random() < p else -1.0
    while True:
        if style == "stop-and-go":
            yield rng.uniform(1.0, 4.0), sign(0.75) * rng.uniform(0.25, 1.0), rng.choice([0, 0, 1]) * rng.uniform(-0.5, 0.5)
            yield rng.uniform(0.5, 2.5), 0.0, 0.0
        elif style == "straights":
            yield rng.uniform(4.0, 9.0), rng.uniform(0.4, 1.0), 0.0
            yield rng.uniform(0.8, 2.0), 0.0, sign() * rng.uniform(0.4, 1.0)
        elif style == "arcs":
            yield rng.uniform(2.0, 6.0), sign(0.8) * rng.uniform(0.3, 0.9), rng.uniform(-0.7, 0.7)
        elif style == "spins":
            yield rng.uniform(1.0, 4.0), 0.0, sign() * rng.uniform(0.3, 1.0)
            yield rng.uniform(0.5, 3.0), rng.choice([0.0, 0.6, -0.6]), 0.0
        elif style == "to-and-fro":
            speed = rng.uniform(0.4, 1.0)
            yield rng.uniform(2.0, 5.0), speed, rng.uniform(-0.15, 0.15)
            yield rng.uniform(0.0, 0.6) + 0.05, 0.0, 0.0
            yield rng.uniform(2.0, 5.0), -speed, rng.uniform(-0.15, 0.15)
        else:  # mission: a bit of all, slowly
            yield rng.uniform(3.0, 6.0), rng.uniform(0.3, 0.8), rng.uniform(-0.3, 0.3)
            yield rng.uniform(1.0, 2.0), 0.0, sign() * 0.6
            yield rng.uniform(1.0, 6.0), 0.0, 0.0


STYLES = ["stop-and-go", "straights", "arcs", "spins", "to-and-fro", "mission"]


def reference(robot, style, rng):
    """Wheel speeds (left, right) in rad/s at every step."""
    count = int(round(SECONDS / STEP))
    v, yaw = np.zeros(count), np.zeros(count)
    at = int(rng.uniform(0.5, 2.0) / STEP)
    for length, speed, turn in pieces(rng, style):
        to = at + max(1, int(length / STEP))
        v[at:to], yaw[at:to] = speed * robot.v_max, turn * robot.yaw_max
        at = to
        if at >= count:
            break
    v, yaw = limited(v, robot.a_max * rng.uniform(0.5, 1.0)), limited(yaw, robot.yaw_acc * rng.uniform(0.5, 1.0))
    half = 0.5 * robot.track * yaw
    # Neither wheel is asked for more than the drive can do.
    most = np.maximum(np.abs(v) + np.abs(half), 1e-9)
    fit = np.minimum(1.0, robot.v_max / most)[:, None]
    return fit * np.stack([v - half, v + half], axis=1) / robot.radius
