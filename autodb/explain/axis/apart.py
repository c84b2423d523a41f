"""The move on which two explanations of one recording would differ most for the noise there is.

Both are fitted on the recording and carried to a move that follows it, where
`explain.engine.telling` says how far they differ: in rows that the recording's filter makes white,
of unit variance. The difference in the channel's unit is d − X δ with the move counted as one row:
δ then only takes up what the recording leaves open. Shapes are held.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.elsewhere import AxisAccount, account_columns, fit_axis_account, signals_on
from autodb.explain.axis.moves import (
    LIBRARY,
    AxisMove,
    AxisPath,
    Reach,
    again,
    joined_paths,
    reach,
    still,
)
from autodb.explain.axis.reading import AxisReading
from autodb.explain.axis.signals import AxisSignals
from autodb.explain.engine.candidates import Choice
from autodb.explain.engine.fit import rms
from autodb.explain.engine.plain.odds import of_plain
from autodb.explain.engine.telling import (
    NEAREST,
    SEPARATES,
    Separation,
    called,
    odds,
    sentence,
    stand_in,
)
from autodb.explain.engine.tuning import BesideShapes, tuned
from autodb.explain.engine.working import reduced
from autodb.files.channels import place_channel, way_unit
from autodb.sensing.drives.moves.motion import STILL_SHARE, noise_sd, standstill_speed
from autodb.terms.vocabulary import term_called
from autodb.wording import significant, stored_msgid

Array = NDArray[np.float64]

NONE_TELLS = stored_msgid("No move in the library separates {one} and {other}.")
NOISE = stored_msgid("noise is {size}")
PEAK = 0.999
"""Quantile of the difference that counts as its peak: single rows at a reversal do not."""


@dataclass(frozen=True)
class RunMove:
    """A move in words, and the axis' signals on it: its rows are the last ones."""

    words: str
    signals: AxisSignals
    rows: int


def move_that_tells(
    reading: AxisReading, number: int, rivals: Sequence[str], never: Sequence[str]
) -> str | None:
    """Return what would tell the found effect ``number`` from its rivals, nearest first, or None.

    ``never``: names that no move tells from it. Where the library has no move, the term's own words
    follow.
    """
    if not rivals and not never:
        return None
    term = term_called(reading.everything[number].candidate.term)
    level = noise(reading)
    found = {name: _from_rival(reading, number, name) for name in rivals[:NEAREST]}
    best = {**dict.fromkeys(never), **found}
    lines = [_line(b, (term.name, name), level, reading.unit) for name, b in best.items()]
    if None in best.values() and term.distinguished_by:
        lines.append(term.distinguished_by)
    return " ".join(lines)


def _from_rival(reading: AxisReading, number: int, name: str) -> Separation | None:
    swapped = instead(reading, number, name)
    return separation(reading, reading.everything, swapped) if swapped else None


def _line(best: Separation | None, names: tuple[str, str], level: float, unit: str) -> str:
    if best is None:
        return NONE_TELLS.format(one=names[0], other=names[1])
    noise = NOISE.format(size=f"{significant(level, 2)} {unit}")
    return sentence(best, names, unit, noise)


def instead(reading: AxisReading, number: int, name: str) -> tuple[Choice, ...] | None:
    """Return the best set in which a term stands in for a found effect; its shape is tuned."""
    inquiry = reading.inquiry
    choice = inquiry.choices[number]
    if inquiry.rows is not None and choice in inquiry.founded:
        rival = of_plain(inquiry.rows, inquiry.founded, choice).instead.get(name)
        others = tuple(c for c in inquiry.choices if c.key != choice.key)
        return _with_tuned(reading, others, rival) if rival else None
    key = choice.candidate.key
    swap = stand_in(inquiry.search, inquiry.found, key, called(inquiry.search, name, but=key))
    if swap is None:
        return None
    rival = next(c for c in swap[0].choices if c.candidate.key == swap[1].candidate.key)
    others = (*inquiry.founded, *swap[0].without(swap[1].candidate.key))
    return _with_tuned(reading, others, rival)


def _with_tuned(
    reading: AxisReading, others: tuple[Choice, ...], rival: Choice
) -> tuple[Choice, ...]:
    beside = BesideShapes(reading.whole, others, reading.inquiry.noise)
    return (*others, tuned(rival, beside).choice)


def separation(
    reading: AxisReading, first: tuple[Choice, ...], second: tuple[Choice, ...]
) -> Separation | None:
    """Return the move with the greatest distance for its noise, or None where none separates."""
    accounts = fit_axis_account(reading, first), fit_axis_account(reading, second)
    able = [gap for gap in account_distances(reading, accounts) if gap.odds > SEPARATES]
    return max(able, key=lambda gap: gap.distance, default=None)


