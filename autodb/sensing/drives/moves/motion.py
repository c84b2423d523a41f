"""An axis' motion from its recording, and the inputs that terms take."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.files.channels import LINEAR_AXES, ROTARY_AXES, place_channel
from autodb.fitting.linear import spread
from autodb.records.tables import Recording
from autodb.sensing.drives.moves.dead_bands import refuse_dead_bands
from autodb.sensing.drives.moves.protocol import FilterProtocol, default_protocol
from autodb.terms.friction import STANDSTILL_MM_S, direction, since_reversal
from autodb.terms.term import Channel
from autodb.wording import stored_msgid

Array = NDArray[np.float64]

STANDSTILL_RPM = 1.0
"""Spindle speed below which the direction fades out. Chosen."""
NOISE_BAND = 4.0
"""Standard deviations of a velocity's noise within which an axis counts as standing."""
STILL_BAND = 2.0
"""Standard deviations of a velocity's noise below which none of it is motion: there an axis that
stands would turn with its noise, while the drive holds anything up to breakaway. Chosen."""
STILL_SHARE = 1.0 / 3000.0
"""Share of the top speed below which the direction fades out: 0.05 mm/s of 150 mm/s. Chosen."""
TOP_QUANTILE = 0.95
"""Quantile of the speeds in motion that counts as the top speed. Chosen."""
FLICKER = 4.0
"""A move that ends within so many standard deviations of a position's noise, or steps of its
encoder, from where it began is none. Chosen."""
MOVED = 3.0
"""An axis that went less far than so many of its largest steps in a row flickers. Chosen."""

NOISE_SHARE = 0.01
"""Share of an acceleration's variance that its noise may have: as much lower least squares find its
coefficient. Chosen."""
DROWNED = 1.0
"""The same where the effort is not filtered with it: a filter then takes off what is there. Chosen;
on recordings of real axes shares of 0.01 to 0.3 fitted worse than none."""
LOWEST_HZ, LOWER = 5.0, 0.8
"""Lowest cutoff, and by what it is lowered at a time. Chosen."""
LOWERED = stored_msgid("lowered for the noise of {channel}")
SPINDLE = "spindle"


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


def axis_motion(
    recording: Recording, axis: str, *, cutoff_hz: float, own_speeds: bool = False
) -> AxisMotion:
    """Return the motion of an axis; what is not recorded is derived at the cutoff.

    Acceleration from velocity where that is recorded, otherwise from position. The direction fades
    out below STANDSTILL_MM_S, with ``own_speeds`` below a share of the recording's top speed: two
    recordings of one axis have one direction with the first, two units of one with the second.
    Where the axis flickers about one place it is 0.

    Raises UnusableInput when there is not even a position, or one or an effort with a coarse dead
    band.
    """
    position = recording[place_channel(axis)]
    velocity = recording.get(f"{axis}.velocity")
    acceleration = recording.get(f"{axis}.acceleration")
    refuse_dead_bands(recording, axis, derived=velocity is None)
    if velocity is None:
        timing = recording.timing
        smooth, v, a = signals.derivatives(
            recording.t_s, position, cutoff_hz=cutoff_hz, timing=timing
        )
        sense = _derived_direction(
            recording, position, v, cutoff_hz=cutoff_hz, own_speeds=own_speeds
        )
        sense = without_flicker(sense, position)
        return AxisMotion(smooth, v, a if acceleration is None else acceleration, sense)
    if acceleration is None:
        acceleration = _slope_of(recording, velocity, cutoff_hz=cutoff_hz)
    noise = noise_sd(velocity)
    still = standstill_speed(position, velocity, noise) if own_speeds else STANDSTILL_MM_S
    sense = _noisy_direction(velocity, still=still, noise=noise, own_speeds=own_speeds)
    sense = without_flicker(sense, position)
    return AxisMotion(position, velocity, acceleration, sense)


def _slope_of(recording: Recording, values: Array, *, cutoff_hz: float) -> Array:
    """Return the slope of values (n,), low-passed at the cutoff."""
    smooth = signals.lowpass_pieces(values, recording.timing, cutoff_hz=cutoff_hz)
    return signals.slope(smooth, recording.timing, recording.t_s)


def protocol_of(
    recording: Recording, axis: str, *, noise_share: float = NOISE_SHARE
) -> FilterProtocol:
    """Return the default protocol, with a lower cutoff where noise asks for it.

    White noise σ of a position gives an acceleration derived from it at the cutoff f the variance
    (2π)⁴ σ² · 2 f⁵ / (5 rate), of a velocity (2π)² σ² · 2 f³ / (3 rate): the cutoff is lowered
    until that is ``noise_share`` of the acceleration's own at most. What stamps may be wrong by is
    noise too.
    """
    protocol = default_protocol(recording.timing.rate_hz)
    if axis == SPINDLE:
        return protocol
    names = (f"{axis}.acceleration", f"{axis}.velocity", place_channel(axis))
    order = next((k for k, name in enumerate(names) if recording.get(name) is not None), 0)
    if not order:
        return protocol
    source = recording[names[order]]
    while protocol.cutoff_hz > LOWEST_HZ:
        noise = _derived_noise(recording, source, order, protocol.cutoff_hz)
        derived = source
        for _ in range(order):
            derived = _slope_of(recording, derived, cutoff_hz=protocol.cutoff_hz)
        if noise**2 <= noise_share * max(float(np.mean(derived**2)) - noise**2, 0.0):
            break
        protocol = replace(
            protocol,
            cutoff_hz=max(LOWEST_HZ, LOWER * protocol.cutoff_hz),
            lowered=f" ({LOWERED.format(channel=names[order])})",
        )
    return protocol


