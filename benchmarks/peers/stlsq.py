"""Sequentially thresholded least squares of pysindy on given columns, settings held out.

Source: Brunton, Proctor, Kutz 2016, Discovering governing equations from data by sparse
identification of nonlinear dynamical systems, PNAS 113:3932.
"""

import warnings
from collections.abc import Iterator

import numpy as np
from pysindy.optimizers import STLSQ

from benchmarks.peers.choosing import best
from benchmarks.peers.problem import Array, Rows, Split, rms

THRESHOLDS = np.geomspace(0.6, 0.02, 10)
"""Shares of the target's norm below which a column is dropped."""
RIDGES = (0.05, 0.5, 5.0)
"""Weights of squared coefficients beside columns of unit norm; pysindy's own is the first."""
Setting = tuple[float, float]


def sparse(columns: Array, target: Array, parts: Split) -> Array:
    """Return coefficients (p,) of columns (m, p), most of them 0, for a target (m,)."""
    setting = best(_tried(columns, target, parts.fitted), target, parts)
    if setting is None:
        return np.zeros(columns.shape[1])
    return _fitted(columns, target, np.ones_like(parts.fitted), setting)


def _tried(columns: Array, target: Array, rows: Rows) -> Iterator[tuple[Setting, Array]]:
    for threshold in THRESHOLDS:
        for ridge in RIDGES:
            setting = float(threshold), ridge
            yield setting, columns @ _fitted(columns, target, rows, setting)


def _fitted(columns: Array, target: Array, rows: Rows, setting: Setting) -> Array:
    """Return coefficients at a threshold and a ridge; columns of zeros in these rows get none.

    A column of unit norm has the norm of its contribution as coefficient.
    """
    used = np.flatnonzero(np.any(columns[rows] != 0.0, axis=0))
    threshold, ridge = setting
    level = threshold * rms(target[rows]) * float(np.sqrt(np.count_nonzero(rows)))
    optimiser = STLSQ(threshold=level, alpha=ridge, normalize_columns=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that a threshold eliminates everything is an answer
        optimiser.fit(columns[rows][:, used], target[rows][:, None])
    coefficients = np.zeros(columns.shape[1])
    coefficients[used] = np.ravel(optimiser.coef_)
    return coefficients