def account_distances(
    reading: AxisReading, accounts: tuple[AxisAccount, AxisAccount]
) -> list[Separation]:
    """Return how far two accounts differ on every move that the axis can run, but those of so few
    rows that none is left when they are made white.
    """
    fewest = len(reading.inquiry.whitener.coefficients)
    warm = any(c.candidate.term == "warmup" for of in accounts for c in of.choices)
    made = possible_runs(reading.signals, reading.bench.factor, history=warm)
    return [accounts_apart(reading, accounts, run) for run in made if run.rows > fewest]


def accounts_apart(
    reading: AxisReading, accounts: tuple[AxisAccount, AxisAccount], run: RunMove
) -> Separation:
    """Return how far two accounts differ on one move."""
    one, two = accounts
    columns = [account_columns(of, run.signals)[-run.rows :] for of in accounts]
    difference = columns[0] @ one.coefficients - columns[1] @ two.coefficients
    free = np.column_stack([columns[0] @ one.root, columns[1] @ two.root])
    noise_sd = float(np.sqrt(reading.inquiry.variance))
    white, right = (reading.inquiry.whitener.unbroken(v) / noise_sd for v in (free, difference))
    gained, taken = odds(white, right)
    return Separation(
        words=run.words,
        odds=gained,
        distance=float(np.sqrt(gained / len(right))),
        peak=float(np.quantile(np.abs(difference - free @ taken), PEAK)),
    )


def noise(reading: AxisReading) -> float:
    """Return the rms of what the accepted set leaves at the working rate."""
    bench = reading.bench
    return rms(bench.left(bench.chosen(reading.choices), reading.inquiry.whitener))


def possible_runs(recorded: AxisSignals, factor: int, *, history: bool) -> list[RunMove]:
    """Return every move that the axis can run, at the working rate.

    ``history``: before a move that is not run cold comes the recording's own motion, which warms.
    """
    longest = max(recorded.pieces, key=lambda piece: piece.stop - piece.start)
    moved = [getattr(recorded, field.name)[longest] for field in fields(AxisPath)]
    programme = AxisPath(*(reduced(values, factor) for values in moved))
    rate_hz = 1.0 / (factor * float(np.median(np.diff(recorded.t_s))))
    moves = (*LIBRARY, again(programme))
    made = [_paths(move, recorded, rate_hz) for move in moves]
    return [
        _after(words, paths, recorded, None if move.cold or not history else programme, rate_hz)
        for move, run in zip(moves, made, strict=True)
        if run is not None
        for words, paths in [run]
    ]


def _after(
    words: str,
    paths: tuple[AxisPath, AxisPath],
    recorded: AxisSignals,
    before: AxisPath | None,
    rate_hz: float,
) -> RunMove:
    """Return a run of this axis and of the others, right after what ran before."""
    rows, begin_s = len(paths[0].t_s), float(recorded.t_s[-1]) + 1.0 / rate_hz
    if before is not None:
        own, other = paths
        paths = (
            joined_paths([before, own], rate_hz),
            joined_paths([still(before, 0.0), other], rate_hz),
        )
        begin_s -= len(before.t_s) / rate_hz
    return RunMove(words, signals_on(*paths, recorded, begin_s=begin_s), rows)


def _paths(
    move: AxisMove, recorded: AxisSignals, rate_hz: float
) -> tuple[str, tuple[AxisPath, AxisPath]] | None:
    """Return a move in words, and the paths of this axis and the others; None: it cannot run."""
    own = reach(
        recorded.position, recorded.velocity, recorded.acceleration,
        unit=recorded.unit, still=STILL_SHARE * recorded.scales.top,
    )  # fmt: skip
    if move.of_other:
        return _paths_of_other(move, own, recorded, rate_hz)
    if move.scaled and not own.moves:
        return None
    path = move.path(own, rate_hz)
    return move.words(own), (path, still(path, 0.0))


def _paths_of_other(
    move: AxisMove, own: Reach, recorded: AxisSignals, rate_hz: float
) -> tuple[str, tuple[AxisPath, AxisPath]] | None:
    other = next((name.partition(".")[0] for name in recorded.others), None)
    if other is None:
        return None
    names = (place_channel(other), f"{other}.velocity", f"{other}.acceleration")
    place, velocity, acceleration = (recorded.others[name] for name in names)
    slowest = standstill_speed(place, velocity, noise_sd(velocity))
    its = reach(place, velocity, acceleration, unit=way_unit(other), still=slowest)
    path = move.path(its, rate_hz)
    return move.words(its), (still(path, own.middle_mm), path)
