"""Steps one and two of a linear drive: the load over the travel, a line and a table of a pole (P0).

The mean of both ways at one speed is the load alone, where friction is alike in both directions.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.fitting.groups import small_sample
from autodb.sensing.drives.staged.clusters import lack, one_out, scores, within
from autodb.sensing.drives.staged.pairs import Pairs, pairs_of
from autodb.sensing.drives.staged.stages import MeasuredStretch
from autodb.sensing.drives.staged.weight import Weight, weight_of
from autodb.terms.ripple import cogging_table
from autodb.wording import localized, phrase

Array = NDArray[np.float64]
Numbers = NDArray[np.intp]

FEWEST_PAIRS = 4
"""Passes there and back over the travel, which tell how sure its load is. Chosen."""
FEWEST_POLES = 3.0
"""Poles that such passes cross at least: a line within one pole is no line. Chosen."""
CROSSED = 0.5
"""Share of the travel that they cross at least. Chosen."""
NEARLY = 0.99
"""Part of that way from segment's middle to segment's middle that will do."""
PATCHES = 10
"""Parts of the travel within which the load's deviations are alike, where no pole is known."""


@dataclass(frozen=True)
class TravelLoad:
    """Load over the travel, effort's unit: ``level`` + columns · values, columns x mm and a table.

    ``values``: slope k and, with a pole, the table's nodes but the last; ``covariance`` of them;
    ``level`` at x = 0: weight, a sensor's zero and what friction differs by direction in one.
    ``centre``: the columns' mean over the passes, there the level is sure by its own sd.
    ``lack``: sd of the load at a place off line and table, beyond the error; ``off`` (k,): by how
    much it is, place by place; ``pairs``: how many passes there and back told it.
    """

    level: Weight
    values: Array
    covariance: Array
    centre: Array
    pole_mm: float | None
    lack: float
    off: Array
    pairs: int

    def at(self, x_mm: Array) -> Array:
        """Return the load (n,) at places (n,)."""
        return np.asarray(self.level.value + _columns(x_mm, self.pole_mm) @ self.values)

    def told(self, x_mm: Array, take: Array) -> tuple[Array, Array]:
        """Return sums ``take`` (q, n) of the loads at places (n,), and their sd (q,).

        Of line and table: by how much the load at a place is off them is not in it.
        """
        whole = take.sum(axis=1)
        columns = take @ _columns(x_mm, self.pole_mm)
        off_centre = columns - np.multiply.outer(whole, self.centre)
        variance = np.einsum("ij,jk,ik->i", off_centre, self.covariance, off_centre)
        sd = np.sqrt(np.maximum(variance, 0.0) + (whole * self.level.sd) ** 2)
        return whole * self.level.value + columns @ self.values, sd

    def lack_over(self, places: int) -> float:
        """Return the rms of what the load is off line and table in the mean of neighbours."""
        count = min(places, len(self.off))
        means = np.convolve(self.off, np.full(count, 1.0 / count), mode="valid")
        return float(np.sqrt(np.mean(means**2)))

    @property
    def slope(self) -> tuple[float, float]:
        """k, effort's unit over mm, and its sd."""
        return float(self.values[0]), float(np.sqrt(self.covariance[0, 0]))

    @property
    def rest(self) -> tuple[float, float]:
        """Place s_r mm at which the line is 0, and its sd: −level/k."""
        k, level = self.values[0], self.level.value
        by_values = self.centre / k
        by_values[0] += level / k**2
        variance = by_values @ self.covariance @ by_values + (self.level.sd / k) ** 2
        return float(-level / k), float(np.sqrt(variance))

    @property
    def table(self) -> tuple[Array, Array]:
        """Nodes (n,) of the table over a pole, from x = 0, and their sd; none without a pole.

        The last node is minus the sum of the others.
        """
        count = len(self.values) - 1
        take = np.vstack([np.eye(count), -np.ones((min(count, 1), count))])
        inner = self.covariance[1:, 1:]
        variance = np.einsum("ij,jk,ik->i", take, inner, take)
        return take @ self.values[1:], np.sqrt(np.maximum(variance, 0.0))


