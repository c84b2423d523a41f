"""What a file holds, read once in blocks: memory stays that of one block however long it is."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from autodb.files.channels import LINEAR_AXES, axis_of, unit_of
from autodb.records.channel_summary import ChannelSummary
from autodb.records.convert import Conversion
from autodb.records.source import ChannelSet, RecordingSource
from autodb.records.stamps import StampsSoFar
from autodb.records.tables import Array, CutTable, Recording, check_cuts
from autodb.timing import Timing


@dataclass
class BaseSummary:
    """One time base or table of cuts of a file.

    ``timing``: what its time is; None of a table of cuts. ``rates``: see `Rates`.
    ``operations``: the first row of each. ``speed_ratios``: π D n over the cutting speed, of the
    cuts that state diameter, spindle speed and cutting speed.
    """

    name: str
    holds_cuts: bool
    channels: dict[str, ChannelSummary]
    rows: int = 0
    start_s: float = np.nan
    end_s: float = np.nan
    timing: Timing | None = None
    stamps: StampsSoFar = field(default_factory=StampsSoFar)
    rates: "dict[str, Rates]" = field(default_factory=dict)
    operations: dict[str, int] = field(default_factory=dict)
    speed_ratios: list[Array] = field(default_factory=list)

    @property
    def rate_hz(self) -> float | None:
        """Rows per second; None for a table of cuts."""
        return None if self.timing is None else self.timing.rate_hz


ROWS_MOVING = 10.0
"""How many rows must share a velocity before it is compared with a position. Chosen."""


@dataclass
class Rates:
    """Moments of a recorded velocity v against the slope of its position, to compare the two."""

    vv: float = 0.0
    vd: float = 0.0
    dd: float = 0.0
    v4: float = 0.0
    d4: float = 0.0

    def add(self, velocity: Array, slope: Array) -> None:
        """Take in the next block (n,)."""
        good = np.isfinite(velocity) & np.isfinite(slope)
        self.vv += float(velocity[good] @ velocity[good])
        self.vd += float(velocity[good] @ slope[good])
        self.dd += float(slope[good] @ slope[good])
        self.v4 += float(np.sum(velocity[good] ** 4))
        self.d4 += float(np.sum(slope[good] ** 4))

    @property
    def factor(self) -> float | None:
        """How many times the slope of the position the velocity is; None where they are unlike.

        None too where it rests on less than ROWS_MOVING rows: a jump of an axis that stands.
        """
        if self.vd**2 < 0.8 * self.vv * self.dd or self.vd == 0:
            return None
        if self.vv**2 < ROWS_MOVING * self.v4 or self.dd**2 < ROWS_MOVING * self.d4:
            return None
        return self.vv / self.vd


def summarise(
    source: RecordingSource, *, progress: Callable[[str], None] | None = None
) -> tuple[BaseSummary, ...]:
    """Read every time base of a file once, in blocks.

    Raises UnusableInput for what cannot be read, stamps that cannot be used, or cuts numbered
    twice. Where stamps are not even a time base is read once more, as a whole.
    """
    return tuple(_summarise_base(base, progress) for base in source.usable())


def summary_of(table: Recording | CutTable, *, axis: str | None = None) -> BaseSummary:
    """Return the summary of a table that has been read; with ``axis`` only of its channels."""
    conversion = Conversion(table.path, table.side.channels, table.side)
    channels = {
        name: values
        for name, values in table.channels.items()
        if axis is None or name == "t" or axis_of(name) == axis
    }
    made = _empty("", isinstance(table, CutTable), list(channels), conversion)
    for row, operation in enumerate(table.texts.get("operation", ()), start=1):
        made.operations.setdefault(operation, row)
    _take(made, channels)
    if isinstance(table, Recording):
        _timed_by(made, table)
    return made


def _summarise_base(base: ChannelSet, progress: Callable[[str], None] | None) -> BaseSummary:
    conversion = base.conversion
    made: BaseSummary | None = None
    numbers: list[Array] = []
    for channels, texts in base.blocks():
        if made is None:
            made = _empty(base.name, base.holds_cuts, list(channels), conversion)
        for row, operation in enumerate(texts.get("operation", ()), start=made.rows + 1):
            made.operations.setdefault(operation, row)
        _take(made, channels)
        if base.holds_cuts:
            numbers.append(channels["cut"])
        if progress:
            progress(f"{made.rows} rows")
    assert made is not None  # a reader without rows has raised
    if numbers:
        check_cuts(conversion.path, np.concatenate(numbers))
    elif made.stamps.even:
        _even_by(made)
    else:
        table = base.read()
        assert isinstance(table, Recording)  # it holds no cuts
        _timed_by(made, table)
    return made


def _empty(name: str, holds_cuts: bool, channels: list[str], conversion: Conversion) -> BaseSummary:
    units = conversion.units
    return BaseSummary(
        name,
        holds_cuts,
        {
            c: ChannelSummary(c, units.get(c) or unit_of(c) or "1", conversion.is_stated(c))
            for c in channels
        },
    )


def _take(made: BaseSummary, channels: dict[str, Array]) -> None:
    """Take the next block into the summary of its time base."""
    for name, values in channels.items():
        made.channels[name].add(values)
    if made.holds_cuts:
        made.speed_ratios.append(_speed_ratios(channels))
    else:
        _take_time(made, channels)
    made.rows += len(next(iter(channels.values())))


def _speed_ratios(channels: dict[str, Array]) -> Array:
    parts = [channels.get(n) for n in ("work.diameter", "spindle.speed", "cutting.speed")]
    if any(part is None for part in parts):
        return np.zeros(0)
    diameter_mm, speed_rpm, speed_m_min = (np.asarray(part) for part in parts)
    known = (diameter_mm > 0) & (speed_rpm > 0) & (speed_m_min > 0)
    around_m_min = np.pi * diameter_mm[known] * speed_rpm[known] / 1000.0
    return np.asarray(around_m_min / speed_m_min[known], dtype=np.float64)


def _take_time(made: BaseSummary, channels: dict[str, Array]) -> None:
    """Take in the next block's stamps, and its speeds where they are even so far."""
    t_s = channels["t"]
    made.stamps.add(t_s, channels)
    if made.stamps.even:
        _take_rates(made, channels)


def _take_rates(made: BaseSummary, channels: dict[str, Array]) -> None:
    t_s = channels["t"]
    for axis in LINEAR_AXES:
        position, velocity = channels.get(f"{axis}.position"), channels.get(f"{axis}.velocity")
        if position is not None and velocity is not None and len(t_s) > 1:
            rates = made.rates.setdefault(axis, Rates())
            rates.add(velocity, np.gradient(position, t_s))


def _even_by(made: BaseSummary) -> None:
    """Keep what the stamps of a time base are, that are even as they came."""
    made.timing = made.stamps.timing()
    made.start_s, made.end_s = made.stamps.first_s, made.stamps.last_s


def _timed_by(made: BaseSummary, table: Recording) -> None:
    """Keep what the stamps of a time base are, whose rows had to be laid out."""
    made.timing = table.timing
    made.start_s, made.end_s = float(table.t_s[0]), float(table.t_s[-1])
    made.rates = {}
    for piece in table.pieces:
        _take_rates(made, {name: values[piece] for name, values in table.channels.items()})
