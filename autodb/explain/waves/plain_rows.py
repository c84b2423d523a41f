"""Named laws that a milled waveform needs, by the error on blocks of time left out of the fit.

As of axes and tables (``engine.plain``): rows as they are, each component over its noise. Of a long
recording some rows: every part of a turn is among them, as their places are no even steps.

A real edge follows no law to a part in a hundred, and what it does otherwise comes round with every
turn, so that white rows hold endless evidence of it. Where a course over the turn that no law has
predicts clearly better beside all named laws, these rows decide alone (``PlainAccount``).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.plain.founded import ROUNDS
from autodb.explain.engine.plain.growing import (
    CLEAR,
    GAIN,
    IN_BLOCKS,
    best_offer,
    completed,
    grown,
    merged_laws,
)
from autodb.explain.engine.plain.rows import NEEDED, OWN, ROWS, PlainRows, rms_fall
from autodb.explain.waves.candidates import OVER_TURN
from autodb.explain.waves.fit import WhitenedNoise, WhiteWaves, component_noise_sd

Array = NDArray[np.float64]

GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
"""Multiples of it fill an interval evenly and in step with nothing (Weyl 1916)."""


class WaveRows:
    """Rows of a waveform as they are: difference and columns over the noise of each component."""

    gap = 0
    apart = False
    progress: Array | None = None

    def __init__(self, bench: WhiteWaves, quiet: WhitenedNoise) -> None:
        self.own = bench.own
        self.own_sizes = np.ones(len(bench.own))
        self._bench = bench
        self._noise = component_noise_sd(quiet)
        components, rows = bench.difference.shape
        some = min(rows, ROWS // components)
        steps = np.arange(some) + np.mod(np.arange(some) * GOLDEN, 1.0)
        self._rows = np.minimum((steps * rows / some).astype(np.intp), rows - 1)

    def _flat(self, columns: Array) -> Array:
        """Return columns (C, n, p) as rows (m·C, p), a moment's components together."""
        scaled = columns[:, self._rows] / self._noise[:, None, None]
        return np.asfortranarray(np.moveaxis(scaled, 0, 1).reshape(-1, columns.shape[2]))

    @property
    def reduced_difference(self) -> Array:
        """The difference of recording and simulation, (m·C,)."""
        return self._flat(self._bench.difference[:, :, None])[:, 0]

    def chosen(self, choices: Sequence[Choice]) -> Array:
        """Return own and chosen columns, (m·C, p)."""
        return self._flat(self._bench.chosen(choices))

    def columns(self, key: tuple[str, int], form: CandidateForm) -> Array:
        """Return a form's columns, (m·C, p)."""
        return self._flat(self._bench.columns(key, form))


class PlainWaves(PlainRows):
    """Plain rows of a waveform, where a law's tangential, radial and axial part trade with those of
    the others: each has to be worth it.
    """

    def asked_more(self, choice: Choice) -> float:
        """Return the share that its further columns cost."""
        return self.richness(choice)


@dataclass(frozen=True)
class PlainAccount:
    """What plain rows need: named ``laws``, and the ``course`` without a name that they leave; None
    where the laws are all there is.

    ``left``: the sum of squares of blocks of time predicted with the laws.
    """

    laws: tuple[Choice, ...]
    course: Choice | None
    left: float


def static_laws(
    bench: WhiteWaves, quiet: WhitenedNoise, candidates: Sequence[Candidate]
) -> tuple[Choice, ...]:
    """Return the laws that go with the chip alone which blocks of time left out clearly need."""
    laws = [c for c in candidates if c.named and c.static]
    rows = PlainWaves(WaveRows(bench, quiet), laws)
    return tuple(merged_laws(rows, grown(rows, [], laws)))


def needed_laws(
    bench: WhiteWaves, quiet: WhitenedNoise, candidates: Sequence[Candidate]
) -> tuple[Choice, ...]:
    """Return what a search begins with: static laws, or in their place an account of any kind that
    predicts blocks left out better for its coefficients, as a scale or crosstalk does beside a
    smooth law of the chip.
    """
    static = list(static_laws(bench, quiet, candidates))
    if not static:
        return ()
    named = [c for c in candidates if c.named]
    rows = PlainWaves(WaveRows(bench, quiet), named)
    return tuple(_simpler(rows, static, _continued(rows, _alone(rows, named))))


