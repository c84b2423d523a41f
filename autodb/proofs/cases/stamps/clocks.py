"""Clocks that jitter, drift, wrap or are set, and loops whose sampling itself jitters."""

from collections.abc import Callable

import numpy as np

from autodb.proofs.cases.base.moves import log_uniform
from autodb.proofs.cases.stamps.axis_rows import AxisDraw
from autodb.proofs.cases.stamps.programme import Array
from autodb.proofs.cases.stamps.stamped import (
    Rng,
    StampedRows,
    StampKind,
    Write,
    even_rows,
    seconds_texts,
    unit_side,
    whole_texts,
)

JITTER = (0.02, 0.30)
"""Standard deviation, of a step."""
DRIFT = (50e-6, 500e-6)
WANDER = (200e-6, 2000e-6)
STEP_S = (0.1, 1.0)
DAY_S = 86_400.0
FETCH_S = 1e-6
"""What it takes at least to fetch the next row. Chosen."""
PARETO = 2.5
"""Exponent of the tail of a latency. Chosen: its mean exists, its fourth moment does not."""


def _jittered(rng: Rng, draw: AxisDraw) -> StampedRows:
    share = log_uniform(rng, *JITTER)
    t_s = draw.grid_s + rng.normal(0.0, share / draw.rate_hz, len(draw.grid_s))
    return StampedRows(even_rows(draw), seconds_texts(t_s), "", {"sd of a step": share})


def _late(rng: Rng, draw: AxisDraw) -> StampedRows:
    """Rows are sampled evenly and stamped when they are fetched, one after another."""
    share = log_uniform(rng, *JITTER)
    late_s = share / draw.rate_hz * rng.pareto(PARETO, len(draw.grid_s))
    least_s = FETCH_S * np.arange(len(late_s))
    t_s = np.maximum.accumulate(draw.grid_s + late_s - least_s) + least_s
    return StampedRows(even_rows(draw), seconds_texts(t_s), "", {"latency of a step": share})


def _honest(draw: AxisDraw, true_s: Array, drawn: dict[str, float]) -> StampedRows:
    return StampedRows(draw.rows(true_s), seconds_texts(true_s), "", drawn)


def _about_the_grid(rng: Rng, draw: AxisDraw) -> StampedRows:
    share = log_uniform(rng, *JITTER)
    true_s = draw.grid_s + rng.normal(0.0, share / draw.rate_hz, len(draw.grid_s))
    return _honest(draw, np.sort(true_s), {"sd of a step": share})


def _accumulating(rng: Rng, draw: AxisDraw) -> StampedRows:
    share = log_uniform(rng, *JITTER)
    steps = rng.gamma(share**-2, share**2, len(draw.grid_s)) / draw.rate_hz
    true_s = np.cumsum(steps) - steps[0]
    inside = true_s < draw.programme.seconds
    return _honest(draw, true_s[inside], {"sd of a step": share})


def _overruns(rng: Rng, draw: AxisDraw) -> StampedRows:
    """A loop that waits for a full step after its work: now and then it comes late for good."""
    share, late = float(rng.uniform(0.005, 0.03)), rng.uniform(1.0, 4.0)
    steps = (1.0 + late * (rng.random(len(draw.grid_s)) < share)) / draw.rate_hz
    true_s = np.cumsum(steps) - steps[0]
    return _honest(draw, true_s[true_s < draw.programme.seconds], {"share": share, "steps": late})


def _drift(rng: Rng, draw: AxisDraw) -> StampedRows:
    part = float(rng.choice([-1.0, 1.0])) * rng.uniform(*DRIFT)
    return StampedRows(even_rows(draw), seconds_texts(draw.grid_s * (1.0 + part)), "",
                       {"ppm": 1e6 * part})  # fmt: skip


def _wander(rng: Rng, draw: AxisDraw) -> StampedRows:
    part, period_s = log_uniform(rng, *WANDER), rng.uniform(0.3, 2.0) * draw.programme.seconds
    turn = 2.0 * np.pi / period_s
    t_s = draw.grid_s + part / turn * (1.0 - np.cos(turn * draw.grid_s))
    return StampedRows(even_rows(draw), seconds_texts(t_s), "", {"ppm": 1e6 * part})


def _slewed(rng: Rng, draw: AxisDraw) -> StampedRows:
    """From a moment on a clock runs 500 ppm faster or slower: it is brought to another's time."""
    from_s = rng.uniform(0.2, 0.8) * draw.programme.seconds
    part = float(rng.choice([-500e-6, 500e-6]))
    t_s = draw.grid_s + part * np.maximum(draw.grid_s - from_s, 0.0)
    return StampedRows(even_rows(draw), seconds_texts(t_s), "", {"from": from_s})


