"""Writes reference/adapt.csv: mass and ground by dense Gaussian conditioning in NumPy. python3 reference_adapt.py

The mass is constant; rolling and scrub are Gauss-Markov processes of unit variance, their correlation over a bucket in the first
column. Behind it three samples a bucket (slopes and what was measured, unit noise), then posterior mean and covariance of the three
at that bucket, from all samples so far at once.
"""

from pathlib import Path

import numpy as np

BUCKETS, SAMPLES = 40, 3
rng = np.random.default_rng(20)
steps = rng.uniform(0.9, 0.999, BUCKETS)
slopes = np.round(rng.normal(size=(BUCKETS, SAMPLES, 3)) * [0.4, 1.5, 0.8], 4)
measured = np.round(rng.normal(size=(BUCKETS, SAMPLES)) * 2.0, 4)
steps = np.round(steps, 4)

# Prior covariance of (mass, rolling_1 .. rolling_n, scrub_1 .. scrub_n).
logs = np.cumsum(np.log(steps))
markov = np.exp(-np.abs(logs[:, None] - logs[None, :]))
prior = np.zeros((1 + 2 * BUCKETS,) * 2)
prior[0, 0] = 1.0
prior[1 : 1 + BUCKETS, 1 : 1 + BUCKETS] = markov
prior[1 + BUCKETS :, 1 + BUCKETS :] = markov

with open(Path(__file__).parent / "reference" / "adapt.csv", "w") as out:
    names = ["correlation"] + [f"{name}{i}" for i in range(SAMPLES) for name in ("m", "r", "s", "p")]
    names += ["mass", "rolling", "scrub"] + [f"c{i}{j}" for i in range(3) for j in range(3)]
    out.write(",".join(names) + "\n")
    for bucket in range(BUCKETS):
        rows, seen = [], []
        for then in range(bucket + 1):
            for sample in range(SAMPLES):
                row = np.zeros(1 + 2 * BUCKETS)
                row[[0, 1 + then, 1 + BUCKETS + then]] = slopes[then, sample]
                rows.append(row)
                seen.append(measured[then, sample])
        h, z = np.array(rows), np.array(seen)
        gain = prior @ h.T @ np.linalg.inv(h @ prior @ h.T + np.eye(len(z)))
        pick = [0, 1 + bucket, 1 + BUCKETS + bucket]
        mean, covariance = (gain @ z)[pick], (prior - gain @ h @ prior)[np.ix_(pick, pick)]
        cells = [steps[bucket]]
        for sample in range(SAMPLES):
            cells += [*slopes[bucket, sample], measured[bucket, sample]]
        cells += [*mean, *covariance.ravel()]
        out.write(",".join(f"{cell:.12g}" for cell in cells) + "\n")
