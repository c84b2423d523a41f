"""Runs of even rows: where rows are missing, and what is done about it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.timing.clock import Clock, clock
from autodb.timing.layout import LaidPiece
from autodb.timing.places import leaping
from autodb.timing.steps import FILLED_ROWS, Numbered, numbered, share_stamps
from autodb.timing.verdict import StampFinding
from autodb.wording import stored_msgid

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Flags = NDArray[np.bool_]

HELD_S = 10.0
"""Longest time without a change over which rows written on change are held. Chosen."""
BLURRED = ("jittered", "shared")
"""Kinds of stamps that do not say which rows are missing."""
FEWEST_SPANS, RESTING, ON_CHANGE = 10, 1.5, 0.95
"""Rows are written on change where so many spans are missing, and over this share of them places
move by less than RESTING times what they move in one step. Chosen."""
MOSTLY_COPIES = 0.9
"""Share of the rows with the stamp of the row before that are copies of it, where rows that share
stamps are doubled besides. Chosen."""
SHORTEST_S, SHORTEST_ROWS = 0.5, 50
"""Shorter pieces are left out where there are others. Chosen: what filters take in."""
SAME_STEP = 1e-3
"""Share by which the steps of runs may differ and be one. Chosen."""
SHOWN = 3
COARSER = 4.0
"""A run with steps longer by this than the most rows have is left out. Chosen."""
SAME_STAMP = stored_msgid("{count} rows with the stamp of another left out")
TWICE = stored_msgid("{count} rows written twice left out")
RESAMPLED = stored_msgid("{count} rows at {rate} resampled")
HELD_AT_LAST = stored_msgid(
    "rows written on change: {count} rows ({share} of all) held at the last value"
)
FILLED = stored_msgid("{count} missing rows filled from their neighbours")
ONE_GAP = stored_msgid("gap of {length} after {at}")
GAPS = stored_msgid("{count} gaps, the longest of {length} after {at}")
LEAPS = stored_msgid("{channel} leaps as no axis moves (at {places}): parted there")


@dataclass(frozen=True)
class Run:
    """One run of a clock: the file's ``rows`` (n,) in time, numbered, and when they were taken."""

    rows: Index
    numbered: Numbered
    clock: Clock
    findings: tuple[StampFinding, ...]


def run_of(
    rows: Index, t_s: Array, channels: Mapping[str, Array], places: Sequence[str]
) -> Run | None:
    """Return the run of the file's ``rows`` with the stamps ``t_s`` (n,).

    None where it has too few rows, or its stamps stand still.
    """
    kept, findings = _without_copies(rows, t_s, list(channels.values()))
    rows, t = rows[kept], t_s[kept]
    found = numbered(t) if len(t) > 2 else None
    if found is None:
        return None
    once = np.append(True, np.diff(found.number) > 0)
    if not once.all():
        count = int(np.sum(~once))
        findings.append(StampFinding("doubled", SAME_STAMP.format(count=count), count))
        rows, t = rows[once], t[once]
        found = numbered(t)
    if found is None:
        return None
    here = {name: channels[name][rows] for name in places}
    speeds = [(here[name], channels[of][rows]) for name, of in _speeds(places, channels)]
    at = clock(t, found, list(here.values()), speeds)
    return Run(rows, found, at, (*findings, *at.findings))


def _speeds(places: Sequence[str], channels: Mapping[str, Array]) -> list[tuple[str, str]]:
    """Return the places whose speed was recorded on every row, with the name of that."""
    named = [(name, f"{name.rpartition('.')[0]}.velocity") for name in places]
    return [(p, v) for p, v in named if v in channels and np.isfinite(channels[v]).all()]


def _without_copies(
    rows: Index, t_s: Array, channels: Sequence[Array]
) -> tuple[Flags, list[StampFinding]]:
    """Return which rows (n,) are no copy of the row before, stamp and all."""
    same = np.append(False, np.diff(t_s) == 0)
    if not channels or not same.any():
        return np.ones(len(rows), dtype=np.bool_), []
    copies = same.copy()
    for values in channels:
        own = values[rows]
        copies[1:] &= (own[1:] == own[:-1]) | (np.isnan(own[1:]) & np.isnan(own[:-1]))
    count = int(copies.sum())
    if not count or (share_stamps(t_s) and count < MOSTLY_COPIES * same.sum()):
        return np.ones(len(rows), dtype=np.bool_), []
    return ~copies, [StampFinding("doubled", TWICE.format(count=count), count)]


