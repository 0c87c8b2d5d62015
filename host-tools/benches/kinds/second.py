"""A drive of the second simulator's servo: python second.py JUDGE MASS REFERENCE.npy OUT.npz"""

import sys

import numpy as np

sys.path.insert(0, sys.argv[1])

from drives import STEP
from plant import World, integrate
from robots import ROBOTS

ROBOT = "servo"
# The reference's rate.
EVERY = round(0.005 / STEP)

mass, reference = float(sys.argv[2]), np.load(sys.argv[3])
robot = ROBOTS[ROBOT]
count = len(reference) * EVERY
wheels = np.column_stack([np.interp(np.arange(1, count + 1), EVERY * np.arange(1, len(reference) + 1), w) for w in reference.T])
none, pairs = np.zeros(count), np.zeros((count, 2))
power, angle, _ = integrate(robot, World(), mass, wheels, none + robot.rolling, none, pairs, pairs)
np.savez(sys.argv[4], angle=angle[EVERY - 1 :: EVERY], power=power.reshape(-1, EVERY).mean(axis=1))
