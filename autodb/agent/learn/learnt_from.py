"""What a pair learnt from, its cuts' operations and the ranges of what they state, and what not."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy import bindparam, func, literal_column, select
from sqlalchemy.orm import Session

from autodb.agent.rows.posteriors import as_posterior, chain_ids, latest
from autodb.agent.rows.recorded_edges import cut_before_column, cut_before_s
from autodb.agent.rows.sensed_forces import usable
from autodb.pairs.engaged import CUTTING_TIME, DEPTH, FEED, FLANK_WEAR, SPEED, UNSAID
from autodb.store import models
from autodb.store.models.learning import cutting_parameters_force

CHANNELS = (DEPTH, FEED, SPEED, CUTTING_TIME, FLANK_WEAR)
"""What a cut's ranges are kept of."""


@dataclass(frozen=True)
class LearntFrom:
    """``operations`` that were cut; ``ranges``: lowest and highest of a channel, where stated."""

    operations: frozenset[str]
    ranges: Mapping[str, tuple[float, float]]


_PARAMETERS, _CUT, _FORCE = map(
    models.table_of, (models.CuttingParameters, models.Cut, models.SensedForce)
)
_versions = (
    select(_PARAMETERS.c.id, _PARAMETERS.c.previous_id)
    .where(_PARAMETERS.c.id == bindparam("newest"))
    .cte("versions", recursive=True)
)
_versions = _versions.union_all(
    select(_PARAMETERS.c.id, _PARAMETERS.c.previous_id).join(
        _versions, _PARAMETERS.c.id == _versions.c.previous_id
    )
)
_stated = [
    cut_before_column(_CUT.c) if name == CUTTING_TIME else _CUT.c.conditions[name].as_float()
    for name in CHANNELS
]
_operation = func.coalesce(_CUT.c.operation, literal_column(f"'{UNSAID}'"))
_used = cutting_parameters_force.c
_LEARNT_FROM = (
    select(
        _operation,
        *(end(one) for one in _stated for end in (func.min, func.max)),
    )
    .select_from(_versions)
    .join(cutting_parameters_force, _used.cutting_parameters_id == _versions.c.id)
    .join(_FORCE, _FORCE.c.id == _used.sensed_force_id)
    .join(_CUT, _CUT.c.id == _FORCE.c.cut_id)
    .group_by(_operation)
)
"""Of a version and those it was built on, one row an operation."""


def learnt_from(session: Session, parameters_id: int) -> LearntFrom:
    """Return what the cuts of a version and of those before it were."""
    rows = session.connection().execute(_LEARNT_FROM, {"newest": parameters_id}).all()
    ranges = {}
    for k, name in enumerate(CHANNELS):
        low = [row[2 * k + 1] for row in rows if row[2 * k + 1] is not None]
        high = [row[2 * k + 2] for row in rows if row[2 * k + 2] is not None]
        if low:
            ranges[name] = (min(low), max(high))
    return LearntFrom(frozenset(row[0] for row in rows), ranges)


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
    after = 0 if newest is None else _before_newest(session, pair_id, upto, newest)
    first = 0 if after == 0 else _first_to_learn(session, after)
    versions = chain_ids((row for row in states if row is not None), down_to=first)
    seen = models.cutting_parameters_force.c
    learnt = (
        select(models.SensedForce.cut_id)
        .join(models.cutting_parameters_force, seen.sensed_force_id == models.SensedForce.id)
        .where(seen.cutting_parameters_id.in_(versions), models.SensedForce.cut_id > after)
    )
    query = select(models.Cut).where(
        models.Cut.id > after,
        models.Cut.recording.has(machine_id=machine_id),
        models.Cut.pair_id == pair_id,
        models.Cut.id <= upto,
        models.counting_cut(models.Cut.superseded_at),
        models.Cut.id.in_(
            select(models.SensedForce.cut_id).where(
                models.SensedForce.cut_id > after, models.SensedForce.value_N.is_not(None)
            )
        ),
        models.Cut.id.not_in(learnt),
    )
    cuts = session.scalars(query.order_by(models.Cut.id)).all()
    worn = as_posterior(usual).wear is not None
    return [cut for cut in cuts if usable(cut) and (not worn or cut_before_s(cut) is not None)]


def _first_to_learn(session: Session, after: int) -> int:
    """Return the first version, by id, that learnt forces of cuts behind one; 0: none has."""
    seen = models.cutting_parameters_force.c
    query = (
        select(func.min(seen.cutting_parameters_id))
        .join(models.SensedForce, seen.sensed_force_id == models.SensedForce.id)
        .where(models.SensedForce.cut_id > after)
    )
    return session.scalar(query) or 0


def _before_newest(session: Session, pair_id: int, upto: int, newest: int) -> int:
    """Return the id of the cut of a pair before its newest ones; 0 where it has no more."""
    query = select(models.Cut.id).where(models.Cut.pair_id == pair_id, models.Cut.id <= upto)
    return session.scalar(query.order_by(models.Cut.id.desc()).offset(newest).limit(1)) or 0
