"""Whether a machine still feels cuts of known force as it should: what tells gain from cutting."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.pairs.disagreeing import SensedStandardCut
from autodb.pairs.handbook.material_groups import plain_name
from autodb.standard import read_protocol, shipped
from autodb.standard.matching import MATCH
from autodb.standard.protocol import CutProtocol
from autodb.standard.protocol import StandardCut as CutOfKnownForce
from autodb.store import models

TRUTH_SHARE = 0.04
"""Sd of a standard cut's force from machine to machine (assumed)."""
ALONG = {"y": (1.0, 0.0), "x": (0.0, 1.0), "z": (0.0, 1.0)}
"""Which gain, along the cutting speed or across it, a component in turning tells."""
TURNING = ("turn", "face")
HALF_95 = 3.92
"""Widths of a 95 % interval in standard deviations."""


def standard_cut(
    session: Session, machine_id: int, protocols: Sequence[CutProtocol] = ()
) -> SensedStandardCut | None:
    """Return what a machine sensed of standard cuts in turning beside those it was calibrated with.

    Those of the kit and of ``protocols``, by material, operation, speed, feed and depth; None where
    there is none. Cuts that a calibration was fitted to agree with it whatever it is worth.
    """
    sensed: dict[str, list[tuple[float, float]]] = {}
    for protocol in (*map(read_protocol, shipped()), *protocols):
        for cut in protocol.cut:
            if cut.reference and cut.operation in TURNING:
                for force in _sensed(session, machine_id, protocol, cut):
                    sensed.setdefault(force.component, []).append(_gain(force, cut))
    if not sensed:
        return None
    gains = {name: np.array(some) for name, some in sensed.items()}
    own = [np.sqrt(np.sum(g[:, 1] ** 2)) / len(g) for g in gains.values()]
    return SensedStandardCut(
        gain=np.array([np.mean(g[:, 0]) for g in gains.values()]),
        sd=np.hypot(own, TRUTH_SHARE),
        along=np.array([ALONG[name] for name in gains]),
    )


def _gain(force: models.SensedForce, cut: CutOfKnownForce) -> tuple[float, float]:
    """Return by what share a force was sensed too large, and its sd for one cut."""
    known = cut.reference[force.component]
    scatter = (known.upper - known.lower) / HALF_95
    sensed = float(force.value_N or 0.0)
    return sensed / known.value - 1.0, float(np.hypot(scatter, force.sd_N or 0.0)) / abs(
        known.value
    )


def _sensed(
    session: Session, machine_id: int, protocol: CutProtocol, cut: CutOfKnownForce
) -> Iterable[models.SensedForce]:
    """Return the forces that were sensed of a standard cut, each by its newest calibration."""
    force = models.SensedForce
    rows = session.scalars(
        select(force)
        .join(models.Cut)
        .join(models.StoredRecording)
        .where(
            models.StoredRecording.machine_id == machine_id,
            models.counting_cut(models.Cut.superseded_at),
            models.Cut.operation == cut.operation,
            force.value_N.is_not(None),
            force.calibration_id.is_not(None),
            force.component.in_(list(cut.reference)),
        )
        .order_by(force.id)
    )
    newest: dict[tuple[int, str], models.SensedForce] = {}
    for row in rows:
        if _of_pair(row.cut.pair, protocol) and _is(row.cut.conditions, cut):
            newest[row.cut_id, row.component] = row
    for row in newest.values():
        assert row.calibration is not None
        if row.cut.recording_id not in {one.id for one in row.calibration.recordings}:
            yield row


def _of_pair(pair: models.Pair | None, protocol: CutProtocol) -> bool:
    names = () if pair is None else (pair.material.name, pair.tool.name)
    return [plain_name(one) for one in names] == [
        plain_name(protocol.material),
        plain_name(protocol.tool),
    ]


def _is(conditions: Mapping[str, float | str], cut: CutOfKnownForce) -> bool:
    wanted = {"spindle.speed": cut.speed_rpm, "cutting.feed": cut.feed_mm}
    if cut.depth_mm is not None:
        wanted["cutting.depth"] = cut.depth_mm
    return all(
        abs(float(conditions.get(name, np.nan)) / value - 1.0) < MATCH
        for name, value in wanted.items()
    )