def travel_load_of(
    stretch: MeasuredStretch, position: Array, *, axis: str, path: str
) -> TravelLoad:
    """Return the load over the travel that passes there and back tell, of levels that do not stick.

    Line and table are fitted together, within pairs of passes: what friction differs by direction
    at a speed is a constant of each. The errors are from what pairs differ by, one left out at a
    time, and from what poles differ by beyond that; both as Student's t of so few has it.

    Raises UnusableInput where too few pairs cross enough of the travel.
    """
    cut, pole_mm = stretch.cut, stretch.length.period_mm
    pairs = pairs_of(cut, stretch.told)
    x_mm, travel_mm = cut.x_mm[pairs.ahead], float(np.ptp(position))
    long = _crossing(pairs, x_mm, travel_mm, pole_mm, axis=axis, path=path)
    columns = np.column_stack([cut.means(one) for one in _columns(position, pole_mm).T])
    both = np.column_stack([pairs.mean(one) for one in columns.T])
    design, scale = _scaled(np.column_stack([within(one, pairs.of) for one in both.T]),
                            pole_mm, path)  # fmt: skip
    target = within(pairs.mean(stretch.effort), pairs.of)
    values = np.linalg.lstsq(design, target, rcond=None)[0]
    left = target - design @ values
    off, beyond = _by_place(left, pairs.place), lack(pairs.place, left)
    covariance = one_out(design, target, pairs.of) * small_sample(long - 1)
    if beyond > 0.0:
        poles = patches(x_mm, pole_mm, travel_mm)
        covariance += _of_poles(design, beyond / _rms(off) * off[_at(pairs.place)], poles)
    return TravelLoad(
        level=weight_of(cut, stretch.effort - columns @ (values / scale), stretch.told, path=path),
        values=values / scale,
        covariance=covariance / np.multiply.outer(scale, scale),
        centre=np.array([_mean_of_pairs(one, pairs.of) for one in both.T]),
        pole_mm=pole_mm,
        lack=beyond,
        off=off,
        pairs=len(np.unique(pairs.of)),
    )


def _of_poles(design: Array, off: Array, poles: Numbers) -> Array:
    """Return the covariance (p, p) from places that are off line and table, alike within a pole."""
    between, count = scores(design, off, poles)
    inverse, few = np.linalg.inv(design.T @ design), max(1, count - 1)
    return np.asarray(inverse @ between @ inverse * count / few * small_sample(few))


def patches(x_mm: Array, pole_mm: float | None, travel_mm: float) -> Numbers:
    """Return the number (n,) of the pole at places (n,), or of a part of the travel without one."""
    return np.asarray(np.floor(x_mm / (pole_mm or travel_mm / PATCHES)), dtype=np.intp)


def _columns(x_mm: Array, pole_mm: float | None) -> Array:
    if pole_mm is None:
        return x_mm[:, None].copy()
    return np.column_stack([x_mm, cogging_table(x_mm, period_mm=pole_mm)])


def _crossing(
    pairs: Pairs, x_mm: Array, travel_mm: float, pole_mm: float | None, *, axis: str, path: str
) -> int:
    """Return how many pairs cross enough of the travel; raises UnusableInput below FEWEST_PAIRS."""
    needed_mm = max(CROSSED * travel_mm, FEWEST_POLES * (pole_mm or 0.0))
    crossed = [np.ptp(x_mm[pairs.of == one]) for one in np.unique(pairs.of)]
    count = sum(bool(way_mm >= NEARLY * needed_mm) for way_mm in crossed)
    if count < FEWEST_PAIRS:
        poles = (
            ""
            if pole_mm is None
            else phrase(
                ", {fewest_poles} poles at least", fewest_poles=localized(f"{FEWEST_POLES:g}")
            )
        )
        raise UnusableInput(
            phrase(
                "{file}: {axis} passes {needed} mm (half of the travel{poles}) there and back "
                "{n} times, and the four steps of a linear drive need {fewest_pairs}; add "
                "speeds or repeats over the travel",
                file=path,
                axis=axis,
                needed=localized(f"{needed_mm:.4g}"),
                poles=poles,
                n=count,
                fewest_pairs=FEWEST_PAIRS,
            )
        )
    return count


def _scaled(design: Array, pole_mm: float | None, path: str) -> tuple[Array, Array]:
    """Return columns (n, p) of rms 1 and their rms; raises UnusableInput for nodes without rows."""
    scale = np.sqrt(np.mean(design**2, axis=0))
    if not scale.all() or np.linalg.matrix_rank(design / scale) < design.shape[1]:
        raise UnusableInput(
            phrase(
                "{file}: passes there and back leave parts of the pole of {pole} mm without a "
                "row; make slower passes or record faster",
                file=path,
                pole=localized(f"{pole_mm:g}"),
            )
        )
    return design / scale, scale


def _mean_of_pairs(values: Array, of: Numbers) -> float:
    count = np.bincount(of)
    seen = count > 0
    return float(np.mean(np.bincount(of, values)[seen] / count[seen]))


def _at(place: Numbers) -> Numbers:
    """Return the number (n,) of each place among those there are."""
    return np.asarray(np.unique(place, return_inverse=True)[1], dtype=np.intp)


def _by_place(left: Array, place: Numbers) -> Array:
    """Return the mean (k,) of what is left at each place, in their order."""
    at = _at(place)
    return np.asarray(np.bincount(at, left) / np.bincount(at))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
