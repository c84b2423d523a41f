"""Cuts as they happen: out of values that come in come the rows of each cut.

Nothing here looks at a clock or a file: the same batches give the same cuts, so that a journal
that is read again after a kill gives again what was not written.
"""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from autodb.live.agentfile import AgentFile
from autodb.live.batch import Batch, Value

SETTLE_S = 1.0
"""How much later than another item's value a value may come in. Chosen: five publishing cycles."""

ON_GRID = 0.01
"""By how much of a row instants are off for being s since 1970 in double precision, and more."""


FEWEST_STEPS, SELDOM = 5, 1.5
"""An item came seldom where so many of its steps are known, and their median is longer than so many
rows. Chosen."""


@dataclass(frozen=True)
class LiveCut:
    """A cut as it was recorded.

    ``start_s``: the instant (s since 1970) of row 0; ``begin_s`` and ``end_s`` of the cut itself.
    ``t`` (n,) s from row 0; ``columns`` (n,) each, NaN where the machine did not know. ``said``: by
    section and key, what items told in the middle of the cut. ``cut_off``: something is missing
    behind its end. ``seldom``: of a column whose item came less often than once a row, the time
    from one to the next, s.
    """

    start_s: float
    begin_s: float
    end_s: float
    t: NDArray[np.float64]
    columns: dict[str, NDArray[np.float64]]
    said: dict[str, Value]
    cut_off: bool = False
    seldom: dict[str, float] = field(default_factory=dict)


@dataclass
class _Series:
    """The values of one item, as far back as they are needed."""

    instants: list[float] = field(default_factory=list)
    values: list[Value] = field(default_factory=list)

    def add(self, instants: list[float], values: list[Value]) -> int:
        """Add values; return how many came too late for their place."""
        late = 0
        for instant, value in zip(instants, values, strict=True):
            if self.instants and instant < self.instants[-1]:
                late += 1
            elif self.instants and instant == self.instants[-1]:
                self.values[-1] = value
            else:
                self.instants.append(instant)
                self.values.append(value)
        return late

    def at(self, instant: float) -> Value:
        """Return what was said last by then; None: nothing."""
        place = bisect_right(self.instants, instant)
        return self.values[place - 1] if place else None

    def forget(self, before: float) -> None:
        """Forget what is not needed to know every value from ``before`` on."""
        place = bisect_right(self.instants, before) - 1
        if place > 0:
            del self.instants[:place], self.values[:place]


@dataclass
class _Cutting:
    """Since when it cuts, and since when not any more; None: it does not cut, or still does."""

    begin_s: float
    off_s: float | None = None


@dataclass(frozen=True)
class _Ended:
    begin_s: float
    end_s: float
    cut_off: bool = False


