"""Gains of sensing axes that have drifted: from which recording on, and by about how much.

As long as nobody says otherwise, what an axis has sensed since then has a gain of its own that all
its cuts share: pairs learn from them what differs between cuts, and their level from the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import object_session

from autodb.agent.rows.mismatches import GAIN_TERM, SINCE
from autodb.store import models


@dataclass(frozen=True)
class DriftedGain:
    """A calibration, by id, whose axis reads otherwise ``since`` a recording, by about a share."""

    calibration: int
    since: int
    share: float


def drifted_gains(forces: Sequence[models.SensedForce]) -> list[DriftedGain]:
    """Return the drifted gains of the machine that sensed forces, which nobody has rejected."""
    session = object_session(forces[0]) if forces else None
    if session is None:
        return []
    rows = session.scalars(
        select(models.Mismatch)
        .join(models.StoredRecording)
        .where(
            models.StoredRecording.machine_id == forces[0].cut.recording.machine_id,
            models.Mismatch.term == GAIN_TERM,
            models.Mismatch.status != "rejected",
            models.Mismatch.found_in.is_not(None),
        )
        .order_by(models.Mismatch.id)
    )
    return [
        DriftedGain(
            int(row.found_in["calibration"]),
            int(row.found_in[SINCE]),
            float(row.parameters["factor"]["value"]) - 1.0,
        )
        for row in rows
        if row.found_in is not None and SINCE in row.found_in
    ]
