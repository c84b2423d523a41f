"""pysindy: STLSQ on a dictionary that holds every effect that could be hidden."""

from importlib.metadata import version

import numpy as np

from benchmarks.peers.axis_dictionary import axis_columns
from benchmarks.peers.cut_dictionary import cut_columns
from benchmarks.peers.problem import Answer, Part, Problem, rms, thinned
from benchmarks.peers.stlsq import sparse

VERSION = f"pysindy {version('pysindy')}"
MOST_ROWS = 6000


def answer(problem: Problem) -> Answer:
    """Answer a problem; every column stands for its term."""
    thin = thinned(problem, MOST_ROWS)
    correction, parts = np.zeros_like(problem.difference), list[Part]()
    for i, name in enumerate(problem.names):
        found = cut_columns(problem, i) if problem.table else axis_columns(problem)
        columns = np.array([column for _, _, column in found])
        coefficients = sparse(thin.of(columns).T, thin.of(problem.difference[i]), thin.split)
        correction[i] = coefficients @ columns
        whole, terms = rms(correction[i]), np.array([term for term, _, _ in found])
        for j in np.flatnonzero(coefficients):
            same = terms == terms[j]
            share = rms(coefficients[same] @ columns[same]) / whole
            parts.append(Part(name, *found[j][:2], share))
    return Answer(correction, tuple(parts))