class Segmenter:
    """Tells cuts from what is between them, batch by batch.

    ``done_s``: what was cut before it was written already.
    """

    def __init__(self, plan: AgentFile, *, done_s: float = -np.inf) -> None:
        self._plan, self._done_s = plan, done_s
        self._series: dict[str, _Series] = {item: _Series() for item in plan.items()}
        self._heard_s = self._looked_s = self._floor_s = -np.inf
        self._cutting: _Cutting | None = None
        self._ended: list[_Ended] = []
        self._lost = True
        self.late = 0
        """How many values came in too late for their place."""

    @property
    def cutting_since_s(self) -> float | None:
        """Since when it cuts; None: it does not."""
        return None if self._cutting is None else self._cutting.begin_s

    @property
    def needs_from_s(self) -> float:
        """From when on values may still be needed."""
        begins = [one.begin_s for one in self._ended]
        if self._cutting is not None:
            begins.append(self._cutting.begin_s)
        least = min([self._looked_s, *begins]) - self._plan.cut.before_s
        return max(least, self._floor_s)

    def latest(self) -> dict[str, tuple[float, Value]]:
        """Return the newest value of each item, with its instant."""
        return {
            item: (series.instants[-1], series.values[-1])
            for item, series in self._series.items()
            if series.instants
        }

    def take(self, batch: Batch) -> list[LiveCut]:
        """Take in what was said; return the cuts that are whole by now, in turn."""
        found = self.ended() if batch.gap else []
        for item, (instants, values) in batch.values.items():
            series = self._series.get(item)
            if series is not None:
                self.late += series.add(instants, values)
        self._heard_s = max(self._heard_s, batch.upto_s)
        if self._lost and not self._found_again():
            return found
        self._look(self._heard_s - SETTLE_S)
        found += self._whole()
        self._forget()
        return found

    def ended(self) -> list[LiveCut]:
        """End what is open, as what was said next is not known; begin anew behind it."""
        self._look(self._heard_s)
        if self._cutting is not None:
            end = self._heard_s if self._cutting.off_s is None else self._cutting.off_s
            self._ended.append(_Ended(self._cutting.begin_s, end, cut_off=True))
            self._cutting = None
        found = self._whole(everything=True)
        self._series = {item: _Series() for item in self._series}
        self._floor_s, self._lost = self._heard_s, True
        return found

    def _found_again(self) -> bool:
        """Say whether channels were heard, at first or behind a gap; then cuts may begin there."""
        firsts = []
        for item in self._plan.channels.values():
            instants = self._series[item.item].instants
            firsts += instants[bisect_right(instants, self._floor_s) :][:1]
        if firsts:
            self._floor_s = self._looked_s = max(firsts)
            self._lost = False
        return not self._lost

    def _look(self, upto_s: float) -> None:
        """Follow what must hold while it cuts, up to an instant."""
        if upto_s <= self._looked_s:
            return
        for instant in self._changes(upto_s):
            self._part(instant)
            self._switch(instant, self._holds(instant))
        self._looked_s = upto_s
        self._part(upto_s)
        off_s = None if self._cutting is None else self._cutting.off_s
        if off_s is not None and upto_s - off_s >= self._plan.cut.pause_s:
            self._end(off_s)

    def _part(self, upto_s: float) -> None:
        """End a part of a cut that is as long as may be, and begin the next."""
        longest_s = self._plan.cut.longest_s
        while (cutting := self._cutting) is not None:
            end = upto_s if cutting.off_s is None else cutting.off_s
            if end - cutting.begin_s <= longest_s:
                return
            self._end(cutting.begin_s + longest_s)
            self._cutting = _Cutting(cutting.begin_s + longest_s, cutting.off_s)

    def _changes(self, upto_s: float) -> list[float]:
        """Return the instants at which something was said of what must hold, in turn."""
        found = set() if np.isneginf(self._looked_s) else {self._looked_s}  # what came late
        for condition in self._plan.cut.while_:
            instants = self._series[condition.item].instants
            first, last = (bisect_right(instants, end) for end in (self._looked_s, upto_s))
            found.update(instants[first:last])
        return sorted(found)

    def _holds(self, instant: float) -> bool:
        return all(one.holds(self._series[one.item].at(instant)) for one in self._plan.cut.while_)

    def _switch(self, instant: float, holds: bool) -> None:
        cutting, rules = self._cutting, self._plan.cut
        if not holds:
            if cutting is not None and cutting.off_s is None:
                cutting.off_s = instant
        elif cutting is None:
            self._cutting = _Cutting(max(instant, self._done_s))
        elif cutting.off_s is not None:
            if instant - cutting.off_s < rules.pause_s:
                cutting.off_s = None
            else:
                self._end(cutting.off_s)
                self._cutting = _Cutting(max(instant, self._done_s))

    def _end(self, end_s: float) -> None:
        if self._cutting is not None:
            self._ended.append(_Ended(self._cutting.begin_s, end_s))
            self._cutting = None

    def _whole(self, *, everything: bool = False) -> list[LiveCut]:
        """Return the cuts that nothing more can belong to."""
        found = []
        while self._ended:
            one = self._ended[0]
            follower = self._next_begin()
            stop = min(one.end_s + self._plan.cut.after_s, follower)
            if not everything and self._looked_s < stop:
                break
            self._ended.pop(0)
            if one.end_s > one.begin_s and one.end_s - one.begin_s >= self._plan.cut.least_s:
                found.append(self._cut(one, stop))
        return found

    def _next_begin(self) -> float:
        """Return when the cut behind the first that ended begins."""
        begins = [one.begin_s for one in self._ended[1:2]]
        if self._cutting is not None:
            begins.append(self._cutting.begin_s)
        return min(begins, default=np.inf)

    def _cut(self, one: _Ended, stop_s: float) -> LiveCut:
        plan = self._plan
        low = max(one.begin_s - plan.cut.before_s, self._floor_s)
        instants = [self._series[item.item].instants for item in plan.channels.values()]
        firsts = [at[place] for at in instants if (place := bisect_left(at, low)) < len(at)]
        lasts = [at[place - 1] for at in instants if (place := bisect_right(at, stop_s))]
        start = min([one.begin_s, *(first for first in firsts if first < stop_s)])
        end = min(stop_s, max([one.end_s, *lasts]) if lasts else stop_s)
        rows = max(1, int(np.floor((end - start) * plan.rate_hz + ON_GRID)) + 1)
        t = np.arange(rows) / plan.rate_hz
        columns = {
            name: self._held(item.item, start + t + 0.5 / plan.rate_hz)
            for name, item in plan.channels.items()
        }
        middle = 0.5 * (one.begin_s + one.end_s)
        said = {key: self._series[told.item].at(middle) for key, told in plan.said().items()}
        seldom = self._seldom(start, end)
        return LiveCut(start, one.begin_s, one.end_s, t, columns, said, one.cut_off, seldom)

    def _seldom(self, start_s: float, end_s: float) -> dict[str, float]:
        """Return the time between an item's values, s, of columns whose rows repeat them."""
        found = {}
        for name, item in self._plan.channels.items():
            instants = np.array(self._series[item.item].instants)
            steps = np.diff(instants[(instants >= start_s) & (instants <= end_s)])
            if steps.size >= FEWEST_STEPS and np.median(steps) * self._plan.rate_hz > SELDOM:
                found[name] = float(np.median(steps))
        return found

    def _held(self, item: str, instants: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the newest number that an item said by each instant; NaN: none."""
        series = self._series[item]
        said = np.array([np.nan, *(_number(value) for value in series.values)])
        return said[np.searchsorted(np.array(series.instants), instants, side="right")]

    def _forget(self) -> None:
        needed = self.needs_from_s
        for series in self._series.values():
            series.forget(needed)


def _number(value: Value) -> float:
    try:
        return np.nan if value is None else float(value)
    except ValueError:
        return np.nan
