"""Rows of all force components of a waveform, made white, and what is fitted to them.

The noise of a force whose waveform is full of lines is read off a running median of its
periodogram: an autoregression fitted to what is left would take a strong line, chatter say, for
colour and filter it away. The median over neighbouring frequencies does not see a line. Of
exponentially distributed powers the median is ln 2 of the mean.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise
from operator import add

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.ndimage import median_filter

from autodb.explain.engine.bench import ROWS_A_COLUMN, fewest_first
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.evidence import Products
from autodb.explain.engine.noise import ORDER, PLAIN, Whitener
from autodb.explain.engine.normal import HELD, Normal, normal
from autodb.explain.engine.search import DETAIL
from autodb.explain.engine.working import WorkingRate
from autodb.explain.waves.world import shape_columns
from autodb.fitting.linear import orthonormal_basis
from autodb.timing import Timing

Array = NDArray[np.float64]

WIDE = 0.02
"""Width of the running median, a share of all frequencies. Chosen: lines of 1 to 5 Hz and their
side bands are far narrower."""
FEWEST = 15
FLOOR = 1e-12
BLOCKS, FOLDS = 40, 5
SILENT = 1e-9
"""Share of a component's largest force that its noise is at least: numbers have digits."""
SOME = 97
"""Rows of which one is looked at first, to see that a column holds anything."""
MEMORY = 4000
"""Rows after which a noise of ORDER taps has forgotten a knock."""


def whitener_of(left: Array, timing: Timing | None = None) -> Whitener:
    """Return the filter that makes the noise in what is left (n,) white, of variance 1.

    It is an autoregression with the spectrum's running median, divided by its sd. Where there are
    gaps, spectra are of pieces that the filter fits in, and no row is filtered across; None: rows
    are in one piece.
    """
    pieces = () if timing is None else timing.pieces
    long = [piece for piece in pieces if piece.stop - piece.start > ORDER]
    if len(pieces) < 2 or not long:
        covariance = _covariance(left)
    else:
        lasts = [piece.stop - piece.start for piece in long]
        every = [_covariance(left[piece]) for piece in long]
        covariance = np.average(every, axis=0, weights=lasts)
    covariance[0] *= 1.0 + 1e-9
    taps = solve_toeplitz(covariance[:ORDER], covariance[1:])
    linked = WorkingRate(1, timing, edge_s=0.0).linked(ORDER)
    return Whitener(np.asarray(taps, dtype=np.float64), linked)


def _covariance(left: Array) -> Array:
    """Return the covariance (ORDER + 1,) of rows (n,) so far apart, lines aside."""
    n = len(left)
    power = np.abs(np.fft.rfft(left - left.mean())) ** 2 / n
    width = max(FEWEST, 2 * int(WIDE * len(power) / 2) + 1)
    smooth = median_filter(power, size=width, mode="nearest") / np.log(2.0)
    smooth = np.maximum(smooth, FLOOR * float(np.max(power)) + 1e-300)
    return np.asarray(np.fft.irfft(smooth, n)[: ORDER + 1], dtype=np.float64)


def variance_of(whitener: Whitener, left: Array) -> float:
    """Return the variance of a white row, lines aside."""
    white = whitener(left)
    power = np.abs(np.fft.rfft(white)) ** 2 / len(white)
    return float(np.median(power)) / float(np.log(2.0))


