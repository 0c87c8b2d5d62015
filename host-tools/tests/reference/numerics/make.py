"""Reference numbers for least squares with a prior (host-tools/numerics/src/least_squares), by SciPy.

    python3 -m venv venv && venv/bin/pip install numpy scipy && venv/bin/python make.py

writes prior_least_squares.json beside this file. The prior is put in as further rows, L (theta + delta - mu) with L'L = P, and the
stacked problem is solved by an orthogonal factorisation (scipy.linalg.lstsq), which shares nothing with normal equations. The
further column's score is the last coefficient of the problem with that column in it.
"""

import json
from pathlib import Path

import numpy as np
from scipy.linalg import cholesky, inv, lstsq

random = np.random.default_rng(11)
rows, columns = 40, 4
# Columns of unlike units, one next to another.
slopes = random.normal(size=(rows, columns)) * [1.0, 1e-3, 50.0, 1e4]
slopes[:, 2] = 50 * (slopes[:, 0] + 0.05 * slopes[:, 2] / 50)
further = random.normal(size=rows) + slopes[:, 0] + slopes[:, 3] / 1e4
weights = random.uniform(0.2, 3.0, size=rows)
residual = random.normal(size=rows) + 0.7 * further
root = random.normal(size=(2, 2))
precision = root @ root.T + np.diag([1.0, 1e4])
offset = np.array([0.3, -0.02])


def solve(slopes):
    """Solution, covariance and what is left, prior included."""
    known = len(offset)
    factor = cholesky(precision)
    pad = np.zeros((known, slopes.shape[1]))
    pad[:, :known] = factor
    stacked = np.vstack([np.sqrt(weights)[:, None] * slopes, pad])
    right = np.concatenate([np.sqrt(weights) * residual, -factor @ offset])
    scale = np.linalg.norm(stacked, axis=0)
    solution = lstsq(stacked / scale, right)[0] / scale
    triangle = np.linalg.qr(stacked / scale, mode="r")
    half = inv(triangle) / scale[:, None]
    loss = np.sum((right - stacked @ solution) ** 2)
    return solution, half @ half.T, loss


solution, covariance, loss = solve(slopes)
joint, joint_covariance, joint_loss = solve(np.column_stack([slopes, further]))
reference = {
    "slopes": slopes.tolist(),
    "further": further.tolist(),
    "weights": weights.tolist(),
    "residual": residual.tolist(),
    "precision": precision.tolist(),
    "offset": offset.tolist(),
    "solution": solution.tolist(),
    "covariance": covariance.tolist(),
    "loss": loss,
    "further_value": joint[-1],
    "further_std_err": np.sqrt(joint_covariance[-1, -1]),
    "loss_with_further": joint_loss,
}
Path(__file__).with_name("prior_least_squares.json").write_text(json.dumps(reference, indent=1) + "\n")
