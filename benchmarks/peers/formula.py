"""A formula in the inputs as numbers, and as a reader sees it: its summands and their terms."""

import numpy as np
import sympy

from benchmarks.peers.problem import Array, Part, Problem, rms
from benchmarks.peers.reading import Summand, axis_term, cut_term

Signals = dict[str, Array]
TURNED = ("s", "v")
STRAIGHT = 0.999


def parsed(text: str, signals: Signals, functions: dict[str, object] | None = None) -> sympy.Expr:
    """Return a formula; a name that is an input is that input, whatever it means otherwise."""
    names: dict[str, object] = {name: sympy.Symbol(name, real=True) for name in signals}
    return sympy.sympify(text, locals={**(functions or {}), **names})


def values(formula: sympy.Expr, signals: Signals) -> Array:
    """Return a formula at every row, (n,); what is no number there is 0."""
    symbols = [sympy.Symbol(name, real=True) for name in signals]
    with np.errstate(all="ignore"):
        given = sympy.lambdify(symbols, formula, "numpy")(*signals.values())
    full = np.broadcast_to(
        np.asarray(given, dtype=np.complex128), len(next(iter(signals.values())))
    )
    real = np.where(np.abs(full.imag) > 0.0, np.nan, full.real)
    return np.nan_to_num(real, nan=0.0, posinf=0.0, neginf=0.0)


def parts(formula: sympy.Expr, problem: Problem, channel: int) -> list[Part]:
    """Return what a reader reads: summands of the expanded formula, shares of all of one term."""
    signals = problem.signals(channel)
    read = cut_term if problem.table else axis_term
    found = [
        (read(_summand(one, signals)), str(one), values(one, signals))
        for one in sympy.Add.make_args(sympy.expand(formula))
    ]
    whole = rms(np.sum([given for _, _, given in found], axis=0))
    if whole == 0.0:
        return []
    return [
        Part(
            problem.names[channel],
            term,
            text,
            rms(np.sum([given for other, _, given in found if other == term], axis=0)) / whole,
        )
        for term, text, _ in found
    ]


def _summand(one: sympy.Expr, signals: Signals) -> Summand:
    names = frozenset(str(symbol) for symbol in one.free_symbols)
    here = values(one, signals)
    other_way = {name: -q if name in TURNED else q for name, q in signals.items()}
    if names == {"sim"}:
        other_way["sim"] = -signals["sim"]
    there = values(one, other_way)
    straight = False
    if len(names) == 1 and np.ptp(here) > 0.0:
        straight = abs(np.corrcoef(here, signals[next(iter(names))])[0, 1]) > STRAIGHT
    return Summand(
        names,
        even=rms(here - there) < rms(here + there),
        wave=one.has(sympy.sin, sympy.cos),
        straight=straight,
    )