@dataclass(frozen=True)
class WhitenedNoise:
    """How each component's noise is made white and of variance 1."""

    whiteners: tuple[Whitener, ...]
    sd: tuple[float, ...]

    def __call__(self, columns: Array) -> Array:
        """Return white rows (C · m, p) of columns (C, n, p)."""
        return np.concatenate(self.each(columns))

    def over(self, timing: Timing) -> "WhitenedNoise":
        """Return the same noise in rows of another timing."""
        linked = WorkingRate(1, timing, edge_s=0.0).linked(ORDER)
        whiteners = tuple(
            Whitener(one.coefficients, linked) if len(one.coefficients) else one
            for one in self.whiteners
        )
        return WhitenedNoise(whiteners, self.sd)

    def places(self, rows: int) -> NDArray[np.intp]:
        """Return the row, of so many, that each white row of a component stands at."""
        return self.whiteners[0].places(rows)

    def inner(self, blocks: Sequence[Array]) -> Array:
        """Return the inner products (p, p) of the white columns of blocks (C, n, k).

        Most columns are in one component alone: only what a component holds is filtered there.
        """
        count = sum(block.shape[-1] for block in blocks)
        made = np.zeros((count, count))
        for number, (whitener, sd) in enumerate(zip(self.whiteners, self.sd, strict=True)):
            columns = [column for block in blocks for column in block[number].T]
            at = [i for i, column in enumerate(columns) if column[::SOME].any() or column.any()]
            white = whitener.side_by_side([columns[i][:, None] for i in at])
            made[np.ix_(at, at)] += white.T @ white / sd**2
        return made

    def each(self, columns: Array) -> list[Array]:
        """Return the white rows (m, ...) of each component of columns (C, n, ...)."""
        return [
            whitener(one) / sd
            for whitener, sd, one in zip(self.whiteners, self.sd, columns, strict=True)
        ]


