"""Lines, and scores on what was left out of the fit."""

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.linear import LinearFit, least_squares, robust_least_squares, solve, triangle

Array = NDArray[np.float64]


def straight_line(x: Array, y: Array) -> LinearFit:
    """Fit y = c0 + c1 x; coefficients are (c0, c1)."""
    return least_squares(np.column_stack([np.ones_like(x), x]), y)


def robust_line(x: Array, y: Array) -> Array:
    """Return (c0, c1) of a line by Huber's weights at 1.345 robust standard deviations."""
    return robust_least_squares(np.column_stack([np.ones_like(x), x]), y).coefficients


def leave_group_out(x: Array, y: Array, groups: NDArray[np.generic]) -> Array:
    """Return y − ŷ (n,) where ŷ comes from a line fitted without the row's own group."""
    errors = np.empty_like(y)
    for group in np.unique(groups):
        held = groups == group
        c0, c1 = straight_line(x[~held], y[~held]).coefficients
        errors[held] = y[held] - (c0 + c1 * x[held])
    return errors


def leave_one_out(
    design: Array,
    values: Array,
    blocks: NDArray[np.intp],
    *,
    gap: int,
    folds: int = 5,
    pull: Array | None = None,
) -> Array:
    """Return y − ŷ (n,), ŷ from coefficients fitted without the row's own fold.

    Contiguous ``blocks`` (n,) 0 … G − 1 are dealt to the folds in turn; ``gap`` rows on each side
    of what is left out are not fitted on either, because noise is correlated that far. Directions
    that the rest does not hold get nothing. ``pull`` (p,) holds coefficients towards 0, as a row
    each: what few rows show only must not be carried to others.
    """
    errors, gap = np.empty_like(values), min(gap, (len(values) - 1) // 2)
    towards = np.diag(np.zeros(design.shape[1]) if pull is None else pull)
    nothing = np.zeros(len(towards))
    for fold in range(min(folds, int(blocks.max()) + 1)):
        test = blocks % folds == fold
        near = np.convolve(test, np.ones(2 * gap + 1), mode="same") > 0 if gap else test
        fitted = np.vstack([design[~near], towards])
        reduced = triangle(fitted, np.concatenate([values[~near], nothing]))
        errors[test] = values[test] - design[test] @ solve(reduced)[0]
    return errors


def r_squared(errors: Array, y: Array) -> float:
    """Return 1 − Σe²/Σ(y − ȳ)²; −inf when y does not vary."""
    total = float(np.sum((y - y.mean()) ** 2))
    return 1.0 - float(np.sum(errors**2)) / total if total > 0 else float("-inf")


def bootstrap_r_squared(
    errors: Array, y: Array, groups: NDArray[np.generic], *, draws: int = 4000, seed: int = 20
) -> tuple[float, float]:
    """Return the 95 % interval of R² over groups drawn with replacement (percentiles).

    Groups, not rows, are the independent units: rows of one tool share its errors.
    """
    rng = np.random.default_rng(seed)
    names = np.unique(groups)
    parts = np.array(
        [
            (np.sum(errors[groups == g] ** 2), np.sum(y[groups == g] ** 2),
             np.sum(y[groups == g]), np.sum(groups == g))
            for g in names
        ]
    )  # fmt: skip
    sums = parts[rng.integers(len(names), size=(draws, len(names)))].sum(axis=1)
    total = sums[:, 1] - sums[:, 2] ** 2 / sums[:, 3]
    with np.errstate(divide="ignore"):
        values = np.where(total > 0, 1.0 - sums[:, 0] / total, -np.inf)
    low, high = np.quantile(values, [0.025, 0.975], method="lower")
    return float(low), float(high)
