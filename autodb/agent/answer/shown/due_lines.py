"""What waits for a person on a machine: a calibration, a decision, a refresh."""

from collections.abc import Iterable
from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.learn.passes import last_passes_of
from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.refresh_cursor import last_mark
from autodb.store import models
from autodb.terms.vocabulary import effect_called
from autodb.wording import phrase, phrase_many
from autodb.wording.kept import said_again


@dataclass(frozen=True)
class DueLine:
    """Something that waits for a person: in words, and what it is about, by kind and number."""

    kind: str
    number: int | None
    words: str


def due_on(session: Session, machine: str) -> list[DueLine]:
    """Return what waits for a person on a machine; raises NotThere for an unknown one."""
    return list(_due(session, find_machine(session, machine)))


def _due(session: Session, owner: models.Machine) -> Iterable[DueLine]:
    """Yield what waits: calibrations as the last refresh said, mismatches, recordings."""
    for done in last_passes_of(session, owner.id, most=1):
        for said in done.done.due:
            what = said_again(said)
            yield DueLine("calibration", None, phrase("Calibrate {what}", what=what))
    mismatch, table = models.Mismatch, models.StoredRecording
    open_ones = select(mismatch).join(table, table.id == mismatch.recording_id)
    own = table.machine_id == owner.id, mismatch.status == "open"
    for one in session.scalars(open_ones.where(*own).order_by(mismatch.id)):
        said = phrase(
            "Decide on mismatch {number}: {effect}",
            number=one.id,
            effect=phrase(effect_called(one.term).title),
        )
        yield DueLine("mismatch", one.id, said)
    mark, cut = last_mark(session, owner.id), models.Cut
    new = cut.id > (mark.cut if mark else 0), models.counting_cut(cut.superseded_at)
    waiting = session.scalar(
        select(func.count(cut.recording_id.distinct()))
        .join(table, table.id == cut.recording_id)
        .where(table.machine_id == owner.id, *new)
    )
    if waiting:
        words = phrase_many(
            "{count} recording came since the last refresh",
            "{count} recordings came since the last refresh",
            waiting,
        )
        yield DueLine("recording", None, words)