class WhiteWaves:
    """A difference (C, n), the simulation's own columns, and candidates' columns at every row.

    A form's columns are (C, n, p); those of ``own`` (C, n), by term. ``timing``: the pieces that
    the rows lie in; None: they are in one.
    """

    def __init__(
        self, difference: Array, own: dict[str, Array], timing: Timing | None = None
    ) -> None:
        self.difference = difference
        self.timing = timing
        self.own = own
        self._own = np.stack(list(own.values()), axis=-1)
        self._kept: dict[tuple[str, int], tuple[CandidateForm | None, Array]] = {}

    def columns(self, key: tuple[str, int], form: CandidateForm) -> Array:
        """Return a shape's columns (C, n, p), built once."""
        shape, columns = self._kept.get(key, (None, np.empty(0)))
        if shape != form:
            columns = shape_columns(form)
            self._kept[key] = (form, columns)
        return columns

    def detail(self, candidate: Candidate) -> Array:
        """Return what a candidate's shapes may get wrong (C, n, p), p = 0 if nothing."""
        key = (candidate.key, DETAIL)
        if key not in self._kept:
            none = np.empty((*self.difference.shape, 0))
            self._kept[key] = (None, none if candidate.detail is None else candidate.detail())
        return self._kept[key][1]

    def forget(self, keys: Iterable[str]) -> None:
        """Drop the columns of candidates that are built anew."""
        gone = set(keys)
        self._kept = {key: value for key, value in self._kept.items() if key[0] not in gone}

    def chosen(self, choices: Sequence[Choice], *, detail: bool = False) -> Array:
        """Return own and chosen columns (C, n, p)."""
        parts = [self._own, *(self.columns(c.key, c.shape) for c in choices)]
        if detail:
            parts += [self.detail(c.candidate) for c in choices]
        return np.concatenate(parts, axis=-1)

    def everything(self, candidates: Iterable[Candidate]) -> list[Array]:
        """Return blocks (C, n, p): own columns, then the richest shape of every candidate, those
        with the fewest columns first.
        """
        rich = [
            self.detail(s)
            if s.detail is not None
            else self.columns((s.key, len(s.forms) - 1), s.forms[-1])
            for s in candidates
        ]
        room = self.difference.size // ROWS_A_COLUMN - self._own.shape[-1]
        return [self._own, *fewest_first(rich, room)]

    def quiet(self, blocks: Sequence[Array], begin: WhitenedNoise | None = None) -> WhitenedNoise:
        """Return the noise that columns leave, each component by itself.

        It is fitted twice; once where it begins with a noise that was found before.
        """
        quiet = begin
        for _ in range(2 if begin is None else 1):
            quiet = self._noise_of(self.left(blocks, quiet))
        assert quiet is not None
        return quiet

    def _noise_of(self, left: Array) -> WhitenedNoise:
        """Return the noise that is left (C, n)."""
        whiteners = tuple(whitener_of(one, self.timing) for one in left)
        sd = tuple(
            max(float(np.sqrt(variance_of(w, one))), SILENT * float(np.max(np.abs(own))))
            for w, one, own in zip(whiteners, left, self._own, strict=True)
        )
        return WhitenedNoise(whiteners, sd)

    def plain(self, columns: Array) -> WhitenedNoise:
        """Return the noise that columns leave of each component by itself, taken as white."""
        sd = np.sqrt(np.mean(self.left([columns], None) ** 2, axis=1))
        return WhitenedNoise((PLAIN,) * len(sd), tuple(sd.tolist()))

    def left(self, blocks: Sequence[Array], quiet: WhitenedNoise | None) -> Array:
        """Return what columns, in blocks (C, n, p), leave of the difference (C, n)."""
        left, first = self.difference.copy(), 0
        fitted = self._fitted(blocks, quiet)
        for block in blocks:
            left -= block @ fitted[first : first + block.shape[-1]]
            first += block.shape[-1]
        return left

    def _fitted(self, blocks: Sequence[Array], quiet: WhitenedNoise | None) -> Array:
        """Return coefficients (p,) of columns in blocks."""
        noise = quiet or WhitenedNoise(
            (PLAIN,) * len(self.difference), (1.0,) * len(self.difference)
        )
        inner = noise.inner([self.difference[:, :, None], *blocks])
        return Normal(inner[1:, 1:], inner[1:, 0]).solved()

    def products(self, candidates: Sequence[Candidate], quiet: WhitenedNoise) -> Products:
        """Return the inner products of the white difference, own columns and all shapes."""
        blocks: dict[tuple[str, int], Array] = {}
        for candidate in candidates:
            for number, form in enumerate(candidate.forms):
                blocks[candidate.key, number] = self.columns((candidate.key, number), form)
            blocks[candidate.key, DETAIL] = self.detail(candidate)
        return self.inner(blocks, quiet)

    def inner(self, blocks: dict[tuple[str, int], Array], quiet: WhitenedNoise) -> Products:
        """Return the inner products of the white difference, own columns and blocks (C, n, p)."""
        components, rows = self.difference.shape
        return Products(
            quiet.inner([self.difference[:, :, None], self._own, *blocks.values()]),
            own=self._own.shape[-1],
            widths={key: block.shape[-1] for key, block in blocks.items()},
            rows=components * len(quiet.places(rows)),
            variance=1.0,
        )

    def held_out(self, choices: Sequence[Choice], quiet: WhitenedNoise) -> tuple[Array, Array]:
        """Return what is left (C, n) of blocks of time predicted by a fit of the others.

        And the same (C · m,) of white rows.
        """
        columns = self.chosen(choices)
        white, target = quiet(columns), quiet(self.difference[:, :, None])[:, 0]
        count, rows = len(self.difference), self.difference.shape[1]
        order = len(quiet.whiteners[0].coefficients)
        of_white = _folds(rows - order)[quiet.places(rows) - order]
        folds = [
            normal(white[np.tile(of_white == k, count)], target[np.tile(of_white == k, count)])
            for k in range(FOLDS)
        ]
        left, white_left, of_row = self.difference.copy(), target.copy(), _folds(rows)
        for k in range(FOLDS):
            fitted = reduce(add, (one for j, one in enumerate(folds) if j != k)).solved()
            here = of_row == k
            left[:, here] -= columns[:, here] @ fitted
            there = np.tile(of_white == k, count)
            white_left[there] -= white[there] @ fitted
        return left, white_left


