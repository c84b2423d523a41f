"""adcd: a search for a correction along each signal, as its README shows for one's own data."""

import logging
import time
from collections.abc import Iterator
from importlib.metadata import version

import numpy as np
import sympy
from adcd import fit
from scipy.stats import spearmanr

from benchmarks.peers.choosing import best
from benchmarks.peers.formula import parts, values
from benchmarks.peers.problem import Answer, Array, Part, Problem, Thinned, thinned

VERSION = f"adcd {version('adcd')}"
MOST_ROWS = 1000
WHOLE_S = 80.0
"""Processor time after which no further search begins, shared by the channels."""


def answer(problem: Problem) -> Answer:
    """Answer a problem with a formula in one signal for each channel."""
    logging.disable(logging.CRITICAL)
    thin = thinned(problem, MOST_ROWS)
    correction, found = np.zeros_like(problem.difference), list[Part]()
    for i in range(len(problem.names)):
        until_s = time.process_time() + WHOLE_S / len(problem.names)
        target = thin.of(problem.difference[i])
        formula = best(_searches(problem, i, thin, until_s), target, thin.split)
        if formula is not None:
            correction[i] = values(formula, problem.signals(i))
            found += parts(formula, problem, i)
    return Answer(correction, tuple(found))


def _searches(
    problem: Problem, channel: int, thin: Thinned, until_s: float
) -> Iterator[tuple[sympy.Expr, Array]]:
    """Search along one signal after the other; a formula that came without its sizes is none."""
    signals = {name: thin.of(q) for name, q in problem.signals(channel).items()}
    measured, simulated = thin.of(problem.measured[channel]), thin.of(problem.simulated[channel])
    rows = thin.split.fitted
    for name in _in_order(signals, measured - simulated):
        if time.process_time() > until_s:
            return
        result = fit(
            X={name: signals[name][rows]},
            y_obs=measured[rows],
            y_classical=simulated[rows],
            limit_variable=name,
            limit_direction="0",
            correction_mode="additive",
            verbose=False,
            seed=0,
        )
        formula = _with_sizes(result.best_expr or "0", name, result.best_theta)
        if {str(symbol) for symbol in formula.free_symbols} <= {name}:
            yield formula, values(formula, signals)


def _in_order(signals: dict[str, Array], target: Array) -> list[str]:
    """Return the signals, those first that go best with the target, as they are or in size."""

    def together(name: str) -> float:
        both = [spearmanr(q, target).statistic for q in (signals[name], np.abs(signals[name]))]
        return max(abs(float(one)) if np.isfinite(one) else 0.0 for one in both)

    return sorted(signals, key=together, reverse=True)


def _with_sizes(text: str, name: str, sizes: dict[str, float]) -> sympy.Expr:
    symbol = sympy.Symbol(name, real=True)
    known = {size: sympy.Float(value) for size, value in sizes.items()}
    return sympy.sympify(text, locals={name: symbol}).subs(known)
