"""What cuts that were predicted then took: their forces, measured or sensed, kept with the link."""

from collections.abc import Sequence
from math import pi
from typing import Any

from sqlalchemy import Select, exists, select
from sqlalchemy.orm import Session

from autodb.agent.matching.asked_jobs import AskedCuts
from autodb.agent.rows.calibrations import current_calibrations
from autodb.agent.rows.refresh_cursor import Span
from autodb.agent.rows.sensed_forces import Calibrations, forces_of_cuts
from autodb.agent.sense.sensed import sd_beside_N
from autodb.pairs.engaged import RPM
from autodb.store import models

Link = models.PredictedCutMade
AT_ONCE = 500
"""Links whose forces are read by one query."""
TORQUE, POWER = "torque.spindle", "spindle.power"


def take_forces(
    session: Session, links: Sequence[Link], calibrations: Sequence[Calibrations]
) -> None:
    """Keep what the cuts of some links took, as it is known now.

    A force's standard deviation is without the errors of sensing that the prediction's posterior
    holds: these move both alike. Torque is what was recorded of the spindle's, and power that
    torque at the spindle's speed; nobody stated their error.
    """
    forces = forces_of_cuts(session, [link.cut_id for link in links], calibrations)
    by_cut: dict[int, list[models.SensedForce]] = {}
    for force in forces:
        by_cut.setdefault(force.cut_id, []).append(force)
    known: dict[int, set[str]] = {}
    for link in links:
        number = link.prediction_id
        if number not in known:
            known[number] = AskedCuts(session, number).errors
        made: dict[str, Any] = {
            f"force.{force.component}": [
                force.value_N, sd_beside_N(force, known[number]), force.id,
            ]
            for force in by_cut.get(link.cut_id, ())
        }  # fmt: skip
        link.made = made | _of_spindle(link.cut) or None


def _of_spindle(cut: models.Cut) -> dict[str, list[float | None]]:
    """Return torque and power of a cut whose torque was recorded."""
    torque_N_m, rpm = cut.measured.get(TORQUE), cut.conditions.get(RPM)
    if torque_N_m is None:
        return {}
    found: dict[str, list[float | None]] = {TORQUE: [torque_N_m, None, None]}
    if rpm is not None:
        found[POWER] = [torque_N_m * 2.0 * pi * rpm / 60.0, None, None]
    return found


def take_new_forces(
    session: Session, owner: models.Machine, span: Span, calibrations: Sequence[Calibrations]
) -> None:
    """Keep what cuts took of which a pass over a span has made forces, or other ones."""
    query = _links(owner.id).where(models.Cut.id <= span.upto)
    if not span.anew:
        anew = exists().where(
            models.SensedForce.cut_id == models.Cut.id, models.SensedForce.id > span.force
        )
        query = query.where((models.Cut.id > span.old) | anew)
    links = session.scalars(query).all()
    for begin in range(0, len(links), AT_ONCE):
        take_forces(session, links[begin : begin + AT_ONCE], calibrations)


def _links(machine_id: int) -> Select[Link]:
    return (
        select(Link)
        .join(models.Cut)
        .join(models.StoredRecording)
        .where(
            models.StoredRecording.machine_id == machine_id,
            models.counting_cut(models.Cut.superseded_at),
        )
        .order_by(Link.id)
    )


def offered_calibrations(session: Session, owner: models.Machine) -> list[Calibrations]:
    """Return the calibrations of each axis that feels force, as a refresh senses with them."""
    current = [current_calibrations(session, owner.id, axis.name) for axis in owner.axes]
    return [rows for rows in current if any(row.offered for row in rows)]
