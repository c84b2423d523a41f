"""What a sensor of one component may do by itself, the others untouched."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import Rows, SmoothCurve, added, only, relative, values_of
from autodb.explain.cuts.stack import Conditions, Stack
from autodb.explain.engine.candidates import Candidate, CandidateForm

Array = NDArray[np.float64]

SETTLING = (0.08, 0.3)
"""Time constants of settling as a share of the table's time."""
CURVE = 5


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
    """Return a factor on one component that changes with the time; none where there is but one."""
    if len(stack.names) < 2:
        return []
    found = []
    for i, name in enumerate(stack.names):
        forms = tuple(
            CandidateForm(only(stack, relative(stack, s, w), i)) for s, w in drift_courses(stack)
        )
        free = _over_time(stack, 2 * CURVE)
        detail = only(stack, relative(stack, free, free.width), i)
        found.append(Candidate(f"gain {name}", "gain", forms, ("t",), detail=detail))
    return found
