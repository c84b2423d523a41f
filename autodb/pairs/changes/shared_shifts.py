"""Cells of sensed shares, and fits of the shifts that they share.

Wear is in every fit: each pair's component grows with the time on the edge, and all of a component
with the clock of a recording (warming), as the cuts within a recording say. What is left of a pair,
a component and a recording is one cell, its median. A shift comes at once, or over two recordings.
Fits are robust (Student's t, 4 degrees of freedom: one hard bar is no account), and each is scored
by the log density of cells that it was not fitted to: all of a recording are left out at once,
since they share its day.

Sources: robust regression by t likelihoods, Lange, Little and Taylor 1989; leaving groups out by
the hat matrix, Allen 1974.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

FREEDOM = 4.0
ROUNDS = 15
OVER = (1, 2)
"""Recordings that a shift takes to come."""
BEFORE, AFTER = 3, 2
"""Recordings before a shift, and since it came, at least."""
PAIRS = 2
"""Pairs that must share a shift. Chosen: of one, its own change is as good an account."""
WORN, WARMED, AGAIN = 0.15, 0.1, 0.05
"""Prior sd of a share: of wear in 1000 s, of warming in an hour, and of what cells' means differ
from the wear found within them in 1000 s. Chosen: wide."""
LEVEL = 1.0
"""Prior sd of a pair's own level, a share: none."""
SHIFT = 0.1
"""Prior sd of a shift, a share. Chosen: twice what a drifting calibration is found with."""
START, LEAST_SCALE = 0.05, 0.005
"""Scale of cells' residuals to begin with, and at least, a share."""
ALIKE, ALIKE_CELLS, MOST_ALIKE = 0.5, 10.0, 0.9
"""Correlation between a cell's components before any is seen, how many cells that counts as, and
the most that is believed. Chosen: wear and hard work move all components."""


@dataclass(frozen=True)
class SensedShares:
    """Readings (n,) of cuts: place of pair, recording, component; log of sensed over expected.

    ``recording`` counts in the order of time; ``used_s``: time on the edge, NaN: not stated;
    ``clock_s``: since the recording began.
    """

    pair: Ints
    recording: Ints
    component: Ints
    off: Array
    used_s: Array
    clock_s: Array


@dataclass(frozen=True)
class ShareCells:
    """Robust means (n,) of what is left of pair, component and recording, their mean edge age."""

    pair: Ints
    component: Ints
    recording: Ints
    off: Array
    used_s: Array

    @property
    def group(self) -> Ints:
        """What one component tells of another: a pair in a recording."""
        return np.asarray(self.recording * (int(self.pair.max()) + 1) + self.pair)


@dataclass(frozen=True)
class Account:
    """What shifts (``which`` component or pair), since which recording, over how many."""

    kind: str
    which: int
    since: int
    over: int

    def columns(self, cells: ShareCells) -> Array:
        """Return what its shifts add to cells, a column a shift."""
        come = np.clip((cells.recording - self.since + 1) / self.over, 0.0, 1.0)
        if self.kind == "axis":
            return np.asarray(come * (cells.component == self.which))[:, None]
        own = cells.pair == self.which if self.kind == "pair" else np.ones(len(come), dtype=bool)
        each = [come * own * (cells.component == c) for c in np.unique(cells.component)]
        return np.column_stack(each)


@dataclass(frozen=True)
class Fit:
    """Shifts of accounts with their covariance, residuals of cells, and the score.

    The score is the log density of all cells, each recording left out in turn.
    """

    shift: Array
    covariance: Array
    residual: Array
    score: float


def cells_of(readings: SensedShares) -> ShareCells | None:
    """Return the cells of readings; None where too few recordings or pairs hold them."""
    level = _within(readings)
    key = np.stack([readings.pair, readings.component, readings.recording])
    which, place = np.unique(key, axis=1, return_inverse=True)
    if len(np.unique(which[2])) < BEFORE + AFTER or len(np.unique(which[0])) < PAIRS:
        return None
    rows = [np.flatnonzero(place == k) for k in range(which.shape[1])]
    pair, component, recording = which
    return ShareCells(
        pair,
        component,
        recording,
        np.array([float(np.median(level[some])) for some in rows]),
        np.array([float(np.mean(np.nan_to_num(readings.used_s[some]))) for some in rows]),
    )


