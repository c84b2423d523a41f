"""The edge that a cut was made with, also where it was changed and nobody recorded it.

An inferred change is a mismatch of its pair (``autodb.agent.learn.inferred_edges``). Until a person
rejects it, cuts from it on count as made with a new edge, which had then cut nothing: of an edge
that a file states, or that a recorded change began (``recorded_edges``).
"""

from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session, object_session

from autodb.agent.rows.mismatches import NEW_EDGE
from autodb.agent.rows.recorded_edges import (
    Conditions,
    cut_before_column,
    cut_before_s,
    edge_label,
    recorded_conditions,
)
from autodb.pairs.changes.edge_changes import AROUND
from autodb.pairs.engaged import CUTTING_TIME, EDGE
from autodb.store import models


@dataclass(frozen=True)
class InferredChange:
    """Of a pair's edge, as it was written down, the first cut, by id, that a new one made.

    ``used_s``: for how long the old one had cut then, as written down; ``upto``: the last cut, by
    id, that the label was not used for anew; None: it was not.
    """

    mismatch: int
    edge: str | None
    first: int
    number: float
    used_s: float
    upto: int | None

    def holds(self, cut: models.Cut) -> bool:
        """Say whether a cut was made after the change, with what is written down as that edge."""
        used_s = cut_before_s(cut)
        return (
            cut.id >= self.first
            and (self.upto is None or cut.id <= self.upto)
            and edge_label(cut) == self.edge
            and used_s is not None
            and used_s >= self.used_s
        )


def inferred_changes(session: Session, pair_id: int) -> list[InferredChange]:
    """Return the edge changes of a pair that were inferred and that nobody has rejected."""
    rows = session.scalars(
        select(models.Mismatch)
        .where(
            models.Mismatch.pairs.any(models.Pair.id == pair_id),
            models.Mismatch.status != "rejected",
            models.Mismatch.found_in.is_not(None),
        )
        .order_by(models.Mismatch.id)
    )
    found = []
    for row in rows:
        if row.found_in is not None and NEW_EDGE in row.found_in:
            first = session.get_one(models.Cut, row.found_in[NEW_EDGE])
            found.append(_change(session, row.id, first))
    return [one for one in found if one is not None]


def _change(session: Session, mismatch: int, first: models.Cut) -> InferredChange | None:
    """Return a change before a cut; None: by what a person recorded since, it is none."""
    edge, used_s = edge_label(first), cut_before_s(first)
    if used_s is None or not _stands(session, first):
        return None
    later = session.scalars(
        select(models.Cut)
        .where(
            models.Cut.pair_id == first.pair_id,
            models.Cut.id > first.id,
            cut_before_column() < used_s,
        )
        .order_by(models.Cut.id)
    )
    anew = next((cut.id for cut in later if edge_label(cut) == edge), None)
    upto = None if anew is None else anew - 1
    return InferredChange(mismatch, edge, first.id, first.number, used_s, upto)


def _stands(session: Session, first: models.Cut) -> bool:
    """Say whether the cuts that a change was inferred from are of one edge still, as recorded."""
    own = select(models.Cut.edge_change_id).where(
        models.Cut.recording.has(machine_id=first.recording.machine_id),
        models.Cut.pair_id == first.pair_id,
        models.counting_cut(models.Cut.superseded_at),
    )
    before = own.where(models.Cut.id < first.id).order_by(models.Cut.id.desc()).limit(AROUND)
    after = own.where(models.Cut.id >= first.id).order_by(models.Cut.id).limit(AROUND)
    near = [*session.scalars(before), *session.scalars(after)]
    return all(one == first.edge_change_id for one in near)


def conditions_in_use(cuts: Sequence[models.Cut]) -> list[Conditions]:
    """Return the conditions of a pair's cuts, with the edges that they were made with."""
    session = object_session(cuts[0]) if cuts else None
    pair = cuts[0].pair_id if cuts else None
    changes = [] if session is None or pair is None else inferred_changes(session, pair)
    return [_in_use(cut, changes) for cut in cuts]


def _in_use(cut: models.Cut, changes: Sequence[InferredChange]) -> Conditions:
    """Return a cut's conditions after the last change that holds for it."""
    last = max((one for one in changes if one.holds(cut)), key=lambda c: c.used_s, default=None)
    known = recorded_conditions(cut)
    if last is None:
        return known
    used_s = float(known[CUTTING_TIME]) - last.used_s
    name = f"{last.edge or 'edge'}, new at cut {last.number:g} ({last.mismatch})"
    return {**known, EDGE: name, CUTTING_TIME: used_s}
