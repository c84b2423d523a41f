"""Laws over cuts, how the components share them, and which way they may go.

A law gives columns for every component; its spread says which of them move together: all alike by
one factor, each by its own, or one component alone. Inner products of all laws are taken once,
component by component, and spread afterwards: block-diagonal columns are never written out. A law
has an effect's name only where its fitted coefficients have the effect's sign.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from autodb.explain.cuts.stack import Conditions, Stack
from autodb.explain.engine.candidates import CandidateForm

Array = NDArray[np.float64]
Rows = slice
ALL = slice(None)
Allowed = Callable[[Array], bool]

RUBS = 0.1
"""Growth of the second of several components of a worn edge, of that of the strongest, at least.
Chosen: friction on a flank is 0.2 to 0.6 of its pressure, and half of that is left to scatter."""
TURN_BACK = 0.25
"""Share of its rise that a monotone curve may fall back, by scatter. Chosen."""


@dataclass(frozen=True, eq=False)
class SpreadLaw:
    """Columns (C, rows, width) of every component [N per coefficient]."""

    build: Callable[[Rows], Array]
    width: int = 1


@dataclass(frozen=True, eq=False)
class LawColumns:
    """A law in a spread: ``mix`` (C, width, p) adds up the law's columns to p of the stack.

    ``sd`` (p,): of the coefficients' prior, None where they have none.
    """

    stack: Stack
    law: SpreadLaw
    mix: Array
    sd: Array | None = None

    @property
    def precision(self) -> Array:
        """Precision (p,) of the coefficients' prior, 0 where there is none."""
        return np.zeros(self.mix.shape[2]) if self.sd is None else self.sd**-2.0

    def raw(self, rows: Rows = ALL) -> Array:
        """Return the columns (C, rows, p) [N per coefficient]."""
        return np.asarray(np.einsum("cnq,cqp->cnp", self.law.build(rows), self.mix))

    def __call__(self, rows: Rows = ALL) -> Array:
        """Return the white columns (C·m, p) of some cuts."""
        return self.stack.white(self.raw(rows), rows)

    @cached_property
    def strength(self) -> Array:
        """Norm of each white column, (p,)."""
        squares = [np.sum(self(rows) ** 2, axis=0) for rows in self.stack.chunks]
        return np.asarray(np.sqrt(np.sum(squares, axis=0)))

    @cached_property
    def mean(self) -> Array:
        """Mean of each column in each component [N per coefficient], (C, p)."""
        sums = [np.sum(self.raw(rows), axis=1) for rows in self.stack.chunks]
        return np.asarray(np.sum(sums, axis=0) / len(self.stack.known))

    def of(self, component: int) -> Array:
        """Return the columns (n, p) of one component [N per coefficient]."""
        return np.concatenate([self.raw(rows)[component] for rows in self.stack.chunks])

    def part(self, coefficients: Array) -> Array:
        """Return what the columns add up to with coefficients (p,), (C, n) [N]."""
        mixed = (self.mix @ coefficients)[:, :, None]
        parts = [(self.law.build(rows) @ mixed)[:, :, 0] for rows in self.stack.chunks]
        return np.concatenate(parts, axis=1)


def alike(stack: Stack, law: SpreadLaw) -> LawColumns:
    """Return a law with one coefficient for all components, by column."""
    return LawColumns(stack, law, np.stack([np.eye(law.width)] * len(stack.names)))


def each(stack: Stack, law: SpreadLaw) -> LawColumns:
    """Return a law with coefficients of each component: all of the first component, then on."""
    count, width = len(stack.names), law.width
    return LawColumns(stack, law, np.eye(count * width).reshape(count, width, count * width))


def only(stack: Stack, law: SpreadLaw, component: int) -> LawColumns:
    """Return a law of one component."""
    mix = np.zeros((len(stack.names), law.width, law.width))
    mix[component] = np.eye(law.width)
    return LawColumns(stack, law, mix)


def tied(stack: Stack, law: SpreadLaw, ratio: Array) -> LawColumns:
    """Return a law whose components move in a given ratio (C,), by column."""
    return LawColumns(stack, law, ratio[:, None, None] * np.eye(law.width))


def relative(stack: Stack, shape: Callable[[Rows], Array], width: int = 1) -> SpreadLaw:
    """Return a factor on the whole simulated force: F · shape, shape (rows, width)."""
    return _scaled(stack.simulation, shape, width)


def chip_factor(stack: Stack, shape: Callable[[Rows], Array], width: int = 1) -> SpreadLaw:
    """Return a factor on the chip's part of the simulated force."""
    return _scaled(stack.chip, shape, width)


def per_depth(stack: Stack, shape: Callable[[Rows], Array], width: int = 1) -> SpreadLaw:
    """Return a force per depth of cut in the direction of each component: a_p · shape."""
    return _scaled(stack.sign[:, None] * stack.known.depth_mm, shape, width)


def along_edge(stack: Stack) -> SpreadLaw:
    """Return the edge's force of the simulation by its coefficient: the length that it acts on."""
    return _scaled(stack.sign[:, None] * stack.edge_mm, values_of(np.ones(len(stack.known))), 1)