def _within(readings: SensedShares) -> Array:
    """Return readings without the wear and the warming that cuts within recordings show."""
    pair_component = readings.pair * (int(readings.component.max()) + 1) + readings.component
    used = np.nan_to_num(readings.used_s) / 1000.0
    columns = [used * (pair_component == k) for k in np.unique(pair_component)]
    sds = [WORN] * len(columns)
    hours = readings.clock_s / 3600.0
    for component in np.unique(readings.component):
        columns.append(hours * (readings.component == component))
        sds.append(WARMED)
    design = np.column_stack(columns)
    key = np.stack([pair_component, readings.recording])
    _, place = np.unique(key, axis=1, return_inverse=True)
    count = np.bincount(place)

    def inside(values: Array) -> Array:
        return values - (np.bincount(place, values) / count)[place]

    demeaned = np.column_stack([inside(column) for column in design.T])
    slopes = _robust(demeaned, inside(readings.off), np.array(sds))
    return np.asarray(readings.off - design @ slopes)


def accounts_of(cells: ShareCells) -> Iterator[Account]:
    """Return every account of a shift that recordings before and after it can tell."""
    last = int(cells.recording.max())
    for since in range(BEFORE, last + 2 - AFTER):
        for over in OVER:
            if since + over - 1 > last:
                continue
            yield from (Account("axis", int(c), since, over) for c in np.unique(cells.component))
            yield from (Account("pair", int(k), since, over) for k in np.unique(cells.pair))
            yield Account("both", 0, since, over)


def _levels(cells: ShareCells) -> tuple[Array, Array]:
    """Return the columns of all accounts, and the prior sds of their coefficients."""
    own = cells.pair * (int(cells.component.max()) + 1) + cells.component
    levels = [(own == k).astype(np.float64) for k in np.unique(own)]
    worn = [level * cells.used_s / 1000.0 for level in levels]
    return (
        np.column_stack([*levels, *worn]),
        np.array([LEVEL] * len(levels) + [AGAIN] * len(worn)),
    )


@dataclass(frozen=True)
class _Stack:
    """Cells by group (g, c), with their places among the cells; those that are not there are -1."""

    place: Ints

    @classmethod
    def of(cls, cells: ShareCells) -> "_Stack":
        """Return cells by pair and recording, and by component."""
        group = np.unique(cells.group, return_inverse=True)[1]
        component = np.unique(cells.component, return_inverse=True)[1]
        place = np.full((int(group.max()) + 1, int(component.max()) + 1), -1, dtype=np.intp)
        place[group, component] = np.arange(len(group))
        return cls(place)

    @property
    def there(self) -> NDArray[np.bool_]:
        """Which cells are there (g, c)."""
        return self.place >= 0

    def laid(self, values: Array) -> Array:
        """Return values (n, ...) of cells by group and component, 0 where there is none."""
        found = values[np.maximum(self.place, 0)]
        found[~self.there] = 0.0
        return found

    def shape(self, scale: Array, alike: float) -> Array:
        """Return the covariance (g, c, c) of groups: components go together by ``alike``."""
        both = self.there[:, :, None] & self.there[:, None, :]
        one = np.eye(len(scale), dtype=bool)
        together = np.where(one, 1.0, np.where(both, alike, 0.0))
        return np.asarray(together * np.outer(scale, scale))


