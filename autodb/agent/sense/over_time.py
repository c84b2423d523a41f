"""Forces of cuts that were recorded over time, as a machine's drives, network and table feel them.

Each cut is read and sensed before anything is written: it takes seconds; then it is kept at once,
so that a pass that was killed goes on behind it. What a cut's force was sensed with is kept with
it; a new version of that feels it anew.
"""

from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.ingest.importing import files_of
from autodb.agent.rows.estimators import FittedComponent, keep_estimator, newest
from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.refresh_cursor import ESTIMATORS, SENSED_OVER_TIME, last_mark
from autodb.agent.sense.fusing import fused_on_machine
from autodb.agent.sense.identifying import newest_model
from autodb.agent.sense.reconstructing import ReconstructedLoad, known_scale
from autodb.errors import UnusableInput
from autodb.files.channels import LINEAR_AXES
from autodb.files.checksums import checksum
from autodb.files.side import SideFile
from autodb.records.source import open_as_stored
from autodb.records.tables import Recording
from autodb.sensing.ranges.in_cut import mean_of, steady_rows
from autodb.store import Store, models
from autodb.wording import phrase, stored_msgid

DRIVE = "drive"

NO_SENSOR = stored_msgid("{file}: no sensor of force.{component} was recorded")
SENSING_FILE = stored_msgid("sensing forces in {file}")
NOT_THERE_NOW = stored_msgid(
    "{file}: the file is missing or has changed since its import, so its forces cannot be sensed"
)


@dataclass(frozen=True)
class SensedMean:
    """A component of a cut as a sensor sensed it, or why it did not; rows of the database by id."""

    cut_id: int
    component: str
    kind: str
    estimator_id: int
    value_N: float | None
    sd_N: float | None
    share: float | None
    reason: str | None

    def row(self) -> models.SensedForce:
        """Return it as the database keeps it."""
        return models.SensedForce(
            cut_id=self.cut_id,
            component=self.component,
            estimator=self.kind,
            estimator_id=self.estimator_id,
            value_N=self.value_N,
            sd_N=self.sd_N,
            common=None if self.share is None else [self.share],
            reason=self.reason,
        )


@dataclass(frozen=True)
class SensedOverTime:
    """What came of feeling cuts: forces sensed and not, and what is to be said of it: why some was
    not, who did not agree. ``last_cut``: the newest cut there was, by id.
    """

    sensed: int
    not_sensed: int
    notes: list[str]
    last_cut: int


def cuts_to_feel(store: Store, machine: str) -> list[int]:
    """Return the cuts of recordings over time, by id, that are not sensed yet.

    Raises UnusableInput for an unknown machine.
    """
    return [one.cut_id for one in _to_feel(store, machine)[1]]


