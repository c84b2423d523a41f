"""One channel's rows: reduced to a working rate, whitened, made into products for the search."""

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice, of_its_kind
from autodb.explain.engine.evidence import Products
from autodb.explain.engine.noise import ORDER, Noise, Whitener, fitted_whitener
from autodb.explain.engine.normal import columns_side_by_side, solved
from autodb.explain.engine.search import DETAIL, MISTAKEN
from autodb.explain.engine.working import WorkingRate
from autodb.timing import Timing

Array = NDArray[np.float64]

ROWS_A_COLUMN = 10
"""Rows that the model of everything has at least for each column: with fewer it takes up noise."""


def fewest_first(blocks: Sequence[Array], room: int) -> list[Array]:
    """Return blocks of columns (..., p), those with the fewest first, as many as have room."""
    ordered = sorted(blocks, key=lambda block: block.shape[-1])
    total = np.cumsum([block.shape[-1] for block in ordered])
    return [block for block, sum_ in zip(ordered, total, strict=True) if sum_ <= room]


class RowsSource(Protocol):
    """Where plain rows come from: a difference (m,), own columns, and those of candidates' forms.

    ``own`` terms by name, with the coefficients ``own_sizes`` in the simulation; ``gap``: rows over
    which noise is correlated; ``apart``: whether each row was measured by itself, as a cut is, and
    is no part of a course; ``progress`` (n,): the share of the course that lies behind each row
    as recorded, None: of the rows.
    """

    gap: int
    apart: bool
    progress: Array | None
    own_sizes: Array

    @property
    def own(self) -> Mapping[str, object]:
        """The simulation's own terms."""

    @property
    def reduced_difference(self) -> Array:
        """The difference, (m,)."""

    def chosen(self, choices: Sequence[Choice]) -> Array:
        """Return own and chosen columns, (m, p)."""

    def columns(self, key: tuple[str, int], form: CandidateForm) -> Array:
        """Return a form's columns, (m, p)."""