def added(stack: Stack, shape: Callable[[Rows], Array], width: int = 1) -> SpreadLaw:
    """Return a force that is there whatever the cut."""
    return _scaled(np.ones_like(stack.simulation), shape, width)


def as_simulated(part: Array) -> SpreadLaw:
    """Return a part (C, n) of the simulated force, by a share of it."""
    return _scaled(part, values_of(np.ones(part.shape[1])), 1)


def _scaled(scale: Array, shape: Callable[[Rows], Array], width: int) -> SpreadLaw:
    def build(rows: Rows) -> Array:
        columns = shape(rows)
        return np.asarray(scale[:, rows, None] * columns.reshape(len(columns), -1))

    return SpreadLaw(build, width)


def values_of(values: Array) -> Callable[[Rows], Array]:
    """Return the shape that has these values (n,) or (n, width)."""
    return lambda rows: values[rows]


@dataclass(frozen=True, eq=False)
class SmoothCurve:
    """A smooth curve over a variable (n,): cubic B-splines, or a step for each of few levels.

    ``like``: values that knots and levels are taken from, where they are not its own. Beyond them
    the curve keeps its last value; between two levels it is straight.
    """

    values: Array
    count: int
    like: Array | None = None

    @property
    def frame(self) -> Array:
        """The values that knots and levels are taken from."""
        return self.values if self.like is None else self.like

    @cached_property
    def levels(self) -> Array | None:
        """The levels of a variable that takes few, None for others."""
        found = np.unique(self.frame)
        return found if len(found) <= self.count else None

    @cached_property
    def width(self) -> int:
        """Number of columns."""
        return self.count if self.levels is None else len(self.levels)

    @cached_property
    def knots(self) -> Array:
        """Knots at quantiles of the distinct values, each end four times."""
        distinct = np.unique(self.frame)
        low, high = distinct[0], distinct[-1]
        inner = np.quantile(distinct, np.linspace(0, 1, self.count - 2)[1:-1])
        return np.concatenate([[low] * 4, inner, [high] * 4])

    def at(self, values: Array) -> Array:
        """Return the columns (m, width) at values (m,)."""
        if self.levels is not None:
            near = [np.interp(values, self.levels, one) for one in np.eye(len(self.levels))]
            return np.column_stack(near)
        inside = np.clip(values, self.knots[0], self.knots[-1])
        matrix = BSpline.design_matrix(inside, self.knots, 3)
        return np.asarray(matrix.toarray(), dtype=np.float64)

    def __call__(self, rows: Rows) -> Array:
        """Return the columns (rows, width)."""
        return self.at(self.values[rows])

    @cached_property
    def along(self) -> Array:
        """Columns (m, width) at rising values, to look at a fitted curve."""
        low, high = float(self.frame.min()), float(self.frame.max())
        return self.at(self.levels if self.levels is not None else np.linspace(low, high, 40))


def curve_of(stack: Stack, over: Callable[[Conditions], Array], count: int) -> SmoothCurve:
    """Return the curve over what is read off the conditions, its knots those of the table."""
    return SmoothCurve(over(stack.known), count, over(stack.frame.known))


def mostly_positive(columns: LawColumns) -> Allowed:
    """Return whether the coefficient that does most is positive."""

    def allowed(coefficients: Array) -> bool:
        return bool(coefficients[np.argmax(np.abs(coefficients) * columns.strength)] > 0)

    return allowed


def mostly_negative(columns: LawColumns) -> Allowed:
    """Return whether the coefficient that does most is negative."""
    positive = mostly_positive(columns)
    return lambda coefficients: not positive(coefficients)


def pressing(columns: LawColumns, beside: Allowed | None) -> Allowed:
    """Return whether force grows in more than one of several components: a worn flank presses on
    the work and rubs along it. What one of them has alone is its sensor's.

    ``beside``: what is asked besides.
    """
    stack = columns.stack

    def allowed(coefficients: Array) -> bool:
        grown = np.sort(stack.sign * (columns.mean @ coefficients))
        alone = len(grown) > 1 and grown[-2] < RUBS * np.abs(grown).max()
        return not alone and (beside is None or beside(coefficients))

    return allowed


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
    """Return whether thrust goes from the axial into the radial force, but for scatter, and no more
    of it than there is in any cut.
    """
    stack = columns.stack
    axial = stack.names.index("force.z")
    share = columns.raw()[axial] / np.abs(stack.simulation[axial])[:, None]

    def allowed(coefficients: Array) -> bool:
        sensed = coefficients * columns.strength
        taken = float(np.max(np.abs(share @ coefficients)))
        return bool(sensed.min() > -0.25 * sensed.max() and taken <= 1.0)

    return allowed


def grows(columns: LawColumns, shape: dict[str, float]) -> CandidateForm:
    """Return a shape that is the effect's where it adds force."""
    return CandidateForm(columns, shape, allowed=mostly_positive(columns))