def _folds(rows: int) -> NDArray[np.intp]:
    return np.asarray(np.arange(rows) * BLOCKS // rows % FOLDS, dtype=np.intp)


@dataclass(frozen=True)
class WavesFit:
    """Coefficients (p,), own terms' first, with their covariance (p, p), of ``columns`` (C, n, p).

    ``places``: each effect's among the coefficients; ``own``: how many are own terms'. Coefficients
    beyond the last effect's are ways of own terms.
    """

    columns: Array
    coefficients: Array
    covariance: Array
    places: tuple[slice, ...]
    own: int

    def part(self, number: int) -> Array:
        """Return what an effect adds (C, n)."""
        at = self.places[number]
        return np.asarray(self.columns[..., at] @ self.coefficients[at])

    @property
    def correction(self) -> Array:
        """What is added to the simulation (C, n)."""
        return np.asarray(self.columns @ self.coefficients)


def fit_waves(
    bench: WhiteWaves,
    choices: Sequence[Choice],
    quiet: WhitenedNoise,
    *,
    beside: Sequence[Choice] = (),
) -> WavesFit:
    """Fit own terms and effects; directions that the rows do not hold get nothing.

    ``beside``: own terms' ways, retuned too. Coefficients of these and of curves are drawn to none.
    """
    columns = bench.chosen([*choices, *beside])
    found = normal(quiet(columns), quiet(bench.difference[:, :, None])[:, 0])
    weight = _drawn(bench, [*choices, *beside], quiet)
    widths = [bench.columns(c.key, c.shape).shape[-1] for c in choices]
    ends = np.cumsum([len(bench.own), *widths])
    return WavesFit(
        columns=columns,
        coefficients=found.solved(weight),
        covariance=found.inverse(weight),
        places=tuple(slice(int(a), int(b)) for a, b in pairwise(ends)),
        own=len(bench.own),
    )


def _drawn(bench: WhiteWaves, choices: Sequence[Choice], quiet: WhitenedNoise) -> Array:
    """Return what a squared coefficient costs, (p,) of own and chosen columns.

    Own columns and plain laws cost nothing; of others the size is that of the greatest evidence.
    """
    products = bench.inner({c.key: bench.columns(c.key, c.shape) for c in choices}, quiet)
    weights = [np.zeros(len(bench.own))]
    for choice in choices:
        norm = products.norm[products.places[choice.key]]
        if choice.shape.names or len(norm) == 1:
            weights.append(np.zeros(len(norm)))
            continue
        given = products.given([c.key for c in choices if c.key != choice.key])
        weights.append(norm**2 / given.gain(choice.key).size)
    return np.concatenate(weights)


def component_noise_sd(quiet: WhitenedNoise) -> Array:
    """Return the standard deviation of each component's noise (C,), colour and all: the mean of its
    spectrum.
    """
    sizes = []
    for whitener, sd in zip(quiet.whiteners, quiet.sd, strict=True):
        taps = np.concatenate([[1.0], -whitener.coefficients])
        sizes.append(sd * float(np.sqrt(np.mean(np.abs(np.fft.fft(taps, MEMORY)) ** -2.0))))
    return np.array(sizes)


class BesideWaves:
    """White rows after own terms and other effects are projected out of them.

    ``minus`` (C, n): what is taken off the difference first; ``repeats``: rows for each value that
    their noise is free to take, where it comes round.
    """

    def __init__(
        self,
        bench: WhiteWaves,
        others: Sequence[Choice],
        quiet: WhitenedNoise,
        *,
        minus: Array | None = None,
        repeats: float = 1.0,
    ) -> None:
        self.quiet, self._repeats = quiet, repeats
        white = quiet(bench.chosen(others))
        self._basis = orthonormal_basis(white, least=HELD)
        difference = bench.difference if minus is None else bench.difference - minus
        self._left = self._clear(difference[:, :, None])[:, 0]

    def _clear(self, columns: Array) -> Array:
        white = self.quiet(columns)
        return np.asarray(white - self._basis @ (self._basis.T @ white))

    def fitted(self, columns: Array) -> tuple[Array, Array]:
        """Return coefficients (p,) of columns (C, n, p) and their covariance (p, p)."""
        found = normal(self._clear(columns), self._left)
        return found.solved(), self._repeats * found.inverse()

    def gain(self, columns: Array) -> float:
        """Return by how much the sum of squares falls by columns (C, n, p)."""
        found = normal(self._clear(columns), self._left)
        return float(found.right @ found.solved()) / self._repeats
