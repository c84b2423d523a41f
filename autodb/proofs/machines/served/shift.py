"""A shift of a virtual machine: cuts with pauses, as the control says its channels and states."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.jobs import cut_at
from autodb.proofs.machines.lathe.phases import raw_cut
from autodb.proofs.machines.mill.reference_cuts import MillCut
from autodb.proofs.machines.mill.reference_mill import draw_mill
from autodb.proofs.machines.mill.reference_mill_moves import RATE_HZ
from autodb.proofs.machines.mill.reference_plan import PlannedCut, record_planned
from autodb.proofs.machines.sample import SAMPLE_LATHE, SAMPLE_PAIR

Array = NDArray[np.float64]
STATE = float | str

MONDAY_S = 1_790_000_000.0
"""When a shift begins, s since 1970: the same every time, so that it is the same every time."""
PAUSE_S = 2.0
LATHE_HZ = 1000.0
LATHE_CUTS = (  # depth mm, feed mm, rpm, diameter mm; chosen within the standard cuts
    (2.0, 0.20, 1500.0, 62.0),
    (1.0, 0.15, 1200.0, 58.0),
    (1.5, 0.25, 1000.0, 56.0),
    (2.5, 0.10, 1600.0, 53.0),
)
LATHE_CUT_S = 2.5
MILL_CUTS = ((2.0, 5.0, 500.0, 4500.0), (1.0, 7.0, 400.0, 3500.0), (3.0, 4.0, 500.0, 5400.0))
"""Depth, width mm, feed mm/min, rpm; chosen within the plan of 181 cuts."""


@dataclass(frozen=True)
class ServedShift:
    """Rows of channels (n,) at ``rate_hz`` from ``start_s`` on, and states by the row that they
    begin with. ``cuts``: first row and the row behind the last of each. All of it is done ``times``
    times over. ``clock_set``: from which row on the machine's clock is off, by how many seconds.
    """

    rate_hz: float
    columns: dict[str, Array]
    states: dict[str, list[tuple[int, STATE]]]
    cuts: list[tuple[int, int]]
    start_s: float = MONDAY_S
    times: int = 1
    clock_set: tuple[int, float] | None = None

    @property
    def rows(self) -> int:
        """How many rows it has."""
        return self._once * self.times

    @property
    def _once(self) -> int:
        return len(next(iter(self.columns.values())))

    def values(self, name: str, begin: int, end: int) -> Array:
        """Return rows of a channel."""
        return self.columns[name][np.arange(begin, end) % self._once]

    def instant_s(self, row: int) -> float:
        """Return when a row is, s since 1970."""
        off_s = 0.0
        if self.clock_set is not None and row >= self.clock_set[0]:
            off_s = self.clock_set[1]
        return self.start_s + row / self.rate_hz + off_s

    def at(self, row: int) -> dict[str, STATE]:
        """Return the states that begin with a row."""
        return self._changes.get(row % self._once, {})

    @cached_property
    def _changes(self) -> dict[int, dict[str, STATE]]:
        found: dict[int, dict[str, STATE]] = {}
        for name, changes in self.states.items():
            for row, value in changes:
                found.setdefault(row, {})[name] = value
        return found


@dataclass
class _Making:
    """A shift while it is made."""

    rate_hz: float
    pause_s: float
    rng: np.random.Generator
    parts: dict[str, list[Array]] = field(default_factory=dict)
    states: dict[str, list[tuple[int, STATE]]] = field(default_factory=dict)
    cuts: list[tuple[int, int]] = field(default_factory=list)
    rows: int = 0

    def say(self, states: dict[str, STATE]) -> None:
        """Have states begin with the next row."""
        for name, value in states.items():
            self.states.setdefault(name, []).append((self.rows, value))

    def cut(self, columns: dict[str, Array], states: dict[str, STATE]) -> None:
        """Add a pause and a cut behind it, which the control calls active."""
        self.pause(columns)
        self.say({"execution": "ACTIVE", **states})
        begin = self.rows
        self._add(columns)
        self.cuts.append((begin, self.rows))
        self.say({"execution": "READY"})

    def pause(self, columns: dict[str, Array]) -> None:
        """Add a pause in which everything stays as it is in the first row, but for noise."""
        rows = round(self.pause_s * self.rate_hz)
        self._add(
            {
                name: column[0] + 0.01 * self.rng.standard_normal(rows)
                for name, column in columns.items()
            }
        )

    def _add(self, columns: dict[str, Array]) -> None:
        for name, column in columns.items():
            self.parts.setdefault(name, []).append(column)
        self.rows += len(next(iter(columns.values())))

    def made(self) -> ServedShift:
        """Return the shift."""
        columns = {name: np.concatenate(parts) for name, parts in self.parts.items()}
        return ServedShift(self.rate_hz, columns, self.states, self.cuts)


def lathe_shift(cuts: int, seed: int) -> ServedShift:
    """Return a shift of the sample lathe: bars turned down, currents of each phase at 1 kHz."""
    making = _Making(LATHE_HZ, PAUSE_S, np.random.default_rng([seed, 120]))
    making.say({"execution": "READY", "tool": 1.0, "work": "none"})
    columns: dict[str, Array] = {}
    for number in range(cuts):
        depth, feed, rpm, diameter = LATHE_CUTS[number % len(LATHE_CUTS)]
        cut = cut_at((depth, feed, rpm, diameter), edge=f"shift-{number}", duration_s=LATHE_CUT_S)
        columns = raw_cut(SAMPLE_LATHE, SAMPLE_PAIR, cut, seed + number, False, rate_hz=LATHE_HZ)
        del columns["t"]
        states: dict[str, STATE] = {
            "work": cut.material,
            "depth": depth,
            "path_feed": feed * rpm,
            "commanded_speed": rpm,
        }
        making.cut(columns, states)
    making.pause(columns)
    return making.made()


def mill_shift(
    cuts: int, seed: int, *, longest_s: float = 4.0, pause_s: float = PAUSE_S
) -> ServedShift:
    """Return a shift of a reference mill: sides, 14 channels at 250 Hz, of each cut the middle."""
    making = _Making(RATE_HZ, pause_s, np.random.default_rng([seed, 121]))
    making.say({"execution": "READY", "tool": 1.0, "work": "none"})
    mill, columns = draw_mill(seed), {}
    for number in range(cuts):
        depth, width, feed, rpm = MILL_CUTS[number % len(MILL_CUTS)]
        cut = MillCut(
            name=f"shift {number}",
            operation="side",
            depth_mm=depth,
            width_mm=width,
            feed_mm_min=feed,
            speed_rpm=rpm,
        )
        made = record_planned(seed, mill, PlannedCut(number, cut, 0, test=False)).channels
        columns = _middle(made, round(longest_s * RATE_HZ))
        states: dict[str, STATE] = {
            "work": "C45",
            "depth": depth,
            "width": width,
            "path_feed": feed,
            "commanded_speed": rpm,
        }
        making.cut(columns, states)
    making.pause(columns)
    return making.made()


def _middle(columns: dict[str, Array], rows: int) -> dict[str, Array]:
    size = len(next(iter(columns.values())))
    first = max(0, (size - rows) // 2)
    return {name: column[first : first + rows] for name, column in columns.items()}
