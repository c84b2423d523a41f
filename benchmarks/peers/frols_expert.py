"""SysIdentPy: forward regression on a dictionary that holds every effect that could be hidden."""

from importlib.metadata import version

import numpy as np

from benchmarks.peers.axis_dictionary import axis_columns
from benchmarks.peers.cut_dictionary import cut_columns
from benchmarks.peers.forward import forward
from benchmarks.peers.problem import Answer, Part, Problem, rms, thinned

VERSION = f"SysIdentPy {version('sysidentpy')}"
MOST_ROWS = 6000


def answer(problem: Problem) -> Answer:
    """Answer a problem; every column stands for its term."""
    thin = thinned(problem, MOST_ROWS)
    correction, parts = np.zeros_like(problem.difference), list[Part]()
    for i, name in enumerate(problem.names):
        found = cut_columns(problem, i) if problem.table else axis_columns(problem)
        columns = np.array([column for _, _, column in found])
        target = thin.of(problem.difference[i])
        coefficients = forward(thin.of(columns).T, target, thin.split)
        correction[i] = coefficients @ columns
        whole, terms = rms(correction[i]), np.array([term for term, _, _ in found])
        for j in np.flatnonzero(coefficients):
            same = terms == terms[j]
            share = rms(coefficients[same] @ columns[same]) / whole
            parts.append(Part(name, *found[j][:2], share))
    return Answer(correction, tuple(parts))
