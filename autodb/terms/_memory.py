"""What remembers: filters of even rows, among which some may be missing."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.terms.term import step_s

Array = NDArray[np.float64]

NEXT = 1.5
"""Steps within which a row follows the one before: more is a gap."""


def unbroken_rows(t_s: Array) -> list[slice]:
    """Return the runs of rows of a clock (n,), s, that follow each other without a gap."""
    gaps = np.flatnonzero(np.diff(t_s) > NEXT * step_s(t_s)) + 1
    return [slice(int(a), int(b)) for a, b in pairwise([0, *gaps, len(t_s)])]


def first_order(driven: Array, t_s: Array, *, time_constant_s: float, meanwhile: Array) -> Array:
    """Return u (n,) of T·du/dt = driven − u, u = 0 at the first row: exact for a driven value that
    holds over a step.

    ``meanwhile`` (n,): what drives it over a gap of the clock that follows a row.
    """
    from scipy import signal

    keep = float(np.exp(-step_s(t_s) / time_constant_s))
    parts, state = list[Array](), 0.0
    for run in unbroken_rows(t_s):
        if parts:
            lasts_s = float(t_s[run.start] - t_s[run.start - 1])
            share = -float(np.expm1(-lasts_s / time_constant_s))
            state += share * (float(meanwhile[run.start - 1]) - state)
        own, _ = signal.lfilter([0.0, 1.0 - keep], [1.0, -keep], driven[run], zi=[state])
        state = float(own[-1])
        parts.append(own)
    return np.concatenate(parts)


def by_run(filtered: Callable[[Array], Array], values: Array, t_s: Array) -> Array:
    """Return values (n,) through a filter that starts anew after each gap of the clock."""
    return np.concatenate([filtered(values[run]) for run in unbroken_rows(t_s)])
