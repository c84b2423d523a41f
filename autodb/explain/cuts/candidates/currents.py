"""What a run of standard cuts may hold in an axis' current that its calibration does not.

Two components: the rise of the current over its value in air, simulated as the calibration turned
round gives it at the reference force, and the current in air, where it was recorded. The rise is
gain times force; friction is in the air, and in the rise only as far as the load adds to it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import (
    LawColumns,
    Rows,
    SpreadLaw,
    added,
    alike,
    grows,
    only,
    per_depth,
    relative,
    values_of,
)
from autodb.explain.cuts.candidates.library import Library
from autodb.explain.cuts.candidates.over_time import drift_courses
from autodb.explain.cuts.candidates.searched import SHORTEST
from autodb.explain.cuts.stack import Conditions, Stack, table_conditions
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.records.tables import CutTable

Array = NDArray[np.float64]
FEWEST = 8
"""Standard cuts of a run in which something is looked for, at least. Chosen."""
Make = Callable[[Stack, Callable[[Rows], Array], int], SpreadLaw]
Course = tuple[Callable[[Rows], Array], int, dict[str, float], int]
"""Columns over the cuts, their number, what their shape is, and how many were tried."""

RISE, AIR = 0, 1
GAIN, OFFSET, FRICTION, WEAR = "gain", "sensor_drift", "coulomb", "tool_wear"
SPEED = "friction.speed"
"""Under which name the conditions of a run have the speed that friction in air goes with."""
CONDITION = "cut.condition"
"""The same of the number of each cut's condition."""
LEVELS = "levels"
REPEATED = 3
"""Cuts of one condition from which on it has a level of its own: no calibration is right in each.
Chosen."""
MOST_STEPS = 60
"""Cuts at which a step is tried at most, evenly over the run, the last one included."""
SPEEDS = 2
"""Highest power of the speed by which friction in air is followed. Chosen."""


@dataclass(frozen=True)
class StandardRun:
    """Cuts (n,) of one axis in the order in which they were made.

    ``table``: how they were made; ``conditions``: cuts of one number were made alike; ``rise`` and
    ``expected``: recorded, and by the calibration at the reference force; ``air``: the current
    before each cut, None where that was not recorded; ``speed``: what friction in air goes with
    (NaN: not known). ``measured``: whether the force of each cut was measured, so that ``expected``
    has moved with it. All currents in ``unit``.
    """

    table: CutTable
    conditions: NDArray[np.intp]
    rise: Array
    expected: Array
    air: Array | None
    speed: Array
    measured: bool
    unit: str

    @property
    def enough(self) -> bool:
        """Whether there are cuts enough to look for anything in."""
        return len(self.rise) >= FEWEST


def stack_of_run(run: StandardRun) -> Stack:
    """Return the components stacked, scatter not yet estimated."""
    rows, simulated = [run.rise], [run.expected]
    if run.air is not None and np.any(run.air):
        rows.append(run.air)
        simulated.append(np.full_like(run.air, float(np.mean(run.air))))
    recording, simulation = np.stack(rows), np.stack(simulated)
    count = len(rows)
    return Stack(
        ("rise", "air")[:count], _known(run), recording, simulation,
        np.zeros(count), np.zeros_like(recording), np.ones_like(recording), np.eye(count),
    )  # fmt: skip


def _known(run: StandardRun) -> Conditions:
    """Return the conditions; a column with a zero states none, time that does not rise no clock."""
    table = run.table
    stated = {
        name: values
        for name, values in table.channels.items()
        if not (name.startswith("cutting.") and np.nanmin(values, initial=np.inf) <= 0)
    }
    known = table_conditions(replace(table, channels=stated))
    order = np.arange(len(table), dtype=np.float64)
    followed = {SPEED: run.speed} if np.isfinite(run.speed).all() else {}
    followed[CONDITION] = run.conditions.astype(np.float64)
    known = replace(known, number=order + 1.0, other={**known.other, **followed})
    clock = np.isfinite(known.t_s).all() and np.all(np.diff(known.t_s) > 0)
    return known if clock else replace(known, t_s=order)


def run_candidates(*, measured: bool) -> Library:
    """Return what the currents of a run may hold; ``measured`` as in ``StandardRun``."""

    def candidates(stack: Stack) -> list[Candidate]:
        found = [current_gain(stack), offset(stack)]
        if len(stack.names) > 1:
            found.append(friction(stack))
        return found if measured else [*found, *wear(stack)]

    return Library(own_of_run, candidates, lambda *_: [], levels=(LEVELS,))


def own_of_run(stack: Stack) -> dict[str, LawColumns]:
    """Return what is free anyhow: a factor and a constant of the rise, and air by the speed."""
    one = values_of(np.ones(len(stack.known)))
    found = {
        "rise": only(stack, relative(stack, one), RISE),
        "constant": only(stack, added(stack, one), RISE),
    }
    levels = _levels(stack)
    if levels.shape[1]:
        law = added(stack, values_of(levels), levels.shape[1])
        found[LEVELS] = only(stack, law, RISE)
    if len(stack.names) > 1:
        powers = _powers(stack)
        found["air"] = only(stack, added(stack, values_of(powers), powers.shape[1]), AIR)
    return found


