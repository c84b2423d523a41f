"""gplearn: genetic programming; its parsimony is chosen on the held-out rows."""

from collections.abc import Iterator
from importlib.metadata import version

import numpy as np
import sympy
from gplearn.genetic import SymbolicRegressor

from benchmarks.peers.choosing import best
from benchmarks.peers.formula import parsed, parts
from benchmarks.peers.problem import Answer, Array, Part, Problem, Thinned, thinned

VERSION = f"gplearn {version('gplearn')}"
MOST_ROWS = 1000
PARSIMONY = (0.01, 0.001)
SETTINGS = {
    "population_size": 1000,
    "generations": 20,
    "function_set": ("add", "sub", "mul", "div", "sqrt", "abs", "neg", "max", "min", "sin", "cos"),
    "const_range": (-5.0, 5.0),
    "metric": "rmse",
    "random_state": 0,
}
WRITTEN = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "neg": lambda a: -a,
    "sqrt": lambda a: sympy.sqrt(abs(a)),
    "abs": sympy.Abs,
    "max": sympy.Max,
    "min": sympy.Min,
}


def answer(problem: Problem) -> Answer:
    """Answer a problem with a formula for each channel."""
    thin = thinned(problem, MOST_ROWS)
    correction, found = np.zeros_like(problem.difference), list[Part]()
    for i in range(len(problem.names)):
        signals = problem.signals(i)
        scales = {name: float(np.max(np.abs(q))) for name, q in signals.items()}
        size = float(np.std(problem.difference[i]))
        chosen = best(_tried(problem, i, thin, scales), thin.of(problem.difference[i]), thin.split)
        if chosen is None:
            continue
        rows = np.column_stack([q / scales[name] for name, q in signals.items()])
        correction[i] = size * chosen.predict(rows)
        scaled = {
            sympy.Symbol(n, real=True): sympy.Symbol(n, real=True) / s for n, s in scales.items()
        }
        formula = parsed(str(chosen), signals, dict(WRITTEN))
        found += parts(size * formula.subs(scaled, simultaneous=True), problem, i)
    return Answer(correction, tuple(found))


def _tried(
    problem: Problem, channel: int, thin: Thinned, scales: dict[str, float]
) -> Iterator[tuple[SymbolicRegressor, Array]]:
    """Fit at each parsimony, signals over their largest, the target over its deviation."""
    signals = {name: thin.of(q) / scales[name] for name, q in problem.signals(channel).items()}
    rows = np.column_stack(list(signals.values()))
    size = float(np.std(problem.difference[channel]))
    target = thin.of(problem.difference[channel]) / size
    for parsimony in PARSIMONY:
        model = SymbolicRegressor(
            feature_names=list(signals), parsimony_coefficient=parsimony, **SETTINGS
        )
        model.fit(rows[thin.split.fitted], target[thin.split.fitted])
        yield model, size * model.predict(rows)
