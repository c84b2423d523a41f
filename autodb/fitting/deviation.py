"""Least squares where the law may deviate from the truth and the noise is coloured.

values = X·β + Σ_g Z_g·u_g + e, e an autoregression, u_g ~ N(0, τ_g²): the deviation columns Z_g
(smooth shapes that the law leaves out) get as much freedom as the data show that they need. The
variances τ_g² are found by restricted maximum likelihood (Patterson and Thompson 1971, Biometrika
58:545), β and u by Henderson's mixed-model equations (1975, Biometrics 31:423), e by the residual
of the saturated fit. Coefficients whose law is right are then as sharp as the noise allows, the
others as wide as the deviation makes them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from autodb.fitting.covariance import autoregression
from autodb.fitting.linear import RANK, triangle
from autodb.fitting.optimum import optima

Array = NDArray[np.float64]

RIDGE = 1e-10
"""Added to the scaled inner products: a direction that no row shows gets the value 0 and a variance
10¹⁰ times that of a column seen whole, instead of no answer at all."""
STARTS = (0.3, 3.0)
"""Sizes of the deviations, in standard deviations of the noise that a column's rows together leave,
from which the likelihood is climbed."""
VAST = 30.0
"""A size's logarithm is taken to be below VAST beforehand, as one standard deviation: what the rows
do not show stays where none is needed, and no other is moved by it. Chosen."""
FOLLOWED = 1e-3
"""Share of a group's largest direction that the law leaves of one it can follow itself, at most:
such a direction tells nothing of how large deviations are. Chosen: of axes laws leave up to 4e-4 of
the directions they can follow, and 1e-2 at least of all others.
"""
LEAST_ADDED = 1e-6
"""Share of its own variance that leaving out a block adds to a coefficient's at least: less is
rounding. Chosen."""
SURE = 0.999
"""Blocks widen the covariance by half of what they show where chance would make them differ so much
in 1 case of 1000, by more beyond, by less below."""


@dataclass(frozen=True)
class Deviating:
    """β then u (p + m,), their covariance (p + m, p + m), and the first p of both.

    ``sds`` (groups,): τ_g; ``whitener`` (order,): the autoregression of the noise;
    ``inflation`` (p,): how much wider the blocks of motion made each of the first p coefficients.
    """

    whole: Array
    whole_covariance: Array
    columns: int
    sds: Array
    whitener: Array
    inflation: Array

    @property
    def coefficients(self) -> Array:
        """β, (p,)."""
        return self.whole[: self.columns]

    @property
    def covariance(self) -> Array:
        """Covariance of β, (p, p)."""
        return self.whole_covariance[: self.columns, : self.columns]

    @property
    def narrow_covariance(self) -> Array:
        """Covariance (p + m, p + m) before blocks widened it: how one value follows another."""
        wide = np.ones(len(self.whole))
        wide[: self.columns] = self.inflation
        return self.whole_covariance / np.outer(wide, wide)


@dataclass(frozen=True)
class _Rows:
    """The white rows reduced: R (p + m + 1, p + m + 1) of [X, Z, values], columns scaled.

    ``scale`` (p + m,) of them; ``unit`` (groups,): the mean of a group's scales. ``left`` (m, m):
    what X leaves of Z, in units, without directions that X can follow. ``likely`` (groups,): the
    size that τ_g/σ is taken to have at most, σ that of the noise which X and Z together leave.
    """

    factor: Array
    scale: Array
    rows: int
    columns: int
    group: NDArray[np.intp]
    unit: Array
    left: Array
    likely: Array

    @property
    def freedom(self) -> int:
        """Rows that X leaves."""
        return self.rows - self.columns

    def sizes(self, at: Array) -> Array:
        """Return τ_g/σ (groups,) where the likelihood is evaluated.

        τ_g/σ = sinh(at)/unit: as even as τ² near none, as slow as its logarithm where it is much.
        """
        return np.asarray(np.abs(np.sinh(at)) / self.unit)


def least_squares_with_deviation(
    design: Array,
    deviations: Sequence[Array],
    values: Array,
    *,
    blocks: NDArray[np.intp],
    order: int = 10,
    likely: Sequence[float] | None = None,
) -> Deviating:
    """Fit values (n,) = design (n, p) · β + deviations (n, m_g) · u + coloured noise.

    ``blocks`` (n,): contiguous blocks of motion, 0 … G − 1. Where leaving them out one by one moves
    β by more than the model expects (about the 99.9 % point of χ²/(G − 1) and beyond), the
    covariance is widened towards what the blocks show: the model misses something that differs
    between them. It is
    scaled so that ± 1.96 sd are 95 % of Student's t with G − 1 degrees of freedom: how noise and
    deviation vary is not known better than the blocks show.

    ``likely`` (groups,): how large each τ_g may be taken to be beforehand (a normal's sd; infinite,
    or without it: any). Where rows hardly show a group they would else let it be anything.

    Raises NotSettled where the variances' likelihood has no end to climb to.
    """
    matrix = np.column_stack([design, *deviations])
    group = np.repeat(np.arange(len(deviations)), [z.shape[1] for z in deviations])
    whitener = _noise(matrix, values, order)
    white = _whitened(np.column_stack([matrix, values]), whitener)
    rows = _reduced(white, design.shape[1], group, likely or [np.inf] * len(deviations))
    places = _optima(rows)
    shares = [share for share, _ in places]
    answers = [_answer(rows, rows.sizes(at), white, blocks[order:]) for _, at in places]
    whole = np.average([one.whole for one in answers], axis=0, weights=shares)
    apart = [np.outer(one.whole - whole, one.whole - whole) for one in answers]
    within = [one.covariance for one in answers]
    covariance = np.average(np.add(within, apart), axis=0, weights=shares)
    inflation = np.average([one.inflation for one in answers], axis=0, weights=shares)
    full = np.concatenate([inflation, np.ones(len(whole) - len(inflation))])
    full *= _few_blocks(int(blocks.max()) + 1)
    return Deviating(
        whole,
        covariance * np.outer(full, full),
        design.shape[1],
        np.sqrt(np.average([one.variances for one in answers], axis=0, weights=shares)),
        whitener,
        inflation,
    )


def _noise(matrix: Array, values: Array, order: int) -> Array:
    reduced = triangle(matrix, values)
    k = reduced.columns
    found = np.linalg.lstsq(reduced.factor[:, :k], reduced.factor[:, k], rcond=1e-10)[0]
    residual = values - matrix @ (found / reduced.scale)
    return autoregression(residual, order)[0]


def _whitened(columns: Array, a: Array) -> Array:
    from scipy.signal import lfilter

    taps = np.concatenate([[1.0], -a])
    return np.asarray(lfilter(taps, [1.0], columns, axis=0)[len(a) :], dtype=np.float64)


def _reduced(white: Array, columns: int, group: NDArray[np.intp], likely: Sequence[float]) -> _Rows:
    found = triangle(white[:, :-1], white[:, -1])
    k = found.columns
    ridged = np.vstack([found.factor, np.sqrt(RIDGE) * np.eye(k, k + 1)])
    factor = np.asarray(np.linalg.qr(ridged, mode="r"))
    groups = len(likely)
    unit = np.array([found.scale[columns:][group == g].mean() for g in range(groups)])
    left = factor[columns:-1, columns:-1] * (found.scale[columns:] / unit[group])
    for g in range(groups):
        left[:, group == g] = _unfollowed(left[:, group == g])
    # The noise is what all columns leave; an exact fit leaves its rounding
    exact = RANK * float(np.linalg.norm(factor[:, -1]))
    noise = max(abs(float(factor[-1, -1])), exact) / np.sqrt(max(found.rows - k, 1))
    most = np.asarray(likely, dtype=np.float64) / max(noise, np.finfo(float).tiny)
    return _Rows(factor, found.scale, found.rows, columns, group, unit, left, most)


def _unfollowed(left: Array) -> Array:
    """Return what laws leave of a group's columns (m, k) without directions they can follow."""
    to, size, of = np.linalg.svd(left, full_matrices=False)
    return np.asarray((to * np.where(size > FOLLOWED * size[0], size, 0.0)) @ of)


