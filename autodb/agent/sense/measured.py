"""Forces that were measured in cuts, beside those that are sensed: each with its own errors.

A force channel of a cut is kept as a force once, with what is known of its errors: from the side
file, else from the machine's file (``autodb.sensing.dynamometer``). Where a machine's file comes to
state another dynamometer, its recordings' forces are kept anew; the newest counts.

Of a recording over time it is the mean over its cut. Where the machine has a table dynamometer,
force channels are its readings, and its model tells the forces (``autodb.agent.sense.over_time``).
"""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import exists, select
from sqlalchemy.orm import Session

from autodb.agent.ingest.importing import files_of
from autodb.agent.rows.estimators import newest
from autodb.agent.rows.force_errors import errors_of
from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.refresh_cursor import Span
from autodb.agent.rows.sensed_forces import MEASURED
from autodb.agent.sense.dynamometers import KIND
from autodb.agent.sense.over_time import WaitingCut
from autodb.errors import UnusableInput
from autodb.files.channels import FORCES
from autodb.files.dynamometer import COMPONENTS, DynamometerSection
from autodb.files.side import SideFile
from autodb.records.tables import Recording
from autodb.sensing.dynamometer import ForceError, ForceStatement, MeasuredForces, mean_errors
from autodb.sensing.ranges.in_cut import steady_rows
from autodb.store import Store, models
from autodb.wording import significant, stored_msgid

PARTS_OF_CUT = 10
"""Parts of a cut whose means tell the standard error of the whole cut's. Chosen."""
_CHANNELS = {c: f"force.{c}" for c in COMPONENTS}
_SAME_CUT = (
    "cutting.feed", "cutting.depth", "cutting.width", "cutting.speed", "cutting.direction",
    "spindle.speed", "work.diameter", "tool.edge",
)  # fmt: skip
"""What repeats of a cut have in common, to three digits."""
TAKING = stored_msgid("taking measured forces of {file}")


def statement_of(owner: models.Machine, recording: models.StoredRecording) -> ForceStatement:
    """Return where the forces of a recording are from: its side file says, else the machine's."""
    side = SideFile.model_validate(recording.side)
    if side.dynamometer is not None or side.source is not None or owner.dynamometer is None:
        return ForceStatement(side.dynamometer, side.source)
    return ForceStatement(DynamometerSection.model_validate(owner.dynamometer))


def measured_in(cut: models.Cut) -> dict[str, float]:
    """Return the forces that were measured in a cut, N by component."""
    return {c: float(cut.measured[name]) for c, name in _CHANNELS.items() if name in cut.measured}


def take_measured(session: Session, owner: models.Machine, span: Span) -> None:
    """Keep the forces that were measured in the cuts of a span, unless they are kept as stated."""
    cuts = session.scalars(
        select(models.Cut)
        .where(
            models.Cut.id > span.after,
            models.Cut.id <= span.upto,
            models.counting_cut(models.Cut.superseded_at),
            models.Cut.recording.has(machine_id=owner.id),
        )
        .order_by(models.Cut.id)
    )
    by_recording: dict[int, list[models.Cut]] = {}
    for cut in cuts:
        if measured_in(cut):
            by_recording.setdefault(cut.recording_id, []).append(cut)
    for some in by_recording.values():
        _take(session, owner, some)
    session.flush()


def _take(session: Session, owner: models.Machine, cuts: Sequence[models.Cut]) -> None:
    """Keep the measured forces of some cuts of one recording."""
    recording = cuts[0].recording
    statement = statement_of(owner, recording)
    counting = [cut for cut in recording.cuts if cut.superseded_at is None]
    every = MeasuredForces(
        [measured_in(cut) for cut in counting], [_conditions(cut) for cut in counting]
    )
    noise = {c: statement.noise(c, every) for c in COMPONENTS}
    kept = _kept(session, cuts)
    for cut in cuts:
        forces_N = measured_in(cut)
        for c, force_N in forces_N.items():
            errors = [noise[c], *statement.errors(c, forces_N)]
            row = measured_row(cut, c, force_N, errors)
            before = kept.get((cut.id, c))
            if before is None or _shared(before) != _shared(row):
                session.add(row)


