"""How far a machine's refresh has come: a pass goes on from the mark that the last one left.

What a pass costs is then what came in since. Where what senses forces, or what a person decided, is
no longer what it was (``basis_of``), every cut is examined once more.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.rows.calibrations import current_calibrations
from autodb.agent.rows.estimators import FUSION, newest
from autodb.store import models

CUTS_A_PASS = 2000
"""New cuts that one pass takes: as much as a kill may undo. Chosen: some ten seconds' work."""
SENSED_OVER_TIME = ("drive", "table", FUSION)
"""Kinds of estimators that sense cuts which were recorded over time, the surest last."""

CALIBRATIONS, ESTIMATORS, DYNAMOMETER = SENSORS = ("calibrations", "estimators", "dynamometer")
"""Of a basis, what forces are sensed with, or measured."""
ASKED = "asked"
"""Beside what a pass did its work by: what it, or one before it, explained and of what evidence."""


@dataclass(frozen=True)
class Mark:
    """The last cut and the last sensed force that passes have examined, by id; what by.

    ``asked``: what was explained and of what evidence, as the pass kept it.
    """

    cut: int
    force: int
    basis: Mapping[str, Any]
    asked: Sequence[Mapping[str, Any]] = ()


@dataclass(frozen=True)
class Span:
    """What a pass looks at: cuts with ids above ``after`` and up to ``upto`` are sensed.

    ``old`` and ``force``: the cut and the sensed force up to which passes before have come;
    ``anew``: of every pair all forces are examined again, not those of new cuts alone.
    """

    after: int
    upto: int
    old: int
    force: int
    anew: bool


def last_mark(session: Session, machine_id: int) -> Mark | None:
    """Return the mark of a machine's last pass; None where none left one."""
    one = models.table_of(models.RefreshPass).c
    query = (
        select(one.last_cut_id, one.last_force_id, one.basis)
        .where(one.machine_id == machine_id, one.last_cut_id.is_not(None))
        .order_by(one.id.desc())
        .limit(1)
    )
    row = session.connection().execute(query).first()
    if row is None:
        return None
    basis = dict(row.basis or {})
    asked = basis.pop(ASKED, ())
    return Mark(row.last_cut_id, row.last_force_id or 0, basis, asked)


def basis_of(session: Session, owner: models.Machine) -> dict[str, Any]:
    """Return what forces are sensed with now, and what was decided of them."""
    axes = [axis.name for axis in owner.axes]
    ranges = [row.id for name in axes for row in current_calibrations(session, owner.id, name)]
    others = [row.id for kind in SENSED_OVER_TIME for row in newest(session, owner.id, kind)]
    return {
        CALIBRATIONS: ranges,
        ESTIMATORS: others,
        DYNAMOMETER: owner.dynamometer or {},
        "decided": _decided(session, owner.id),
        "superseded": _superseded(session, owner.id),
        "undone": _undone(session, owner.id),
        **_recounted(session, owner.id),
    }


def _decided(session: Session, machine_id: int) -> list[Any]:
    """Return how many mismatches of a machine are decided, and when the last was."""
    row = session.execute(
        select(func.count(), func.max(models.Mismatch.decided_at))
        .select_from(models.Mismatch)
        .join(models.StoredRecording)
        .where(models.StoredRecording.machine_id == machine_id, models.Mismatch.status != "open")
    ).one()
    return list(row)


def _superseded(session: Session, machine_id: int) -> int:
    query = (
        select(func.count())
        .select_from(models.Cut)
        .join(models.StoredRecording)
        .where(
            models.Cut.superseded_at.is_not(None),
            models.StoredRecording.machine_id == machine_id,
            models.StoredRecording.looked_at.is_(None),
        )
    )
    return session.scalar(query) or 0


def _undone(session: Session, machine_id: int) -> int:
    query = (
        select(func.count())
        .select_from(models.CuttingParameters)
        .where(
            models.CuttingParameters.machine_id == machine_id,
            models.CuttingParameters.undone_at.is_not(None),
        )
    )
    return session.scalar(query) or 0


def _recounted(session: Session, machine_id: int) -> dict[str, int]:
    """Return how often edges of cuts that were there were counted anew; nothing: never."""
    changes = models.ChangedEdge
    query = select(func.sum(changes.recounts)).where(changes.machine_id == machine_id)
    times = session.scalar(query)
    return {"recounted": int(times)} if times else {}


def next_span(
    session: Session,
    machine_id: int,
    mark: Mark | None,
    basis: Mapping[str, Any],
    *,
    newest_cut: int,
) -> Span:
    """Return what the next pass looks at: at most CUTS_A_PASS new cuts, or all where it must.

    Of cuts behind ``newest_cut`` none: they came in after those over time were sensed.
    """
    if mark is None and _has_learnt(session, machine_id):  # by a version that left no marks
        return Span(0, newest_cut, old=newest_cut, force=last_force(session), anew=True)
    old, force = (0, 0) if mark is None else (mark.cut, mark.force)
    if mark is not None and mark.basis != basis:
        alike = all(mark.basis.get(name) == basis[name] for name in SENSORS)
        return Span(old if alike else 0, newest_cut, old=old, force=force, anew=True)
    some = (
        select(models.Cut.id)
        .where(
            models.Cut.id > old,
            models.Cut.id <= newest_cut,
            models.Cut.recording.has(machine_id=machine_id),
        )
        .order_by(models.Cut.id)
        .limit(CUTS_A_PASS + 1)
    )
    ids = session.scalars(some).all()
    upto = ids[CUTS_A_PASS - 1] if len(ids) > CUTS_A_PASS else newest_cut
    return Span(old, upto, old=old, force=force, anew=False)


def last_force(session: Session) -> int:
    """Return the id of the sensed force that was kept last; 0: none."""
    return session.scalar(select(func.max(models.SensedForce.id))) or 0


def _has_learnt(session: Session, machine_id: int) -> bool:
    query = select(models.CuttingParameters.id).where(
        models.CuttingParameters.machine_id == machine_id
    )
    return session.scalar(query.limit(1)) is not None