def _derived_noise(recording: Recording, source: Array, order: int, cutoff_hz: float) -> float:
    """Return the noise's sd of the slope of this order, derived at the cutoff."""
    timing = recording.timing
    sigma = noise_sd(source)
    if timing.blur_s:
        speed = signals.slope(source, timing, recording.t_s)
        sigma = float(np.hypot(sigma, timing.blur_s * np.sqrt(np.mean(speed**2))))
    power = 2 * order + 1
    band = np.sqrt(2.0 * cutoff_hz**power / (power * timing.rate_hz))
    return float((2.0 * np.pi) ** order * sigma * band)


def top_speed(velocity: Array, noise: float = 0.0) -> float:
    """Return the speed that 95 % of a velocity's (n,) moving rows stay below; 0 where none moves.

    ``noise``: its sd; a row moves beyond NOISE_BAND of it.
    """
    speed = np.abs(velocity)
    moving = speed[speed > NOISE_BAND * noise]
    return float(np.quantile(moving, TOP_QUANTILE)) if moving.size else 0.0


def standstill_speed(position: Array, velocity: Array, noise: float) -> float:
    """Return the speed below which the direction fades out, in the velocity's (n,) unit.

    A share of the recording's own top speed, so that no unit matters; STANDSTILL_MM_S of an axis
    that stands or flickers, whose speeds tell nothing.
    """
    top = top_speed(velocity, noise)
    step = float(np.quantile(np.abs(np.diff(position)), 0.999))
    if not top or float(np.ptp(position)) < MOVED * step:
        return STANDSTILL_MM_S
    return STILL_SHARE * top


def without_flicker(sense: Array, position: Array) -> Array:
    """Return a direction (n,) that is 0 where the axis turns and turns back on one place.

    An encoder's noise and last step at standstill have a speed, but lead nowhere.
    """
    steps = np.abs(np.diff(position))
    step = float(steps[steps > 0.0].min()) if np.any(steps > 0.0) else 0.0
    least = FLICKER * max(noise_sd(position), step)
    last, _ = since_reversal(sense, position)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(last) != 0) + 1])
    ends = np.append(starts[1:], len(last))
    moved = np.abs(position[ends - 1] - position[starts])
    flickers = np.repeat(moved < least, ends - starts)
    return np.where(flickers, 0.0, sense)


def noise_sd(values: Array) -> float:
    """Return the sd of white noise in a signal: third differences hold hardly any motion, √20 σ."""
    return spread(np.diff(values, 3)) / float(np.sqrt(20.0))


def _derived_direction(
    recording: Recording, position: Array, filtered: Array, *, cutoff_hz: float, own_speeds: bool
) -> Array:
    """Return the direction from plain differences of position, or from its filtered velocity.

    White noise σ of the position gives the central difference σ·rate/√2, and the velocity filtered
    at f_c 2πσ·√(2 f_c³/(3 rate)). The plain one is used while its noise stays within standstill.
    """
    timing = recording.timing
    rate_hz = timing.rate_hz
    sigma = noise_sd(position)
    plain = sigma * rate_hz / np.sqrt(2.0)
    passed = min(cutoff_hz, 0.5 * rate_hz)
    noise = float(min(plain, 2 * np.pi * sigma * np.sqrt(2.0 * passed**3 / (3.0 * rate_hz))))
    still = standstill_speed(position, filtered, noise) if own_speeds else STANDSTILL_MM_S
    if NOISE_BAND * plain < still:
        return direction(signals.slope(position, timing, recording.t_s), standstill_mm_s=still)
    return _noisy_direction(filtered, still=still, noise=noise, own_speeds=own_speeds)


def _noisy_direction(velocity: Array, *, still: float, noise: float, own_speeds: bool) -> Array:
    """Return the direction of a velocity (n,) whose noise has this sd.

    It fades out below ``still``. Where the noise is larger it is ±1 beyond NOISE_BAND of it, and 0
    below STILL_BAND; with ``own_speeds`` it fades to 0 at standstill.
    """
    band = NOISE_BAND * noise
    sense = direction(velocity, standstill_mm_s=max(still, band))
    if own_speeds or band <= still:
        return sense
    inner = STILL_BAND / NOISE_BAND
    faded = np.maximum(np.abs(sense) - inner, 0.0) / (1.0 - inner)
    return np.asarray(np.sign(sense) * faded)


def term_inputs(
    recording: Recording, axis: str, *, cutoff_hz: float, own_speeds: bool = False
) -> dict[str, Array]:
    """Return what the terms of an axis take: t, position, velocity, acceleration, direction, (n,).

    Other linear axes with a position give `AXIS.acceleration`; ``own_speeds`` as `axis_motion`.
    """
    moved = axis_motion(recording, axis, cutoff_hz=cutoff_hz, own_speeds=own_speeds)
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


def axis_kind(axis: str) -> Channel:
    """Return which terms an axis' effort may have."""
    return "spindle" if axis == SPINDLE else "rotary" if axis in ROTARY_AXES else "axis"


def spindle_inputs(recording: Recording, spindle: str, *, cutoff_hz: float) -> dict[str, Array]:
    """Return what a spindle's terms take: t, velocity rpm, acceleration rpm/s, direction, (n,).

    The acceleration is the slope of the speed, low-passed at the cutoff.
    """
    speed = recording[f"{spindle}.speed"]
    band = max(STANDSTILL_RPM, NOISE_BAND * noise_sd(speed))
    return {
        "t": recording.t_s,
        "velocity": speed,
        "acceleration": _slope_of(recording, speed, cutoff_hz=cutoff_hz),
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
