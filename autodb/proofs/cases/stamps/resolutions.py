"""Stamps that are honest but coarse: rounded, cut off, ticks, packets, single precision."""

import numpy as np

from autodb.proofs.cases.stamps.axis_rows import AxisDraw
from autodb.proofs.cases.stamps.programme import Array
from autodb.proofs.cases.stamps.stamped import (
    UNEVEN_HZ,
    Rng,
    StampedRows,
    StampKind,
    Texts,
    Write,
    even_rows,
    seconds_texts,
)

TICK_S = 0.015625
PACKET_ROWS = (10, 50)
LATENCY_S = (0.0005, 0.004)
FINE_HZ = (300.0, 700.0, 1600.0)
"""Rates whose step is no whole number of 10 µs."""
FAST_HZ = (1600.0, 2000.0)


def _even(rng: Rng, draw: AxisDraw) -> StampedRows:
    return StampedRows(even_rows(draw), seconds_texts(draw.grid_s, int(rng.integers(6, 10))))


def _later(rng: Rng, draw: AxisDraw) -> StampedRows:
    start_s = float(rng.uniform(1.0, 5000.0))
    return StampedRows(
        even_rows(draw), seconds_texts(start_s + draw.grid_s), "", {"start": start_s}
    )


def rounded_to(step_s: float, *, down: bool = False) -> Write:
    """Return what writes stamps rounded to a step, or cut off at it; sampling began anywhere."""

    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        t_s = rng.uniform(0.0, 1.0) * step_s + draw.grid_s
        steps = np.floor(t_s / step_s) if down else np.round(t_s / step_s)
        return StampedRows(even_rows(draw), seconds_texts(steps * step_s))

    return write


def _six_digits(rng: Rng, draw: AxisDraw) -> StampedRows:
    start_s = float(rng.uniform(101.0, 5000.0))
    texts = [f"{value:.6g}" for value in (start_s + draw.grid_s).tolist()]
    return StampedRows(even_rows(draw), texts, "", {"start": start_s})


def _single(low_s: float, high_s: float) -> Write:
    """Return what writes seconds from somewhere between on, kept in single precision."""

    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        start_s = float(rng.uniform(low_s, high_s))
        kept = (start_s + draw.grid_s).astype(np.float32).astype(np.float64)
        return StampedRows(even_rows(draw), seconds_texts(kept), "", {"start": start_s})

    return write


def _packets(rng: Rng, draw: AxisDraw) -> StampedRows:
    size = int(rng.integers(*PACKET_ROWS))
    return StampedRows(even_rows(draw), _arrivals(rng, draw, size), "", {"rows": size})


def _arrivals(rng: Rng, draw: AxisDraw, size: int) -> Texts:
    """Return for each row when its packet of ``size`` came in: the last row's time, and later."""
    count = -(-len(draw.grid_s) // size)
    sent_s = np.arange(1, count + 1) * size / draw.rate_hz
    late_s = rng.exponential(rng.uniform(*LATENCY_S), count)
    came_s: Array = np.maximum.accumulate(sent_s + late_s)
    return seconds_texts(np.repeat(came_s, size)[: len(draw.grid_s)])


RESOLUTIONS = (
    StampKind("even", "Even sampling, even stamps from 0 on.",
              "What every other kind is compared with.", _even, plain=True),
    StampKind("even, later", "Even sampling, even stamps that start somewhere.",
              "A logger that was started before.", _later, plain=True),
    StampKind("1 ms, rounded", "Stamps are rounded to 1 ms; a step is no whole number of them.",
              "shared/failures/logs/ms400.csv: 400 Hz in ms.", rounded_to(1e-3),
              rates_hz=UNEVEN_HZ),
    StampKind("1 ms, cut off", "Stamps are cut off at 1 ms.",
              "Counters of whole milliseconds, such as a PLC's.", rounded_to(1e-3, down=True),
              rates_hz=UNEVEN_HZ),
    StampKind("10 µs, rounded", "Stamps are rounded to 10 µs; a step is no whole number of them.",
              "Five digits behind the point.", rounded_to(1e-5), rates_hz=FINE_HZ),
    StampKind("10 µs, cut off", "Stamps are cut off at 10 µs.",
              "A timer of 100 kHz.", rounded_to(1e-5, down=True), rates_hz=FINE_HZ),
    StampKind("0.1 s, rounded", "Stamps are rounded to 0.1 s: many rows share one.",
              "One digit behind the point.", rounded_to(0.1)),
    StampKind("0.1 s, cut off", "Stamps are cut off at 0.1 s.",
              "Tenths of a second, as controls log alarms.", rounded_to(0.1, down=True)),
    StampKind("10 ms, rounded", "Stamps are rounded to 10 ms: two to twenty rows share one.",
              "SINUMERIK and PLC traces with hundredths.", rounded_to(0.01)),
    StampKind("1 ms, several rows", "Two or more rows share a millisecond.",
              "Fast loggers with stamps of a PC in ms.", rounded_to(1e-3, down=True),
              rates_hz=FAST_HZ),
    StampKind("Windows tick", "Stamps are those of a clock that moves on every 15.625 ms.",
              "GetSystemTimeAsFileTime: 10 to 16 ms (Microsoft, Windows Time).",
              rounded_to(TICK_S, down=True)),
    StampKind("six digits", "Stamps have six digits in all, from hundreds of seconds on.",
              "printf's %g.", _six_digits),
    StampKind("single, POSIX", "POSIX seconds in single precision: steps of 128 s.",
              "A REAL of a PLC holds 24 bits.", _single(1.7e9, 1.8e9)),
    StampKind("single, time of day", "Seconds of the day in single precision: steps of 4 to 8 ms.",
              "A REAL of a PLC holds 24 bits.", _single(33000.0, 86000.0)),
    StampKind("single, uptime", "Seconds since a start, in single precision: steps of 0.1 to 1 ms.",
              "LabVIEW's SGL, numpy's float32.", _single(1100.0, 9000.0)),
    StampKind("packets", "Ten to fifty rows bear the time at which their packet came in.",
              "OPC UA publishing, TCP and serial loggers stamp what arrives.", _packets),
)  # fmt: skip