def _levels(stack: Stack) -> Array:
    """Return a column for each condition that was repeated often enough, (n, p).

    A factor and a constant are free beside them: where all conditions have a level, two have none.
    """
    seen = stack.frame.known.other[CONDITION]
    names, counts = np.unique(seen, return_counts=True)
    often = names[counts >= REPEATED]
    often = often[2:] if len(often) == len(names) else often
    return np.asarray(stack.known.other[CONDITION][:, None] == often, dtype=np.float64)


def _powers(stack: Stack) -> Array:
    """Return powers of the speed (n, p), as many as it takes values; a constant where not known."""
    seen = stack.frame.known.other.get(SPEED, np.zeros(1))
    degree = min(SPEEDS, len(np.unique(np.round(seen, 6))) - 1)
    if degree == 0:
        return np.ones((len(stack.known), 1))
    scaled = (stack.known.other[SPEED] - seen.mean()) / float(np.ptp(seen))
    return np.column_stack([scaled**k for k in range(degree + 1)])


def current_gain(stack: Stack) -> Candidate:
    """Return a change of current over force: of the rise, or of rise and air by one share."""
    forms = [_form(stack, relative, course, RISE) for course in _courses(stack)]
    if len(stack.names) > 1:
        forms += [_form(stack, relative, course, None) for course in _courses(stack)]
    return _candidate(stack, GAIN, relative, forms, current_gain)


def offset(stack: Stack) -> Candidate:
    """Return a change of the rise that is the same whatever the force."""
    forms = [_form(stack, added, course, RISE) for course in _courses(stack)]
    return _candidate(stack, OFFSET, added, forms, offset)


def friction(stack: Stack) -> Candidate:
    """Return a change of the current in air that leaves the rise over it as it is."""
    forms = [_form(stack, added, course, AIR) for course in _courses(stack)]
    return _candidate(stack, FRICTION, added, forms, friction, component=AIR)


def wear(stack: Stack) -> list[Candidate]:
    """Return a force that grows with the cutting time of an edge, where that is recorded."""
    time, seen = stack.known.cutting_time_s, stack.frame.known.cutting_time_s
    if time is None or seen is None or np.ptp(seen) == 0:
        return []
    law = per_depth(stack, values_of(time / float(seen.max())))
    form = grows(only(stack, law, RISE), {})
    names = ("tool.cutting_time", "tool.edge")
    return [Candidate(WEAR, WEAR, (form,), names, anew=lambda other: wear(other)[0])]


def at_the_end(stack: Stack, term: str, component: int | None) -> Choice:
    """Return a gain, an offset or friction that the last cut alone shows, and what follows it.

    ``component``: of which it is; None: of rise and air alike.
    """

    def made(other: Stack) -> Candidate:
        course = _step(other, len(other.frame.known) - 1, 1)
        form = _form(other, relative if term == GAIN else added, course, component)
        return Candidate(f"{term} at the end", term, (form,), ("t",), anew=made)

    return Choice(made(stack), 0)


def _candidate(
    stack: Stack,
    term: str,
    make: Make,
    forms: list[CandidateForm],
    anew: Callable[[Stack], Candidate],
    *,
    component: int = RISE,
) -> Candidate:
    free = _curve(stack)
    detail = only(stack, make(stack, *free), component)
    return Candidate(term, term, tuple(forms), ("t",), detail=detail, anew=anew)


def _curve(stack: Stack) -> tuple[Callable[[Rows], Array], int]:
    """Return a course of a few columns, to take up what a plain one gets wrong."""
    return max(drift_courses(stack), key=lambda course: course[1])


def _courses(stack: Stack) -> list[Course]:
    """Return the courses over the run: those of a sensor that drifts, and steps.

    A step may be as late as the last cut: that repeats the first one.
    """
    count = len(stack.frame.known)
    drifts: list[Course] = [(shape, width, {}, 1) for shape, width in drift_courses(stack)]
    starts = np.linspace(SHORTEST, count - 1, min(MOST_STEPS, count - SHORTEST))
    steps = np.unique(np.round(starts).astype(np.intp)).tolist()
    return [*drifts, *(_step(stack, start, len(steps)) for start in steps)]


def _step(stack: Stack, start: int, tries: int) -> Course:
    after = np.asarray(stack.row >= start, dtype=np.float64)
    return values_of(after), 1, {"at": start + 1.0}, tries


def _form(stack: Stack, make: Make, course: Course, component: int | None) -> CandidateForm:
    """Return a course of one component, or of all alike (None)."""
    shape, width, variables, tries = course
    law = make(stack, shape, width)
    columns = alike(stack, law) if component is None else only(stack, law, component)
    return CandidateForm(columns, variables, tries=tries)
