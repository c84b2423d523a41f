"""scikit-learn's Gaussian process: RBF with a length for each input, and white noise."""

import warnings
from importlib.metadata import version

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from benchmarks.peers.problem import Answer, Array, Problem, Split
from benchmarks.peers.regression import Predict, answered

VERSION = f"scikit-learn {version('scikit-learn')}"
MOST_ROWS = 400
AT_ONCE = 4000
LENGTHS = (0.05, 1e3)
NOISE = (1e-4, 1e2)


def answer(problem: Problem) -> Answer:
    """Answer a problem."""
    return answered(problem, _fit, most_rows=MOST_ROWS)


def _fit(rows: Array, target: Array, parts: Split) -> Predict:
    middle, scale = np.mean(rows, axis=0), np.std(rows, axis=0)
    kernel = ConstantKernel() * RBF(np.ones(rows.shape[1]), LENGTHS) + WhiteKernel(1.0, NOISE)
    model = GaussianProcessRegressor(kernel, normalize_y=True, random_state=0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # a length at its bound: no influence
        model.fit(((rows - middle) / scale)[parts.fitted], target[parts.fitted])

    def predict(asked: Array) -> Array:
        scaled = (asked - middle) / scale
        pieces = [model.predict(scaled[i : i + AT_ONCE]) for i in range(0, len(scaled), AT_ONCE)]
        return np.concatenate(pieces)

    return predict
