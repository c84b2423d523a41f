"""Versions of what senses forces on a machine beside current ranges: a row a component."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.store import models

FUSION = "fusion"
"""Kind of how several sensors go together."""


@dataclass(frozen=True)
class FittedComponent:
    """What a version keeps of a component: its model, how inputs are normalised, its scores."""

    model: dict[str, Any]
    scores: dict[str, Any]
    normalisation: dict[str, Any] | None = None


def newest(session: Session, machine_id: int, kind: str) -> list[models.Estimator]:
    """Return the rows of a kind's newest version that was not taken back, by component."""
    own = (
        models.Estimator.machine_id == machine_id,
        models.Estimator.kind == kind,
        models.Estimator.undone_at.is_(None),
    )
    version = session.scalar(select(func.max(models.Estimator.version)).where(*own))
    query = select(models.Estimator).where(*own, models.Estimator.version == version)
    return list(session.scalars(query.order_by(models.Estimator.component)))


def is_learnt_from(rows: Sequence[models.Estimator], recordings: Sequence[int]) -> bool:
    """Say whether a version was learnt from these recordings and no others."""
    return bool(rows) and {one.id for one in rows[0].recordings} == set(recordings)


def keep_estimator(
    session: Session,
    machine_id: int,
    kind: str,
    fitted: Mapping[str, FittedComponent],
    recordings: Sequence[models.StoredRecording],
) -> int:
    """Add a version, of what was fitted by component, and return its number."""
    own = models.Estimator.machine_id == machine_id, models.Estimator.kind == kind
    version = 1 + (session.scalar(select(func.max(models.Estimator.version)).where(*own)) or 0)
    for component, one in sorted(fitted.items()):
        session.add(
            models.Estimator(
                machine_id=machine_id,
                kind=kind,
                component=component,
                version=version,
                model=one.model,
                normalisation=one.normalisation,
                scores=one.scores,
                recordings=list(recordings),
            )
        )
    session.flush()
    return version
