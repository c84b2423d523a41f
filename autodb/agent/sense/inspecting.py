"""The passive force of a cut, of its finished part, kept beside what currents tell of the cut."""

from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.estimators import FittedComponent, keep_estimator, newest
from autodb.agent.rows.machines import find_machine
from autodb.errors import UnusableInput, behind_name
from autodb.files.checksums import checksum
from autodb.files.part import PartFile
from autodb.sensing.ranges.inspection import Inspected, as_measured, passive_force
from autodb.store import Store, models
from autodb.wording import localized, phrase

KIND = "inspection"
PASSIVE = "x"
"""The component: radial, outward."""


@dataclass(frozen=True)
class OfCut:
    """Which cut of which imported recording a part is of."""

    machine: str
    recording: Path
    cut: float


def inspect(part: PartFile, *, where: str) -> Inspected:
    """Return the passive force that a part tells; raises UnusableInput naming ``where``."""
    try:
        return passive_force(as_measured(part), range_N=part.measured.largest_N)
    except UnusableInput as error:
        raise UnusableInput(behind_name(where, error.line)) from None


def keep_inspected(store: Store, part: PartFile, found: Inspected, of: OfCut) -> bool:
    """Keep what a part tells as a force sensed of its cut; False where it is kept already.

    Raises UnusableInput where the recording was not imported, has no such cut, or the cut's force
    was told by another part.
    """
    with store.writing(of.machine) as session:
        cut = _cut(session, of)
        row = _estimator(session, cut.recording.machine_id, part, cut.recording)
        measured = found.why_not is None
        sensed = {
            "value_N": found.force_N if measured else None,
            "sd_N": found.own_sd_N if measured else None,
            "common": [part.bar.share] if measured else None,
            "reason": found.why_not,
        }
        before = session.scalar(
            select(models.SensedForce).where(
                models.SensedForce.cut_id == cut.id,
                models.SensedForce.component == PASSIVE,
                models.SensedForce.estimator == KIND,
            )
        )
        if before is not None:
            if all(getattr(before, name) == value for name, value in sensed.items()):
                return False
            raise UnusableInput(
                phrase(
                    "{recording}: cut {cut}: its passive force was determined from another part; a "
                    "force that was used in a fit is not replaced",
                    recording=of.recording,
                    cut=localized(f"{of.cut:g}"),
                )
            )
        session.add(
            models.SensedForce(
                cut_id=cut.id, component=PASSIVE, estimator=KIND, estimator_id=row.id, **sensed
            )
        )
    return True


def _cut(session: Session, of: OfCut) -> models.Cut:
    owner = find_machine(session, of.machine)
    recording = session.scalar(
        select(models.StoredRecording).where(
            models.StoredRecording.machine_id == owner.id,
            models.StoredRecording.sha256 == checksum(of.recording),
            models.StoredRecording.withdrawn_at.is_(None),
        )
    )
    if recording is None:
        raise UnusableInput(
            phrase(
                "{recording}: not imported; run 'autodb import {recording} --machine {machine}'",
                recording=of.recording,
                machine=of.machine,
            )
        )
    found = next((cut for cut in recording.cuts if cut.number == of.cut), None)
    if found is None:
        numbers = ", ".join(f"{cut.number:g}" for cut in recording.cuts[:12])
        raise UnusableInput(
            phrase(
                "{file}: no cut {cut}; it has {numbers}",
                file=of.recording,
                cut=localized(f"{of.cut:g}"),
                numbers=numbers or phrase("no cuts"),
            )
        )
    return found


def _estimator(
    session: Session, machine_id: int, part: PartFile, recording: models.StoredRecording
) -> models.Estimator:
    """Return the version of this bar and machine: parts of one share its compliance's error."""
    model = {
        "bar": part.bar.model_dump(mode="json"),
        "machine_compliance_mm_N": part.machine_compliance_mm_N,
    }
    rows = newest(session, machine_id, KIND)
    if not rows or rows[0].model != model:
        scores = {"share": part.bar.share}
        keep_estimator(
            session, machine_id, KIND, {PASSIVE: FittedComponent(model, scores)}, [recording]
        )
        rows = newest(session, machine_id, KIND)
    elif recording not in rows[0].recordings:
        rows[0].recordings.append(recording)
    return rows[0]
