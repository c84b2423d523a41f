"""Where weight helps the motion the range is |load| / m: it folds where the load changes its sign.

P1 section 8, equation 2: the load against the motion is weight + friction + cutting force, and the
weight may help. The range 2·sqrt(I_mag² + (load/m)²) then falls to its least as the cutting force
takes up the weight, and rises again beyond: one range, two loads.

A drive at its current limit: the range sits flat at its maximum while it fluctuates below.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.signals.segments import flagged_runs

Array = NDArray[np.float64]

TOUCHES = 0.2
"""Share of the lower of its two sides that a range falls to where it counts as touching its least:
chosen above what averaging over 0.5 s leaves of a load that takes 1.5 s or longer to reverse."""
RISES = 0.1
"""Share of the recording's largest range by which a range rises again on both sides: chosen, ten
times the demodulator's error."""


@dataclass(frozen=True)
class Unfolded:
    """The range with the load's sign (n,), A, NaN where that is not known, and the folds' rows.

    ``reason``: why part of it is not known, or None.
    """

    load_A: Array
    folds: tuple[int, ...]
    reason: str | None


def load_range_A(range_A: Array, *, magnetising_A: float = 0.0) -> Array:
    """Return the part of a range (n,) that carries load: sqrt(range² − magnetising range²)."""
    return np.asarray(np.sqrt(np.maximum(range_A**2 - magnetising_A**2, 0.0)), dtype=np.float64)


def touches(range_A: Array, *, magnetising_A: float = 0.0) -> tuple[int, ...]:
    """Return the rows in which a range (n,) touches its least and rises again on both sides.

    NaN (standing) is bridged. A load that comes down to nothing and goes back looks the same as one
    that changes its sign; one that reverses faster than the range is averaged does not touch.
    """
    from scipy.signal import find_peaks

    known = np.isfinite(range_A)
    if known.sum() < 3:
        return ()
    rows = np.flatnonzero(known)
    load = load_range_A(range_A[rows], magnetising_A=magnetising_A)
    least = RISES * float(np.max(load))
    if least == 0.0:
        return ()
    low, found = find_peaks(-load, prominence=least)
    deep = load[low] <= TOUCHES * (load[low] + found["prominences"])
    return tuple(int(rows[at]) for at in low[deep])


def unfolded(
    range_A: Array, *, power: Array | None = None, begins: int = 1, magnetising_A: float = 0.0
) -> Unfolded:
    """Return a range (n,) with the sign of its load against the motion.

    ``power`` (n,): whatever has that sign, in any unit: the drive's power, or its signed current
    i_q times the sign of `PhaseRange.frequency_hz` (the phase order tells the direction of motion).
    Without it the sign is ``begins``, 1 or −1, up to the first row in which the range touches its
    least, and not known from there on. A power that changes its sign where the range does not touch
    is of another axis or moment: nothing is known then.
    """
    load = load_range_A(range_A, magnetising_A=magnetising_A)
    touched = touches(range_A, magnetising_A=magnetising_A)
    if power is None:
        if not touched:
            return Unfolded(begins * load, (), None)
        before = np.arange(len(load)) < touched[0]
        reason = (
            f"the range touches its least at row {touched[0]}, and beyond it two loads give one "
            "range; record the drive's power or its signed current"
        )
        return Unfolded(np.where(before, begins * load, np.nan), touched[:1], reason)
    edges = (0, *touched, len(load))
    parts = list(pairwise(edges))
    signs = [_sign(power[a:b], load[a:b]) for a, b in parts]
    mixed = [a for (a, _), sign in zip(parts, signs, strict=True) if sign == 0]
    if mixed:
        reason = f"the power has both signs from row {mixed[0]} on, where the range does not touch"
        return Unfolded(np.full_like(load, np.nan), (), reason)
    sign = np.repeat(signs, [b - a for a, b in parts])
    changed = tuple(edges[i] for i in range(1, len(signs)) if signs[i] != signs[i - 1])
    return Unfolded(sign * load, changed, None)


def _sign(power: Array, load: Array) -> int:
    """Return the sign of the power where there is load: 0 where a tenth of it has the other."""
    weight = np.where(np.isfinite(power) & np.isfinite(load), load, 0.0)
    positive, negative = (float(weight[np.nan_to_num(s * power) > 0].sum()) for s in (1, -1))
    if min(positive, negative) > 0.1 * max(positive, negative):
        return 0
    return 1 if positive >= negative else -1


WITHIN = 3.0
"""Flat: within this many standard deviations of the noise."""
DIPS, DEEP = 2, 8.0
"""The range comes back to the top from so many dips, deeper than this many of them: nothing else
tells a limit from a force that is constant, or rises and then is. Chosen."""
SHARE, MORE = 0.15, 2.0
"""The range is at its top for this share of the cut at least, and this times as long as at any
level below, at each fifth of the way up to three. Chosen."""
QUIET = 1.45
"""and scatters by no more than this times the noise: a load that turns slowly at its top scatters
by twice of it. Chosen."""


@dataclass(frozen=True)
class Flat:
    """The level of a limit, in the unit of the range, and for what share of the time it is held."""

    level: float
    share: float


def held_at_top(range_A: Array, *, noise_A: float) -> Flat | None:
    """Return the limit that a range (n,) in cut runs into, or None.

    ``noise_A``: standard deviation of the range in air, where nothing fluctuates. A range that is
    at its limit from entry to exit is not told from a constant one.
    """
    known = range_A[np.isfinite(range_A)]
    if known.size == 0 or noise_A <= 0.0:
        return None
    top, low = (float(v) for v in np.quantile(known, (0.9, 0.02)))
    if _dips(known, top, noise_A) < DIPS:
        return None
    flat = known[np.abs(known - top) <= WITHIN * noise_A]
    levels = low + np.array([0.2, 0.4, 0.6]) * (top - low)
    below = np.mean(np.abs(known[:, None] - levels) <= WITHIN * noise_A, axis=0)
    share = flat.size / known.size
    if share < max(SHARE, MORE * float(np.max(below))) or np.std(flat) > QUIET * noise_A:
        return None
    return Flat(float(np.mean(flat)), share)


def _dips(range_A: Array, top_A: float, noise_A: float) -> int:
    """Return how often the range leaves its top and comes back."""
    at_top = np.flatnonzero(np.abs(range_A - top_A) <= WITHIN * noise_A)
    if not at_top.size:
        return 0
    return len(flagged_runs(range_A[at_top[0] : at_top[-1]] < top_A - DEEP * noise_A))
