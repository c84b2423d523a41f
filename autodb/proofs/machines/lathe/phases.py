"""Raw three-phase recording of one cut on the virtual lathe: air, entry, cut, exit, air.

P1 section 7: Hall sensors on the phases, dynamometer, 1000 Hz.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.drives import spindle_share
from autodb.proofs.machines.lathe.lathe import Lathe, arm_mm, ranges_A, sensing_A
from autodb.proofs.machines.lathe.process import MOVING, Array, TrueCut, TruePair, true_forces_N

AIR_BEFORE_S, RAMP_S, AIR_AFTER_S = 2.0, 0.2, 1.0
FEED_HZ_PER_MM_S = 16.0 / 50.0  # 16 Hz at rapid (P1 section 8); rapid of 50 mm/s chosen
SPINDLE_HZ_PER_RPM = 184.0 / 5000.0  # 184 Hz (P1 section 8) at 5000 rpm (P1 section 6)
SLIP = 0.02  # extra phase frequency at the full cutting force; chosen
HALL_OFFSET_A = 0.05  # sd of the offset of one Hall sensor; chosen
NOISE_SHARE = 10.0 ** (-30.0 / 20.0)  # rms noise over rms signal: 30 dB
FIFTH_HARMONIC = 0.02  # share of the spindle's amplitude; chosen
RUNOUT = 0.015  # force once per revolution, share; chosen
RINGING, RINGING_HZ, RINGING_DAMPING = 0.05, 187.0, 0.03  # tool ringing: rms share; chosen
DYNAMOMETER_SAMPLE_N = 3.0  # white noise of one sample; chosen
Z_START_MM = 320.0  # slide positions at the start; chosen


@dataclass(frozen=True)
class RecordingClock:
    """The time base of one recording, s, and the share of the cut that is engaged, 0 to 1."""

    t: Array
    engaged: Array
    middle_s: float


def draw_clock(cut: TrueCut, rate_hz: float) -> RecordingClock:
    """Air approach, cosine entry ramp, cut, exit ramp, air: t and engagement at `rate_hz`."""
    total_s = AIR_BEFORE_S + 2.0 * RAMP_S + cut.duration_s + AIR_AFTER_S
    t = np.arange(round(total_s * rate_hz)) / rate_hz
    leaves_s = AIR_BEFORE_S + RAMP_S + cut.duration_s
    rise = np.clip((t - AIR_BEFORE_S) / RAMP_S, 0.0, 1.0)
    fall = np.clip((t - leaves_s) / RAMP_S, 0.0, 1.0)
    engaged = 0.5 * (np.cos(np.pi * fall) - np.cos(np.pi * rise))
    return RecordingClock(t, engaged, AIR_BEFORE_S + RAMP_S + 0.5 * cut.duration_s)


def phases(
    rng: np.random.Generator,
    range_A: Array,
    hertz: Array,
    rate_hz: float,
    harmonic: float = 0.0,
    *,
    gains: tuple[float, float, float] = (1.0, 1.0, 1.0),
    noise_share: float = NOISE_SHARE,
) -> dict[str, Array]:
    """Currents of three Hall sensors, A: range/2 sin(theta - k 2 pi/3), d theta/dt = 2 pi f.

    At standstill theta is frozen and the currents are constant. A negative frequency reverses the
    phase order. Noise is white, 30 dB below the signal unless its rms share of it is given; each
    sensor has an offset and a gain.
    """
    theta = rng.uniform(0.0, 2.0 * np.pi) + 2.0 * np.pi * np.cumsum(hertz) / rate_hz
    noise_A = noise_share * float(np.mean(range_A)) / 2.0 / np.sqrt(2.0)
    currents = {}
    for k, name in enumerate("uvw"):
        angle = theta - 2.0 * np.pi / 3.0 * k
        wave = 0.5 * gains[k] * range_A * (np.sin(angle) + harmonic * np.sin(5.0 * angle))
        noise = noise_A * rng.standard_normal(range_A.size)
        currents[name] = wave + noise + HALL_OFFSET_A * rng.standard_normal()
    return currents


def ringing(rng: np.random.Generator, size: int, rate_hz: float) -> Array:
    """Narrow-band noise of unit rms: white noise through a lightly damped resonance."""
    hertz = np.fft.rfftfreq(size, 1.0 / rate_hz) / RINGING_HZ
    response = 1.0 / (1.0 - hertz**2 + 2j * RINGING_DAMPING * hertz)
    response[0] = 0.0
    wave = np.fft.irfft(np.fft.rfft(rng.standard_normal(size)) * response, size)
    return np.asarray(wave / np.std(wave), dtype=np.float64)


def dynamometer_N(
    rng: np.random.Generator, force_N: Array, engaged: Array, turns: Array, rate_hz: float
) -> Array:
    """Dynamometer signal (3, n), N: engaged mean force, runout, tool ringing and white noise."""
    rows = []
    for mean_N in force_N:
        swing = RUNOUT * np.sin(2.0 * np.pi * turns) + RINGING * ringing(rng, turns.size, rate_hz)
        noise_N = DYNAMOMETER_SAMPLE_N * rng.standard_normal(turns.size)
        rows.append(mean_N * engaged * (1.0 + swing) + noise_N)
    return np.array(rows)


def raw_cut(
    lathe: Lathe,
    pair: TruePair,
    cut: TrueCut,
    seed: int,
    dynamometer: bool,
    *,
    rate_hz: float = 1000.0,
) -> dict[str, NDArray[np.float64]]:
    """One cut as the phase sensors saw it: the channels of the contract, one array each.

    The slides' positions are tool travel, mm (x: radius); `work.diameter` follows the tool tip. The
    tool feeds at the same speed in air and in the cut, so the approach gives the air range. The
    force and the sensing error of the cut are drawn once; the cold drive starts at t = 0. Cuts that
    feed one slide only.
    """
    process, sensing, waves, reading = (np.random.default_rng([seed, 7, k]) for k in range(4))
    time = draw_clock(cut, rate_hz)
    force_N = lathe.work_factor * true_forces_N(pair, cut, process)
    (feed,) = MOVING[cut.operation]

    # Motion: the feed runs towards -z (turn) or -x (face); facing shrinks the radius
    feed_mm_s = cut.feed_mm * cut.spindle_rpm / 60.0
    travel_mm = feed_mm_s * (time.t - time.middle_s)
    speed_mm_s = {"x": 0.0, "z": 0.0, feed: -feed_mm_s}
    radius_mm = 0.5 * cut.diameter_mm - (travel_mm if feed == "x" else 0.0 * travel_mm)
    z_mm = Z_START_MM - (travel_mm if feed == "z" else 0.0 * travel_mm)

    # Ranges follow the engaged force; one sensing error for the whole cut
    arm = radius_mm + (arm_mm(cut) - 0.5 * cut.diameter_mm)
    share = spindle_share(lathe.spindle, seed, time.middle_s)
    ranges = ranges_A(lathe, cut, force_N[:, None] * time.engaged, radius_mm=arm, share=share)
    errors_A = {name: sd * sensing.standard_normal() for name, sd in sensing_A(lathe, cut).items()}

    slip = 1.0 + SLIP * time.engaged
    channels = {
        "t": time.t,
        "x.position": radius_mm,
        "z.position": z_mm,
        "work.diameter": 2.0 * radius_mm,
        "spindle.speed": np.full_like(time.t, cut.spindle_rpm),
    }
    hertz = {axis: FEED_HZ_PER_MM_S * speed for axis, speed in speed_mm_s.items()}
    hertz["spindle"] = SPINDLE_HZ_PER_RPM * cut.spindle_rpm
    harmonic = {"spindle": FIFTH_HARMONIC}
    for axis in ("x", "z", "spindle"):
        range_A = np.abs(ranges[axis] + errors_A[axis] * time.engaged)
        three = phases(waves, range_A, hertz[axis] * slip, rate_hz, harmonic.get(axis, 0.0))
        channels |= {f"{axis}.current.{name}": current for name, current in three.items()}
    if dynamometer:
        turns = cut.spindle_rpm / 60.0 * time.t
        signal_N = dynamometer_N(reading, force_N, time.engaged, turns, rate_hz)
        channels |= {f"force.{name}": signal_N[k] for k, name in enumerate("xyz")}
    return channels
