"""A raw cut whose force fluctuates, and what may go wrong while it is recorded.

Disturbances act on the ranges before they become phase currents: chatter, a feed that stops, a
spindle that brakes, a drive at its current limit, lubrication pulses. Levels are the caller's.
"""

from dataclasses import dataclass

import numpy as np

from autodb.proofs.machines.lathe.lathe import Lathe, arm_mm, ranges_A
from autodb.proofs.machines.lathe.phases import (
    AIR_AFTER_S,
    AIR_BEFORE_S,
    FEED_HZ_PER_MM_S,
    FIFTH_HARMONIC,
    RAMP_S,
    SLIP,
    SPINDLE_HZ_PER_RPM,
    dynamometer_N,
    phases,
)
from autodb.proofs.machines.lathe.process import MOVING, Array, TrueCut, TruePair, mean_forces_N

WANDER_SHARE, WANDER_S = 0.02, 0.2  # the force's own scatter and its correlation time; chosen
CURRENT_FOLLOWS = 0.5  # share of a chatter force that the drives' currents follow; chosen
STOPS_IN_S = 0.05  # a feed stops and starts within; chosen
OIL_FALLS_S = 0.2  # time constant with which a lubrication pulse fades; chosen


@dataclass(frozen=True)
class CutDisturbance:
    """What happens in one recording; the default is a clean cut.

    ``chatter_share``: amplitude over the mean force; it builds up in 0.5 s. ``stop_s``: from when
    to when the feed stands, on the recording's clock. ``brake_s``: how long the spindle takes to
    stop, ``brake_after_s`` after the tool left, at ``brake_share`` of its range in cut.
    ``limit_share``: the spindle's largest range over that in cut. Pulses raise the range of the
    feeding slide by ``pulse_share`` every ``pulse_every_s``, first at ``pulse_first_s``.
    """

    wander_share: float = WANDER_SHARE
    chatter_share: float = 0.0
    chatter_hz: float = 0.0
    stop_s: tuple[float, float] | None = None
    brake_s: float = 0.0
    brake_after_s: float = AIR_AFTER_S
    brake_share: float = 1.5
    limit_share: float = np.inf
    pulse_share: float = 0.0
    pulse_every_s: float = 3.0
    pulse_first_s: float = 1.0


@dataclass(frozen=True)
class Disturbed:
    """The channels of a recording, and the expected range of each axis in cut and in air, A."""

    channels: dict[str, Array]
    cut_A: dict[str, float]
    air_A: dict[str, float]


