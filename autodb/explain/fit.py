"""Fit the accepted columns, and score the correction on blocks that the fit did not see."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import FitQuality

Array = NDArray[np.float64]

FOLDS = 5
BLOCKS = 40


@dataclass(frozen=True)
class Estimate:
    """Coefficients (p,) and their standard deviations (p,)."""

    coefficients: Array
    sd: Array


def estimate(
    columns: Array, difference: Array, *, norm: Array | None = None, weakest: float = 1e-8
) -> Estimate:
    """Fit white rows by least squares, dropping directions that the rows do not hold.

    ``norm`` (p,): size of each column in the whole recording, when the rows are a part of it;
    directions weaker than ``weakest`` of the strongest get no coefficient.
    """
    norm = np.linalg.norm(columns, axis=0) if norm is None else norm.copy()
    norm[norm == 0] = 1.0
    inverse = np.linalg.pinv((columns / norm).T @ (columns / norm), rcond=weakest, hermitian=True)
    coefficients = inverse @ ((columns / norm).T @ difference)
    residual = difference - (columns / norm) @ coefficients
    variance = float(residual @ residual) / max(1, len(difference) - columns.shape[1])
    return Estimate(coefficients / norm, np.sqrt(np.diag(inverse) * variance) / norm)


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def held_out(columns: Array, difference: Array, *, gap: int) -> Array:
    """Return difference − correction (n,) on rows whose block, and ``gap`` rows around it, was
    left out of the fit; blocks of contiguous rows are dealt to the folds in turn.
    """
    n = len(difference)
    block = np.minimum(np.arange(n) * BLOCKS // n, BLOCKS - 1)
    left = np.empty(n)
    norm = np.linalg.norm(columns, axis=0)
    for fold in range(FOLDS):
        test = block % FOLDS == fold
        near = np.convolve(test, np.ones(2 * gap + 1), mode="same") > 0 if gap else test
        fitted = estimate(columns[~near], difference[~near], norm=norm, weakest=1e-5)
        left[test] = difference[test] - columns[test] @ fitted.coefficients
    return left


def quality(*, before: Array, after: Array, columns: Array, floor: float, gap: int) -> FitQuality:
    """Return the errors before and after, on all rows and on rows left out of the fit.

    ``before`` and ``after`` (n,) at every row, ``columns`` (n, p) the accepted ones (p may be 0).
    """
    kept_out = held_out(columns, before, gap=gap) if columns.shape[1] else before
    return FitQuality(
        rms_before=rms(before),
        rms_after=rms(after),
        heldout_before=rms(before),
        heldout_after=rms(kept_out),
        noise_floor=floor,
    )
