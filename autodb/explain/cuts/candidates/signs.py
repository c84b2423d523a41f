"""Which way an effect may go: what fitted coefficients must be like for it to have its name."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import LawColumns, SmoothCurve
from autodb.explain.engine.candidates import CandidateForm

Array = NDArray[np.float64]
Allowed = Callable[[Array], bool]

TURN_BACK = 0.25
"""Share of its rise that a monotone curve may fall back, by scatter. Chosen."""


def mostly_positive(columns: LawColumns) -> Allowed:
    """Return whether the coefficient that does most is positive."""

    def allowed(coefficients: Array) -> bool:
        return bool(coefficients[np.argmax(np.abs(coefficients) * columns.strength)] > 0)

    return allowed


def mostly_negative(columns: LawColumns) -> Allowed:
    """Return whether the coefficient that does most is negative."""
    positive = mostly_positive(columns)
    return lambda coefficients: not positive(coefficients)


def monotone(curve: SmoothCurve, columns: LawColumns, *, direction: float = 0.0) -> Allowed:
    """Return whether a curve goes one way but for scatter: the components' mean by their weight."""

    def allowed(coefficients: Array) -> bool:
        weight = columns.strength.reshape(-1, curve.width).mean(axis=1)
        mean = weight @ coefficients.reshape(-1, curve.width)
        steps = np.diff(curve.along @ mean)
        net, way = float(steps.sum()), float(np.abs(steps).sum())
        right_way = direction == 0.0 or np.sign(net) == direction
        return bool(right_way and way - abs(net) <= 2.0 * TURN_BACK * abs(net))

    return allowed


def turns_away(columns: LawColumns) -> Allowed:
    """Return whether thrust goes from the axial into the radial force, but for scatter."""

    def allowed(coefficients: Array) -> bool:
        sensed = coefficients * columns.strength
        return bool(sensed.min() > -0.25 * sensed.max())

    return allowed


def grows(columns: LawColumns, shape: dict[str, float]) -> CandidateForm:
    """Return a shape that is the effect's where it adds force."""
    return CandidateForm(columns, shape, allowed=mostly_positive(columns))
