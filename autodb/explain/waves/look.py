"""Look for the effects that a milled waveform holds."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.normal import solved
from autodb.explain.engine.plain.rows import BEYOND
from autodb.explain.engine.search import (
    FAINT,
    MARGIN,
    CandidateSearch,
    FoundSet,
    settled_set,
)
from autodb.explain.waves.candidates import (
    COURSE,
    OVER_TURN,
    candidates_by_key,
    candidates_of_waves,
)
from autodb.explain.waves.fit import WhitenedNoise, WhiteWaves, fit_waves
from autodb.explain.waves.long_waveforms import rows_searched
from autodb.explain.waves.plain_rows import account_of_waves, needed_laws
from autodb.explain.waves.refined import seen_anew, sharpened, with_sensed_force
from autodb.explain.waves.scans import proposals_of_waves
from autodb.explain.waves.simulation import waves_of
from autodb.explain.waves.teeth import TABLE, is_tilted, table_angles
from autodb.explain.waves.waves import Waves
from autodb.explain.waves.world import (
    SimulatedWaves,
    Tilted,
    form,
    own_columns_of_waves,
    shape_columns,
)
from autodb.records.tables import Recording
from autodb.signals import by_piece
from autodb.wording import phrase
from autodb.wording.kept import said_again

Array = NDArray[np.float64]

ROUNDS = 5
EDGED = 0.02
"""Share of a simulation's squares from which on what no chip changes counts as its edge's."""
BAR = 3.0
SMOOTH_S = 0.02
MEASURED = 0.5
"""Share of the time from first to last row that must have been recorded: tones are looked for, and
wear and drift followed, over gaps. Chosen."""
COMPONENTS = 3
"""Coefficients of a plain law: tangential, radial, axial. One with more may follow what others do.
"""
FAINTEST = 0.002
"""`search.FAINT` of waves whose law is known exactly: shapes are then made of the very chips.
Chosen."""


@dataclass(frozen=True)
class FoundInWaves:
    """What was found, with the world and the bench that it was found on.

    ``laws``: those that plain rows need; where ``plainly``, these rows decided alone. What they
    leave is no noise but comes round: ``repeats`` rows for each value that it is free to take.
    ``search`` holds products of the rows that were searched.
    """

    world: SimulatedWaves
    bench: WhiteWaves
    search: CandidateSearch
    found: FoundSet
    quiet: WhitenedNoise
    laws: tuple[Choice, ...] = ()
    repeats: float | None = None

    @property
    def plainly(self) -> bool:
        """Whether plain rows decided alone."""
        return self.repeats is not None


def look_in_waves(
    recording: Recording, simulation: dict[str, Array], includes: list[str] | None
) -> tuple[FoundInWaves, FoundInWaves]:
    """Return the effects that force components of a recording hold beside a simulation (n,), as
    they were searched for, and the same at every row: a long waveform is searched in some turns.

    Raises UnusableInput where the side file says too little of the mill and its cut, or gaps make
    up most of the recording.
    """
    _refuse_mostly_gaps(recording)
    waves = waves_of(recording, simulation, includes)
    measured = np.array([recording[name] for name in waves.names])
    world = SimulatedWaves(
        waves=waves,
        timing=recording.timing,
        has_edge=_has_edge(waves, includes),
        tilted=_tilted(recording),
    )
    rows = rows_searched(world)
    if rows is None:
        looked = _looked(world, measured)
        return looked, looked
    looked = _looked(world.at(rows), measured[:, rows])
    return looked, _at_every_row(looked, world, measured)


def _at_every_row(looked: FoundInWaves, world: SimulatedWaves, measured: Array) -> FoundInWaves:
    """Return what was found in some rows of a world, built at all of them."""
    world = replace(world, out=looked.world.out, deeper_mm=looked.world.deeper_mm)
    bench, quiet = _bench(world, measured), looked.quiet.over(world.timing)
    choices = _built(looked.found.choices, world)
    if looked.world.lacking is not None:
        world, _ = with_sensed_force(world, bench, tuple(choices.values()), quiet)
        bench, choices = _bench(world, measured), _built(looked.found.choices, world)
    laws = tuple(choices[c.candidate.key] for c in looked.laws)
    if looked.plainly:
        choices[OVER_TURN] = but_for_laws(bench, laws, choices[OVER_TURN], quiet)
    found = replace(looked.found, choices=tuple(choices.values()))
    return replace(looked, world=world, bench=bench, found=found, quiet=quiet, laws=laws)


def _built(choices: Sequence[Choice], world: SimulatedWaves) -> dict[str, Choice]:
    """Return choices by key, with columns at the rows of a world."""
    standing = candidates_by_key(world, [c.candidate.key for c in choices])

    def built(choice: Choice) -> Choice:
        anew = choice.candidate.anew
        made = standing[choice.candidate.key] if anew is None else anew(world)
        return Choice(made, int(choice.shape.shape.get(COURSE, choice.form)))

    return {c.candidate.key: built(c) for c in choices}


def _refuse_mostly_gaps(recording: Recording) -> None:
    timing, t = recording.timing, recording.t_s
    measured_s = len(recording) * timing.step_s
    if measured_s < MEASURED * float(t[-1] - t[0]):
        raise UnusableInput(
            phrase(
                "{file}: column 't': {timing}; its gaps last longer than all that was "
                "recorded: give one piece as a file of its own ({parted})",
                file=recording.path,
                timing=said_again(str(timing)),
                parted=timing.parted(t),
            )
        )


def _has_edge(waves: Waves, includes: list[str] | None) -> bool:
    if includes is not None:
        return "edge_force" in includes
    edge = waves.seen(waves.teeth.forces(waves.law.of_edge))
    return bool(np.sum(edge**2) > EDGED * np.sum(waves.simulation**2))


def _tilted(recording: Recording) -> Tilted | None:
    """Return how a table is tilted, and its rates, smoothed over SMOOTH_S; None: still."""
    angles = table_angles(recording)
    if not is_tilted(angles):
        return None
    step = 1.0 / recording.timing.rate_hz
    window = max(3, round(SMOOTH_S / step))
    smooth = np.hanning(window + 2)[1:-1]
    smooth /= smooth.sum()

    def slope(values: Array) -> Array:
        padded = np.pad(values, window, mode="edge")
        return np.gradient(np.convolve(padded, smooth, mode="same")[window:-window], step)

    def rate(values: Array) -> Array:
        return by_piece(slope, values, recording.pieces)

    omega = TABLE.omega(angles, {axis: rate(angle) for axis, angle in angles.items()})
    return Tilted(TABLE.rotation(angles), omega, np.array([rate(one) for one in omega]))


def _looked(world: SimulatedWaves, measured: Array) -> FoundInWaves:
    """Return what is found in rounds, each with what scans find in what the last one left.

    Noise comes from everything at first, then from what the found set leaves. Where teeth stand
    out, or the depth is off, otherwise than the columns were made for, these are made anew and the
    round counts for no more.
    """
    bench, standing = _laid_out(world, measured)
    quiet = bench.quiet(bench.everything(standing))
    scanned = proposals_of_waves(world, bench.left([bench.chosen(())], quiet), quiet, 0)
    plain = _seen_plainly(world, measured, bench, quiet, [*standing, *scanned])
    if plain is not None:
        return plain
    quiet = bench.quiet(bench.everything([*standing, *scanned]), quiet)
    found: tuple[str, ...] | None = None
    for number in range(1, ROUNDS + 1):
        looked = _searched(world, bench, quiet, (*standing, *scanned))
        sharper = sharpened(world, bench, looked.found, quiet)
        scanned = [sharper.get(one.key, one) for one in scanned]
        bench.forget(sharper)
        choices = _anew(looked.found.choices, scanned)
        world, moved = seen_anew(world, bench, looked.found, quiet)
        if number == ROUNDS or (not moved and looked.found.keys in ((), found)):
            break
        found = looked.found.keys
        if moved:
            bench, standing = _laid_out(world, measured)
            choices = _anew(choices, standing)
        quiet = bench.quiet(
            bench.everything(standing) if moved else [bench.chosen(choices, detail=True)], quiet
        )
        scanned = [one for one in scanned if one.key in looked.found.keys]
        scanned += _scanned(world, bench, choices, quiet, number)
    return looked


def _seen_plainly(
    world: SimulatedWaves,
    measured: Array,
    bench: WhiteWaves,
    quiet: WhitenedNoise,
    candidates: Sequence[Candidate],
) -> FoundInWaves | None:
    """Return what plain rows say where the laws that they need leave more than noise; else None."""
    account = account_of_waves(bench, quiet, candidates)
    scanned = [one for one in candidates if one.scanned]
    for _ in range(ROUNDS):
        anew, moved = seen_anew(world, bench, FoundSet(account.laws), quiet)
        if not moved:
            break
        other, others = _laid_out(anew, measured)
        now = account_of_waves(other, quiet, [*others, *scanned])
        if now.left >= account.left:
            break
        world, bench, account, candidates = anew, other, now, [*others, *scanned]
    if account.course is None:
        return None
    plain = bench.plain(bench.chosen(account.laws))
    course = but_for_laws(bench, account.laws, account.course, plain)
    key = course.candidate.key
    every = [course.candidate if one.key == key else one for one in candidates]
    bench.forget([key])
    search = CandidateSearch(bench.products(every, plain), every, begin=(*account.laws, course))
    free = shape_columns(course.shape).shape[-1]
    repeats = max(1.0, bench.difference.size / free)
    return FoundInWaves(world, bench, search, search.begin, plain, account.laws, repeats)


def but_for_laws(
    bench: WhiteWaves, laws: Sequence[Choice], course: Choice, plain: WhitenedNoise
) -> Choice:
    """Return a course without a name in what own terms and laws leave of it: they come first."""
    known, columns = bench.chosen(laws), bench.columns(course.key, course.shape)
    given = solved(plain(known), plain(columns))
    shape = form(columns - known @ given, course.shape.shape)
    return Choice(replace(course.candidate, forms=(shape,)), 0)


def _scanned(
    world: SimulatedWaves,
    bench: WhiteWaves,
    choices: Sequence[Choice],
    quiet: WhitenedNoise,
    number: int,
) -> list[Candidate]:
    """Return what scans find in what choices leave, and in what those with a name alone leave.

    Families follow a stretch that was not seen beside other effects, and nothing is left of it.
    """
    found = proposals_of_waves(world, bench.left([bench.chosen(choices)], quiet), quiet, number)
    known = [choice for choice in choices if choice.candidate.named]
    if len(known) < len(choices):
        left = bench.left([bench.chosen(known)], quiet)
        found += proposals_of_waves(world, left, quiet, ROUNDS + number)
    return found


def _searched(
    world: SimulatedWaves, bench: WhiteWaves, quiet: WhitenedNoise, every: Sequence[Candidate]
) -> FoundInWaves:
    """Return the best set of candidates on a bench, that begins with the laws which blocks of time
    left out need.
    """
    laws = needed_laws(bench, quiet, every)
    needed = {c.candidate.key: c.candidate for c in laws}
    asked = [needed.get(one.key, _asked(one)) for one in every]
    faint = float(np.clip(1.0 - world.waves.fits, FAINTEST, FAINT))
    search = CandidateSearch(bench.products(asked, quiet), asked, faint=faint, begin=laws)
    found = _predicting(bench, search, quiet)
    held = [c for c in found.choices if c.candidate.key in search.begin.keys]
    if any(bench.columns(c.key, c.shape).shape[-1] > COMPONENTS for c in held):
        freely = CandidateSearch(search.products, [_asked(one) for one in every], faint=faint)
        other = _predicting(bench, freely, quiet)
        if _simpler_and_better(bench, other, found, quiet):
            search, found = freely, other
    laws = tuple(c for c in search.begin.choices if c.candidate.key in found.keys)
    return FoundInWaves(world, bench, search, found, quiet, laws)


def _asked(candidate: Candidate) -> Candidate:
    """Return a candidate of which more evidence is asked than of the laws that plain rows need."""
    return replace(candidate, bar=candidate.bar + BAR)


def _simpler_and_better(
    bench: WhiteWaves, other: FoundSet, found: FoundSet, quiet: WhitenedNoise
) -> bool:
    """Whether an account by evidence alone does better than one that begins with laws: by its
    evidence and on blocks of time left out, with no more coefficients; with fewer, as well by its
    evidence.
    """
    its, laws = (bench.chosen(one.choices).shape[-1] for one in (other, found))
    ahead = other.score - found.score
    if its > laws or ahead < (MARGIN if its == laws else 0.0):
        return False
    return _squares(bench, other.choices, quiet) < _squares(bench, found.choices, quiet)


def _anew(choices: Sequence[Choice], standing: Sequence[Candidate]) -> tuple[Choice, ...]:
    """Return choices of candidates that were made anew, in the shapes that they have now."""
    known = {one.key: one for one in standing}
    now = [Choice(known.get(c.candidate.key, c.candidate), c.form) for c in choices]
    return tuple(one for one in now if one.form < len(one.candidate.forms))


def _laid_out(world: SimulatedWaves, measured: Array) -> tuple[WhiteWaves, list[Candidate]]:
    return _bench(world, measured), candidates_of_waves(world)


def _bench(world: SimulatedWaves, measured: Array) -> WhiteWaves:
    difference = measured - world.waves.simulation
    return WhiteWaves(difference, own_columns_of_waves(world), world.timing)


def _predicting(bench: WhiteWaves, search: CandidateSearch, quiet: WhitenedNoise) -> FoundSet:
    """Return the best set of which every effect, laws aside, is of a size that may be and helps to
    predict stretches of time left out.
    """
    held = search.begin.keys
    while True:
        found = search.cleared(settled_set(search, search.best(), held=held))
        beside = [c for c in found.choices if c.candidate.key not in held]
        if not beside:
            return found
        largest = _beyond(bench, found, beside, quiet)
        if largest is not None:
            for number in range(len(largest.candidate.forms)):
                search.bar(Choice(largest.candidate, number))
            continue
        whole = _squares(bench, found.choices, quiet)
        without = [_squares(bench, found.without(c.candidate.key), quiet) for c in beside]
        weakest = int(np.argmin(without))
        if without[weakest] > whole:
            return found
        search.bar(beside[weakest])


def _beyond(
    bench: WhiteWaves, found: FoundSet, beside: Sequence[Choice], quiet: WhitenedNoise
) -> Choice | None:
    """Return the largest of some effects of a set in which one adds much more than all that is off:
    they make up for each other, and only what they leave is there. None: all are of a size that may
    be.
    """
    fit = fit_waves(bench, found.choices, quiet)
    off = BEYOND * float(np.max(np.ptp(bench.difference, axis=1)))
    peak = {
        c.candidate.key: float(np.max(np.abs(fit.part(k)))) for k, c in enumerate(found.choices)
    }
    if max(peak.values()) <= off:
        return None
    return max(beside, key=lambda c: peak[c.candidate.key])


def _squares(bench: WhiteWaves, choices: tuple[Choice, ...], quiet: WhitenedNoise) -> float:
    return float(np.sum(bench.held_out(choices, quiet)[1] ** 2))
