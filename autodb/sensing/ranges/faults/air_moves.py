"""Faults of an axis' moves in air: a sign reversed, another axis' effort, a closed brake.

All from what must hold of any axis. Friction takes work out, never puts it in. Effort follows its
own axis. A brake opposes the motion in both directions, and holds what the drive cannot move.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.files.channels import LINEAR_AXES
from autodb.records.tables import Recording
from autodb.sensing.drives.moves.motion import SPINDLE, term_inputs
from autodb.sensing.drives.moves.prepared import SHORTEST_ROWS, effort_channel
from autodb.sensing.ranges.faults.check import DataCheck
from autodb.signals.segments import flagged_runs
from autodb.wording import localized, phrase, significant

Array = NDArray[np.float64]

CUTOFF_HZ = 20.0
"""Above it an effort says nothing of friction and inertia. Chosen."""
BOTH_WAYS = 0.05
"""Share of the rows in motion that each direction must have: else weight and friction are one."""
WORK = -0.1
"""Work of friction over all work that the effort does: a drive that brakes most of what moves. A
sound axis has 0 (inertia alone) to 1 (friction alone), one turned round the negative of it.
"""
FOLLOWS, LESS = 0.5, 0.5
"""An effort is another axis' whose moves explain more than that share of its variance, where its
own explain less than that part of it. Chosen.
"""
HELD_S, HELD = 0.3, 1.5
"""An axis is held that stands for so long under so many times what moving it took. Chosen."""
DRAGGED_S, DRAGGED = 0.5, 1.0
"""A brake drags where friction is higher by that share of itself for so long. Chosen."""
CLEAR = 8.0
"""Robust standard deviations of what friction is off by, above which it is beyond chance."""
ROUNDS = 30


def faults_of_moves(recording: Recording, axis: str) -> list[DataCheck]:
    """Return whether an axis' moves are sound; a spindle's, and too few rows, are not examined."""
    if axis == SPINDLE or len(recording) < SHORTEST_ROWS:
        return []
    channel = effort_channel(recording, axis)
    timing = recording.timing
    cutoff_hz = min(CUTOFF_HZ, 0.25 * timing.rate_hz)
    effort = signals.lowpass_pieces(recording[channel], timing, cutoff_hz=cutoff_hz)
    inputs = term_inputs(recording, axis, cutoff_hz=cutoff_hz)
    found = [_another(recording, axis, effort, inputs, cutoff_hz)]
    moving = np.abs(inputs["direction"]) >= 1.0
    there = float(np.mean(inputs["direction"][moving] > 0)) if moving.any() else 0.0
    if BOTH_WAYS < there < 1.0 - BOTH_WAYS:
        found.append(_sign(channel, axis, effort, inputs))
    found += _held(recording, axis, effort, inputs)
    found += _dragged(recording, axis, effort, inputs)
    return found


def _columns(inputs: dict[str, Array]) -> Array:
    names = ("direction", "velocity", "acceleration")
    return np.column_stack([np.ones_like(inputs["t"]), *(inputs[name] for name in names)])


def _sign(channel: str, axis: str, effort: Array, inputs: dict[str, Array]) -> DataCheck:
    columns = _columns(inputs)
    weights = np.linalg.lstsq(columns, effort, rcond=None)[0]
    friction = columns[:, 1:3] @ weights[1:3]
    work = float(friction @ inputs["velocity"])
    whole = float(np.sum(np.abs(effort * inputs["velocity"]))) or 1.0
    return DataCheck(
        "sign of the effort", work / whole, ">=", WORK,
        phrase(
"{channel}: friction would drive {axis} instead of holding it back, so its "
"sign is reversed; change current_sign of the axis in the machine's file, or "
"set sign = -1 for the column in the side file",
channel=channel,
axis=axis
),
    )  # fmt: skip


def _another(
    recording: Recording, axis: str, effort: Array, inputs: dict[str, Array], cutoff_hz: float
) -> DataCheck:
    """Return whether the effort follows another recorded axis and not its own."""
    own = _explained(effort, inputs)
    others = {
        other: _explained(effort, term_inputs(recording, other, cutoff_hz=cutoff_hz))
        for other in LINEAR_AXES
        if other != axis and f"{other}.position" in recording
    }
    best = max(others, key=lambda name: others[name], default=None)
    is_other = best is not None and others[best] > FOLLOWS and own < LESS * others[best]
    channel = effort_channel(recording, axis)
    return DataCheck(
        "effort of this axis", 1.0 if is_other else 0.0, "<=", 0.0,
        phrase(
"{channel} follows {best}, not {axis}: {best}'s moves explain {get} % of it, "
"{axis}'s {own} %; use the current of {axis} itself, or --axis {best} with its "
"column",
channel=channel,
best=best,
axis=axis,
get=localized(f"{100.0 * others.get(best or '', 0.0):.0f}"),
own=localized(f"{100.0 * own:.0f}")
),
    )  # fmt: skip


def _explained(effort: Array, inputs: dict[str, Array]) -> float:
    """Return the share of an effort's variance that moves explain."""
    columns = _columns(inputs)
    left = effort - columns @ np.linalg.lstsq(columns, effort, rcond=None)[0]
    whole = float(np.var(effort))
    return 1.0 - float(np.var(left)) / whole if whole > 0 else 0.0


