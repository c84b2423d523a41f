"""Score a correction on blocks of rows that its fit did not see.

Squares on stretches left out of a fit, for many sets of columns, from sums of their products.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import ChannelAnswer, FitQuality, Where
from autodb.explain.engine.noise import PLAIN, Whitener
from autodb.explain.engine.normal import HELD, solved
from autodb.explain.engine.working import WorkingRate

Array = NDArray[np.float64]
Index = NDArray[np.intp]

SAME = 1e-9
"""Share of a channel's rms below which a difference from it is none."""
FOLDS = 5
BLOCKS = 40
TURN = (3.0 - np.sqrt(5.0)) / 2.0
"""Share of the folds by which a round of deals begins later: the golden section repeats latest."""


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def fold_of_block(blocks: int, folds: int) -> Index:
    """Return the fold that each block (blocks,) is dealt to.

    Each round of deals begins further on, by about 0.382 of the folds: dealt in turn, the blocks of
    a fold would come back at the same phase of a move that repeats, as sines and strokes do, and
    what acts there alone, at reversals, would be left out of its fit altogether.
    """
    block = np.arange(blocks)
    return np.asarray((block + round(TURN * folds) * (block // folds)) % folds, dtype=np.intp)


def block_edges(rows: int, blocks: int, progress: Array | None = None) -> Index:
    """Return the rows (blocks + 1,) that contiguous blocks begin and end at.

    ``progress`` (n,): the share of the course that lies behind each row as recorded, of which each
    block has as much as any other; None: blocks of as many rows each.
    """
    shares = np.linspace(0.0, 1.0, blocks + 1)
    if progress is not None:
        behind = np.concatenate([[0.0], progress])
        shares[1:-1] = np.interp(shares[1:-1], behind, np.linspace(0.0, 1.0, len(behind)))
    return np.asarray(rows * shares, dtype=np.float64).astype(np.intp)


def no_difference(unit: str) -> ChannelAnswer:
    """Return the answer where recording and simulation are the same numbers."""
    nothing = FitQuality(
        rms_before=0.0, rms_after=0.0, heldout_before=0.0, heldout_after=0.0, noise_floor=0.0
    )
    return ChannelAnswer(unit=unit, mismatch=False, where=Where(), missing=(), fit=nothing)


@dataclass(frozen=True)
class FittedRows:
    """Rows that coefficients are fitted to: at a working rate, made white by a filter."""

    rate: WorkingRate = field(default_factory=lambda: WorkingRate(1))
    whitener: Whitener = PLAIN

    def __call__(self, values: Array) -> Array:
        """Return values (n,) or columns (n, p) in these rows, (m,) or (m, p)."""
        return self.whitener(self.rate.reduced(values))

    def places(self, rows: int) -> Index:
        """Return the row, of so many as recorded, that each stands at, (m,)."""
        middles = self.rate.reduced(np.arange(rows, dtype=np.float64)).astype(np.intp)
        return middles[self.whitener.places(len(middles))]


AS_RECORDED = FittedRows()


def held_out_residual(
    columns: Array,
    difference: Array,
    values: Array,
    *,
    gap: int,
    fitted_on: FittedRows = AS_RECORDED,
) -> Array:
    """Return difference − correction (n,) on rows whose block, and ``gap`` rows around it, was
    left out of the fit; blocks of contiguous rows are dealt to the folds. A gap is no longer than a
    block, so that two fifths of a short recording remain.

    A coefficient that the rows left do not hold is drawn to none as far as its size in all rows, of
    ``values`` (p,), allows. ``fitted_on``: the rows that coefficients are fitted to.
    """
    n = len(difference)
    rows, target, at = fitted_on(columns), fitted_on(difference), fitted_on.places(n)
    block = np.minimum(np.arange(n) * BLOCKS // n, BLOCKS - 1)
    weight = float(np.var(target - rows @ values)) / np.maximum(values**2, 1e-300)
    left, gap, dealt = np.empty(n), min(gap, n // BLOCKS), fold_of_block(BLOCKS, FOLDS)[block]
    for fold in range(FOLDS):
        test = dealt == fold
        near = np.convolve(test, np.ones(2 * gap + 1), mode="same") > 0 if gap else test
        used = ~near[at]
        fitted = solved(rows[used], target[used], weight=weight)
        left[test] = difference[test] - columns[test] @ fitted
    return left


def quality(
    *,
    before: Array,
    after: Array,
    columns: Array,
    values: Array,
    gap: int,
    fitted_on: FittedRows = AS_RECORDED,
) -> FitQuality:
    """Return the errors before and after, on all rows and on rows left out of the fit.

    ``before`` and ``after`` (n,) at every row, ``columns`` (n, p) the accepted ones (p may be 0)
    with their coefficients, ``fitted_on`` the rows that these are of. The noise floor is what they
    leave of plain rows.
    """
    kept_out = before
    if columns.shape[1]:
        kept_out = held_out_residual(columns, before, values, gap=gap, fitted_on=fitted_on)
    return FitQuality(
        rms_before=rms(before),
        rms_after=rms(after),
        heldout_before=rms(before),
        heldout_after=rms(kept_out),
        noise_floor=rms(before - columns @ solved(columns, before)),
    )


class Folds:
    """Rows (n, q), the first column what is to be predicted, in contiguous blocks.

    Blocks are dealt to folds; the fit that predicts a fold is without its blocks and the
    ``gap`` rows on both sides of each; ``progress``: as of `block_edges`.
    """

    def __init__(
        self,
        rows: Array,
        gap: int,
        *,
        blocks: int = BLOCKS,
        folds: int = FOLDS,
        progress: Array | None = None,
    ) -> None:
        edges = block_edges(len(rows), blocks, progress)
        shape = (folds, rows.shape[1], rows.shape[1])
        self.test, self.train = np.empty(shape), np.empty(shape)
        dealt = fold_of_block(blocks, folds)
        for fold, (test, train) in enumerate(zip(self.test, self.train, strict=True)):
            own = [span for span, of in zip(pairwise(edges), dealt, strict=True) if of == fold]
            _products([rows[start:end] for start, end in own], out=test)
            near = [rows[max(0, start - gap) : end + gap] for start, end in own]
            _products(near, out=train)
        self.whole = self.test.sum(axis=0)
        np.subtract(self.whole, self.train, out=self.train)

    def by_fold(self, columns: Sequence[int] | Index, weight: Array) -> Array:
        """Return the sum of squares of each fold (folds,), predicted by a fit of ``columns`` to
        the others.

        ``weight`` (p,): what a squared coefficient costs.
        """
        at = np.asarray(columns, dtype=np.intp)
        inner = self.train[:, at[:, None], at] + np.diag(weight)
        norm = np.sqrt(np.maximum(np.diagonal(inner, axis1=1, axis2=2), 0.0))
        norm[norm == 0] = 1.0
        scaled = inner / (norm[:, :, None] * norm[:, None, :]) + HELD * np.eye(len(at))
        right = (self.train[:, at, 0] / norm)[:, :, None]
        fitted = np.linalg.solve(scaled, right)[:, :, 0] / norm
        along = np.einsum("fi,fi->f", fitted, self.test[:, at, 0])
        seen = np.einsum("fi,fij,fj->f", fitted, self.test[:, at[:, None], at], fitted)
        return np.asarray(np.maximum(self.test[:, 0, 0] - 2.0 * along + seen, 0.0))

    def squares(self, columns: Sequence[int] | Index, weight: Array) -> float:
        """Return the sum of squares on all rows, each predicted by a fit of ``columns`` to others.

        ``weight`` (p,): what a squared coefficient costs.
        """
        return float(self.by_fold(columns, weight).sum())


def _products(blocks: Sequence[Array], *, out: Array) -> None:
    """Write the inner products (q, q) of the rows (., q) of several blocks."""
    rows = np.concatenate(blocks)
    np.matmul(rows.T, rows, out=out)
