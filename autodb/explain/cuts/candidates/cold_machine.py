"""What is sensed on a cold machine: more than on the warm one that it was calibrated on.

Friction that the lubricant loses as it warms, and the current that a drive takes for a force, both
shift what is sensed. The machine warms while it cuts and cools in pauses: without a pause in the
table this is not distinguished from whatever else settles, so that it is not searched for.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import LawColumns, SpreadLaw, each, grows
from autodb.explain.cuts.stack import Conditions, Stack
from autodb.explain.engine.candidates import Candidate

Array = NDArray[np.float64]

PAUSE = 5.0
"""A step from cut to cut this many times the usual one is a pause in which the machine cools."""
TIMES_S = (600.0, 1500.0, 4000.0)
"""Time constants of warming: from a motor's to a machine frame's. Chosen."""
LEVELLING = (2.0,)
"""How much sooner the fall levels off than the heat, as in the term `warmup`. Chosen."""
LAWS = 2
"""Laws of ``cold_laws``."""


def warming_candidates(stack: Stack) -> list[Candidate]:
    """Return what a cold machine adds to the sensed forces; none where the table has no pause."""
    if not has_pause(stack.frame.known):
        return []
    forms = []
    for time_s in TIMES_S:
        for levelling in LEVELLING:
            cold = coldness(stack, time_s, levelling=levelling)
            shape = {"time_constant": time_s, "levelling": levelling}
            forms += [grows(each(stack, law), shape) for law in cold_laws(stack, cold)]
    slow = np.column_stack([coldness(stack, time_s) for time_s in (TIMES_S[0], TIMES_S[-1])])
    detail = each(stack, _added(stack, slow))
    return [Candidate("warmup", "warmup", tuple(forms), ("t",), detail=detail)]


def warming_columns(stack: Stack, form: int, time_s: float) -> LawColumns:
    """Return the columns of one of the candidate's shapes at another time constant."""
    levelling = LEVELLING[form // LAWS % len(LEVELLING)]
    return each(stack, cold_laws(stack, coldness(stack, time_s, levelling=levelling))[form % LAWS])


def has_pause(known: Conditions) -> bool:
    """Whether the machine stood still for much longer than it does between two cuts."""
    steps = np.diff(known.t_s)
    return "t" in known.recorded and bool(steps.max() > PAUSE * np.median(steps))


def cold_laws(stack: Stack, cold: Array) -> list[SpreadLaw]:
    """Return friction that a cold machine (n,) has besides, or a factor on its forces."""
    offset, factor = _added(stack, cold), _factor(stack, cold)
    return [offset, factor]


def _added(stack: Stack, shape: Array) -> SpreadLaw:
    columns = shape.reshape(len(shape), -1)
    sign = stack.sign[:, None, None]
    return SpreadLaw(lambda rows: sign * columns[None, rows], columns.shape[1])


def _factor(stack: Stack, cold: Array) -> SpreadLaw:
    return SpreadLaw(lambda rows: stack.simulation[:, rows, None] * cold[None, rows, None])


def coldness(stack: Stack, time_s: float, *, levelling: float = 0.0) -> Array:
    """Return how cold the machine is in each cut, 1 at the first one and 0 in steady work, (n,).

    1 − s(1 + b)/(1 + b s), s the machine's warmth over that of steady work, b ``levelling``;
    T dw/dt = 1 − w while it cuts and −w while it does not (see `terms.drive.warmup`).
    """
    seen = stack.frame.known
    work = UsualWork.of(seen)
    warm, end = _warmth(seen, work, time_s, 0.0)
    if stack.like is not None:
        warm = _after(stack.known, seen, work, time_s, end)
    share = warm / work.busy
    return np.asarray(1.0 - share * (1.0 + levelling) / (1.0 + levelling * share))


@dataclass(frozen=True)
class UsualWork:
    """How a machine works: a cut's usual duration, and the share of the time in which it cuts."""

    usual_s: float
    busy: float

    @classmethod
    def of(cls, known: Conditions) -> "UsualWork":
        """Read it off a table, pauses left out."""
        steps = np.diff(known.t_s)
        cuts = _durations(known, float(np.median(steps)))
        kept = steps <= PAUSE * np.median(steps)
        busy = float(np.sum(np.minimum(cuts[:-1], steps)[kept]) / np.sum(steps[kept]))
        return cls(float(np.median(cuts)), busy)


def _durations(known: Conditions, usual_s: float) -> Array:
    """Return how long each cut lasts, by the cutting time of its edge where that goes on, (n,)."""
    found = np.full(len(known), np.nan)
    if known.cutting_time_s is not None:
        grown = np.diff(known.cutting_time_s)
        found[:-1] = np.where(grown > 0, grown, np.nan)
    median = float(np.nanmedian(found)) if np.isfinite(found).any() else usual_s
    return np.where(np.isfinite(found), found, median)


def _warmth(known: Conditions, work: UsualWork, time_s: float, begin: float) -> tuple[Array, float]:
    """Return the warmth in the middle of each cut (n,), and at the end of the last one."""
    lasts = _durations(known, work.usual_s)
    lasts[:-1] = np.minimum(lasts[:-1], np.diff(known.t_s))
    half = np.exp(-0.5 * lasts / time_s)
    rest = np.exp(-(np.diff(known.t_s) - lasts[:-1]) / time_s)
    found, warm = np.empty(len(known)), begin
    for row in range(len(known)):
        found[row] = 1.0 + (warm - 1.0) * half[row]
        warm = 1.0 + (found[row] - 1.0) * half[row]
        if row < len(rest):
            warm *= rest[row]
    return found, warm


def _after(
    known: Conditions, seen: Conditions, work: UsualWork, time_s: float, end: float
) -> Array:
    """Return the warmth in cuts that follow a table, each run of rising time by itself, (m,)."""
    turns = np.flatnonzero(np.diff(known.t_s) <= 0) + 1
    last_s = float(seen.t_s[-1]) + work.usual_s
    found = []
    for rows in np.split(np.arange(len(known)), turns):
        pause_s = max(float(known.t_s[rows[0]]) - last_s, 0.0)
        part = _rows(known, rows)
        found.append(_warmth(part, work, time_s, end * float(np.exp(-pause_s / time_s)))[0])
    return np.concatenate(found)


def _rows(known: Conditions, rows: NDArray[np.intp]) -> Conditions:
    """Return time and cutting time of some cuts."""
    time = known.cutting_time_s
    return Conditions(
        known.number[rows], known.t_s[rows], known.depth_mm[rows], None, None, None, {},
        None if time is None else time[rows],
    )  # fmt: skip
