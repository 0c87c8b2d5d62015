"""Gaussian process and perceptron by scikit-learn and NumPy."""

import warnings

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from sklearn.metrics import r2_score
from sklearn.neural_network import MLPRegressor

import drive

LENGTHS = (0.1, 100.0)
GIVEN = [([0.6, 1.1, 1.9, 5.0], 0.05), ([2.0, 2.0, 2.0, 2.0], 0.1), ([0.3, 0.8, 20.0, 100.0], 1e-3)]


def kernel(signal, lengths, noise, free):
    bounds = {"constant_value_bounds": (1e-6, 1e6)} if free else {"constant_value_bounds": "fixed"}
    length_bounds, noise_bounds = (LENGTHS, (1e-9, 1e3)) if free else ("fixed", "fixed")
    smooth = ConstantKernel(signal, **bounds) * RBF(lengths, length_bounds)
    return smooth + WhiteKernel(signal * noise, noise_bounds)


def process():
    """Samples in standard deviations of their inputs; likelihoods and means at given parameters; and the most likely."""
    rng = np.random.default_rng(11)
    i = np.arange(140)
    x = np.sqrt(2) * np.sin(np.outer(i, [0.911, 1.717, 2.323, 3.137]))
    y = np.sin(2.0 * x[:, 0]) + 0.6 * np.cos(1.1 * x[:, 1]) * x[:, 2] + 0.2 * x[:, 3] + rng.normal(0, 0.15, len(i))
    samples = np.round(np.column_stack([x, y]), 6)
    x, y = samples[:, :4], samples[:, 4]
    at = np.round(np.sqrt(2) * np.sin(np.outer(np.arange(12) + 0.5, [0.911, 1.717, 2.323, 3.137])), 6)
    given = []
    for lengths, noise in GIVEN:
        # The signal's variance at which these are the most likely, by its normal equations.
        unit = kernel(1.0, lengths, noise, False)
        signal = y @ np.linalg.solve(unit(x), y) / len(y)
        fixed = GaussianProcessRegressor(kernel(signal, lengths, noise, False), alpha=0.0, optimizer=None).fit(x, y)
        given.append({"lengths": lengths, "noise": noise, "signal": np.sqrt(signal),
                      "log_likelihood": fixed.log_marginal_likelihood_value_, "means": fixed.predict(at).tolist()})
    free = GaussianProcessRegressor(kernel(1.0, [1.0] * 4, 0.1, True), alpha=0.0, n_restarts_optimizer=6, random_state=1)
    free.fit(x, y)
    print("most likely:", free.kernel_, free.log_marginal_likelihood_value_)
    return {"samples": samples.tolist(), "at": at.tolist(), "given": given,
            "best_log_likelihood": free.log_marginal_likelihood_value_}


def network():
    """Output, and the derivative of the sum of slope times output, of a network of 3, 5, 4 and 1 neurons."""
    rng = np.random.default_rng(3)
    sizes = [3, 5, 4, 1]
    layers = [(np.round(rng.normal(0, 0.7, (o, i)), 3), np.round(rng.normal(0, 0.3, o), 3))
              for i, o in zip(sizes, sizes[1:])]
    x, slopes = np.round(rng.normal(0, 1, (3, 8)), 3), np.round(rng.normal(0, 1, (1, 8)), 3)
    signals = [x]
    for place, (weight, bias) in enumerate(layers):
        after = weight @ signals[-1] + bias[:, None]
        # No kink of a ReLU is near enough for single precision to end up on its other side.
        assert place == 2 or np.abs(after).min() > 1e-3
        signals.append(after if place == 2 else np.maximum(after, 0))
    gradient, back = [], slopes
    for place in (2, 1, 0):
        if place < 2:
            back = back * (signals[place + 1] > 0)
        gradient.insert(0, {"weight": (back @ signals[place].T).tolist(), "bias": back.sum(axis=1).tolist()})
        back = layers[place][0].T @ back
    return {"layers": [{"weight": w.tolist(), "bias": b.tolist()} for w, b in layers], "inputs": x.tolist(),
            "slopes": slopes[0].tolist(), "outputs": signals[-1][0].tolist(), "gradient": gradient}


def perceptron(log):
    """R² of eight perceptrons on the run that they have not seen: seven layers of 32, as the paper trains them.

    The loss of scikit-learn is half the mean square, so that its tolerance is half of that in variances of the power.
    """
    column = dict(zip(drive.COLUMNS, log.T))
    v, omega = drive.body(column["wl"], column["wr"], drive.RADIUS, drive.TRACK)
    dv, domega = drive.body(column["al"], column["ar"], drive.RADIUS, drive.TRACK)
    x, y = np.column_stack([v, omega, dv, domega, column["mass_kg"]]), column["level_w"]
    known, unseen = slice(0, drive.TRAINING), slice(drive.TRAINING, None)
    x = (x - x[known].mean(axis=0)) / x[known].std(axis=0)
    target = (y - y[known].mean()) / y[known].std()
    warnings.simplefilter("ignore", ConvergenceWarning)
    found = []
    for seed in range(8):
        model = MLPRegressor(hidden_layer_sizes=(32,) * 7, alpha=0.0, learning_rate_init=0.01, batch_size=200, tol=0.5e-4,
                             n_iter_no_change=50, max_iter=1000, random_state=seed).fit(x[known], target[known])
        found.append(r2_score(target[unseen], model.predict(x[unseen])))
    return found