def laid_pieces(
    run: Run, step_s: float, channels: Mapping[str, Array], places: Sequence[str]
) -> tuple[list[LaidPiece], list[StampFinding]]:
    """Return the pieces of a run on steps of ``step_s``, and what was done about missing rows."""
    findings: list[StampFinding] = []
    missing = np.diff(run.numbered.number) - 1
    spans = np.flatnonzero(missing > 0)
    on_change = _on_change(run, spans, [channels[name][run.rows] for name in places])
    longest = HELD_S / run.numbered.step_s if on_change else FILLED_ROWS
    parted = spans[missing[spans] > longest]
    filled = spans[missing[spans] <= longest]
    leaps = _leaps(run, missing, channels, places, findings)
    findings += _missing_rows(run, missing, filled, on_change=on_change)
    findings += _gaps(run, parted)
    borders = [0, *sorted({*(parted + 1), *leaps}), len(run.rows)]
    regular = abs(run.numbered.step_s / step_s - 1.0) <= SAME_STEP
    pieces = []
    for begin, end in pairwise(borders):
        if end - begin > 1:
            whole = regular and run.clock.on_grid and not missing[begin : end - 1].any()
            rows = slice(int(begin), int(end))
            own = [channels[name] for name in places]
            pieces.append(
                _exact_piece(run, rows, step_s)
                if whole
                else _piece(run, rows, step_s, own, on_change=on_change)
            )
    if not regular:
        count = len(run.rows)
        findings.append(
            StampFinding(
                "other rate",
                RESAMPLED.format(count=count, rate=f"{1.0 / run.numbered.step_s:.6g} Hz"),
                count,
            )
        )
    return pieces, findings


def _leaps(
    run: Run,
    missing: Index,
    channels: Mapping[str, Array],
    places: Sequence[str],
    findings: list[StampFinding],
) -> set[int]:
    """Return the rows before which a place leaps though no time passes, and say so."""
    found: set[int] = set()
    for name in places:
        rows = {int(row) for row in leaping(channels[name][run.rows]) if missing[row - 1] == 0}
        if rows:
            at = ", ".join(f"{run.clock.times_s[row]:.6g} s" for row in sorted(rows)[:SHOWN])
            more = f" and {len(rows) - SHOWN} more" if len(rows) > SHOWN else ""
            sentence = LEAPS.format(channel=name, places=f"{at}{more}")
            findings.append(StampFinding("leap", sentence, len(rows)))
        found |= rows
    return found


def _on_change(run: Run, spans: Index, places: Sequence[Array]) -> bool:
    """Say whether rows are missing because nothing changed: places rest where they are."""
    clean = run.clock.on_grid and not any(one.kind in BLURRED for one in run.clock.findings)
    if len(spans) < FEWEST_SPANS or not places or not clean:
        return False
    one = np.diff(run.numbered.number) == 1
    for place in places:
        way = np.abs(np.diff(place))
        moved = way[one & (way > 0)]
        if not moved.size:
            continue
        if np.mean(way[spans] <= RESTING * np.median(moved)) < ON_CHANGE:
            return False
    return True


def _exact_piece(run: Run, rows: slice, step_s: float) -> LaidPiece:
    times = run.clock.times_s[rows]
    none = np.zeros(len(times), dtype=np.bool_)
    t = times[0] + step_s * np.arange(len(times))
    return LaidPiece(run.rows[rows], times, t, held=none, resting=none, exact=True)


def _piece(
    run: Run, rows: slice, step_s: float, places: Sequence[Array], *, on_change: bool
) -> LaidPiece:
    """Return a piece whose rows do not all lie on its even times."""
    times = run.clock.times_s[rows]
    t = times[0] + step_s * np.arange(int(np.floor((times[-1] - times[0]) / step_s + 1e-6)) + 1)
    latest = np.maximum.accumulate(times)
    increasing = np.append(True, times[1:] > latest[:-1] + 1e-3 * step_s)
    times, own = times[increasing], run.rows[rows][increasing]
    held = resting = np.zeros(len(t), dtype=np.bool_)
    if on_change:
        last = np.searchsorted(times, t + 0.5 * step_s, side="right") - 1
        held = t - times[last] > 0.5 * step_s
        still = np.ones(len(own) - 1, dtype=np.bool_)
        for place in places:
            still &= np.diff(place[own]) == 0
        resting = np.append(False, still)[last]
    return LaidPiece(own, times, t, held=held, resting=resting, exact=False)


def _missing_rows(
    run: Run, missing: Index, filled: Index, *, on_change: bool
) -> list[StampFinding]:
    count = int(missing[filled].sum())
    if not count:
        return []
    share = count / (count + len(run.rows))
    if on_change:
        return [
            StampFinding(
                "on change",
                HELD_AT_LAST.format(count=count, share=f"{share:.2g}"),
                count,
            )
        ]
    return [StampFinding("missing rows", FILLED.format(count=count), count)]


def _gaps(run: Run, parted: Index) -> list[StampFinding]:
    if not len(parted):
        return []
    t = run.clock.times_s
    wide = t[parted + 1] - t[parted]
    longest = int(np.argmax(wide))
    many = ONE_GAP if len(parted) == 1 else GAPS
    length, at = f"{wide[longest]:.4g} s", f"{t[parted[longest]]:.6g} s"
    sentence = many.format(count=len(parted), length=length, at=at)
    return [StampFinding("gap", sentence, len(parted))]
