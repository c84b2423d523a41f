"""A usual cut of a pair: one of its own, near the middle of what they state."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydantic import ValidationError
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.sensed_forces import operation_of
from autodb.files.job_cut import KEYS, JobCut
from autodb.pairs.engaged import (
    DEPTH,
    DIAMETER,
    DIRECTION,
    DRILL,
    END_MILL,
    FEED,
    HOLE,
    INSERT,
    RAMP,
    RPM,
    SPEED,
    WIDTH,
)
from autodb.store import models

NEWEST = 200
"""Newest cuts that count. Chosen."""
STATED = {
    DEPTH: "depth_mm", WIDTH: "width_mm", DIAMETER: "diameter_mm", DIRECTION: "direction_deg",
    RAMP: "ramp_deg", HOLE: "pocket_diameter_mm", SPEED: "speed_m_min", RPM: "speed_rpm",
}  # fmt: skip
"""Keys of a job's cut by channel; a feed is by turn or by tooth."""
OTHERWISE: Mapping[str, JobCut] = {
    INSERT: JobCut(
        operation="turn", diameter_mm=50.0, depth_mm=2.0, feed_mm_rev=0.25, speed_m_min=150.0
    ),
    END_MILL: JobCut(operation="slot", depth_mm=1.0, feed_mm_tooth=0.05, speed_m_min=100.0),
    DRILL: JobCut(operation="drill", feed_mm_rev=0.1, speed_m_min=60.0),
}
"""A cut by kind of tool, where a pair has none of its own. Chosen."""


def usual_cut(session: Session, machine_id: int, material: str, tool: str) -> JobCut:
    """Return a usual cut of a machine's pair; where it has none, one that its kind of tool makes.

    Numbers have three digits: whoever asks for it again can write it down.
    """
    cuts = session.scalars(
        select(models.Cut)
        .join(models.StoredRecording)
        .join(models.Pair, models.Pair.id == models.Cut.pair_id)
        .join(models.Material)
        .join(models.Tool)
        .where(
            models.StoredRecording.machine_id == machine_id,
            models.Material.name == material,
            models.Tool.name == tool,
        )
        .order_by(models.Cut.id.desc())
        .limit(NEWEST)
    ).all()
    made = _as_asked(nearest_to_median(cuts)) if cuts else None
    if made is not None:
        return made
    kind = session.scalar(select(models.Tool.kind).where(models.Tool.name == tool))
    return OTHERWISE[kind or INSERT]


def nearest_to_median(cuts: Sequence[models.Cut]) -> models.Cut:
    """Return the cut nearest to the median of what the cuts of its operation state."""
    operations = [operation_of(cut) for cut in cuts]
    most = max(set(operations), key=operations.count)
    some = [cut for cut, name in zip(cuts, operations, strict=True) if name == most]
    stated = np.array(
        [[float(cut.conditions.get(name, 0.0)) for name in (DEPTH, FEED, SPEED)] for cut in some]
    )
    middle = np.median(stated, axis=0)
    spread = np.maximum(np.abs(middle), 1e-9)
    return some[int(np.argmin(np.sum(((stated - middle) / spread) ** 2, axis=1)))]


def _as_asked(cut: models.Cut) -> JobCut | None:
    """Return a cut as a planner would ask for it; None where it lacks what that needs."""
    operation = operation_of(cut)
    keys = KEYS.get(operation)
    if keys is None:
        return None
    feed = "feed_mm_tooth" if "feed_mm_tooth" in keys.needs else "feed_mm_rev"
    names = {**STATED, FEED: feed}
    has = {*keys.needs, *keys.may, "speed_m_min", "speed_rpm"}
    asked = {
        names[channel]: float(f"{float(value):.3g}")
        for channel, value in cut.conditions.items()
        if names.get(channel) in has
    }
    if "speed_m_min" in asked:
        asked.pop("speed_rpm", None)
    try:
        return JobCut.model_validate({"operation": operation, **asked})
    except ValidationError:
        return None
