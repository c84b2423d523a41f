"""How a dynamometer's zero drifts while chips heat it, from what it reads while nothing is cut.

P4 section 5.2 names the effect and leaves it out. In component i the drift is

    level_i · (s u_1 + (1 − s) u_2),   T_k du_k/dt = q − u_k   (``terms.table.thermal_drift``),

each component by its own level, all by the same course: the sensor's top warms quickly, the whole
slowly. Heat q comes with the size of the force, which at one speed goes with the power of the cut,
or as long as it cuts, whichever leaves fewer squares. One time constant, s = 1, is used unless two
have the larger Bayesian information (G. Schwarz, Ann. Statist. 6 (1978) 461), in which each
component of each stretch without a cut counts as one value: a zero that wanders makes rows of a
stretch err alike.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from autodb.signals import flagged_runs
from autodb.terms.table import thermal_drift

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]

ONE_S = tuple(np.geomspace(2.0, 500.0, 34).tolist())
"""Time constants of heating that are tried alone, and the best between neighbours. Chosen."""
TWO_S = (2.0, 3.0, 5.0, 7.0, 10.0, 14.0, 20.0, 30.0, 50.0, 100.0, 200.0, 500.0)
"""Time constants of which two are tried together, with SHARES of the quicker. Chosen."""
APART = 2.0
"""Factor between two time constants from which on they are two. Chosen."""
SHARES = tuple(np.linspace(0.1, 0.9, 9).tolist())
AIR_S = 1.0
"""Time without a cut, before and after one, that a drift is estimated from at least."""
BLOCK_S = 0.1
"""Length over which readings are a mean before a drift is fitted. Chosen: far below its times."""
ROUNDS = 2
"""Times that the size of the force is taken, the second without the drift that the first gave."""


@dataclass(frozen=True)
class Heat:
    """A drift (3, n), N, and the variance (3, n) of what is not known of it, with that of what air
    leaves beside it.

    ``times_s``: none, one or two time constants; ``share``: of the quicker; ``by_force``: whether
    heat comes with the size of the force; ``why``: where no drift was estimated, why.
    """

    drift_N: Array
    variance: Array
    times_s: tuple[float, ...] = ()
    share: float = 1.0
    by_force: bool = False
    why: str | None = None


@dataclass(frozen=True)
class HeatBlocks:
    """Means over BLOCK_S: what is left (3, m), N, whether all of it is air (m,), when (m,), s."""

    left_N: Array
    air: Rows
    t_s: Array

    @property
    def runs(self) -> list[slice]:
        """Stretches without a cut."""
        return flagged_runs(self.air)


@dataclass(frozen=True)
class HeatCourse:
    """A course of heating: time constants, share of the quicker, heat that is put in (m,), the
    column u (m,), and the squares that air leaves.
    """

    times_s: tuple[float, ...]
    share: float
    by_force: bool
    column: Array
    squares: float


def heat_of(left_N: Array, cutting: Rows, t_s: Array) -> Heat:
    """Return the drift of a sensor from what it reads (3, n), N, at times (n,), s, while nothing is
    cut (``cutting`` (n,)).

    Beside it a constant each, which is what the zero has moved by since it was measured. Without
    air before and after the cut it is not estimated, and nothing taken off.
    """
    none = np.zeros_like(left_N)
    air, cuts = np.flatnonzero(~cutting), np.flatnonzero(cutting)
    step_s = float(np.median(np.diff(t_s)))
    if not len(cuts):
        return Heat(none, none, why="nothing is cut")
    before, after = np.sum(air < cuts[0]), np.sum(air > cuts[-1])
    if min(before, after) * step_s < AIR_S:
        said = f"drift is not estimated; record {AIR_S:g} s of air before and after the cut"
        return Heat(none, none, why=said)
    rows = max(1, round(BLOCK_S / step_s))
    blocks = HeatBlocks(
        _means(left_N, rows), _means(cutting.astype(np.float64), rows) == 0.0, _means(t_s, rows)
    )
    on = _means(cutting.astype(np.float64), rows)
    courses = list(_courses(blocks, on, by_force=False))
    drift = np.zeros_like(blocks.left_N)
    for _ in range(ROUNDS):
        size = _size_of_force(left_N - _to_rows(drift, blocks.t_s, t_s), cutting, t_s, rows)
        by_force = list(_courses(blocks, size, by_force=True))
        drift = _fitted(blocks, min(by_force, key=_squares).column)[0]
    chosen, near = _chosen([courses, by_force], values=3 * len(blocks.runs))
    drift, variance = _fitted(blocks, chosen.column)
    spread = np.max([(_fitted(blocks, one.column)[0] - drift) ** 2 for one in near], axis=0)
    found, unknown = (_to_rows(one, blocks.t_s, t_s) for one in (drift, variance + spread))
    unknown += (left_N - found)[:, air].var(axis=1, keepdims=True)
    return Heat(found, unknown, chosen.times_s, chosen.share, chosen.by_force)


def _means(values: Array, rows: int) -> Array:
    """Return means over ``rows`` (…, m) of values (…, n), the last over what is left."""
    begins = np.arange(0, values.shape[-1], rows)
    counts = np.diff(np.append(begins, values.shape[-1]))
    return np.asarray(np.add.reduceat(values, begins, axis=-1) / counts)


def _to_rows(values: Array, block_s: Array, t_s: Array) -> Array:
    return np.array([np.interp(t_s, block_s, one) for one in values])


def _size_of_force(left_N: Array, cutting: Rows, t_s: Array, rows: int) -> Array:
    """Return the mean size (m,) of the force over blocks; of rows that cut it is 1 in the mean.

    From the line between stretches of air; what noise has of size is taken off.
    """
    runs = flagged_runs(~cutting)
    middle = [float(t_s[run].mean()) for run in runs]
    size = np.zeros(len(t_s))
    for one in left_N:
        size += (one - np.interp(t_s, middle, [float(one[run].mean()) for run in runs])) ** 2
    size = np.sqrt(size)
    size = np.maximum(size - float(np.median(size[~cutting])), 0.0) * cutting
    return np.asarray(_means(size, rows) / max(float(size[cutting].mean()), 1e-300))


def _courses(blocks: HeatBlocks, heat: Array, *, by_force: bool) -> Iterator[HeatCourse]:
    """Give every course of heating by an input (m,), first those with one time constant."""
    air = blocks.left_N[:, blocks.air]
    air = air - air.mean(axis=1, keepdims=True)
    whole = float(np.sum(air**2))

    def course(times_s: tuple[float, ...], share: float, column: Array) -> HeatCourse:
        own = column[blocks.air] - column[blocks.air].mean()
        explained = float(np.sum((air @ own) ** 2)) / max(float(own @ own), 1e-300)
        return HeatCourse(times_s, share, by_force, column, whole - explained)

    def alone(time_s: float) -> HeatCourse:
        return course((time_s,), 1.0, thermal_drift(heat, blocks.t_s, time_constant_s=time_s))

    ones = [alone(one) for one in ONE_S]
    yield from ones
    yield alone(_between(ones, lambda time_s: alone(time_s).squares))
    parts = [thermal_drift(heat, blocks.t_s, time_constant_s=one) for one in TWO_S]
    for a, b in combinations(range(len(TWO_S)), 2):
        if TWO_S[b] >= APART * TWO_S[a]:
            for share in SHARES:
                column = share * parts[a] + (1.0 - share) * parts[b]
                yield course((TWO_S[a], TWO_S[b]), share, column)


def _between(ones: Sequence[HeatCourse], squares: Callable[[float], float]) -> float:
    """Return the time constant (s) that leaves the fewest squares, near the best of those tried."""
    from scipy.optimize import minimize_scalar

    best = min(range(len(ones)), key=lambda k: ones[k].squares)
    low, high = (
        float(np.log(ones[k].times_s[0])) for k in (max(best - 1, 0), min(best + 1, len(ones) - 1))
    )
    found = minimize_scalar(
        lambda log_s: squares(float(np.exp(log_s))), bounds=(low, high), method="bounded"
    )
    return float(np.exp(found.x))


def _squares(course: HeatCourse) -> float:
    return course.squares


def _chosen(
    inputs: Sequence[Sequence[HeatCourse]], *, values: int
) -> tuple[HeatCourse, list[HeatCourse]]:
    """Return the course that is used, and all whose likelihood is nearly as large.

    ``values``: how many independent ones were read.
    """
    ones = [[one for one in some if len(one.times_s) == 1] for some in inputs]
    alone = min((min(some, key=_squares) for some in ones), key=_squares)
    same = [one for some in inputs for one in some if one.by_force == alone.by_force]
    two = min((one for one in same if len(one.times_s) == 2), key=_squares)
    # The second time constant and the share are two parameters more
    gained = values * np.log(max(alone.squares, 1e-300) / max(two.squares, 1e-300))
    best = two if gained > 2.0 * np.log(values) else alone
    # Within a standard deviation of the best: half a unit of log likelihood
    most = best.squares * float(np.exp(1.0 / values))
    return best, [one for some in inputs for one in some if one.squares <= most]


def _fitted(blocks: HeatBlocks, column: Array) -> tuple[Array, Array]:
    """Return the drift (3, m) by a course, with the constant beside it, and its variance (3, m)."""
    columns = np.column_stack([column, np.ones(len(column))])
    used = columns[blocks.air]
    inner = np.linalg.pinv(used.T @ used)
    left = blocks.left_N[:, blocks.air]
    sizes = left @ used @ inner
    rest = left - sizes @ used.T
    scatter = rest.var(axis=1) * max(1.0, _together(rest))
    variance = scatter[:, None] * np.einsum("ni,ij,nj->n", columns, inner, columns)
    return sizes @ columns.T, variance


def _together(rest: Array) -> float:
    """Return by what factor sums of neighbouring errors vary more than independent ones."""
    length = max(1, rest.shape[1] // 20)
    count = rest.shape[1] // length
    sums = rest[:, : count * length].reshape(len(rest), count, length).sum(axis=2)
    return float(np.mean(sums.var(axis=1) / np.maximum(length * rest.var(axis=1), 1e-300)))
