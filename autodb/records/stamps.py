"""Stamps that come block by block: are they even, so that nothing has to be laid out?"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from autodb.files.side import SideFile
from autodb.records.tables import Array
from autodb.timing import Timing
from autodb.timing.clock import EVEN
from autodb.timing.examined import is_even
from autodb.timing.places import (
    EFFORTS,
    PLACES,
    drawn_between,
    filled_between,
    leaping,
    unwrapped,
)
from autodb.timing.units import doubtful_rate, highest_acceleration

TURNS_ON = "spindle.angle"
"""Turns at constant speed: says nothing of accelerations."""


@dataclass
class StampsSoFar:
    """The stamps of a time base, of which only the ends of blocks are kept.

    ``even``: whether all so far are, and no place wraps or leaps. ``sharpest``: the highest
    acceleration of any place, mm/s²; None where none moved.
    """

    even: bool = True
    sharpest: float | None = None
    _rows: list[int] = field(default_factory=lambda: [0])
    _ends_s: list[float] = field(default_factory=list)

    def add(self, t_s: Array, channels: Mapping[str, Array]) -> None:
        """Take in the next block of stamps (n,), s, and its channels (n,)."""
        if not self.even:
            return
        before = self._ends_s[-1:]
        self.even = is_even(np.concatenate([before, t_s])) and not _odd_places(channels)
        if not before:
            self._ends_s.append(float(t_s[0]))
        self._rows.append(self._rows[-1] + len(t_s) - (not before))
        self._ends_s.append(float(t_s[-1]))
        if self.even:
            ends = np.array(self._ends_s) - self._ends_s[0]
            line = ends[-1] / self._rows[-1] * np.array(self._rows)
            step = ends[-1] / self._rows[-1]
            self.even = bool(np.max(np.abs(ends - line)) <= EVEN * step)
            self._take_sharpest(t_s, channels)

    @property
    def first_s(self) -> float:
        """The first stamp, s."""
        return self._ends_s[0]

    @property
    def last_s(self) -> float:
        """The last stamp, s."""
        return self._ends_s[-1]

    def timing(self) -> Timing:
        """Return the verdict on even stamps."""
        rows = self._rows[-1] + 1
        step_s = (self.last_s - self.first_s) / (rows - 1)
        return Timing(step_s, (slice(0, rows),), rows)

    def _take_sharpest(self, t_s: Array, channels: Mapping[str, Array]) -> None:
        for name, values in channels.items():
            if name.endswith(PLACES) and name != TURNS_ON and np.isfinite(values).all():
                sharp = highest_acceleration(t_s, values)
                if sharp is not None:
                    self.sharpest = max(sharp, self.sharpest or 0.0)


def _odd_places(channels: Mapping[str, Array]) -> bool:
    """Say whether a place wraps or leaps, or it or an effort is refreshed on some rows only."""
    places = {name: values for name, values in channels.items() if name.endswith(PLACES)}
    efforts = {name: values for name, values in channels.items() if name.endswith(EFFORTS)}
    return any(drawn_between(name, one)[1] is not None for name, one in efforts.items()) or any(
        leaping(place).size > 0
        or unwrapped(name, place)[1:] != (None, "")
        or filled_between(name, place)[1] is not None
        for name, place in places.items()
    )


def unit_stated(side: SideFile) -> bool:
    """Say whether a side file states the unit of time, so that a strange one is believed."""
    spec = side.channels.get("t")
    return spec is not None and (
        spec.unit is not None or spec.scale != 1.0 or spec.row_in is not None
    )


def doubt_of_rate(timing: Timing, sharpest: float | None, side: SideFile) -> str:
    """Return what is implausible of stamps taken as seconds; empty where nothing is."""
    return "" if unit_stated(side) else doubtful_rate(timing.step_s, sharpest)
