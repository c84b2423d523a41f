"""Lots of material: the cuts of a hard spot that a person says a lot's name of."""

from collections.abc import Iterable

from sqlalchemy.orm import Session

from autodb.agent.learn.learnt_from import excluded_cuts
from autodb.agent.rows.recordings import counted_cuts
from autodb.agent.rows.sensed_forces import usable
from autodb.errors import UnusableInput
from autodb.store import models
from autodb.wording import listed, phrase


def cuts_of_spot(session: Session, row: models.Mismatch, *, upto: int) -> list[models.Cut]:
    """Return the cuts, up to an id, that a hard spot was found in.

    From its first to its last cut where it is of one recording, else those that are excluded from
    their pair's normal cutting state.
    """
    numbers = [row.parameters[end]["value"] for end in ("first", "last") if end in row.parameters]
    cuts = [cut for one in row.recordings for cut in counted_cuts(one) if usable(cut)]
    if row.pairs:
        cuts = [cut for cut in cuts if cut.pair in row.pairs]
    if len(numbers) == len(("first", "last")) and not row.further:
        return [cut for cut in cuts if min(numbers) <= cut.number <= max(numbers)]
    excluded = set(_excluded(session, row, cuts, upto=upto))
    return [cut for cut in cuts if cut.id in excluded]


def _excluded(
    session: Session, row: models.Mismatch, cuts: Iterable[models.Cut], *, upto: int
) -> Iterable[int]:
    machine = row.recording.machine_id
    for pair in {cut.pair_id for cut in cuts if cut.pair_id is not None}:
        yield from (cut.id for cut in excluded_cuts(session, machine, pair, upto=upto))


def name_lot(session: Session, row: models.Mismatch, lot: str | None, *, upto: int) -> None:
    """Keep with a hard spot which lot it is of, and name its cuts so that nobody named.

    ``lot``: None where the cuts themselves say it; without either, nothing changes. Raises
    UnusableInput where all cuts are said to be of another lot.
    """
    cuts = cuts_of_spot(session, row, upto=upto)
    stated = {cut.lot for cut in cuts if cut.lot is not None}
    if lot is None and len(stated) == 1 and all(cut.lot is not None for cut in cuts):
        (lot,) = stated
    if lot is None:
        return
    unnamed = [cut for cut in cuts if cut.lot is None]
    if not unnamed and lot not in stated:
        where = (
            phrase("its cuts are of lot {names}", names=listed(sorted(stated), phrase(" and ")))
            if stated
            else phrase("it has no cut")
        )
        raise UnusableInput(
            phrase(
                "--lot: mismatch {number} stays open: {where}, not of '{lot}'",
                number=row.id,
                where=where,
                lot=lot,
            )
        )
    for cut in unnamed:
        cut.lot = lot
    row.applied = {**(row.applied or {}), "lot": lot, "cuts": [cut.id for cut in unnamed]}
    session.flush()


def forget_lot(session: Session, row: models.Mismatch) -> None:
    """Take the name of a lot off the cuts that a decision gave it to."""
    for number in (row.applied or {}).get("cuts", ()):
        cut = session.get(models.Cut, number)
        if cut is not None:
            cut.lot = None
