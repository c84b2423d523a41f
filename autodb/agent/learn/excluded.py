"""Cuts that a pair has not learnt from, and the newest version of each of its states."""

from collections.abc import Iterable, Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.posteriors import as_posterior, chain_ids, latest
from autodb.agent.rows.sensed_forces import usable
from autodb.pairs.engaged import CUTTING_TIME
from autodb.store import models


def recordings_of(causes: Iterable[models.Mismatch]) -> set[int]:
    """Return the recordings, by id, that mismatches were found in."""
    return {one.id for row in causes for one in row.recordings}


def newest_states(
    session: Session, machine_id: int, pair_id: int
) -> list[models.CuttingParameters]:
    """Return the newest version of each state of a pair but the usual one."""
    names = session.scalars(
        select(models.CuttingParameters.state)
        .where(
            models.CuttingParameters.machine_id == machine_id,
            models.CuttingParameters.pair_id == pair_id,
            models.CuttingParameters.state.is_not(None),
        )
        .distinct()
    )
    rows = [latest(session, machine_id, pair_id, name) for name in names.all()]
    return [row for row in rows if row is not None]


def excluded_cuts(
    session: Session, machine_id: int, pair_id: int, *, upto: int, newest: int | None = None
) -> Sequence[models.Cut]:
    """Return cuts of a pair, up to an id, that are sensed and of no state that it has learnt.

    ``newest``: of so many cuts of the pair at most, the newest; None: of all.
    """
    states = [latest(session, machine_id, pair_id), *newest_states(session, machine_id, pair_id)]
    usual = states[0]
    if usual is None:
        return []
    versions = chain_ids(row for row in states if row is not None)
    seen = models.cutting_parameters_force.c
    learnt = (
        select(models.SensedForce.cut_id)
        .join(models.cutting_parameters_force, seen.sensed_force_id == models.SensedForce.id)
        .where(seen.cutting_parameters_id.in_(versions))
    )
    after = 0 if newest is None else _before_newest(session, pair_id, upto, newest)
    learnt = learnt.where(models.SensedForce.cut_id > after)
    query = select(models.Cut).where(
        models.Cut.id > after,
        models.Cut.recording.has(machine_id=machine_id),
        models.Cut.pair_id == pair_id,
        models.Cut.id <= upto,
        models.Cut.superseded_at.is_(None),
        models.Cut.id.in_(
            select(models.SensedForce.cut_id).where(
                models.SensedForce.cut_id > after, models.SensedForce.value_N.is_not(None)
            )
        ),
        models.Cut.id.not_in(learnt),
    )
    cuts = session.scalars(query.order_by(models.Cut.id)).all()
    worn = as_posterior(usual).wear is not None
    return [cut for cut in cuts if usable(cut) and (not worn or CUTTING_TIME in cut.conditions)]


def _before_newest(session: Session, pair_id: int, upto: int, newest: int) -> int:
    """Return the id of the cut of a pair before its newest ones; 0 where it has no more."""
    query = select(models.Cut.id).where(models.Cut.pair_id == pair_id, models.Cut.id <= upto)
    return session.scalar(query.order_by(models.Cut.id.desc()).offset(newest).limit(1)) or 0
