"""Recordings of a machine: which there are, what was found in them, what rests on each."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import Select, func, select
from sqlalchemy.orm import Session

from autodb.agent.answer.shown.resting import Resting, resting_on_recording
from autodb.agent.ingest.importing import time_sentences
from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.recordings import stated_start
from autodb.errors import NotThere
from autodb.sensing.ranges.sensed_force import PASSIVE_IN_NO_CURRENT
from autodb.store import models
from autodb.wording import day, msgid, phrase, phrase_many
from autodb.wording.kept import said_again

MISSING = msgid("file missing")
USED, WITHDRAWN, EXPLAINED = msgid("used"), msgid("withdrawn"), msgid("only explained")


@dataclass(frozen=True)
class RecordingSeen:
    """A recording at a glance; ``began_at`` as its side file states, ``cuts`` that were found.

    ``length_s`` and ``rate_hz`` of its longest time base; None of a table of cuts. ``flags``: in
    words, what there is to know of its quality; ``learnt_from``: whether anything rests on it.
    """

    id: int
    name: str
    kind: str
    began_at: str | None
    imported_at: str
    rows: int
    length_s: float | None
    rate_hz: float | None
    channels: int
    cuts: int
    state: str
    flags: tuple[str, ...]
    learnt_from: bool


@dataclass(frozen=True)
class RecordedChannel:
    """A channel of a recording: its rows, rate and range, in ``unit``."""

    name: str
    unit: str
    rows: int
    rate_hz: float | None
    minimum: float | None
    maximum: float | None
    mean: float | None
    sd: float | None


@dataclass(frozen=True)
class RecordingSaid:
    """A recording as it stands: ``findings`` on its quality, and what rests on it.

    ``withdrawn_why``: the reason that was given; None: it is not withdrawn.
    """

    machine: str
    seen: RecordingSeen
    path: str
    sha256: str
    withdrawn_why: str | None
    findings: tuple[str, ...]
    channels: tuple[RecordedChannel, ...]
    resting: tuple[Resting, ...]


def recordings_seen(
    session: Session, machine: str, *, most: int, before: int | None = None
) -> list[RecordingSeen]:
    """Return a machine's recordings, newest first, ``most`` of those ``before`` a number.

    Raises NotThere for an unknown machine.
    """
    table = models.StoredRecording
    query = select(table).where(table.machine_id == find_machine(session, machine).id)
    if before is not None:
        query = query.where(table.id < before)
    return _seen(session, session.scalars(query.order_by(table.id.desc()).limit(most)).all())


def stored_recording(session: Session, machine: str, number: int) -> models.StoredRecording:
    """Return a recording of a machine; raises NotThere where it has none of that number."""
    owner, row = find_machine(session, machine), session.get(models.StoredRecording, number)
    if row is None or row.machine_id != owner.id:
        raise NotThere(
            phrase(
                "machine '{machine}' has no recording {number}; look at all of them",
                machine=machine, number=number,
            )
        )  # fmt: skip
    return row


def recording_said(session: Session, machine: str, number: int) -> RecordingSaid:
    """Return one recording; raises NotThere as ``stored_recording``."""
    row = stored_recording(session, machine, number)
    (seen,) = _seen(session, [row])
    return RecordingSaid(
        machine=machine,
        seen=seen,
        path=row.path,
        sha256=row.sha256,
        withdrawn_why=row.withdrawn_why,
        findings=_findings(session, row, seen),
        channels=tuple(
            RecordedChannel(**{name: getattr(one, name) for name in _OF_CHANNEL})
            for one in row.channels
        ),
        resting=resting_on_recording(session, row),
    )


_OF_CHANNEL = ("name", "unit", "rows", "rate_hz", "minimum", "maximum", "mean", "sd")


def _seen(session: Session, rows: Sequence[models.StoredRecording]) -> list[RecordingSeen]:
    """Return recordings with what is asked of all of them at once."""
    numbers = [row.id for row in rows]
    bases, cuts = _bases(session, numbers), _cuts(session, numbers)
    not_sensed, used = _not_sensed(session, numbers), _used(session, numbers)
    found = []
    for row in rows:
        channels, base_rows, rate_hz = bases.get(row.id, (0, row.rows, None))
        found.append(
            RecordingSeen(
                id=row.id,
                name=Path(row.delivered_as or row.path).name,
                kind=row.kind,
                began_at=None if (at := stated_start(row)) is None else at.isoformat(),
                imported_at=row.imported_at,
                rows=row.rows,
                length_s=base_rows / rate_hz if rate_hz else None,
                rate_hz=rate_hz,
                channels=channels,
                cuts=cuts.get(row.id, 0),
                state=_state(row),
                flags=_flags(row, not_sensed.get(row.id, 0)),
                learnt_from=row.id in used,
            )
        )
    return found


def _state(row: models.StoredRecording) -> str:
    if row.withdrawn_at is not None:
        return WITHDRAWN
    return USED if row.looked_at is None else EXPLAINED


def _flags(row: models.StoredRecording, not_sensed: int) -> tuple[str, ...]:
    """Return what there is to know of a recording's quality, a few words each."""
    uneven = time_sentences(row, but_even=True)
    said = [phrase("uneven time")] if uneven else []
    if not_sensed:
        said.append(
            phrase_many("{count} force not sensed", "{count} forces not sensed", not_sensed)
        )
    if row.dropped_at is not None:
        said.append(phrase("file not kept"))
    elif not any(Path(one).exists() for one in (row.path, row.stored_path) if one):
        said.append(phrase(MISSING))
    return tuple(said)