class WhiteRows:
    """A difference (n,) = recording − simulation, the simulation's own columns, and candidates.

    Columns of candidates are built at every row, reduced to the working rate and kept so. The first
    ``firm`` own columns are the simulation's, with the coefficients ``own_sizes`` there; those that
    ``loosened`` adds follow. ``gap``: rows at the working rate over which noise is correlated;
    ``progress`` (n,): the share of the course that each row has behind it; None: of the rows.
    """

    apart = False

    def __init__(
        self,
        difference: Array,
        own: dict[str, Array],
        factor: int,
        timing: Timing | None = None,
        *,
        own_sizes: Sequence[float] = (),
        gap: int = 0,
        progress: Array | None = None,
    ) -> None:
        self.own_sizes = np.array(own_sizes or np.ones(len(own)), dtype=np.float64)
        self.gap = gap
        self.progress = progress
        self.difference = difference
        self.own = dict(own)
        self.firm = len(own)
        self.factor = factor
        self.rate = WorkingRate(factor, timing)
        self.through: tuple[Choice, ...] = ()
        self._kept: dict[tuple[str, int], tuple[CandidateForm | None, Array]] = {}
        self._own = self.reduce(self.own_columns())
        self._difference = self.rate.reduced(difference)

    @property
    def reduced_difference(self) -> Array:
        """The difference at the working rate, (m,)."""
        return self._difference

    def completed(self, parts: Mapping[str, Array]) -> Self:
        """Return the rows of a simulation that holds further parts (n,) too, by name.

        Each is a column of its own, of size 1.
        """
        own = dict(zip(self.own, self.own_columns().T, strict=True))
        return type(self)(
            self.difference - sum(parts.values(), start=np.zeros_like(self.difference)),
            own | dict(parts),
            self.factor,
            self.rate.timing,
            own_sizes=[*self.own_sizes, *np.ones(len(parts))],
            gap=self.gap,
            progress=self.progress,
        )

    def look_through(self, choices: Sequence[Choice]) -> None:
        """See every column but the choices' own as they let it be recorded."""
        self.through = tuple(choices)
        self._kept = {}
        self._own = self.reduce(self.own_columns())

    def loosened(self, choices: Sequence[Choice]) -> Self:
        """Return the rows with the choices' loose columns among the own ones, which are always
        free.
        """
        free = copy(self)
        free.own = dict(self.own)
        for choice in choices:
            if choice.candidate.loose is not None:
                for number, column in enumerate(choice.candidate.loose().T):
                    free.own[f"{choice.candidate.key} loose {number}"] = column
        free._own = free.reduce(free.own_columns())
        added = len(free.own) - len(self.own_sizes)
        free.own_sizes = np.concatenate([self.own_sizes, np.full(added, np.inf)])
        return free

    def _seen(self, columns: Array) -> Array:
        for choice in self.through:
            columns = choice.shape.seen(columns)
        return columns

    def own_columns(self) -> Array:
        """Return the simulation's own columns at every row, (n, k)."""
        empty = np.empty((len(self.difference), 0))
        return self._seen(columns_side_by_side(empty, *self.own.values()))

    def built(self, form: CandidateForm) -> Array:
        """Return the columns of a shape at every row, (n, p)."""
        return form.build() if form.through is not None else self._seen(form.build())

    def parts(self, choices: Sequence[Choice], whitener: Whitener) -> tuple[Array, list[Array]]:
        """Return the own terms' re-tuning and each choice's contribution at every row, (n,)."""
        own, parts = self._apart(choices, whitener)
        empty = np.empty((len(self.difference), 0))
        return columns_side_by_side(empty, *self.own.values()) @ own, parts

    def _apart(self, choices: Sequence[Choice], whitener: Whitener) -> tuple[Array, list[Array]]:
        """Return own terms' changes (k,), and each choice's contribution at every row, (n,)."""
        columns = self.chosen(choices)
        fitted = solved(whitener(columns), whitener(self._difference))
        at = self._own.shape[1]
        own, parts = fitted[:at], list[Array]()
        for choice in choices:
            built = choice.shape.build()
            parts.append(built @ fitted[at : at + built.shape[1]])
            at += built.shape[1]
        return own, parts

    def beyond_own(self, part: Array) -> Array:
        """Return what own columns do not give of something at every row, (n,)."""
        along = solved(self._own, self.rate.reduced(part))
        return np.asarray(part - self.own_columns() @ along)

    def of_another_kind(self, choices: Sequence[Choice], whitener: Whitener) -> Choice | None:
        """Return the first choice that makes no law of its kind with the others and own terms."""
        if all(choice.candidate.part_of is None for choice in choices):
            return None
        own, parts = self._apart(choices, whitener)
        sizes = np.where(np.isfinite(self.own_sizes), self.own_sizes, 0.0) + own
        every = list(zip(self.own, (self.own_columns() * sizes).T, strict=True))
        every += zip((c.candidate.known_as for c in choices), parts, strict=True)
        unlike = (c for c, p in zip(choices, parts, strict=True) if not of_its_kind(c, p, every))
        return next(unlike, None)

    def everything(self, candidates: Sequence[Candidate]) -> Array:
        """Return own columns and the richest shape of every candidate, (m, p), p ≤ m/10.

        Where the rows are few, so are the columns: candidates with the fewest come first.
        """
        rich = [
            self.detail(s) if s.detail else self.columns((s.key, len(s.forms) - 1), s.forms[-1])
            for s in candidates
        ]
        room = len(self._difference) // ROWS_A_COLUMN - self._own.shape[1]
        return columns_side_by_side(self._own, *fewest_first(rich, room))

    def reduce(self, values: Array) -> Array:
        """Return columns (n,) or (n, p) at the working rate, (m, p), each contiguous in memory."""
        return np.asfortranarray(self.rate.reduced(values.reshape(len(values), -1)))

    def columns(self, key: tuple[str, int], form: CandidateForm) -> Array:
        """Return a shape's columns at the working rate, built once.

        A place on a ladder is built anew where another shape stands in it: one tuned elsewhere.
        """
        shape, columns = self._kept.get(key, (None, np.empty(0)))
        if shape != form:
            columns = self.reduce(self.built(form))
            self._kept[key] = (form, columns)
        return columns

    def detail(self, candidate: Candidate) -> Array:
        """Return a candidate's detail columns at the working rate, (m, p), p = 0 if it has none."""
        key = (candidate.key, DETAIL)
        if key not in self._kept:
            columns = np.empty((len(self.difference), 0))
            if candidate.detail is not None:
                columns = self._seen(candidate.detail())
            self._kept[key] = (None, self.reduce(columns))
        return self._kept[key][1]

    def blocks(self, candidates: Iterable[Candidate]) -> dict[tuple[str, int], Array]:
        """Return the columns of every shape of the candidates, and their details."""
        found: dict[tuple[str, int], Array] = {}
        for candidate in candidates:
            for number, form in enumerate(candidate.forms):
                found[candidate.key, number] = self.columns((candidate.key, number), form)
            found[candidate.key, DETAIL] = self.detail(candidate)
            if candidate.mistaken is not None:
                form = CandidateForm(candidate.mistaken)
                found[candidate.key, MISTAKEN] = self.columns((candidate.key, MISTAKEN), form)
        return found

    def forget(self, keys: Iterable[str]) -> None:
        """Drop the columns of candidates that are looked for anew."""
        gone = set(keys)
        self._kept = {key: value for key, value in self._kept.items() if key[0] not in gone}

    def chosen(self, choices: Sequence[Choice], *, detail: bool = False) -> Array:
        """Return own and chosen columns at the working rate, (m, p)."""
        parts = [self._own, *(self.columns(c.key, c.shape) for c in choices)]
        if detail:
            parts += [self.detail(c.candidate) for c in choices]
        return columns_side_by_side(*parts)

    def left(self, columns: Array, whitener: Whitener | None = None) -> Array:
        """Return what columns (m, p) leave of the difference when fitted to white rows, (m,)."""
        target = self._difference
        if columns.shape[1] == 0:
            return target
        design = columns if whitener is None else whitener(columns)
        right = target if whitener is None else whitener(target)
        return np.asarray(target - columns @ solved(design, right))

    def innovation(self, columns: Array) -> float:
        """Return the innovations' variance of the noise that columns leave, both fitted in turn."""
        whitener = self.whitener_of(self.left(columns))
        left = self.left(columns, whitener)
        whitener = self.whitener_of(left)
        return float(np.mean(whitener(self.left(columns, whitener)) ** 2))

    def whitener_of(self, left: Array) -> Whitener:
        """Return the filter that whitens a residual at the working rate, (m,)."""
        return fitted_whitener(left, linked=self.rate.linked(ORDER))

    def noise(self, columns: Array) -> Noise:
        """Return the whitener and the variance of a white row, of what columns leave.

        Fitted twice: the second time the columns' coefficients are those of white rows.
        """
        whitener = self.whitener_of(self.left(columns))
        left = self.left(columns, whitener)
        whitener = self.whitener_of(left)
        white = whitener(left)
        free = max(1, len(white) - columns.shape[1])
        return whitener, float(white @ white) / free

    def products(self, blocks: Mapping[tuple[str, int], Array], noise: Noise) -> Products:
        """Return the inner products of the difference, own columns and blocks (m, p), all white."""
        whitener, variance = noise
        white = whitener.side_by_side([self._difference[:, None], self._own, *blocks.values()])
        return Products(
            white.T @ white,
            own=self._own.shape[1],
            widths={key: block.shape[1] for key, block in blocks.items()},
            rows=len(white),
            variance=variance,
        )
