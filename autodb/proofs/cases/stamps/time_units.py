"""Times in other units than seconds, under the name ``t``: with nothing stated, and stated."""

import numpy as np

from autodb.proofs.cases.stamps.axis_rows import AxisDraw
from autodb.proofs.cases.stamps.stamped import (
    Rng,
    StampedRows,
    StampKind,
    Write,
    even_rows,
    seconds_texts,
    unit_side,
)

POSIX_S = (1_700_000_000, 1_800_000_000)
EXCEL_DAYS = (45_000.0, 47_000.0)
FILETIME_S = 11_644_473_600
"""Seconds from 1601 to 1970 (Microsoft, FILETIME)."""
PLC_EPOCH_S = 946_684_800
"""Seconds from 1970 to 2000, from which EtherCAT's distributed clocks count."""
SECOND_DIGITS = 6


def in_unit(unit_s: float, digits: int, *, stated: str = "") -> Write:
    """Return what writes times in a unit of ``unit_s`` seconds; ``stated``: in a side file."""

    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        start_s = float(rng.choice([0.0, rng.uniform(0.0, 100.0)]))
        texts = seconds_texts((start_s + draw.grid_s) / unit_s, digits)
        return StampedRows(even_rows(draw), texts, unit_side(stated) if stated else "")

    return write


def since_epoch(per_s: int, *, digits: int = 0, offset_s: int = 0, stated: str = "") -> Write:
    """Return what writes times since 1970, or another epoch, in whole or broken units."""

    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        start_s = int(rng.integers(*POSIX_S)) + offset_s
        first = int(rng.integers(0, per_s))
        ticks = np.round(draw.grid_s * per_s * 10**digits).astype(np.int64)
        texts = [_number((start_s * per_s + first) * 10**digits + int(n), digits) for n in ticks]
        return StampedRows(even_rows(draw), texts, unit_side(stated) if stated else "")

    return write


def _number(count: int, digits: int) -> str:
    """Return count / 10^digits in full, as no floating number of 64 bits could hold it."""
    if not digits:
        return str(count)
    whole, part = divmod(count, 10**digits)
    return f"{whole}.{part:0{digits}d}"


def _excel(stated: str) -> Write:
    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        days = rng.uniform(*EXCEL_DAYS) + draw.grid_s / 86_400.0
        texts = seconds_texts(days, int(rng.integers(9, 12)))
        return StampedRows(even_rows(draw), texts, unit_side(stated) if stated else "")

    return write


def _counted(side: str) -> Write:
    """Return what writes the number of each row under ``t``."""

    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        first = int(rng.integers(0, 10_000))
        texts = [str(first + row) for row in range(len(draw.grid_s))]
        return StampedRows(even_rows(draw), texts, side.format(step=1.0 / draw.rate_hz))

    return write


STEP_SIDE = '[channels]\n"t" = {{column = "t", scale = {step!r}, unit = "s"}}\n'
UNSTATED = "Nothing states the unit: it can only be guessed, or asked for."
STATED = "The side file states the unit, where it is one that is known."
TIME_UNITS = (
    StampKind("ms", UNSTATED, "shared/failures/logs/ms.csv.", in_unit(1e-3, 3)),
    StampKind("µs", UNSTATED, "micros() of Arduino.", in_unit(1e-6, 0)),
    StampKind("ns", UNSTATED, "Monotonic clocks: clock_gettime, perf_counter_ns.",
              in_unit(1e-9, 0)),
    StampKind("minutes", UNSTATED, "Traces of drives over long times.", in_unit(60.0, 9)),
    StampKind("Excel days", UNSTATED, "Serial dates of spreadsheets; MATLAB's datenum.",
              _excel("")),
    StampKind("POSIX s", UNSTATED, "Seconds since 1970, as Python's time().",
              since_epoch(1, digits=SECOND_DIGITS)),
    StampKind("POSIX ms", UNSTATED, "Milliseconds since 1970, as JavaScript's Date.now().",
              since_epoch(1000), rates_hz=(200.0, 250.0, 500.0, 1000.0)),
    StampKind("POSIX ns", UNSTATED, "Nanoseconds since 1970, as InfluxDB exports.",
              since_epoch(10**9)),
    StampKind("FILETIME", UNSTATED, "100 ns since 1601, as Windows and OPC count.",
              since_epoch(10**7, offset_s=FILETIME_S)),
    StampKind("EtherCAT ns", UNSTATED, "Nanoseconds since 2000: distributed clocks of TwinCAT.",
              since_epoch(10**9, offset_s=-PLC_EPOCH_S)),
    StampKind("row number", UNSTATED, "halsampler -t of LinuxCNC prints the sample number.",
              _counted("")),
    StampKind("ms, stated", STATED, "docs/formats.md.", in_unit(1e-3, 3, stated="ms")),
    StampKind("µs, stated", STATED, "docs/formats.md.", in_unit(1e-6, 0, stated="us")),
    StampKind("ns, stated", STATED, "docs/formats.md.", in_unit(1e-9, 0, stated="ns")),
    StampKind("minutes, stated", STATED, "docs/formats.md.", in_unit(60.0, 9, stated="min")),
    StampKind("Excel days, stated", STATED, "docs/formats.md.", _excel("day")),
    StampKind("POSIX s, stated", STATED, "docs/formats.md.",
              since_epoch(1, digits=SECOND_DIGITS, stated="s")),
    StampKind("POSIX ns, stated", STATED, "docs/formats.md.", since_epoch(10**9, stated="ns")),
    StampKind("row number, stated", "The side file states the step of a row's number.",
              "docs/formats.md: a column with a scale.", _counted(STEP_SIDE)),
)  # fmt: skip
