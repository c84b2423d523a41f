"""Greedy least squares on the same columns: what somebody would write in an afternoon.

A term joins where it lowers the held-out error of eight blocks enough, in their sum and in most of
them; friction and mass are not negative; in the end what the others do as well goes out.
"""

from dataclasses import dataclass, field

import numpy as np

from autodb.proofs.cases.real.held_out import BLOCKS, Blocks, HeldOut, fitted_sizes
from autodb.proofs.cases.real.real_axis import Array
from autodb.proofs.cases.real.real_case import RealCase
from autodb.proofs.cases.real.real_columns import NOT_NEGATIVE, REAL_TERMS, columns_of

JOINS = 0.04
"""Share by which a term lowers the held-out error at least."""
IN_BLOCKS = 6
MOST_TERMS = 4
AS_WELL = 1.02
"""Held-out error without a term, of that with it, up to which it goes out."""
PLAIN_NAMES = (
    "coulomb", "viscous", "inertia", "gravity", "spring", "asymmetry", "stribeck",
    "position_friction", "sensor_drift", "cogging",
)  # fmt: skip
"""Columns of the moves alone."""
PEERS = {"greedy, plain columns": PLAIN_NAMES, "greedy, all columns": REAL_TERMS}


@dataclass(frozen=True)
class PeerAnswer:
    """Names with the peak of what each contributes, and the held-out error with them."""

    sizes: dict[str, float] = field(default_factory=dict)
    held_out: float | None = None


@dataclass(frozen=True)
class _Candidate:
    name: str
    columns: Array


def greedy(case: RealCase, names: tuple[str, ...]) -> PeerAnswer:
    """Explain a case: own terms are free, names join one after another."""
    y = case.axis.effort - case.simulated
    own, picked = case.own.columns, list[_Candidate]()
    for _ in range(MOST_TERMS):
        best = _best(case, names, picked, y)
        if best is None:
            break
        picked.append(best)
    picked = _needed(own, picked, y)
    columns = _stacked(own, picked)
    sizes, first = fitted_sizes(columns, y), len(own)
    found = {}
    for one in picked:
        last = first + len(one.columns)
        found[one.name] = float(np.max(np.abs(sizes[first:last] @ one.columns)))
        first = last
    return PeerAnswer(found, _error(own, picked, y).rms)


def _best(
    case: RealCase, names: tuple[str, ...], picked: list[_Candidate], y: Array
) -> _Candidate | None:
    """Return what lowers the held-out error most, of what may join; None where nothing does."""
    columns = _stacked(case.own.columns, picked)
    left = y - fitted_sizes(columns, y) @ columns
    before = Blocks.of(columns, y).held_out(list(range(len(columns))))
    taken = {*case.includes, *(one.name for one in picked)}
    tried = (
        _Candidate(name, shape)
        for name in names
        if name not in taken
        for shape in columns_of(name, case.axis, case.simulated, left)
    )
    found = [(_gain(before, columns, one, y), one) for one in tried]
    best = max(found, key=lambda pair: pair[0], default=(0.0, None))
    return best[1] if best[0] >= JOINS else None


def _gain(before: HeldOut, columns: Array, candidate: _Candidate, y: Array) -> float:
    """Return the share by which the error falls; 0 where it falls in too few blocks, or oddly."""
    both = np.concatenate([columns, candidate.columns])
    after = Blocks.of(both, y).held_out(list(range(len(both))))
    if np.sum(after.squares < before.squares) < min(IN_BLOCKS, BLOCKS):
        return 0.0
    if candidate.name in NOT_NEGATIVE and fitted_sizes(both, y)[-1] < 0.0:
        return 0.0
    return 1.0 - after.rms / before.rms


def _needed(own: Array, picked: list[_Candidate], y: Array) -> list[_Candidate]:
    """Return the terms without those that the others do as well without."""
    for one in list(picked):
        others = [other for other in picked if other is not one]
        if others and _error(own, others, y).rms < AS_WELL * _error(own, picked, y).rms:
            picked = others
    return picked


def _error(own: Array, picked: list[_Candidate], y: Array) -> HeldOut:
    columns = _stacked(own, picked)
    return Blocks.of(columns, y).held_out(list(range(len(columns))))


def _stacked(own: Array, picked: list[_Candidate]) -> Array:
    return np.concatenate([own, *(one.columns for one in picked)])
