"""What may change over the time of a table: an edge wears, a sensor drifts, a machine warms.

An edge's force grows with its cutting time, at one rate or at each edge's own. A sensor of one
component drifts or scales by itself, the others untouched. On a cold machine more is sensed than on
the warm one that it was calibrated on: friction that the lubricant loses as it warms, and the
current that a drive takes for a force, both shift what is sensed. The machine warms while it cuts
and cools in pauses: without a pause in the table this is not distinguished from whatever else
settles, so that it is not searched for.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import (
    LawColumns,
    Rows,
    SmoothCurve,
    SpreadLaw,
    added,
    curve_of,
    each,
    grows,
    monotone,
    only,
    per_depth,
    pressing,
    relative,
    tied,
    values_of,
)
from autodb.explain.cuts.stack import FLANK_WEAR, Conditions, Stack
from autodb.explain.engine.candidates import Candidate, CandidateForm, product

Array = NDArray[np.float64]

WEAR_POWERS = (0.6, 1.7)
RUN_IN = 0.08
"""Time constant of an edge's first rapid wear as a share of the longest cutting time. Chosen: that
of a sensor that settles, so that neither is found for being the quicker."""
FIRST_CUTS = 3
"""Cuts of one edge that a table must have within that time: a course of fewer is a step. Chosen."""
MOST_EDGES = 40
"""Edges with a rate of their own in the search; with more, only one rate for all."""
CURVE = 5
SETTLING = (0.08, 0.3)
"""Time constants of settling as a share of the table's time."""
PAUSE = 5.0
"""A step from cut to cut this many times the usual one is a pause in which the machine cools."""
TIMES_S = (600.0, 1500.0, 4000.0)
"""Time constants of warming: from a motor's to a machine frame's. Chosen."""
LEVELLING = (2.0,)
"""How much sooner the fall levels off than the heat, as in the term `warmup`. Chosen."""
LAWS = 2
"""Laws of ``cold_laws``."""


def _cutting_time(known: Conditions) -> Array:
    assert known.cutting_time_s is not None
    return known.cutting_time_s


def _land(known: Conditions) -> Array:
    assert known.land_mm is not None
    return known.land_mm


def wear_candidates(stack: Stack, own: frozenset[str]) -> list[Candidate]:
    """Return what grows with the cutting time of an edge, or with its flank wear where that was
    measured and no time recorded: the land presses on the work; none where neither is known.

    By the clock it is no law that comes before others: any order of cuts goes with it, and one
    component alone that grows so drifts (``pressing``).
    """
    worn, seen = stack.wear_goes_with, stack.frame.wear_goes_with
    if "tool_wear" in own or worn is None or seen is None or np.ptp(seen) == 0:
        return []
    spent, measured = worn / float(seen.max()), stack.frame.known.by_land
    forms = []
    for power in (1.0, *WEAR_POWERS):
        shape = {} if power == 1.0 else {"power": power}
        law = per_depth(stack, values_of(spent**power))
        forms.append(grows(each(stack, law), shape))
        forms.append(grows(each(stack, relative(stack, values_of(spent**power))), shape))
    if not measured:
        forms += [grows(each(stack, law), shape) for law, shape in _run_in_laws(stack, spent)]
    curve = curve_of(stack, _land if measured else _cutting_time, CURVE)
    if curve.levels is None:
        fresh = _fresh(curve)
        law = per_depth(stack, lambda rows: curve(rows) - fresh, curve.width)
        columns = each(stack, law)
        forms.append(CandidateForm(columns, allowed=monotone(curve, columns, direction=1.0)))
        forms += [] if measured else _edge_forms(stack, spent, curve)
    bow = np.column_stack([spent, spent**2, spent**3])
    detail = each(stack, per_depth(stack, values_of(bow), 3))
    by_clock = stack.frame.known.by_clock and not measured
    if by_clock:
        forms = [replace(one, allowed=pressing(_columns(one), one.allowed)) for one in forms]
    variables = (FLANK_WEAR,) if measured else ("tool.cutting_time", "tool.edge")
    variables = ("t",) if by_clock else variables
    wear = Candidate("tool_wear", "tool_wear", tuple(forms), variables, detail=detail)
    return [replace(wear, static=not by_clock)]


def _columns(form: CandidateForm) -> LawColumns:
    assert isinstance(form.law, LawColumns)  # every candidate of a cut table is made of laws
    return form.law


def _run_in_laws(stack: Stack, spent: Array) -> list[tuple[SpreadLaw, dict[str, float]]]:
    """Return wear that is rapid until a fresh edge has run in: that alone, and even wear with it.

    A ground edge and its coating lose their peaks in the first of its cuts; then the flank wears
    evenly, often by so little that a drill's holes show the first alone. None where no fresh edge
    was seen for a few cuts, or by the clock, which does not say that there was one.
    """
    seen = stack.frame.known
    time = _cutting_time(seen)
    early = time <= RUN_IN * time.max()
    most = max((np.count_nonzero(early[seen.edge == edge]) for edge in seen.edges), default=0)
    if seen.by_clock or most < FIRST_CUTS:
        return []
    first = -np.expm1(-spent / RUN_IN)
    both = np.column_stack([first, spent])
    return [
        (per_depth(stack, values_of(first)), {"run_in": RUN_IN}),
        (per_depth(stack, values_of(both), 2), {"run_in": RUN_IN, "even": 1.0}),
    ]