def account_of_waves(
    bench: WhiteWaves, quiet: WhitenedNoise, candidates: Sequence[Candidate]
) -> PlainAccount:
    """Return what blocks of time left out clearly need: static laws first, then any with a name.

    Where a course without a name does better than these, static laws that are clear stay, and of
    the others what does by itself most of what the course does, or is needed beside it. What laws
    can mostly give is theirs: a sensor's offset along a slot, say, where an edge's axial force is
    as constant.
    """
    named = [c for c in candidates if c.named]
    courses = [c for c in candidates if c.key == OVER_TURN]
    source = WaveRows(bench, quiet)
    found = static = list(static_laws(bench, quiet, candidates))
    rows = PlainWaves(source, [*courses, *(c.candidate for c in static)], static)
    if _course(rows, static, courses) is None:
        return PlainAccount(tuple(static), None, float(rows.squares(static).sum()))
    rows = PlainWaves(source, named)
    found = _continued(rows, found)
    if static:
        found = _simpler(rows, found, _continued(rows, _alone(rows, named)))
    rows = PlainWaves(source, candidates, found)
    course = _course(rows, found, courses)
    if course is None:
        return PlainAccount(tuple(found), None, float(rows.squares(found).sum()))
    course = _course(rows, static, courses) or course
    kept: list[Choice] = []
    for choice in found:
        if _stays(rows, kept, choice, course):
            kept.append(choice)
    return PlainAccount(tuple(kept), course, float(rows.squares(kept).sum()))


def _continued(rows: PlainRows, found: list[Choice]) -> list[Choice]:
    """Return laws with all further ones of any kind that blocks of time left out clearly need."""
    for _ in range(ROUNDS):
        before = {c.candidate.key for c in found}
        found = merged_laws(rows, completed(rows, found))
        if {c.candidate.key for c in found} == before:
            break
    return found


def _alone(rows: PlainRows, candidates: Sequence[Candidate]) -> list[Choice]:
    """Return the effect of any kind that predicts best alone, less what its coefficients cost."""
    offers = [best_offer(rows, [], one) for one in candidates]
    able = [(fall - rows.richness(choice), choice) for fall, choice in offers if choice]
    return [max(able, key=lambda one: one[0])[1]] if able else []


def _simpler(rows: PlainRows, found: list[Choice], other: list[Choice]) -> list[Choice]:
    """Return the account that predicts better, less what its coefficients cost; of two that do
    as well the first.
    """
    fall = rms_fall(rows.squares(found), rows.squares(other))
    richer = sum(map(rows.richness, other)) - sum(map(rows.richness, found))
    return other if fall > richer + NEEDED else found


def _course(rows: PlainRows, choices: list[Choice], courses: Sequence[Candidate]) -> Choice | None:
    """Return the course without a name that predicts best beside choices, where it clearly helps.

    It may hold what the choices do: only what they leave of it is told.
    """
    before = rows.squares(choices)
    every = [Choice(one, number) for one in courses for number in range(len(one.forms))]
    after = [rows.squares([*choices, course]) for course in every]
    clear = [
        (float(squares.sum()), course)
        for course, squares in zip(every, after, strict=True)
        if rms_fall(before, squares) >= GAIN and int(np.sum(squares < before)) >= IN_BLOCKS
    ]
    return min(clear, key=lambda one: one[0])[1] if clear else None


def _does_most(rows: PlainRows, beside: list[Choice], choice: Choice, course: Choice) -> bool:
    """Whether an effect takes most of the squares away that a course over the turn does."""
    none, its, all_ = (
        float(rows.squares([*beside, *one]).sum()) for one in ([], [choice], [course])
    )
    return none - its > OWN * (none - all_)


def _stays(rows: PlainRows, beside: list[Choice], choice: Choice, course: Choice) -> bool:
    """Whether an effect is one of its own where a course over the turn does better than all."""
    if choice.candidate.static:
        without, whole = (rows.squares([*beside, *one]) for one in ([], [choice]))
        if rms_fall(without, whole) >= CLEAR:
            return True
    elif beside and rows.own_share([*beside, choice]) <= OWN:
        return False
    without, whole = (rows.squares([*beside, course, *one]) for one in ([], [choice]))
    return _does_most(rows, beside, choice, course) or rms_fall(without, whole) >= GAIN
