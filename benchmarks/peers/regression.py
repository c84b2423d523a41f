"""What the two methods without formulas share: inputs with and without time, chosen held out."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.choosing import best
from benchmarks.peers.problem import Answer, Array, Problem, Split, thinned

TIMES = ("t", "number")
Predict = Callable[[Array], Array]
Fit = Callable[[Array, Array, Split], Predict]
"""Fits rows (m, k) and a target (m,) on the split's rows."""


def answered(problem: Problem, fit: Fit, *, most_rows: int) -> Answer:
    """Answer a problem channel by channel; what is written has no names."""
    thin = thinned(problem, most_rows)
    correction = np.zeros_like(problem.difference)
    for i in range(len(problem.names)):
        signals, target = problem.signals(i), thin.of(problem.difference[i])
        whole = np.column_stack(list(signals.values()))
        rows = thin.of(whole.T).T
        tried: list[tuple[tuple[Predict, NDArray[np.intp]], Array]] = []
        for left_out in (TIMES, ()):
            kept = np.flatnonzero([name not in left_out for name in signals])
            predict = fit(rows[:, kept], target, thin.split)
            tried.append(((predict, kept), predict(rows[:, kept])))
        chosen = best(tried, target, thin.split)
        if chosen is not None:
            predict, kept = chosen
            correction[i] = predict(whole[:, kept])
    return Answer(correction)
