"""Candidates that must be looked for in what is left: a stretch of load, a ripple over position."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain import search
from autodb.explain.axis import AxisColumns, ripple
from autodb.explain.fit import estimate
from autodb.explain.locate import strongest_interval
from autodb.explain.noise import Whitener
from autodb.explain.state import State, noise_floor, work
from autodb.terms.drive import external_load

Array = NDArray[np.float64]

SHORTEST_LOAD_S = 0.25
INSIDE = 0.02
"""A load begins and ends this share of the recording from its ends; else it is a change."""
LOAD_OVER_NOISE = 0.5
"""A load's level is at least this many noise standard deviations."""


def propose(state: State, columns: AxisColumns, whitener: Whitener) -> None:
    """Look in what is left for a stretch of load and for a ripple over position."""
    for key in [k for k in state.blocks if k.startswith(("external_load", "ripple"))]:
        if key not in state.active:
            del state.blocks[key]
            state.intervals.pop(key, None)
    number = len(state.active)
    now = np.column_stack([state.own_matrix(), state.matrix(state.active)])
    reduced = np.column_stack([work(state, state.own_matrix()), state.working(state.active)])
    white = whitener(np.column_stack([reduced, work(state, state.difference)]))
    left = white[:, -1] - white[:, :-1] @ estimate(white[:, :-1], white[:, -1]).coefficients
    plain = state.difference - now @ estimate(now, state.difference).coefficients
    _propose_load(state, left, plain, order=len(whitener.coefficients))
    place = next(iter(columns.signals))
    found = ripple(columns.signals[place], plain)
    if found is not None and "ripple" not in " ".join(state.active):
        state.add(
            search.Block(
                f"ripple {number}",
                "unknown",
                found.columns,
                (place,),
                tries=found.tries,
                extra_parameters=1,
            )
        )


def _propose_load(state: State, left: Array, plain: Array, *, order: int) -> None:
    """Add the stretch in which a constant explains most of a whitened residual, if it is a load."""
    start, end, tries = strongest_interval(left)
    t = state.t_s[:: state.factor][order:]
    low, high = float(t[start]), float(t[min(end, len(t) - 1)])
    edge = INSIDE * (state.t_s[-1] - state.t_s[0])
    column = external_load(state.t_s, start_s=low, end_s=high)
    level = abs(float(np.mean(plain[column > 0])))
    is_inside = low > state.t_s[0] + edge and high < state.t_s[-1] - edge
    is_apart = all(high < a - edge or low > b + edge for a, b in state.intervals.values())
    if high - low < SHORTEST_LOAD_S or not is_inside or not is_apart:
        return
    if level < LOAD_OVER_NOISE * noise_floor(state):
        return
    key = f"external_load {len(state.active)}"
    state.intervals[key] = (low, high)
    columns = load_columns(state.t_s, low, high)
    state.add(search.Block(key, "external_load", columns, ("t",), tries=tries, extra_parameters=2))


def load_columns(t_s: Array, start_s: float, end_s: float) -> Array:
    """Return columns (n, 5) of a load that need be neither constant nor sudden.

    Level first; then slope and bow within, and the two flanks, which change no level.
    """
    inside = external_load(t_s, start_s=start_s, end_s=end_s)
    run = np.clip(2 * (t_s - start_s) / max(end_s - start_s, 1e-9) - 1, -1, 1)
    flank = min(0.5, 0.1 * (end_s - start_s))
    flanks = [
        external_load(t_s, start_s=at - flank, end_s=at + flank)
        * np.sign(t_s - at)
        * (1 - np.abs(t_s - at) / flank)
        for at in (start_s, end_s)
    ]
    return np.column_stack([inside, inside * run, inside * (1.5 * run**2 - 0.5), *flanks])
