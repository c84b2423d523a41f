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
    white = whitener(work(state, np.column_stack([now, state.difference])))
    left = white[:, -1] - white[:, :-1] @ estimate(white[:, :-1], white[:, -1]).coefficients
    plain = state.difference - now @ estimate(now, state.difference).coefficients
    _propose_load(state, left, plain, order=len(whitener.coefficients))
    place = next(iter(columns.signals))
    found = ripple(columns.signals[place], plain)
    if found is not None and "ripple" not in " ".join(state.active):
        block = search.Block(
            f"ripple {number}", "unknown", found.columns, (place,), tries=found.tries,
            extra_parameters=1,
        )  # fmt: skip
        state.blocks[block.key] = block


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
    state.blocks[key] = search.Block(
        key, "external_load", column[:, None], ("t",), tries=tries, extra_parameters=2
    )


def free_shape(state: State, key: str) -> None:
    """A load need not be constant or sudden: slope, bow and both flanks stay free columns."""
    start, end = state.intervals[key]
    flank = min(0.5, 0.1 * (end - start))
    for name, at in (("start", start), ("end", end)):
        state.own[f"{key} {name}"] = external_load(
            state.t_s, start_s=at - flank, end_s=at + flank
        ) * np.sign(state.t_s - at)
    inside = external_load(state.t_s, start_s=start, end_s=end)
    run = np.clip(2 * (state.t_s - start) / max(end - start, 1e-9) - 1, -1, 1)
    state.own[f"{key} slope"] = inside * run
    state.own[f"{key} bow"] = inside * (1.5 * run**2 - 0.5)