def feel_over_time(
    store: Store,
    machine: str,
    *,
    only: Container[int] | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> SensedOverTime:
    """Feel the cuts of recordings over time that what the machine has now has not sensed yet.

    ``only``: of these alone, by id. Raises UnusableInput for an unknown machine.
    """
    sensors, waiting, last_cut = _to_feel(store, machine)
    if only is not None:
        waiting = [one for one in waiting if one.cut_id in only]
    sensed: list[SensedMean] = []
    notes: list[str] = []
    for one in waiting:
        found, said = _feel(store, machine, one, sensors, progress)
        sensed += _kept(store, machine, found)
        notes += said
    notes += dict.fromkeys(one.reason for one in sensed if one.reason is not None)
    without = sum(one.reason is not None for one in sensed)
    return SensedOverTime(len(sensed) - without, without, notes, last_cut)


def _to_feel(
    store: Store, machine: str
) -> tuple[dict[str, tuple[int, str]], "list[WaitingCut]", int]:
    """Return what feels a machine's cuts by component, the cuts that wait, the newest cut by id."""
    with store.writing(machine) as session:
        owner = find_machine(session, machine)
        _keep_drives(session, owner)
        sensors = {c: (row.id, row.kind) for c, row in _sensors(session, owner).items()}
        waiting = _waiting(session, owner, [number for number, _ in sensors.values()])
        return sensors, waiting, session.scalar(select(func.max(models.Cut.id))) or 0


def _feel(
    store: Store,
    machine: str,
    one: "WaitingCut",
    sensors: Mapping[str, tuple[int, str]],
    progress: Callable[[str], None],
) -> tuple[list[SensedMean], list[str]]:
    """Return the components of a cut as they were sensed, or why not; and who did not agree."""
    try:
        recording = one.recording()
        progress(SENSING_FILE.format(file=recording.path.name))
        told = fused_on_machine(store, machine, recording, progress=progress)
        sensed = {component.load.axis: component for component in told.sensed}
        notes = [
            f"{recording.path.name}: force.{c}: {told_of.disagrees}"
            for c, told_of in sensed.items()
            if told_of.disagrees is not None
        ]
        return _means(one.cut_id, recording, sensed, sensors), notes
    except UnusableInput as error:
        found = [
            SensedMean(one.cut_id, c, kind, number, None, None, None, str(error))
            for c, (number, kind) in sensors.items()
        ]
        return found, []


def _kept(store: Store, machine: str, found: list[SensedMean]) -> list[SensedMean]:
    """Keep what was sensed of a cut, but what another agent kept meanwhile; return what was new."""
    new = []
    with store.writing(machine) as session:
        for one in found:
            there = session.scalar(
                select(models.SensedForce.id).where(
                    models.SensedForce.cut_id == one.cut_id,
                    models.SensedForce.component == one.component,
                    models.SensedForce.estimator_id == one.estimator_id,
                )
            )
            if there is None:
                session.add(one.row())
                new.append(one)
    return new


def _means(
    cut_id: int,
    recording: Recording,
    sensed: Mapping[str, ReconstructedLoad],
    sensors: Mapping[str, tuple[int, str]],
) -> list[SensedMean]:
    forces = np.array([-one.load.value for one in sensed.values()])
    rows = steady_rows(forces, recording.timing, where=str(recording.path))
    found = []
    for c, (number, kind) in sensors.items():
        if c not in sensed:
            reason = NO_SENSOR.format(file=recording.path.name, component=c)
            found.append(SensedMean(cut_id, c, kind, number, None, None, None, reason))
            continue
        load = sensed[c].load
        mean = mean_of(-load.value, load.sd, rows)
        found.append(
            SensedMean(cut_id, c, kind, number, mean.force_N, mean.sd_N, sensed[c].share, None)
        )
    return found


def _keep_drives(session: Session, owner: models.Machine) -> None:
    """Keep drive models that tell newtons as sensors, where they are newer than those kept."""
    axes = {axis.name: axis for axis in owner.axes}
    channels = session.scalars(
        select(models.ChannelModel.channel)
        .where(models.ChannelModel.machine_id == owner.id)
        .distinct()
    )
    fitted = {}
    for channel in sorted(channels):
        row = newest_model(session, owner.id, channel)
        if row is None or row.errors is None or row.axis not in LINEAR_AXES:
            continue
        scaled = row.axis in axes and known_scale(session, axes[row.axis]) is not None
        if row.unit == "N" or scaled:
            model = {"channel": row.channel, "version": row.version}
            fitted[row.axis] = FittedComponent(model, {"rms": row.errors["rms"]})
    before = {row.component: row.model for row in newest(session, owner.id, DRIVE)}
    if fitted and before != {c: one.model for c, one in fitted.items()}:
        keep_estimator(session, owner.id, DRIVE, fitted, [])


def _sensors(session: Session, owner: models.Machine) -> dict[str, models.Estimator]:
    """Return by component what its force is kept as sensed with: all together, a table, a drive."""
    found: dict[str, models.Estimator] = {}
    for kind in SENSED_OVER_TIME:
        found |= {row.component: row for row in newest(session, owner.id, kind)}
    return found


@dataclass(frozen=True)
class WaitingCut:
    """A cut, by id, with its recording: where it was, files with their checksums, side file."""

    cut_id: int
    path: str
    files: Mapping[Path, str]
    side: Mapping[str, Any]

    def recording(self) -> Recording:
        """Read the recording; raises UnusableInput where it is not there as it was imported."""
        there = [path for path, sha256 in self.files.items() if checksum(path) == sha256]
        if not there:
            raise UnusableInput(NOT_THERE_NOW.format(file=self.path))
        found = open_as_stored(there[0], SideFile.model_validate(self.side)).choose().read()
        if not isinstance(found, Recording):
            raise UnusableInput(
                phrase("{there}: is a table of cuts; use a recording over time", there=there[0])
            )
        return found


def _waiting(session: Session, owner: models.Machine, sensors: list[int]) -> list[WaitingCut]:
    """Return the cuts of recordings over time that none of these sensors has looked at.

    Where the last pass had these sensors, none of those that it looked at is among them.
    """
    if not sensors:
        return []
    mark = last_mark(session, owner.id)
    before = 0 if mark is None or set(sensors) - set(mark.basis[ESTIMATORS]) else mark.cut
    looked_at = (
        select(models.SensedForce.id)
        .where(
            models.SensedForce.cut_id == models.Cut.id,
            models.SensedForce.estimator_id.in_(sensors),
        )
        .exists()
    )
    cuts = session.scalars(
        select(models.Cut)
        .join(models.StoredRecording)
        .where(
            models.StoredRecording.machine_id == owner.id,
            models.StoredRecording.kind == "series",
            models.Cut.pair_id.is_not(None),
            models.counting_cut(models.Cut.superseded_at),
            models.Cut.id > before,
            ~looked_at,
        )
        .order_by(models.Cut.id)
    )
    return [
        WaitingCut(cut.id, cut.recording.path, files_of(cut.recording), cut.recording.side)
        for cut in cuts
    ]