def _held(
    recording: Recording, axis: str, effort: Array, inputs: dict[str, Array]
) -> Iterator[DataCheck]:
    """Yield a check where the axis stands under more than moving it took."""
    moving = np.abs(inputs["direction"]) >= 1.0
    if not moving.any():
        return
    took = float(np.quantile(np.abs(effort[moving]), 0.99))
    strong = ~moving & (np.abs(effort) > HELD * took)
    t = recording.t_s
    longest = max(
        flagged_runs(strong), key=lambda run: t[run.stop - 1] - t[run.start], default=None
    )
    if longest is None:
        return
    start_s, end_s = float(t[longest.start]), float(t[longest.stop - 1])
    peak = float(np.max(np.abs(effort[longest])))
    unit = recording.unit(effort_channel(recording, axis))
    yield DataCheck(
        "axis free to move", end_s - start_s, "<=", HELD_S,
        phrase(
"{axis} stands from {start} to {end} s under up to {peak} {unit}, more than "
"the {took} {unit} needed to move it, as when a brake is closed or something "
"is in the way; open the brake and repeat the moves",
axis=axis,
start=localized(f"{start_s:.2f}"),
end=localized(f"{end_s:.2f}"),
peak=significant(peak),
unit=unit,
took=significant(took)
),
    )  # fmt: skip


def _dragged(
    recording: Recording, axis: str, effort: Array, inputs: dict[str, Array]
) -> Iterator[DataCheck]:
    """Yield a check where friction is far higher over a stretch than elsewhere, both ways."""
    columns, sense = _columns(inputs), inputs["direction"]
    moving = np.abs(sense) >= 1.0
    if not moving.any():
        return
    weights = _least_absolute(columns[moving], effort[moving])
    off = (effort - columns @ weights) * sense
    spread = 1.4826 * float(np.median(np.abs(off[moving])))
    usual = float(np.median(columns[moving, 1:3] @ weights[1:3] * sense[moving]))
    much = max(CLEAR * spread, DRAGGED * abs(usual))
    smooth = signals.moving_average(off, rate_hz=recording.timing.rate_hz, window_s=0.5 * DRAGGED_S)
    high = moving & (smooth > much)
    t = recording.t_s
    if not high.any():
        return
    rows = slice(int(np.flatnonzero(high)[0]), int(np.flatnonzero(high)[-1]) + 1)
    lasted_s = float(np.sum(high)) * recording.timing.step_s
    share = float(np.mean(sense[high] > 0))
    if not BOTH_WAYS < share < 1.0 - BOTH_WAYS:
        return
    unit = recording.unit(effort_channel(recording, axis))
    level = float(np.median(off[high]))
    yield DataCheck(
        "friction of one height", lasted_s, "<=", DRAGGED_S,
        phrase(
"{axis} is held back by {level} {unit} more in both directions from {t} to "
"{t_2} s, where it usually takes {usual} {unit}, as by a closed brake or a "
"clamp; open it and repeat the moves",
axis=axis,
level=significant(level),
unit=unit,
t=localized(f"{float(t[rows.start]):.2f}"),
t_2=localized(f"{float(t[rows.stop - 1]):.2f}"),
usual=significant(abs(usual))
),
    )  # fmt: skip


def _least_absolute(columns: Array, values: Array) -> Array:
    """Return coefficients (k,) of least absolute errors: a stretch that is off does not move them.

    By reweighted least squares (Schlossmacher 1973, J. Am. Stat. Assoc. 68:857).
    """
    weights = np.linalg.lstsq(columns, values, rcond=None)[0]
    least = 1e-3 * float(np.std(values)) or 1.0
    for _ in range(ROUNDS):
        root = 1.0 / np.sqrt(np.maximum(np.abs(values - columns @ weights), least))
        weights = np.linalg.lstsq(columns * root[:, None], values * root, rcond=None)[0]
    return np.asarray(weights)
