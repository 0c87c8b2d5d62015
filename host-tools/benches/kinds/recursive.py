"""Recursive least squares for the mass: an independent rival, with nothing of ours in it.

Power is linear in eight terms, four of which the mass multiplies; least squares on the training logs give them. On a test log the mass is the
state of recursive least squares that forgets over a window, and its interval is what the residual's scatter gives.
"""

import numpy as np
from scipy.signal import butter, lfilter

CUTOFF_HZ = 2.0


def read(path):
    """Time, filtered speeds and accelerations (n, 2), filtered power."""
    values = np.genfromtxt(path, delimiter=",", skip_header=1)
    time, speed, power = values[:, 0], values[:, 1:3], values[:, 3]
    b, a = butter(5, CUTOFF_HZ, fs=1.0 / (time[1] - time[0]))
    speed, power = lfilter(b, a, speed, axis=0), lfilter(b, a, power)
    return time, speed, np.gradient(speed, time, axis=0), power


def terms(speed, acceleration, turn_share):
    """What the mass does not multiply and what it does, each (n, 4) summed over the wheels; `turn_share` is (2 k / track)²."""
    forward, turn = acceleration.mean(axis=1), 0.5 * (acceleration[:, 1] - acceleration[:, 0])
    inertial = 0.5 * np.column_stack([forward - turn_share * turn, forward + turn_share * turn])
    drags = np.abs(speed).sum(axis=1), (speed**2).sum(axis=1)
    pushes = (inertial * speed).sum(axis=1), (inertial**2).sum(axis=1)
    own = np.column_stack([*drags, (acceleration * speed).sum(axis=1), (acceleration**2).sum(axis=1)])
    by_mass = np.column_stack([drags[0], pushes[0], pushes[1], (np.sign(speed) * inertial).sum(axis=1)])
    return own, by_mass


def fit(robot, logs):
    """`logs`: (mass, path). The eight weights."""
    share = (2.0 * robot.gyration / robot.track) ** 2
    rows, powers = [], []
    for mass, path in logs:
        _, speed, acceleration, power = read(path)
        own, by_mass = terms(speed, acceleration, share)
        rows.append(np.hstack([own, mass * by_mass]))
        powers.append(power)
    rows = np.vstack(rows)
    scale = np.maximum(np.abs(rows).max(axis=0), 1e-12)
    return np.linalg.lstsq(rows / scale, np.concatenate(powers), rcond=None)[0] / scale


def masses(robot, weights, path, ends, window_s):
    """(mass, half-width of its 95 % interval) at each of the times, kg; within the robot's masses."""
    time, speed, acceleration, power = read(path)
    own, by_mass = terms(speed, acceleration, (2.0 * robot.gyration / robot.track) ** 2)
    slope, rest = by_mass @ weights[4:], power - own @ weights[:4]
    keep = np.exp(-(time[1] - time[0]) / window_s)
    fade = lambda x: lfilter([1.0], [1.0, -keep], x)
    information, score, squares, count = fade(slope**2), fade(slope * rest), fade(rest**2), fade(np.ones(len(rest)))
    found = []
    for end in ends:
        k = min(np.searchsorted(time, end), len(time) - 1)
        mass = score[k] / max(information[k], 1e-300)
        variance = max(squares[k] - mass * score[k], 0.0) / count[k]
        found.append((float(np.clip(mass, robot.empty, robot.full)), 1.96 * float(np.sqrt(variance / max(information[k], 1e-300)))))
    return found
