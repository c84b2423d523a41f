"""What happened in a shop's weeks, when it was named, and what was named that did not happen."""

from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.mismatches import NEW_EDGE
from autodb.proofs.machines.lathe.weeks import BUILT_UP, COMPONENT, FROM_BATCH, PAIRS, Weeks
from autodb.store import models

NAMES = {
    "wear": ("tool_wear",),
    "built-up edge": ("built_up_edge", "speed_softening"),
    "hard batch": ("hard_spot",),
    "calibration": ("gain",),
    "edge change": ("tool_wear",),
}
"""Events, and the terms that name each; a band between two flanks that were hardly cut is a law of
the speed."""
UNKNOWN = "unknown"
WITHIN = 3
"""Cuts of the pair by which an inferred edge change may be off."""


@dataclass(frozen=True)
class Named:
    """An event, or a name that none stands for (``event`` empty, ``term`` the name).

    ``first``: the first batch in which it acts; ``batch``: the first after which it was named;
    ``cuts``: cuts that it acts on until then; None: never.
    """

    event: str
    term: str
    first: int
    batch: int | None
    cuts: int | None


class NamedSoFar:
    """What is named after every batch."""

    def __init__(self, weeks: Weeks) -> None:
        self._weeks = weeks
        self._events = _events(weeks)
        self._batch: dict[tuple[str, int | None], int] = {}
        self._invented: dict[tuple[str, str], int] = {}
        self._waiting: set[int] = set()

    def look(self, session: Session, batch: int) -> list[int]:
        """Look at the open mismatches after a batch; return those to be confirmed, by id."""
        due, waiting = [], set()
        rows = session.scalars(
            select(models.Mismatch)
            .where(models.Mismatch.status == "open")
            .order_by(models.Mismatch.id)
        )
        for row in rows:
            events = self._events_of(row, batch)
            for event in events:
                self._batch.setdefault(event, batch)
            if events:
                if row.id in self._waiting and events[0][0] != "calibration":
                    due.append(row.id)
                waiting.add(row.id)
            elif row.term != UNKNOWN:
                pair = row.pairs[0].material.name if row.pairs else ""
                self._invented.setdefault((row.term, f"{pair} {row.channel}".strip()), batch)
        self._waiting = waiting
        return due

    def outcome(self) -> list[Named]:
        """Return what became of every event, and what was invented."""
        found = [
            Named(
                name, NAMES[name][0], first, at, None if at is None else self._cuts(name, pair, at)
            )
            for (name, pair), first in self._events.items()
            for at in [self._batch.get((name, pair))]
        ]
        invented = [Named("", term, at, at, None) for (term, _), at in self._invented.items()]
        return [*found, *invented]

    def _events_of(self, row: models.Mismatch, batch: int) -> list[tuple[str, int | None]]:
        """Return the events that a mismatch names, of those that have happened by then.

        They are of one kind: a mismatch of a whole file names the wear of every pair in it.
        """
        pairs = [PAIRS.index(one.material.name) for one in row.pairs] or range(len(PAIRS))
        found: list[tuple[str, int | None]] = []
        for (name, pair), first in self._events.items():
            if row.term not in NAMES[name] or first > batch or (found and found[0][0] != name):
                continue
            if self._is_of(row, name, pair, pairs, first):
                found.append((name, pair))
        return found

    def _is_of(
        self, row: models.Mismatch, name: str, pair: int | None, pairs: Sequence[int], first: int
    ) -> bool:
        """Say whether a mismatch with an event's name, of some pairs, is of that event."""
        new_edge = NEW_EDGE in (row.found_in or {})
        if new_edge or name == "edge change":
            return new_edge and name == "edge change" and pair in pairs and self._changed_at(row)
        if pair is None:
            return row.channel == f"force.{COMPONENT[self._weeks.drifts[0]]}"
        return pair in pairs and (name != "hard batch" or self._holds(row, first))

    def _changed_at(self, row: models.Mismatch) -> bool:
        """Say whether an inferred edge change is within some cuts of the one there was."""
        pair, number = self._weeks.unrecorded
        batches = enumerate(self._weeks.batches, start=1)
        own = [
            (f"batch-{batch:02}", k)
            for batch, one in batches
            for k, cut in enumerate(one.cuts, start=1)
            if cut.pair == pair
        ]
        near = own[max(number - 1 - WITHIN, 0) : number + WITHIN]
        interval = row.intervals or []
        at = int(interval[0][1]) if interval else 0
        return any(name in row.recording.path and (not at or at == k) for name, k in near)

    def _holds(self, row: models.Mismatch, batch: int) -> bool:
        """Say whether the recordings of a mismatch hold a batch."""
        return any(f"batch-{batch:02}" in one.path for one in row.recordings)

    def _cuts(self, name: str, pair: int | None, upto: int) -> int:
        """Return how many cuts an event acted on up to a batch."""
        first = self._events[name, pair]
        some = [cut for batch in self._weeks.batches[first - 1 : upto] for cut in batch.cuts]
        own = [cut for cut in some if pair in (None, cut.pair)]
        if name == "built-up edge":
            own = [cut for cut in own if cut.condition == "built-up edge"]
        if name == "hard batch":
            own = own[: len([c for c in self._weeks.batches[first - 1].cuts if c.pair == pair])]
        return len(own)


def _events(weeks: Weeks) -> dict[tuple[str, int | None], int]:
    """Return what happens, to which pair, with the batch, from 1, in which it begins."""
    worn: Sequence[tuple[tuple[str, int | None], int]] = [
        (("wear", k), 1) for k in range(len(PAIRS))
    ]
    pair, batch = weeks.hard
    return {
        **dict(worn),
        ("built-up edge", BUILT_UP): FROM_BATCH + 1,
        ("hard batch", pair): batch + 1,
        ("calibration", None): weeks.drifts[1] + 1,
        ("edge change", weeks.unrecorded[0]): _batch_of(weeks),
    }


def _batch_of(weeks: Weeks) -> int:
    """Return the batch, from 1, in which the edge was changed that nobody recorded."""
    pair, number = weeks.unrecorded
    seen = 0
    for batch, one in enumerate(weeks.batches, start=1):
        seen += sum(cut.pair == pair for cut in one.cuts)
        if seen >= number:
            return batch
    return len(weeks.batches)