def disturbed_cut(
    lathe: Lathe,
    pair: TruePair,
    cut: TrueCut,
    seed: int,
    what: CutDisturbance,
    *,
    rate_hz: float = 1000.0,
) -> Disturbed:
    """One longitudinal cut with its disturbance, as phase sensors and dynamometer saw it."""
    process, waves, reading = (np.random.default_rng([seed, 11, k]) for k in range(3))
    leaves_s = AIR_BEFORE_S + 2.0 * RAMP_S + cut.duration_s
    total_s = leaves_s + (what.brake_after_s + what.brake_s if what.brake_s else AIR_AFTER_S)
    t = np.arange(round(total_s * rate_hz)) / rate_hz
    feeding = _feeding(t, what)
    engaged = _ramp((t - AIR_BEFORE_S) / RAMP_S) - _ramp((t - leaves_s + RAMP_S) / RAMP_S)
    engaged = engaged * feeding
    speed = _speed_share(t, leaves_s + what.brake_after_s, what.brake_s)

    # Force: it wanders around its mean; chatter shows in full on the dynamometer, less in currents
    mean_N = lathe.work_factor * mean_forces_N(pair, cut)
    wander = what.wander_share * wandering_noise(process, t.size, rate_hz)
    grown = 1.0 - np.exp(-np.maximum(t - AIR_BEFORE_S - RAMP_S, 0.0) / 0.5)
    phase = process.uniform(0.0, 2.0 * np.pi)
    chatter = what.chatter_share * grown * np.sin(2.0 * np.pi * what.chatter_hz * t + phase)
    load_N = mean_N[:, None] * engaged * (1.0 + wander + CURRENT_FOLLOWS * chatter)
    sensed_N = engaged * (1.0 + wander + chatter)

    # Ranges, and what they are expected to be without wander
    def ranges(force_N: Array) -> dict[str, Array]:
        return ranges_A(lathe, cut, force_N, radius_mm=arm_mm(cut), share=1.0)

    found, in_cut, in_air = ranges(load_N), ranges(mean_N), ranges(np.zeros(3))
    (feed,) = MOVING[cut.operation]
    standing_A = getattr(lathe, feed).standing_A
    found[feed] = np.where(feeding > 0.0, found[feed] * (1.0 + _pulses(t, what)), standing_A)
    braking_A = what.brake_share * float(in_cut["spindle"])
    found["spindle"] = np.where(speed < 1.0, braking_A, found["spindle"])
    found["spindle"] = np.minimum(found["spindle"], what.limit_share * float(in_cut["spindle"]))

    # Phase currents, speed and forces
    rpm = cut.spindle_rpm * speed
    feed_mm_s = cut.feed_mm * cut.spindle_rpm / 60.0 * np.where(feeding > 0.0, 1.0, 0.0)
    slip = 1.0 + SLIP * engaged
    hertz = {axis: np.zeros_like(t) for axis in "xz"}
    hertz[feed] = -FEED_HZ_PER_MM_S * feed_mm_s * slip
    hertz["spindle"] = SPINDLE_HZ_PER_RPM * rpm * slip
    channels = {"t": t, "spindle.speed": rpm}
    for axis, range_A in found.items():
        harmonic = FIFTH_HARMONIC if axis == "spindle" else 0.0
        three = phases(waves, range_A, hertz[axis], rate_hz, harmonic)
        channels |= {f"{axis}.current.{name}": current for name, current in three.items()}
    turns = np.cumsum(rpm) / 60.0 / rate_hz
    signal_N = dynamometer_N(reading, mean_N, sensed_N, turns, rate_hz)
    channels |= {f"force.{name}": signal_N[k] for k, name in enumerate("xyz")}
    as_float = ({axis: float(v) for axis, v in part.items()} for part in (in_cut, in_air))
    return Disturbed(channels, *as_float)


def wandering_noise(rng: np.random.Generator, size: int, rate_hz: float) -> Array:
    """Noise of unit variance whose autocorrelation fades as exp(−t/WANDER_S)."""
    from scipy.signal import lfilter

    keep = float(np.exp(-1.0 / (WANDER_S * rate_hz)))
    fresh = np.sqrt(1.0 - keep**2) * rng.standard_normal(size)
    first = keep * rng.standard_normal(1)
    made, _ = lfilter([1.0], [1.0, -keep], fresh, zi=first)
    return np.asarray(made, dtype=np.float64)


def _ramp(share: Array) -> Array:
    """0 to 1 along a half cosine."""
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * np.clip(share, 0.0, 1.0)))


def _feeding(t: Array, what: CutDisturbance) -> Array:
    if what.stop_s is None:
        return np.ones_like(t)
    begins_s, ends_s = what.stop_s
    return 1.0 - _ramp((t - begins_s) / STOPS_IN_S) + _ramp((t - ends_s) / STOPS_IN_S)


def _speed_share(t: Array, begins_s: float, lasts_s: float) -> Array:
    if not lasts_s:
        return np.ones_like(t)
    return np.clip(1.0 - (t - begins_s) / lasts_s, 0.0, 1.0)


def _pulses(t: Array, what: CutDisturbance) -> Array:
    """Friction jumps with the oil's pressure and fades: a share of the range."""
    since_s = np.mod(t - what.pulse_first_s, what.pulse_every_s)
    begun = t >= what.pulse_first_s
    return np.where(begun, what.pulse_share * np.exp(-since_s / OIL_FALLS_S), 0.0)