def _findings(
    session: Session, row: models.StoredRecording, seen: RecordingSeen
) -> tuple[str, ...]:
    """Return what was found of a recording's quality, a sentence each."""
    stamps = (said_again(one) for one in time_sentences(row))
    said: list[str] = [phrase("Time stamps: {what}.", what=one) for one in stamps]
    if row.withdrawn_at is not None:
        at = day(row.withdrawn_at[:10])
        said.append(phrase("It was withdrawn on {day}: {why}.", day=at, why=row.withdrawn_why))
    if row.looked_at is not None:
        said.append(phrase("It came in only to be explained: nothing is learnt from it."))
    if row.dropped_at is not None:
        at = day(row.dropped_at[:10])
        said.append(phrase("Its file is not kept since {day}; what rests on it stays.", day=at))
    elif phrase(MISSING) in seen.flags:
        said.append(
            phrase("Its file is not under {path}: put it back to see it and to fit anew.",
                path=row.path)
        )  # fmt: skip
    still = [one.name for one in row.channels if one.rows > 1 and one.minimum == one.maximum]
    if still:
        said.append(phrase("The same number in every row: {channels}.", channels=", ".join(still)))
    force, cut = models.SensedForce, models.Cut
    why = (
        select(force.component, force.reason, func.count())
        .join(cut, cut.id == force.cut_id)
        .where(cut.recording_id == row.id, force.reason.is_not(None))
        .group_by(force.component, force.reason)
        .order_by(func.count().desc())
    )
    for component, reason, count in session.execute(why):
        said.append(
            phrase_many(
                "Force {axis} of {count} cut was not sensed: {why}.",
                "Force {axis} of {count} cuts was not sensed: {why}.",
                count,
                axis=component.upper(),
                why=said_again(reason or ""),
            )
        )
    return tuple(said)


def _bases(session: Session, numbers: Sequence[int]) -> dict[int, tuple[int, int, float | None]]:
    """Return of recordings how many channels they have, and rows and rate of the longest base."""
    table = models.RecordingChannel
    query = (
        select(table.recording_id, func.count(), func.max(table.rows), func.max(table.rate_hz))
        .where(table.recording_id.in_(numbers), table.name.not_in(("t", "cut")))
        .group_by(table.recording_id)
    )
    return {number: (count, rows, rate) for number, count, rows, rate in session.execute(query)}


def _cuts(session: Session, numbers: Sequence[int]) -> dict[int, int]:
    table = models.Cut
    query = select(table.recording_id, func.count()).where(table.recording_id.in_(numbers))
    return _counts(session, query.group_by(table.recording_id))


def _not_sensed(session: Session, numbers: Sequence[int]) -> dict[int, int]:
    """Return how many forces of recordings' cuts were not sensed, but those that never show."""
    force, cut = models.SensedForce, models.Cut
    query = (
        select(cut.recording_id, func.count())
        .join(force, force.cut_id == cut.id)
        .where(
            cut.recording_id.in_(numbers),
            force.reason.is_not(None),
            ~force.reason.endswith(PASSIVE_IN_NO_CURRENT),
        )
        .group_by(cut.recording_id)
    )
    return _counts(session, query)


def _counts(session: Session, query: Select[int, int]) -> dict[int, int]:
    return {row[0]: row[1] for row in session.execute(query)}


def _used(session: Session, numbers: Sequence[int]) -> set[int]:
    """Return which recordings something rests on: a calibration, a model, a sensor, parameters."""
    found: set[int] = set()
    for link in (
        models.calibration_recording, models.channel_model_recording, models.estimator_recording,
    ):  # fmt: skip
        column = link.c.recording_id
        found |= set(session.scalars(select(column).where(column.in_(numbers)).distinct()))
    force, cut, added = models.SensedForce, models.Cut, models.cutting_parameters_force.c
    learnt = (
        select(cut.recording_id)
        .join(force, force.cut_id == cut.id)
        .join(models.cutting_parameters_force, added.sensed_force_id == force.id)
        .where(cut.recording_id.in_(numbers))
        .distinct()
    )
    return found | set(session.scalars(learnt))
