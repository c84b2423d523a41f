"""What a file holds, read once in blocks: memory stays that of one block however long it is."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from autodb.channels import LINEAR_AXES, unit_of
from autodb.errors import UnusableInput
from autodb.records.source import Source, TimeBase
from autodb.records.tables import Array, CutTable, Recording, check_cuts, check_time

RUN = 5
"""Samples in a row that are exactly equal: a plateau."""


@dataclass
class ChannelSummary:
    """One channel: rows, extremes, mean and spread over its finite numbers, and its gaps.

    ``roughness`` is the median over blocks of the median |second difference| that is not zero, over
    the block's range. ``plateau_low`` and ``plateau_high`` count samples in runs of at least RUN
    equal numbers at the lowest and highest value, ``plateau`` those in any such run.
    """

    name: str
    unit: str
    rows: int = 0
    finite: int = 0
    minimum: float = np.inf
    maximum: float = -np.inf
    mean: float = 0.0
    first_gap: int | None = None
    plateau_low: int = 0
    plateau_high: int = 0
    plateau: int = 0
    _squares: float = 0.0
    _rough: list[float] = field(default_factory=list)

    @property
    def sd(self) -> float:
        """Standard deviation over the finite numbers."""
        return float(np.sqrt(self._squares / self.finite)) if self.finite else np.nan

    @property
    def roughness(self) -> float:
        """See the class."""
        return float(np.median(self._rough)) if self._rough else 0.0

    def add(self, values: Array) -> None:
        """Take in the next block (n,)."""
        good = np.isfinite(values)
        if self.first_gap is None and not good.all():
            self.first_gap = self.rows + int(np.argmin(good)) + 1
        self.rows += len(values)
        finite = values[good]
        if finite.size:
            self._moments(finite)
            self._plateaus(finite)

    def _moments(self, values: Array) -> None:
        """Join mean and sum of squares (Chan, Golub, LeVeque 1983)."""
        n, mean = len(values), float(values.mean())
        shift, total = mean - self.mean, self.finite + n
        self._squares += float(((values - mean) ** 2).sum()) + shift**2 * self.finite * n / total
        self.mean += shift * n / total
        self.finite = total

    def _plateaus(self, values: Array) -> None:
        low, high = float(values.min()), float(values.max())
        starts = np.flatnonzero(np.diff(values, prepend=np.nan) != 0)
        lengths = np.diff(np.append(starts, len(values)))
        long = lengths >= RUN
        level, held = values[starts[long]], lengths[long]
        self.plateau += int(held.sum())
        if low <= self.minimum:
            before = self.plateau_low if low == self.minimum else 0
            self.minimum, self.plateau_low = low, before + int(held[level == low].sum())
        if high >= self.maximum:
            before = self.plateau_high if high == self.maximum else 0
            self.maximum, self.plateau_high = high, before + int(held[level == high].sum())
        bends = np.abs(np.diff(values, 2))
        bends = bends[bends > 0]
        if bends.size:
            self._rough.append(float(np.median(bends)) / (high - low))


@dataclass
class BaseSummary:
    """One time base or table of cuts of a file. ``rates``: see `Rates`."""

    name: str
    holds_cuts: bool
    channels: dict[str, ChannelSummary]
    rows: int = 0
    start_s: float = np.nan
    end_s: float = np.nan
    rates: "dict[str, Rates]" = field(default_factory=dict)

    @property
    def rate_hz(self) -> float | None:
        """Rows per second on average; None for a table of cuts."""
        if self.holds_cuts or self.rows < 2:
            return None
        return (self.rows - 1) / (self.end_s - self.start_s)


@dataclass
class Rates:
    """Moments of a recorded velocity v against the slope of its position, to compare the two."""

    vv: float = 0.0
    vd: float = 0.0
    dd: float = 0.0

    def add(self, velocity: Array, slope: Array) -> None:
        """Take in the next block (n,)."""
        good = np.isfinite(velocity) & np.isfinite(slope)
        self.vv += float(velocity[good] @ velocity[good])
        self.vd += float(velocity[good] @ slope[good])
        self.dd += float(slope[good] @ slope[good])

    @property
    def factor(self) -> float | None:
        """How many times the slope of the position the velocity is; None where they are unlike."""
        if self.vd**2 < 0.8 * self.vv * self.dd or self.vd == 0:
            return None
        return self.vv / self.vd


def summarise(
    source: Source, *, progress: Callable[[str], None] | None = None
) -> tuple[BaseSummary, ...]:
    """Read every time base of a file once, in blocks.

    Raises UnusableInput for what cannot be read, time that does not increase, or cuts numbered
    twice.
    """
    return tuple(_summarise_base(base, progress) for base in source.usable())


def summary_of(table: Recording | CutTable) -> BaseSummary:
    """Return the summary of a table that has been read."""
    made = _empty("", isinstance(table, CutTable), list(table.channels), table.units)
    _take(made, table.channels, table.path)
    return made


def _summarise_base(base: TimeBase, progress: Callable[[str], None] | None) -> BaseSummary:
    conversion = base.conversion
    made: BaseSummary | None = None
    numbers: list[Array] = []
    for channels, _ in base.blocks():
        if made is None:
            made = _empty(base.name, base.holds_cuts, list(channels), conversion.units)
        _take(made, channels, conversion.path)
        if base.holds_cuts:
            numbers.append(channels["cut"])
        if progress:
            progress(f"{made.rows} rows")
    assert made is not None  # a reader without rows has raised
    if numbers:
        check_cuts(conversion.path, np.concatenate(numbers))
    return made


def _empty(name: str, holds_cuts: bool, channels: list[str], units: dict[str, str]) -> BaseSummary:
    return BaseSummary(
        name,
        holds_cuts,
        {c: ChannelSummary(c, units.get(c) or unit_of(c) or "1") for c in channels},
    )


def _take(made: BaseSummary, channels: dict[str, Array], path: Path) -> None:
    """Take the next block into the summary of its time base."""
    for name, values in channels.items():
        made.channels[name].add(values)
    if not made.holds_cuts:
        _take_time(made, channels, path)
    made.rows += len(next(iter(channels.values())))


def _take_time(made: BaseSummary, channels: dict[str, Array], path: Path) -> None:
    t_s = channels["t"]
    if made.channels["t"].first_gap is not None:
        raise UnusableInput(
            f"{path}: t, row {made.channels['t'].first_gap}: no finite number; "
            "a time on every row would work"
        )
    if made.rows:
        check_time(path, np.append(made.end_s, t_s), first_row=made.rows)
    else:
        made.start_s = float(t_s[0])
        check_time(path, t_s)
    made.end_s = float(t_s[-1])
    for axis in LINEAR_AXES:
        position, velocity = channels.get(f"{axis}.position"), channels.get(f"{axis}.velocity")
        if position is not None and velocity is not None and len(t_s) > 1:
            rates = made.rates.setdefault(axis, Rates())
            rates.add(velocity, np.gradient(position, t_s))