def measured_row(
    cut: models.Cut, component: str, force_N: float, errors: Sequence[ForceError]
) -> models.SensedForce:
    """Return a measured force as the database keeps it; its own errors make its sd."""
    own = [one.standard_N(force_N) for one in errors if one.of is None]
    return models.SensedForce(
        cut_id=cut.id,
        component=component,
        estimator=MEASURED,
        value_N=force_N,
        sd_N=float(np.linalg.norm(own)),
        errors=[asdict(one) for one in errors],
    )


def _shared(row: models.SensedForce) -> list[ForceError]:
    """Return what a force shares with others: noise that more cuts tell better is no news."""
    return [one for one in errors_of(row) if one.of is not None]


def _kept(
    session: Session, cuts: Sequence[models.Cut]
) -> dict[tuple[int, str], models.SensedForce]:
    """Return the newest measured force of each component of cuts, by cut and component."""
    rows = session.scalars(
        select(models.SensedForce)
        .join(models.Cut)
        .where(
            models.SensedForce.estimator == MEASURED,
            models.Cut.recording_id == cuts[0].recording_id,
        )
        .order_by(models.SensedForce.id)
    )
    return {(row.cut_id, row.component): row for row in rows}


def _conditions(cut: models.Cut) -> Hashable:
    """Return what repeats of a cut have in common."""
    said = [cut.conditions.get(name) for name in _SAME_CUT]
    short = [significant(one) if isinstance(one, float) else one for one in said]
    return (cut.pair_id, cut.operation, *short)


def reference_errors(
    owner: models.Machine, cuts: Sequence[models.Cut], component: str
) -> tuple[ForceError, ...]:
    """Return the errors of the dynamometer that all forces of a calibration's cuts share."""
    statements: dict[int, ForceStatement] = {}
    errors, forces_N = [], []
    for cut in cuts:
        measured = measured_in(cut)
        if component in measured:
            if cut.recording_id not in statements:
                statements[cut.recording_id] = statement_of(owner, cut.recording)
            errors.append(statements[cut.recording_id].errors(component, measured))
            forces_N.append(measured[component])
    return tuple(mean_errors(errors, np.array(forces_N)))


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
            progress(TAKING.format(file=recording.path.name))
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
    rows = steady_rows(forces, recording.timing, where=str(recording.path))
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
        said = stored_msgid("means of {count} parts of the cut").format(count=PARTS_OF_CUT)
        scatter = ForceError(
            stored_msgid("scatter within the cut"),
            0.0,
            mean.error_N,
            "A",
            said,
            freedom=PARTS_OF_CUT - 1.0,
        )
        errors = [scatter, statement.noise(c, alone), *statement.errors(c, forces_N)]
        session.add(measured_row(cut, c, mean.force_N, errors))
    for c in COMPONENTS if why is not None else ():
        session.add(models.SensedForce(cut_id=cut.id, component=c, estimator=MEASURED, reason=why))


def _waiting(session: Session, owner: models.Machine) -> list[WaitingCut]:
    """Return the cuts of recordings over time with force channels that were not taken yet."""
    if newest(session, owner.id, KIND):
        return []
    over_time = select(models.StoredRecording.id).where(
        models.StoredRecording.machine_id == owner.id,
        models.StoredRecording.kind == "series",
        models.StoredRecording.channels.any(models.RecordingChannel.name.in_(FORCES)),
    )
    if session.scalar(over_time.limit(1)) is None:
        return []  # without looking through every cut
    taken = exists().where(
        models.SensedForce.cut_id == models.Cut.id, models.SensedForce.estimator == MEASURED
    )
    cuts = session.scalars(
        select(models.Cut)
        .where(
            models.Cut.recording_id.in_(over_time),
            models.Cut.pair_id.is_not(None),
            models.counting_cut(models.Cut.superseded_at),
            ~taken,
        )
        .order_by(models.Cut.id)
    )
    return [
        WaitingCut(cut.id, cut.recording.path, files_of(cut.recording), cut.recording.side)
        for cut in cuts
        if not measured_in(cut)
    ]
