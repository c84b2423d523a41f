"""SysIdentPy: forward regression on all products of up to three signals, its own basis."""

from importlib.metadata import version

import numpy as np
from sysidentpy.basis_function import Polynomial

from benchmarks.peers.forward import forward
from benchmarks.peers.problem import Answer, Array, Part, Problem, rms, thinned

VERSION = f"SysIdentPy {version('sysidentpy')}"
DEGREE = 3
MOST_ROWS = 8000


def answer(problem: Problem) -> Answer:
    """Answer a problem; what is written stands for no term."""
    thin = thinned(problem, MOST_ROWS)
    correction, parts = np.zeros_like(problem.difference), list[Part]()
    for i, name in enumerate(problem.names):
        columns = _products(problem.signals(i))
        target = thin.of(problem.difference[i])
        coefficients = forward(thin.of(columns.T).T, target, thin.split)
        correction[i] = columns @ coefficients
        whole = rms(correction[i])
        parts += [
            Part(name, "", f"product {j}", rms(columns[:, j] * coefficients[j]) / whole)
            for j in np.flatnonzero(coefficients)
        ]
    return Answer(correction, tuple(parts))


def _products(signals: dict[str, Array]) -> Array:
    """Return the products (n, p) of signals over their standard deviations."""
    values = np.column_stack([(q - np.mean(q)) / np.std(q) for q in signals.values()])
    constant = np.ones((len(values), 1))
    return np.asarray(
        Polynomial(degree=DEGREE).fit(
            np.hstack([constant, values]), 0, 1, 1, "NFIR", predefined_regressors=None
        )
    )
