"""Forces that a dynamometer recorded over time, as the mean of each recording's cut.

Where the machine has a table dynamometer, force channels are that one's readings, and its model
tells the forces (``autodb.agent.sense.over_time``).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import exists, select
from sqlalchemy.orm import Session

from autodb.agent.ingest.importing import files_of
from autodb.agent.rows.estimators import newest
from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.dynamometers import KIND
from autodb.agent.sense.measured import MEASURED, measured_in, measured_row, statement_of
from autodb.agent.sense.over_time import WaitingCut
from autodb.errors import UnusableInput
from autodb.files.channels import FORCES
from autodb.files.dynamometer import COMPONENTS
from autodb.records import Recording
from autodb.sensing.dynamometer import ForceError, MeasuredForces
from autodb.sensing.ranges.in_cut import steady_rows
from autodb.store import Store, models

PARTS_OF_CUT = 10
"""Parts of a cut whose means tell the standard error of the whole cut's. Chosen."""


@dataclass(frozen=True)
class MeasuredMean:
    """Mean force of a cut, and the standard error of it that its parts show."""

    force_N: float
    error_N: float


def measure_over_time(
    store: Store, machine: str, *, progress: Callable[[str], None] = lambda _: None
) -> list[str]:
    """Keep the mean forces of cuts whose recordings have force channels; return why some have none.

    Raises UnusableInput for an unknown machine.
    """
    with store.reading() as session:
        waiting = _waiting(session, find_machine(session, machine))
    said = []
    for one in waiting:
        try:
            recording = one.recording()
            progress(f"taking measured forces of {recording.path.name}")
            means, why = measured_means(recording), None
        except UnusableInput as error:
            means, why = {}, str(error)
            said.append(why)
        with store.writing(machine) as session:
            _keep(session, session.get_one(models.Cut, one.cut_id), means, why)
    return said


def measured_means(recording: Recording) -> dict[str, MeasuredMean]:
    """Return the mean of each force component over the steady part of a recording's cut.

    Raises UnusableInput where there is no such part.
    """
    there = {name.removeprefix("force."): recording[name] for name in FORCES if name in recording}
    forces = np.array(list(there.values()))
    rows = steady_rows(forces, rate_hz=recording.rate_hz, where=str(recording.path))
    return {c: _mean(force[rows]) for c, force in there.items()}


def _mean(force_N: NDArray[np.float64]) -> MeasuredMean:
    parts = [float(np.nanmean(part)) for part in np.array_split(force_N, PARTS_OF_CUT)]
    error_N = float(np.std(parts, ddof=1)) / np.sqrt(PARTS_OF_CUT)
    return MeasuredMean(float(np.nanmean(force_N)), float(error_N))


def _keep(
    session: Session, cut: models.Cut, means: dict[str, MeasuredMean], why: str | None
) -> None:
    owner = session.get_one(models.Machine, cut.recording.machine_id)
    statement = statement_of(owner, cut.recording)
    forces_N = {c: mean.force_N for c, mean in means.items()}
    alone = MeasuredForces([forces_N], [None])
    for c, mean in means.items():
        said = f"means of {PARTS_OF_CUT} parts of the cut"
        scatter = ForceError(
            "scatter within the cut", 0.0, mean.error_N, "A", said, freedom=PARTS_OF_CUT - 1.0
        )
        errors = [scatter, statement.noise(c, alone), *statement.errors(c, forces_N)]
        session.add(measured_row(cut, c, mean.force_N, errors))
    for c in COMPONENTS if why is not None else ():
        session.add(models.SensedForce(cut_id=cut.id, component=c, estimator=MEASURED, reason=why))


def _waiting(session: Session, owner: models.Machine) -> list[WaitingCut]:
    """Return the cuts of recordings over time with force channels that were not taken yet."""
    if newest(session, owner.id, KIND):
        return []
    taken = exists().where(
        models.SensedForce.cut_id == models.Cut.id, models.SensedForce.estimator == MEASURED
    )
    cuts = session.scalars(
        select(models.Cut)
        .join(models.StoredRecording)
        .where(
            models.StoredRecording.machine_id == owner.id,
            models.StoredRecording.kind == "series",
            models.StoredRecording.channels.any(models.RecordingChannel.name.in_(FORCES)),
            models.Cut.pair_id.is_not(None),
            models.Cut.superseded_at.is_(None),
            ~taken,
        )
        .order_by(models.Cut.id)
    )
    return [
        WaitingCut(cut.id, cut.recording.path, files_of(cut.recording), cut.recording.side)
        for cut in cuts
        if not measured_in(cut)
    ]
