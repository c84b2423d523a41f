"""gp-elite: genetic programming; its Pareto front is chosen from on the held-out rows."""

from importlib.metadata import version

import numpy as np
from gp_elite import symbolic_regression

from benchmarks.peers.choosing import best
from benchmarks.peers.formula import parsed, parts, values
from benchmarks.peers.problem import Answer, Array, Part, Problem, Thinned, thinned

VERSION = f"gp-elite {version('gp-elite')}"
MOST_ROWS = 2000
WHOLE_S = 200.0
"""Time of the clock after which searches stop, shared by the channels; a free one needs less."""


def answer(problem: Problem) -> Answer:
    """Answer a problem with a formula for each channel."""
    thin = thinned(problem, MOST_ROWS)
    correction, found = np.zeros_like(problem.difference), list[Part]()
    for i in range(len(problem.names)):
        signals, text = problem.signals(i), _formula(problem, i, thin)
        if text is not None:
            formula = parsed(text, signals)
            correction[i] = values(formula, signals)
            found += parts(formula, problem, i)
    return Answer(correction, tuple(found))


def _formula(problem: Problem, channel: int, thin: Thinned) -> str | None:
    signals = {name: thin.of(q) for name, q in problem.signals(channel).items()}
    target = thin.of(problem.difference[channel])
    rows = np.column_stack(list(signals.values()))
    result = symbolic_regression(
        rows[thin.split.fitted],
        target[thin.split.fitted],
        feature_names=list(signals),
        operators="full",
        speed="thorough" if len(problem.names) == 1 else "fast",
        seed=0,
        parallel=False,
        time_limit=WHOLE_S / len(problem.names),
    )
    front = [*(result.pareto or ()), result]
    given: list[tuple[str, Array]] = []
    for one in front:
        text = str(one.sympy())
        given.append((text, values(parsed(text, signals), signals)))
    return best(given, target, thin.split)