def _fresh(curve: SmoothCurve) -> Array:
    """Return the curve's columns at no cutting time (1, width); 0 where no such edge was seen."""
    return curve.at(np.zeros(1)) if curve.frame.min() <= 0 else np.zeros((1, curve.width))


def _members(stack: Stack) -> Array:
    """Return which of the table's edges made each cut, (n, E); of another edge their mean."""
    edge, edges = stack.known.edge, stack.frame.known.edges
    assert edge is not None
    member = np.asarray(edge[:, None] == edges[None, :], dtype=np.float64)
    member[~member.any(axis=1)] = 1.0 / len(edges)
    return member


def _edge_forms(stack: Stack, spent: Array, curve: SmoothCurve) -> list[CandidateForm]:
    """Return shapes with a rate for each edge, the components in the ratio of the common rate."""
    cuts, edges = len(stack.frame.known), len(stack.frame.known.edges)
    if not 2 <= edges <= min(MOST_EDGES, cuts // 4):
        return []
    ratio, member = wear_ratio(stack.frame), _members(stack)
    forms = []
    for power in (1.0, *WEAR_POWERS):
        law = per_depth(stack, values_of(member * spent[:, None] ** power), edges)
        forms.append(grows(tied(stack, law, ratio), {"power": power, "edges": float(edges)}))
    if cuts > 30 * edges:
        fresh = _fresh(curve)

        def shape(rows: Rows) -> Array:
            return product(member[rows], curve(rows) - fresh)

        law = per_depth(stack, shape, edges * curve.width)
        forms.append(grows(tied(stack, law, ratio), {"curved": 1.0, "edges": float(edges)}))
    return forms


def wear_ratio(stack: Stack) -> Array:
    """Return how strongly wear acts on each component, (C,), the strongest 1."""
    time = _cutting_time(stack.known)
    spent, found = time / float(time.max()), []
    for i in range(len(stack.names)):
        sd = stack.sd[i]
        grown = stack.sign[i] * stack.known.depth_mm * spent
        design = np.column_stack([grown, stack.simulation[i], stack.known.depth_mm]) / sd[:, None]
        difference = (stack.recording[i] - stack.simulation[i]) / sd
        found.append(np.linalg.lstsq(design, difference, rcond=1e-8)[0][0])
    ratio = np.maximum(np.array(found), 0.0)
    most = float(ratio.max())
    return np.asarray(ratio / most if most > 0 else np.ones_like(ratio))


def time_share(known: Conditions, seen: Conditions) -> Array:
    """Return the time of cuts over that of a table, 0 to 1 in it, (n,)."""
    start, end = float(seen.t_s[0]), float(seen.t_s[-1])
    return np.asarray((known.t_s - start) / max(end - start, 1e-300), dtype=np.float64)


def _over_time(stack: Stack, count: int) -> SmoothCurve:
    seen = stack.frame.known
    return SmoothCurve(time_share(stack.known, seen), count, time_share(seen, seen))


def drift_courses(stack: Stack) -> list[tuple[Callable[[Rows], Array], int]]:
    """Return the courses over a table's time that a sensor may drift by, with their widths."""
    t = time_share(stack.known, stack.frame.known)
    shapes: list[tuple[Callable[[Rows], Array], int]] = [(values_of(t), 1)]
    shapes += [(values_of(-np.expm1(-t / tau)), 1) for tau in SETTLING]
    if len(stack.frame.known) >= 4 * CURVE:
        curve = _over_time(stack, CURVE)
        shapes.append((curve, curve.width))
    return shapes


def drift_candidates(stack: Stack) -> list[Candidate]:
    """Return a force of one component that is there whatever the cut, and changes with the time."""
    found = []
    for i, name in enumerate(stack.names):
        laws = [added(stack, shape, width) for shape, width in drift_courses(stack)]
        forms = tuple(CandidateForm(only(stack, law, i)) for law in laws)
        free = _over_time(stack, 2 * CURVE)
        detail = only(stack, added(stack, free, free.width), i)
        key = f"sensor_drift {name}"
        found.append(Candidate(key, "sensor_drift", forms, ("t",), detail=detail))
    return found


def gain_candidates(stack: Stack) -> list[Candidate]:
    """Return a factor on one component that changes with the time."""
    found = []
    for i, name in enumerate(stack.names):
        forms = tuple(
            CandidateForm(only(stack, relative(stack, s, w), i)) for s, w in drift_courses(stack)
        )
        free = _over_time(stack, 2 * CURVE)
        detail = only(stack, relative(stack, free, free.width), i)
        found.append(Candidate(f"gain {name}", "gain", forms, ("t",), detail=detail))
    return found


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
    return [_added(stack, cold), relative(stack, values_of(cold))]


def _added(stack: Stack, shape: Array) -> SpreadLaw:
    columns = shape.reshape(len(shape), -1)
    sign = stack.sign[:, None, None]
    return SpreadLaw(lambda rows: sign * columns[None, rows], columns.shape[1])


def coldness(stack: Stack, time_s: float, *, levelling: float = 0.0) -> Array:
    """Return how cold the machine is in each cut, 1 at the first one and 0 in steady work, (n,).

    1 − s(1 + b)/(1 + b s), s the machine's warmth over that of steady work, b ``levelling``;
    T dw/dt = 1 − w while it cuts and −w while it does not (see `terms.warming.warmup`).
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