def _optima(rows: _Rows) -> list[tuple[float, Array]]:
    """Return where the restricted likelihood is largest, each place with its probability."""
    groups = len(rows.unit)
    if groups == 0:
        return [(1.0, np.empty(0))]
    starts = [np.full(groups, np.arcsinh(size)) for size in STARTS]
    return optima(lambda at: _restricted_likelihood(rows, at), starts, numbers=np.abs)


def _restricted_likelihood(rows: _Rows, at: Array) -> tuple[float, Array]:
    """Return −2 ln of the restricted likelihood, up to a constant, σ² profiled out; its gradient.

    X is taken out by R: what is left of Z, B (m, m), and of the values, y (m,), has the variance
    V = I + B D Bᵀ, in units of σ², and ``beyond`` of the values is out of both. Of a change of D_ii
    the determinant's logarithm changes by bᵢᵀ V⁻¹ bᵢ, yᵀ V⁻¹ y by −(bᵢᵀ V⁻¹ y)².
    """
    p, group, left = rows.columns, rows.group, rows.left
    y, beyond = rows.factor[p:-1, -1], rows.factor[-1, -1]
    size, slope = np.sinh(at), np.cosh(at)
    grown = np.vstack([np.eye(len(y)), (left * size[group]).T])
    root = np.linalg.qr(grown, mode="r")
    white = solve_triangular(root, np.column_stack([left, y]), trans="T")
    rounding = (RANK * float(np.linalg.norm(rows.factor[:, -1]))) ** 2
    rss = float(beyond**2 + white[:, -1] @ white[:, -1] + rounding)
    misfit = rows.freedom * np.log(rss) + 2.0 * float(np.sum(np.log(np.abs(np.diag(root)))))
    misfit += float(np.sum((at / VAST) ** 2))
    most = rows.unit * rows.likely
    misfit += float(np.sum((size / most) ** 2))
    sensed = white[:, :-1].T @ white[:, -1]
    each = np.einsum("ij,ij->j", white[:, :-1], white[:, :-1]) - rows.freedom / rss * sensed**2
    gradient = 2.0 * size * slope * np.bincount(group, each, len(size)) + 2.0 * at / VAST**2
    gradient += 2.0 * size * slope / most**2
    return float(misfit), np.asarray(gradient)


