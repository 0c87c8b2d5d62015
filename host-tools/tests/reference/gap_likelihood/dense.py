"""Evidences of a small problem by its whole covariance: numbers for host-tools/gap/src/likelihood/tests.rs.

    python dense.py

Four runs of 25 rows, two in the field. No run's products, no Schur complements: the covariance of all 100 rows.
"""

import numpy as np

RUNS, ROWS, BASE, FUNCTIONS = 4, 25, 2, 3
SHARED, OWN, LOOSE, OTHER, SIZE = [0.3, 0.02, 0.5], [0.1, 0.2, 0.05], 1e-2, 0.04, 0.7


def value(run, row, column):
    """Column 0 is what was measured, then base, functions, and one effect."""
    return np.sin(0.37 * (column + 1) * row + 1.3 * run + 0.9 * column) + 0.1 * column * np.cos(0.11 * row * (run + 1))


def columns(first, count):
    return np.array([[value(run, row, first + k) for k in range(count)] for run in range(RUNS) for row in range(ROWS)])


def log_evidence(size, other):
    y, base, functions, effect = columns(0, 1)[:, 0], columns(1, BASE), columns(1 + BASE, FUNCTIONS), columns(1 + BASE + FUNCTIONS, 1)[:, 0]
    run = np.repeat(np.arange(RUNS), ROWS)
    field = run < 2
    covariance = np.eye(len(y)) + base @ base.T / LOOSE + functions @ np.diag(SHARED) @ functions.T
    covariance += (run[:, None] == run) * (functions @ np.diag(OWN) @ functions.T)
    both = np.outer(field, field)
    covariance += both * (other * functions @ functions.T + size**2 * np.outer(effect, effect))
    return -0.5 * (y @ np.linalg.solve(covariance, y) + np.linalg.slogdet(covariance)[1])


none = log_evidence(0.0, 0.0)
print("effect", float(log_evidence(SIZE, 0.0) - none))
print("something else", float(log_evidence(0.0, OTHER) - none))
print("effect beside something else", float(log_evidence(SIZE, OTHER) - log_evidence(0.0, OTHER)))
