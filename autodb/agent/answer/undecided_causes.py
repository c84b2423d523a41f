"""What an open mismatch makes of a pair's predictions, until a person decides on it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Select, bindparam, or_, select
from sqlalchemy.orm import Session

from autodb.agent.learn.learnt_from import excluded_cuts
from autodb.agent.rows.calibrations import current_calibrations
from autodb.agent.rows.mismatches import NEW_EDGE, SINCE, recordings_of
from autodb.agent.rows.posteriors import as_posterior
from autodb.agent.rows.refresh_cursor import last_mark
from autodb.agent.rows.sensed_forces import QUANTITY, as_cuts, forces_of_cuts, usable
from autodb.forward.widening import UndecidedCuts, placed
from autodb.pairs.forecast import forecast
from autodb.store import models

NEWEST = 200
"""Cuts of a pair that tell how the next may be. Chosen: six half-lives."""


@dataclass(frozen=True)
class OpenCauses:
    """The open mismatches in the forces of a pair's cuts, by id, and the last cut examined then.

    ``apart``: those that are no cause of excluded cuts: a drifted gain, a new edge.
    """

    mismatches: tuple[int, ...] = ()
    upto: int = 0
    apart: tuple[int, ...] = ()


NONE_OPEN = OpenCauses()


def open_causes(session: Session, parameters: int) -> OpenCauses:
    """Return which causes wait for a person in the forces of the pair that a version is of."""
    found = session.connection().execute(_OPEN, {"usual": parameters}).all()
    if not found:
        return NONE_OPEN
    mark = last_mark(session, found[0].machine_id)
    apart = {row.id for row in found if {SINCE, NEW_EDGE} & (row.found_in or {}).keys()}
    return OpenCauses(
        tuple(row.id for row in found if row.id not in apart),
        0 if mark is None else mark.cut,
        tuple(sorted(apart)),
    )


def _open() -> Select[Any]:
    mismatch, recording, parameters = map(
        models.table_of, (models.Mismatch, models.StoredRecording, models.CuttingParameters)
    )
    row, usual, of_pair = mismatch.c, parameters.c, models.mismatch_pair.c
    pairs = select(of_pair.pair_id).where(of_pair.mismatch_id == row.id).correlate(mismatch)
    return (
        select(row.id, usual.machine_id, row.found_in)
        .select_from(mismatch)
        .join(recording, recording.c.id == row.recording_id)
        .join(parameters, usual.machine_id == recording.c.machine_id)
        .where(
            usual.id == bindparam("usual"),
            row.status == "open",
            row.channel.startswith("force."),
            or_(~pairs.exists(), usual.pair_id.in_(pairs)),
        )
        .order_by(row.id)
    )


_OPEN = _open()
"""Made once: a look-up asks it each time."""


def undecided_cuts(session: Session, parameters: int, causes: OpenCauses) -> UndecidedCuts | None:
    """Return the newest cuts of a version's pair, and how those that open ``causes`` hold were off.

    None where none of their recordings holds an excluded cut of the pair.
    """
    if not causes.mismatches:
        return None
    usual = session.get_one(models.CuttingParameters, parameters)
    machine_id, pair_id, upto = usual.machine_id, usual.pair_id, causes.upto
    rows = [session.get_one(models.Mismatch, number) for number in causes.mismatches]
    excluded = excluded_cuts(session, machine_id, pair_id, upto=upto)
    waiting = {cut.id for cut in excluded if cut.recording_id in recordings_of(rows)}
    named = [row for row in rows if recordings_of([row]) & {cut.recording_id for cut in excluded}]
    cuts = _newest(session, machine_id, pair_id, upto)
    there = np.array([cut.id in waiting for cut in cuts], dtype=np.bool_)
    if not there.any():
        return None
    off, sd = _off(session, usual, cuts)
    return UndecidedCuts(
        placed=np.array([placed(cut.conditions) for cut in cuts]),
        excluded=there,
        off=off,
        sd=sd,
        waiting=tuple((row.id, row.channel, row.term) for row in named),
    )


def said_of_open(session: Session, causes: OpenCauses) -> tuple[str, ...]:
    """Say which drifted gains and new edges of a pair nobody has decided on, and what decides."""
    rows = [session.get_one(models.Mismatch, number) for number in causes.apart]
    return tuple(
        f"mismatch {row.id} is open: {row.statement}; 'autodb mismatch confirm {row.id}' or "
        f"'autodb mismatch reject {row.id}' decides"
        for row in rows
    )


def _newest(session: Session, machine_id: int, pair_id: int, upto: int) -> list[models.Cut]:
    """Return a pair's newest usable cuts that a force is known of, oldest first."""
    query = (
        select(models.Cut)
        .where(
            models.Cut.recording.has(machine_id=machine_id),
            models.Cut.pair_id == pair_id,
            models.Cut.id <= upto,
            models.counting_cut(models.Cut.superseded_at),
            models.Cut.id.in_(
                select(models.SensedForce.cut_id).where(models.SensedForce.value_N.is_not(None))
            ),
        )
        .order_by(models.Cut.id.desc())
        .limit(NEWEST)
    )
    return [cut for cut in reversed(session.scalars(query).all()) if usable(cut)]


def _off(
    session: Session, usual: models.CuttingParameters, cuts: Sequence[models.Cut]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return by what share of what is learnt each force of cuts was off, and its sd, (n, 3).

    The sd is of sensing and of what cuts scatter by; NaN where no force is known.
    """
    owner = session.get_one(models.Machine, usual.machine_id)
    current = [current_calibrations(session, owner.id, axis.name) for axis in owner.axes]
    number, made = as_cuts(cuts)
    expected = [forecast(as_posterior(usual), some) for some in made]
    mean = np.concatenate([one.mean for one in expected])
    own = np.concatenate([one.own for one in expected])
    off, sd = (np.full((len(cuts), len(QUANTITY)), np.nan) for _ in range(2))
    place = {cut.id: k for k, cut in enumerate(cuts)}
    sensors = [rows for rows in current if rows]
    for force in forces_of_cuts(session, [cut.id for cut in cuts], sensors):
        k, row, column = place[force.cut_id], number[force.cut_id], QUANTITY[force.component]
        size = abs(float(mean[row, column]))
        if size > 0.0 and force.value_N is not None:
            off[k, column] = (force.value_N - mean[row, column]) / mean[row, column]
            sd[k, column] = np.hypot(force.sd_N or 0.0, np.sqrt(own[row, column])) / size
    return off, sd