@dataclass(frozen=True)
class _Answer:
    """What the rows say given the sizes of the deviations.

    ``variances`` (groups,): τ_g².
    """

    whole: Array
    covariance: Array
    variances: Array
    inflation: Array


def _answer(rows: _Rows, sizes: Array, white: Array, blocks: NDArray[np.intp]) -> _Answer:
    """Return β and u by the mixed-model equations, in columns at which u has the variance σ²."""
    p = rows.columns
    to_own = np.concatenate([1.0 / rows.scale[:p], sizes[rows.group]])
    seen = rows.factor[:, :-1] * (rows.scale * to_own)
    deviates = np.eye(len(to_own))[p:]
    both = np.vstack(
        [
            np.column_stack([seen, rows.factor[:, -1]]),
            np.column_stack([deviates, np.zeros(len(deviates))]),
        ]
    )
    solved = np.asarray(np.linalg.qr(both, mode="r"))
    inverse = solve_triangular(solved[:-1, :-1], np.eye(len(to_own)))
    scaled = inverse @ solved[:-1, -1]
    variance = float(solved[-1, -1] ** 2) / rows.freedom
    covariance = inverse @ inverse.T * variance
    inflation = _inflation(white, blocks, solved, to_own, covariance[:p, :p])
    return _Answer(
        scaled * to_own,
        covariance * np.outer(to_own, to_own),
        np.square(sizes) * variance,
        inflation,
    )


def _inflation(
    white: Array, blocks: NDArray[np.intp], solved: Array, to_own: Array, covariance: Array
) -> Array:
    """Return how much wider (p,) leaving out blocks shows the coefficients to be, at least 1.

    A coefficient moves by Δ where a block is left out, whose variance by the model is what leaving
    it out adds to the coefficient's own: much where the block alone shows it. ``solved``: the
    triangle of all rows, in columns each ``to_own`` times its own; ``covariance`` (p, p) there.
    """
    p = len(covariance)
    edges = np.searchsorted(blocks, np.arange(blocks[0], blocks[-1] + 2))
    count = len(edges) - 1
    gram = solved[:-1, :-1].T @ solved[:-1, :-1]
    right = solved[:-1, :-1].T @ solved[:-1, -1]
    level = np.sqrt(np.diag(gram)[:p])
    whole = solve_triangular(solved[:-1, :-1], solved[:-1, -1])[:p]
    variance = float(solved[-1, -1] ** 2) / (len(white) - p)
    shown = np.zeros(p)
    for g in range(count):
        part = white[edges[g] : edges[g + 1]]
        columns = part[:, :-1] * to_own
        reduced, asked = gram - columns.T @ columns, right - columns.T @ part[:, -1]
        # The deviations go out first: their own inner products are positive, by what they are taken
        # to be
        out = cho_solve(cho_factor(reduced[p:, p:]), np.column_stack([reduced[p:, :p], asked[p:]]))
        law = (reduced[:p, :p] - reduced[:p, p:] @ out[:, :p]) / np.outer(level, level)
        inverse = np.linalg.pinv(law, rcond=1e-12, hermitian=True) / np.outer(level, level)
        moved = inverse @ (asked[:p] - reduced[:p, p:] @ out[:, p]) - whole
        added = variance * np.diag(inverse) - np.diag(covariance)
        shown += moved**2 / np.maximum(added, LEAST_ADDED * np.diag(covariance))
    return _widened(shown / count, count - 1)


def _widened(ratio: Array, freedom: int) -> Array:
    """Return the standard deviations over the stated ones, where a variance is shown as ``ratio``.

    With the stated variance ``freedom`` · ratio is distributed as χ². The variance is the mean of
    the stated and the shown one, weighed by their likelihoods: both weigh alike where chance would
    show as much in 1 − SURE of all cases, so that nothing jumps there.
    """
    limit = special.gammaincinv(0.5 * freedom, SURE) / (0.5 * freedom)  # quantile of χ²
    more = np.maximum(ratio, 1.0)
    odds = 0.5 * freedom * ((more - np.log(more)) - (limit - np.log(limit)))
    return np.asarray(np.sqrt(1.0 + special.expit(odds) * (more - 1.0)))


def _few_blocks(count: int) -> float:
    """Return how much wider 1.96 sd must be when variances come from ``count`` blocks of motion.

    Student's t over the normal, at 97.5 %.
    """
    return float(special.stdtrit(count - 1, 0.975) / special.ndtri(0.975))
