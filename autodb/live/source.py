"""What both protocols share: a source of batches, and what a machine offers."""

import math
import time
from collections.abc import AsyncGenerator, Iterable
from dataclasses import dataclass
from typing import Protocol

from autodb.errors import UnusableInput, near
from autodb.live.batch import Batch, Position, Said, Value

QUIET_S = 10.0
"""For how long nothing must be said before time is taken to have gone on. Chosen: while a machine
cuts, its currents are never quiet for that long, and a stalled line is mostly back by then."""
STRAGGLE_S = 5.0
"""For how long after a clock was set values by the old one are passed over. Chosen."""
JUMP_S = 10.0
"""From how far apart channels count as said by a clock that was set. Chosen: as QUIET_S."""
BACK_S = 0.5
"""The same of one channel that goes back behind what it said itself: what one item says comes in
its order, and the stamps of one device jitter by less. Chosen."""


class Away(UnusableInput):
    """A machine that does not answer now; later it may."""


@dataclass(frozen=True)
class Offered:
    """An item that a machine offers: its name in an agent file, what it is called there, its kind
    and unit as far as they are said, and what it says now.
    """

    item: str
    called: str
    kind: str
    unit: str
    value: Value = None


class LiveSource(Protocol):
    """A machine as it is read."""

    def batches(self, after: Position | None) -> AsyncGenerator[Batch, None]:
        """Yield what is said from now on, or from behind ``after``, as far as the machine kept it.

        Raises Away where the machine does not answer any more, UnusableInput for an item that it
        does not have.
        """

    async def offered(self) -> list[Offered]:
        """Return what the machine offers; raises Away."""

    async def units(self) -> dict[str, str]:
        """Return the units in which items are sent, where the machine says them; raises Away."""


@dataclass(frozen=True)
class HeardValues:
    """What was said by one clock up to ``upto_s``; ``jump``: it was set just before."""

    values: Said
    upto_s: float
    jump: bool


class SourceClock:
    """Up to when all was said: by the newest instant, after a long quiet by our own clock.

    ``channels``: the items whose instants tell that the machine's clock was set; states may be old.
    """

    def __init__(self, channels: Iterable[str], upto_s: float) -> None:
        self._channels, self._sampled_s = frozenset(channels), upto_s
        self.upto_s, self._moved = upto_s, time.monotonic()
        self._was: tuple[float, float, float] | None = None
        self._sampled_at: float | None = None
        self._newest: dict[str, float] = {}

    def heard(self, values: Said) -> list[HeardValues]:
        """Return what was said, in parts between which the machine's clock was set."""
        parts: list[HeardValues] = []
        jump = False
        if self._was is not None and self._straggles(*self._was):
            _, values = self._parted(values, *self._was[:2])
        while (found := self._set(values)) is not None:
            before, values = self._parted(values, *found)
            if before:
                parts.append(self._part(before, jump=jump))
            self._sampled_s, jump = found[1], True
            self._newest = {}
            self._was = (*found, time.monotonic())
        return [*parts, self._part(values, jump=jump)]

    @staticmethod
    def _straggles(old: float, new: float, when: float) -> bool:
        """Say whether the clock was set just now, by so much that its old values are known."""
        return abs(old - new) > JUMP_S and time.monotonic() - when < STRAGGLE_S

    def _part(self, values: Said, *, jump: bool) -> HeardValues:
        for item, (said, _) in values.items():
            self._newest[item] = max(*said, self._newest.get(item, -math.inf))
        sampled = [said[-1] for item, (said, _) in values.items() if item in self._channels]
        if sampled:
            self._sampled_s = max(self._sampled_s, *sampled)
            self._sampled_at = time.monotonic()
        newest = max((said[-1] for said, _ in values.values()), default=-math.inf)
        quiet_s = time.monotonic() - self._moved
        if jump:
            self.upto_s, self._moved = self._sampled_s, time.monotonic()
        elif newest > self.upto_s:
            self.upto_s, self._moved = newest, time.monotonic()
        elif quiet_s > QUIET_S:
            self.upto_s, self._moved = self.upto_s + quiet_s, time.monotonic()
        return HeardValues(values, self.upto_s, jump)

    def _set(self, values: Said) -> tuple[float, float] | None:
        """Return the instants between which the clock was set: the last before, the first after.

        By the channel that said most; ahead, where it is by more than the time that passed here,
        and no other said anything in between; back, where it is far behind all, or clearly behind
        what it said itself.
        """
        sampled = [said for item, (said, _) in values.items() if item in self._channels]
        last = self._sampled_s
        quiet_s = math.inf if self._sampled_at is None else time.monotonic() - self._sampled_at
        most = max(
            (item for item in values if item in self._channels),
            key=lambda item: len(values[item][0]),
            default="",
        )
        own = self._newest.get(most, -math.inf)
        for instant in values[most][0] if most else []:
            between = (last < other < instant for said in sampled for other in said)
            ahead = instant > last + quiet_s + JUMP_S and not any(between)
            if ahead or instant < last - JUMP_S:
                return (last, instant) if math.isfinite(last) else None
            if instant < own - BACK_S:
                return own, instant
            last, own = instant, max(own, instant)
        return None

    def _parted(self, values: Said, old: float, new: float) -> tuple[Said, Said]:
        """Return what was said by the clock that was at ``old``, and by it set to ``new``."""
        before: Said = {}
        after: Said = {}
        for item, (instants, said) in values.items():
            if abs(old - new) > JUMP_S:
                set_at = (k for k, at in enumerate(instants) if abs(at - new) < abs(at - old))
                place = next(set_at, len(instants))
            else:
                place = _goes_back(instants, self._newest.get(item, -math.inf))
            if place:
                before[item] = (instants[:place], said[:place])
            if place < len(instants):
                after[item] = (instants[place:], said[place:])
        return before, after


def _goes_back(instants: list[float], newest: float) -> int:
    """Return where an item goes back behind what it said itself; how many there are: nowhere."""
    for place, instant in enumerate(instants):
        if instant < newest - BACK_S:
            return place
        newest = max(newest, instant)
    return len(instants)


def unknown_item(url: str, item: str, known: Iterable[str]) -> UnusableInput:
    """Return the refusal of an item that a machine does not have."""
    return UnusableInput(
        f"{url}: has no item '{item}'{near(item, known)}; list its items with --list"
    )
