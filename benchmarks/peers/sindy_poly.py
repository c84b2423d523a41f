"""pysindy: STLSQ on all products of up to three signals."""

from importlib.metadata import version

import numpy as np
from pysindy.feature_library import PolynomialLibrary

from benchmarks.peers.problem import Answer, Array, Part, Problem, rms, thinned
from benchmarks.peers.stlsq import sparse

VERSION = f"pysindy {version('pysindy')}"
DEGREE = 3
MOST_ROWS = 8000


def answer(problem: Problem) -> Answer:
    """Answer a problem; what is written stands for no term."""
    thin = thinned(problem, MOST_ROWS)
    correction, parts = np.zeros_like(problem.difference), list[Part]()
    for i, name in enumerate(problem.names):
        columns, texts = _library(problem.signals(i))
        reduced = thin.of(columns.T).T
        coefficients = sparse(reduced, thin.of(problem.difference[i]), thin.split)
        correction[i] = columns @ coefficients
        whole = rms(correction[i])
        parts += [
            Part(name, "", texts[j], rms(columns[:, j] * coefficients[j]) / whole)
            for j in np.flatnonzero(coefficients)
        ]
    return Answer(correction, tuple(parts))


def _library(signals: dict[str, Array]) -> tuple[Array, list[str]]:
    """Return the products (n, p) of signals over their standard deviations, and their texts."""
    values = np.column_stack([(q - np.mean(q)) / np.std(q) for q in signals.values()])
    library = PolynomialLibrary(degree=DEGREE).fit(values)
    columns = np.asarray(library.transform(values), dtype=np.float64)
    return columns, list(library.get_feature_names(list(signals)))
