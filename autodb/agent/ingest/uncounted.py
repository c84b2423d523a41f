"""Cuts that rest: of a recording that was only looked at, or that was withdrawn."""

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.redelivered import twins
from autodb.agent.rows.counted_edges import count_edges
from autodb.store import models

COPIED = (
    *("recording_id", "pair_id", "operation", "conditions", "measured", "content"),
    *("started_at", "state", "named", "lot"),
)


def counted(session: Session, number: int) -> None:
    """Have the cuts of a recording that was only looked at count; of any other, nothing changes."""
    row = session.get_one(models.StoredRecording, number)
    if row.looked_at is not None:
        anew(session, row, since=row.looked_at)
        row.looked_at = None


def anew(session: Session, row: models.StoredRecording, *, since: str) -> None:
    """Have cuts of a recording count that do not since a moment.

    Those that nobody has sensed yet count as if they came in now.

    Those that are there in another recording meanwhile stay with that. A cut that comes in is newer
    than all others, by its id: passes go on from the newest that the last one looked at.
    """
    resting = [cut for cut in row.cuts if cut.superseded_at == since]
    there = twins(session, row.machine_id, resting)
    sensed = set(
        session.scalars(
            select(models.SensedForce.cut_id)
            .join(models.Cut)
            .where(models.Cut.recording_id == row.id)
        )
    )
    back = [cut for cut in resting if cut.content is None or cut.content not in there]
    for cut in back:
        if cut.id in sensed:
            cut.superseded_at = None
    come_in = _come_in(session, [cut for cut in back if cut.id not in sensed])
    session.expire(row, ["cuts"])
    count_edges(session, row.machine_id, [*(c for c in back if c.id in sensed), *come_in])


def _come_in(session: Session, cuts: Sequence[models.Cut]) -> list[models.Cut]:
    """Put new cuts in the place of some; return them."""
    numbers = {cut.id: cut.number for cut in cuts}
    for place, cut in enumerate(cuts, start=1):
        cut.number = -float(place)  # its number is another's now
    session.flush()
    made = [
        models.Cut(number=numbers[cut.id], **{name: getattr(cut, name) for name in COPIED})
        for cut in cuts
    ]
    session.add_all(made)
    session.flush()
    for cut in cuts:
        session.delete(cut)
    session.flush()
    return made