def _set_by(sign: float) -> Write:
    """Return what writes a clock that is set once, forward or back; rows go on evenly."""

    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        from_s = rng.uniform(0.2, 0.8) * draw.programme.seconds
        by_s = sign * rng.uniform(*STEP_S)
        t_s = draw.grid_s + by_s * (draw.grid_s >= from_s)
        return StampedRows(even_rows(draw), seconds_texts(t_s), "", {"from": from_s, "by": by_s})

    return write


def wrapping(
    counts: float, ticks_per_s: float, unit: str = "", place: Callable[[Rng], float] | None = None
) -> Write:
    """Return what writes a counter that wraps once within: its ticks with a unit, or seconds."""

    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        share = rng.uniform(0.2, 0.8) if place is None else place(rng)
        before = np.floor(share * draw.programme.seconds * ticks_per_s)
        ticks = np.floor(draw.grid_s * ticks_per_s + 1e-6) + counts - before
        ticks = ticks % counts
        drawn = {"after": before / ticks_per_s}
        if unit:
            return StampedRows(even_rows(draw), whole_texts(ticks), unit_side(unit), drawn)
        return StampedRows(even_rows(draw), seconds_texts(ticks / ticks_per_s, 7), "", drawn)

    return write


def _midnight(rng: Rng, draw: AxisDraw) -> StampedRows:
    before_s = rng.uniform(0.2, 0.8) * draw.programme.seconds
    t_s = (DAY_S - before_s + draw.grid_s) % DAY_S
    return StampedRows(even_rows(draw), seconds_texts(t_s), "", {"after": before_s})


CLOCKS = (
    StampKind("stamps jitter", "Sampling is even, stamps scatter with a sd of 2 to 30 % of a step.",
              "Software stamps.", _jittered),
    StampKind("stamps late", "Sampling is even, stamps are late by a latency with a heavy tail.",
              "Stamps of a user-space program that fetches rows.", _late),
    StampKind("sampling jitters", "Rows are sampled about a grid, and stamped honestly.",
              "A soft real-time loop that waits for absolute times.", _about_the_grid),
    StampKind("sampling wanders", "Steps scatter independently, and stamps are honest.",
              "A loop that sleeps after its work.", _accumulating),
    StampKind("loop overruns", "Some steps are two to five times as long; stamps are honest.",
              "A loop that misses its deadline.", _overruns),
    StampKind("clock drifts", "The clock is 50 to 500 ppm too fast or too slow.",
              "Quartz without synchronisation.", _drift),
    StampKind("clock wanders", "The rate of the clock wanders slowly by up to 0.2 %.",
              "RC oscillators, clocks that NTP disciplines.", _wander),
    StampKind("clock slewed", "From a moment on the clock runs 500 ppm faster or slower.",
              "adjtime(3) and chrony slew by 500 ppm.", _slewed),
    StampKind("clock set forward", "The clock is set forward by 0.1 to 1 s; rows go on evenly.",
              "A step of NTP, which steps from 0.128 s on.", _set_by(1.0)),
    StampKind("clock set back", "The clock is set back by 0.1 to 1 s; rows go on evenly.",
              "A step of NTP, which steps from 0.128 s on.", _set_by(-1.0)),
    StampKind("32 bit µs, s", "Seconds of a 32-bit counter of µs, which wraps once.",
              "micros() of Arduino: 4294.967296 s.", wrapping(2.0**32, 1e6)),
    StampKind("32 bit µs, stated", "A 32-bit counter of µs that wraps once; its unit is stated.",
              "micros() of Arduino: 4294.967296 s.", wrapping(2.0**32, 1e6, "us")),
    StampKind("16 bit ms", "Seconds of a 16-bit counter of ms, which wraps once.",
              "CANopen SYNC stamps, small controllers: 65.536 s.", wrapping(2.0**16, 1e3),
              rates_hz=(200.0, 250.0, 500.0, 1000.0)),
    StampKind("16 bit ms, stated", "A 16-bit counter of ms that wraps once; its unit is stated.",
              "CANopen SYNC stamps, small controllers: 65.536 s.", wrapping(2.0**16, 1e3, "ms"),
              rates_hz=(200.0, 250.0, 500.0, 1000.0)),
    StampKind("32 bit 100 ns", "Seconds of a 32-bit counter of 100 ns, which wraps once.",
              "The low word of a FILETIME: 429.4967296 s.", wrapping(2.0**32, 1e7)),
    StampKind("24 bit µs", "Seconds of a 24-bit counter of µs, which wraps once or twice.",
              "SysTick of a Cortex-M: 16.777216 s.", wrapping(2.0**24, 1e6)),
    StampKind("midnight", "Seconds of the day, over midnight.",
              "TIME_OF_DAY of a PLC.", _midnight),
)  # fmt: skip