def fitted(cells: ShareCells, accounts: Sequence[Account]) -> Fit:
    """Fit levels, rests of wear and shifts to cells by a multivariate t law (Lange 1989)."""
    levels, sds = _levels(cells)
    columns = np.column_stack([levels, *(one.columns(cells) for one in accounts)])
    prior = np.append(sds, np.full(columns.shape[1] - len(sds), SHIFT))
    stack = _Stack.of(cells)
    design, off = stack.laid(columns), stack.laid(cells.off)
    count = np.sum(stack.there, axis=1)
    alike, scale = ALIKE, np.full(stack.place.shape[1], START, dtype=np.float64)
    residual = stack.laid(cells.off - levels @ (levels.T @ cells.off / np.sum(levels, axis=0)))
    for _ in range(ROUNDS):
        inner = np.linalg.inv(stack.shape(scale, alike))
        far = np.einsum("gi,gij,gj->g", residual, inner, residual)
        share = (FREEDOM + count) / (FREEDOM + far)
        weight = share[:, None, None] * inner
        weighed = np.einsum("gip,gij->gpj", design, weight)
        covariance = np.linalg.inv(np.einsum("gpj,gjq->pq", weighed, design) + np.diag(prior**-2.0))
        found = covariance @ np.einsum("gpj,gj->p", weighed, off)
        residual = off - design @ found
        z = np.sqrt(share)[:, None] * residual / scale
        squares = np.sum(z**2, axis=0) / np.sum(stack.there, axis=0)
        scale = np.asarray(np.maximum(scale * np.sqrt(squares), LEAST_SCALE))
        alike = _alike(z, stack.there)
    day = np.max(np.where(stack.there, cells.recording[stack.place], -1), axis=1)
    left_out, spread = np.empty_like(residual), np.empty((*residual.shape, len(scale)))
    for one in np.unique(day):
        rows = day == one
        left_out[rows], spread[rows] = _left_out(
            design[rows], weight[rows], covariance, residual[rows]
        )
    shape = stack.shape(scale, alike) + spread
    far = np.vecdot(left_out, np.linalg.solve(shape, left_out[..., None])[..., 0])
    density = -0.5 * (FREEDOM + count) * np.log1p(far / FREEDOM)
    size = np.linalg.slogdet(shape)[1] - np.sum(
        np.where(stack.there, 0.0, 2.0 * np.log(scale)), axis=1
    )
    behind = slice(levels.shape[1], None)
    flat = np.empty(len(cells.off))
    flat[stack.place[stack.there]] = residual[stack.there]
    score = float(np.sum(density - 0.5 * size))
    return Fit(found[behind], covariance[behind, behind], flat, score)


def _left_out(
    design: Array, weight: Array, covariance: Array, residual: Array
) -> tuple[Array, Array]:
    """Return residuals (g, c) of a recording that was left out, and their added covariance.

    ``covariance``: of the coefficients with it; the added one (g, c, c) is that of the prediction.
    """
    count, size = residual.shape
    rows = design.reshape(count * size, -1)
    whole = np.zeros((count * size, count * size))
    for k, one in enumerate(weight):
        whole[k * size : (k + 1) * size, k * size : (k + 1) * size] = one
    known = rows @ covariance @ rows.T
    rest = np.eye(count * size) - known @ whole
    off = np.linalg.solve(rest, residual.ravel()).reshape(count, size)
    predicted = np.linalg.solve(rest, known).reshape(count, size, count, size)
    every = np.arange(count)
    own = predicted[every, :, every, :]
    return np.asarray(off), np.asarray(0.5 * (own + np.swapaxes(own, 1, 2)))


def _alike(z: Array, there: NDArray[np.bool_]) -> float:
    """Return by what the components of a cell go together, from what they are off in scales."""
    products, count = ALIKE_CELLS * ALIKE, ALIKE_CELLS
    for i in range(z.shape[1]):
        for j in range(i):
            products += float(np.sum(z[:, i] * z[:, j]))
            count += float(np.sum(there[:, i] & there[:, j]))
    return min(max(products / count, 0.0), MOST_ALIKE)


def _robust(design: Array, values: Array, prior_sd: Array) -> Array:
    """Return coefficients of a robust regression with a normal prior."""
    scale = max(float(np.std(values)), LEAST_SCALE)
    residual = values
    found = np.zeros(design.shape[1])
    for _ in range(ROUNDS):
        z2 = (residual / scale) ** 2
        weight = (FREEDOM + 1.0) / (FREEDOM + z2)
        precision = design.T @ (design * weight[:, None]) / scale**2 + np.diag(prior_sd**-2.0)
        moment = design.T @ (weight * values) / scale**2
        found = np.asarray(np.linalg.solve(precision, moment))
        residual = np.asarray(values - design @ found)
        scale = max(float(np.sqrt(np.mean(weight * residual**2))), LEAST_SCALE)
    return found
