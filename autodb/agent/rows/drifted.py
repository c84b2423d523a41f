"""Gains of sensing axes that have drifted: from which recording on, and by about how much.

As long as nobody says otherwise, what an axis has sensed since then has a gain of its own that all
its cuts share: pairs learn from them what differs between cuts, and their level from the others.

Once a person confirmed the factor, what is sensed from that cut on is divided by it: value, error
of the cut alone, and what the coefficients' errors move. The factor's own error is shared by all of
these cuts.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import object_session

from autodb.agent.rows.mismatches import GAIN_TERM, SINCE
from autodb.sensing.ranges.chosen import SensedCut
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


def is_after(correction: Mapping[str, Any], cut: models.Cut) -> bool:
    """Say whether a cut is one of those that a correction is of."""
    since = correction["recording"], correction["t_s"]
    return (cut.recording_id, float(cut.conditions.get("t", 0.0))) >= since


def corrected(
    current: Sequence[models.CalibrationVersion], cut: models.Cut, read: SensedCut
) -> SensedCut:
    """Return what one of an axis' calibrations sensed of a cut, as its corrections have it."""
    if read.by is None or read.force_N is None:
        return read
    by = [one for one in current[read.by].corrections or () if is_after(one, cut)]
    for one in by:
        factor = one["factor"]
        assert read.force_N is not None
        assert read.sd_N is not None
        read = replace(
            read,
            force_N=read.force_N / factor,
            sd_N=read.sd_N / factor,
            common=[value / factor for value in read.common or ()],
        )
    return read
