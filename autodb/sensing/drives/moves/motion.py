"""An axis' motion from its recording, and the inputs that terms take."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb import fitting, signals
from autodb.files.channels import LINEAR_AXES, ROTARY_AXES
from autodb.records import Recording
from autodb.terms.friction import STANDSTILL_MM_S, direction

Array = NDArray[np.float64]

STANDSTILL_RPM = 1.0
"""Spindle speed below which the direction fades out. Chosen."""
NOISE_BAND = 4.0
"""Standard deviations of a velocity's noise within which an axis counts as standing."""


@dataclass(frozen=True)
class AxisMotion:
    """An axis' motion (n,): mm, mm/s, mm/s²; of a rotary axis deg, deg/s, deg/s².

    ``direction``: ±1 in motion, fading to 0 through standstill, read from a velocity with as little
    filter as its noise allows, so that reversals stay sharp.
    """

    position: Array
    velocity: Array
    acceleration: Array
    direction: Array


def place_channel(axis: str) -> str:
    """Return the channel of where an axis is: its angle where it is rotary."""
    return f"{axis}.{'angle' if axis in ROTARY_AXES else 'position'}"


def axis_motion(recording: Recording, axis: str, *, cutoff_hz: float) -> AxisMotion:
    """Return the motion of an axis; what is not recorded is derived from position at the cutoff.

    Raises UnusableInput when there is not even a position.
    """
    position = recording[place_channel(axis)]
    velocity = recording.get(f"{axis}.velocity")
    acceleration = recording.get(f"{axis}.acceleration")
    if velocity is not None and acceleration is not None:
        return AxisMotion(
            position, velocity, acceleration, _direction(velocity, noise_sd(velocity))
        )
    smooth, v, a = signals.derivatives(recording.t_s, position, cutoff_hz=cutoff_hz)
    if velocity is None:
        sense = _derived_direction(recording.t_s, position, v, cutoff_hz=cutoff_hz)
    else:
        sense = _direction(velocity, noise_sd(velocity))
    return AxisMotion(
        position=smooth if velocity is None else position,
        velocity=v if velocity is None else velocity,
        acceleration=a if acceleration is None else acceleration,
        direction=sense,
    )


def _direction(velocity: Array, noise: float) -> Array:
    """Return the direction of a velocity (n,) whose noise has this sd: none of it turns anything.

    The band of standstill is NOISE_BAND times the noise where that is wider.
    """
    return direction(velocity, standstill_mm_s=max(STANDSTILL_MM_S, NOISE_BAND * noise))


def noise_sd(values: Array) -> float:
    """Return the sd of white noise in a signal: third differences hold hardly any motion, √20 σ."""
    return fitting.spread(np.diff(values, 3)) / float(np.sqrt(20.0))


def _derived_direction(t_s: Array, position: Array, filtered: Array, *, cutoff_hz: float) -> Array:
    """Return the direction from plain differences of position, or from its filtered velocity.

    White noise σ of the position gives the central difference σ·rate/√2, and the velocity filtered
    at f_c 2πσ·√(2 f_c³/(3 rate)). The plain one is used while its noise stays within standstill.
    """
    rate_hz = 1.0 / float(np.median(np.diff(t_s)))
    sigma = noise_sd(position)
    plain = sigma * rate_hz / np.sqrt(2.0)
    if NOISE_BAND * plain < STANDSTILL_MM_S:
        return direction(np.gradient(position, t_s))
    passed = min(cutoff_hz, 0.5 * rate_hz)
    noise = 2.0 * np.pi * sigma * np.sqrt(2.0 * passed**3 / (3.0 * rate_hz))
    return _direction(filtered, float(min(noise, plain)))


def term_inputs(recording: Recording, axis: str, *, cutoff_hz: float) -> dict[str, Array]:
    """Return what the terms of an axis take: t, position, velocity, acceleration, direction, (n,).

    Other linear axes with a position give `AXIS.acceleration`.
    """
    moved = axis_motion(recording, axis, cutoff_hz=cutoff_hz)
    others = {
        f"{other}.acceleration": axis_motion(recording, other, cutoff_hz=cutoff_hz).acceleration
        for other in LINEAR_AXES
        if other != axis and f"{other}.position" in recording
    }
    return {
        "t": recording.t_s,
        "position": moved.position,
        "velocity": moved.velocity,
        "acceleration": moved.acceleration,
        "direction": moved.direction,
        **others,
    }


def spindle_inputs(recording: Recording, spindle: str, *, cutoff_hz: float) -> dict[str, Array]:
    """Return what a spindle's terms take: t, velocity rpm, acceleration rpm/s, direction, (n,).

    The acceleration is the slope of the speed, low-passed at the cutoff.
    """
    speed = recording[f"{spindle}.speed"]
    rate_hz = recording.rate_hz
    smooth = signals.lowpass(speed, rate_hz=rate_hz, cutoff_hz=cutoff_hz)
    band = max(STANDSTILL_RPM, NOISE_BAND * noise_sd(speed))
    return {
        "t": recording.t_s,
        "velocity": speed,
        "acceleration": np.gradient(smooth, recording.t_s),
        "direction": direction(speed, standstill_mm_s=band),
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
