"""An axis' motion from its recording, and the inputs that terms take."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb import fitting, signals
from autodb.channels import LINEAR_AXES
from autodb.records import Recording
from autodb.terms.friction import STANDSTILL_MM_S, direction

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """An axis' motion (n,): mm, mm/s, mm/s²; ``quick`` is the velocity that the direction is read
    from, with as little filter as the position's noise allows, so that reversals stay sharp.
    """

    position: Array
    velocity: Array
    acceleration: Array
    quick: Array


def motion(recording: Recording, axis: str, *, cutoff_hz: float) -> Motion:
    """Return the motion of an axis; what is not recorded is derived from position at the cutoff.

    Raises UnusableInput when there is not even a position.
    """
    position = recording[f"{axis}.position"]
    velocity = recording.get(f"{axis}.velocity")
    acceleration = recording.get(f"{axis}.acceleration")
    if velocity is not None and acceleration is not None:
        return Motion(position, velocity, acceleration, velocity)
    smooth, v, a = signals.derivatives(recording.t_s, position, cutoff_hz=cutoff_hz)
    return Motion(
        position=smooth if velocity is None else position,
        velocity=v if velocity is None else velocity,
        acceleration=a if acceleration is None else acceleration,
        quick=_quick(recording.t_s, position, v) if velocity is None else velocity,
    )


def _quick(t_s: Array, position: Array, filtered: Array) -> Array:
    """Return plain differences of position where their noise stays below standstill, else filtered.

    Third differences hold hardly any motion; white noise σ of the position gives them √20 σ and the
    central difference σ·rate/√2.
    """
    sigma = fitting.spread(np.diff(position, 3)) / np.sqrt(20.0)
    noise = sigma / float(np.median(np.diff(t_s))) / np.sqrt(2.0)
    return np.gradient(position, t_s) if 4.0 * noise < STANDSTILL_MM_S else filtered


def term_inputs(recording: Recording, axis: str, *, cutoff_hz: float) -> dict[str, Array]:
    """Return what the terms of an axis take: t, position, velocity, acceleration, direction, (n,).

    Other linear axes with a position give `AXIS.acceleration`.
    """
    moved = motion(recording, axis, cutoff_hz=cutoff_hz)
    others = {
        f"{other}.acceleration": motion(recording, other, cutoff_hz=cutoff_hz).acceleration
        for other in LINEAR_AXES
        if other != axis and f"{other}.position" in recording
    }
    return {
        "t": recording.t_s,
        "position": moved.position,
        "velocity": moved.velocity,
        "acceleration": moved.acceleration,
        "direction": direction(moved.quick),
        **others,
    }


def motion_blocks(t_s: Array, sense: Array, *, shortest_s: float = 2.0) -> NDArray[np.intp]:
    """Return the block of motion (n,) that each row is in: 0, 1, … in time.

    A block begins where the direction of motion changes (±1, standstill keeps the last one), and
    lasts at least ``shortest_s``; without eight such, time is cut into twelve equal parts.
    """
    moving = np.where(np.abs(sense) >= 1.0, np.sign(sense), 0.0)
    last = np.maximum.accumulate(np.where(moving != 0, np.arange(len(moving)), 0))
    starts: list[int] = []
    begun = t_s[0]
    for turn in np.flatnonzero(np.diff(moving[last]) != 0) + 1:
        if t_s[turn] - begun >= shortest_s and t_s[-1] - t_s[turn] >= shortest_s:
            starts.append(int(turn))
            begun = t_s[turn]
    if len(starts) < 7:
        return np.asarray(np.arange(len(t_s)) * 12 // len(t_s), dtype=np.intp)
    return np.asarray(np.searchsorted(starts, np.arange(len(t_s)), side="right"), dtype=np.intp)
