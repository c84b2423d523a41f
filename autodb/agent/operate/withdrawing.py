"""A recording that should not have come in is withdrawn, with all that was derived from it.

Its cuts count no more; what was learnt, fitted or calibrated with it is taken back, and what was so
before holds again. The next refresh learns anew without it. Nothing is deleted: a trace says what
was withdrawn, when and why, and it can come back.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.uncounted import anew
from autodb.agent.operate.reversing import forgotten
from autodb.agent.rows.counted_edges import count_edges
from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.posteriors import pair_name, resting_on
from autodb.agent.rows.recordings import counted_cuts
from autodb.errors import NotThere, UnusableInput
from autodb.store import Also, Store, models, nothing_else
from autodb.wording import msgid, phrase, stored_msgid

READ_AGAIN = stored_msgid("its file was read again with another side file")


@dataclass
class Withdrawn:
    """What was done: cuts that count no more, or again; in words, what was taken back with them.

    ``already``: it was so before, and only what is to be learnt anew may still be missing.
    """

    recording: int
    cuts: int
    taken_back: list[str] = field(default_factory=list)
    already: bool = False


def withdraw(
    store: Store, machine: str, number: int, *, why: str, also: Also = nothing_else
) -> Withdrawn:
    """Withdraw a recording of a machine. ``also``: what else is written then.

    Raises NotThere where the machine has none of that number, UnusableInput where it is withdrawn
    for another reason.
    """
    with store.writing(machine) as session:
        row = _recording(session, machine, number)
        if row.withdrawn_at is not None and row.withdrawn_why == why:
            return Withdrawn(number, 0, already=True)
        if row.withdrawn_at is not None:
            raise UnusableInput(
                phrase(
                    "recording {number} was withdrawn on {day} ({why})",
                    number=number,
                    day=row.withdrawn_at,
                    why=row.withdrawn_why,
                )
            )
        if row.looked_at is not None:
            raise UnusableInput(
                phrase(
                    "recording {number} was imported only to be explained; nothing depends on it",
                    number=number,
                )
            )
        done = withdrawn_now(session, row, why)
        also(session, number)
        return done


def withdrawn_now(session: Session, row: models.StoredRecording, why: str) -> Withdrawn:
    """Have a recording count no more, with all that was derived from it."""
    cuts = counted_cuts(row)
    done = Withdrawn(row.id, len(cuts), _taken_back(session, row))
    row.withdrawn_at, row.withdrawn_why = models.now(), why
    for cut in cuts:
        cut.superseded_at = row.withdrawn_at
    for parameters in count_edges(session, row.machine_id, cuts):
        done.taken_back.append(_version_of_pair(parameters))
    return done


def take_again(store: Store, machine: str, number: int, *, also: Also = nothing_else) -> Withdrawn:
    """Have a withdrawn recording count again, as if it came in now; what was fitted with it stays
    taken back. Raises NotThere as ``withdraw``.
    """
    with store.writing(machine) as session:
        row = _recording(session, machine, number)
        if row.withdrawn_at is None:
            return Withdrawn(number, 0, already=True)
        _refuse_a_second(session, row)
        anew(session, row, since=row.withdrawn_at)
        row.withdrawn_at = row.withdrawn_why = None
        also(session, number)
        return Withdrawn(number, len(counted_cuts(row)))


def _recording(session: Session, machine: str, number: int) -> models.StoredRecording:
    owner = find_machine(session, machine)
    row = session.get(models.StoredRecording, number)
    if row is None or row.machine_id != owner.id:
        raise NotThere(
            phrase(
                "machine '{machine}' has no recording {number}; find those behind a number with "
                "'autodb trace'",
                machine=machine,
                number=number,
            )
        )
    return row


def read_again(session: Session, row: models.StoredRecording) -> Withdrawn:
    """Withdraw a recording whose file is read again, as its side file says now."""
    return withdrawn_now(session, row, READ_AGAIN)


def _refuse_a_second(session: Session, row: models.StoredRecording) -> None:
    """Raise UnusableInput where the file of a withdrawn recording counts as another one."""
    alike = models.StoredRecording
    other = session.scalar(
        select(alike.id).where(
            alike.machine_id == row.machine_id,
            alike.sha256 == row.sha256,
            alike.withdrawn_at.is_(None),
        )
    )
    if other is not None:
        raise UnusableInput(
            phrase(
                "recording {number} was read again as recording {other}; withdraw that one first",
                number=row.id,
                other=other,
            )
        )


def _taken_back(session: Session, row: models.StoredRecording) -> list[str]:
    """Take back all that was derived from a recording; return it in words."""
    said = []
    fitted = _calibrations(session, row), _models(session, row), _scales(session, row)
    sensors = _estimators(session, row, fitted[0])
    derived: list[_Derived] = [*fitted[0], *fitted[1], *fitted[2], *sensors]
    for one in derived:
        one.undone_at = models.now()
        said.append(_named(one))
    for parameters in _parameters(session, row, fitted[0], sensors):
        parameters.undone_at = models.now()
        said.append(_version_of_pair(parameters))
    holding = models.Mismatch.found_in_any([row.id])
    for mismatch in session.scalars(
        select(models.Mismatch).where(holding, models.Mismatch.status != "rejected")
    ):
        others = [one for one in mismatch.recordings if one is not row]
        if others:
            said.append(_stays(mismatch, others))
            mismatch.recording, mismatch.further = others[0], others[1:]
            continue
        said += [
            phrase("mismatch {number}, {status}", number=mismatch.id, status=mismatch.status),
            *forgotten(session, mismatch),
        ]
        mismatch.status, mismatch.decided_at = "rejected", models.now()
        mismatch.confirmed_term = mismatch.applied = None
    return said


def _stays(mismatch: models.Mismatch, others: list[models.StoredRecording]) -> str:
    """Return that a mismatch stays, with other recordings that show it."""
    alone = msgid("mismatch {number}, {status}, stays with recording {others}")
    several = msgid("mismatch {number}, {status}, stays with recordings {others}")
    return phrase(
        several if len(others) > 1 else alone,
        number=mismatch.id,
        status=mismatch.status,
        others=", ".join(str(one.id) for one in others),
    )


def _version_of_pair(row: models.CuttingParameters) -> str:
    return phrase("{pair} version {version}", pair=pair_name(row.pair), version=row.version)


_Derived = models.CalibrationVersion | models.ChannelModel | models.DriveScale | models.Estimator


def _named(one: _Derived) -> str:
    match one:
        case models.CalibrationVersion():
            return phrase(
                "calibration of {axis} version {version}", axis=one.axis, version=one.version
            )
        case models.ChannelModel():
            return phrase(
                "model of {channel} version {version}", channel=one.channel, version=one.version
            )
        case models.DriveScale():
            return phrase("scale of {axis} version {version}", axis=one.axis, version=one.version)
    return phrase(
        "sensor {kind} of force.{component} version {version}",
        kind=one.kind,
        component=one.component,
        version=one.version,
    )


def _calibrations(session: Session, row: models.StoredRecording) -> list[models.CalibrationVersion]:
    """Return the calibrations made on a recording, or corrected by what it alone shows."""
    made, link = models.CalibrationVersion, models.calibration_mismatch.c
    corrected = (
        select(link.calibration_id)
        .join(models.Mismatch, models.Mismatch.id == link.mismatch_id)
        .where(models.Mismatch.recording_id == row.id, ~models.Mismatch.further.any())
    )
    query = select(made).where(
        made.undone_at.is_(None),
        made.recordings.any(models.StoredRecording.id == row.id) | made.id.in_(corrected),
    )
    return list(session.scalars(query.order_by(made.id)))


def _models(session: Session, row: models.StoredRecording) -> list[models.ChannelModel]:
    """Return the models fitted with a recording, and those that took one of them as known."""
    made = models.ChannelModel
    every = session.scalars(
        select(made).where(made.machine_id == row.machine_id, made.undone_at.is_(None))
    ).all()
    return [one for one in every if any(row in ancestor.recordings for ancestor in _line(one))]


def _line(model: models.ChannelModel) -> Iterable[models.ChannelModel]:
    one: models.ChannelModel | None = model
    while one is not None:
        yield one
        one = one.parent


def _scales(session: Session, row: models.StoredRecording) -> list[models.DriveScale]:
    made = models.DriveScale
    query = select(made).where(made.undone_at.is_(None), made.recording_id == row.id)
    return list(session.scalars(query.order_by(made.id)))


def _estimators(
    session: Session, row: models.StoredRecording, calibrations: Iterable[models.CalibrationVersion]
) -> list[models.Estimator]:
    made, gone = models.Estimator, [one.id for one in calibrations]
    from_it = made.recordings.any(models.StoredRecording.id == row.id)
    from_it |= made.calibrations.any(models.CalibrationVersion.id.in_(gone))
    return list(session.scalars(select(made).where(made.undone_at.is_(None), from_it)))


def _parameters(
    session: Session,
    row: models.StoredRecording,
    calibrations: Iterable[models.CalibrationVersion],
    sensors: Iterable[models.Estimator],
) -> list[models.CuttingParameters]:
    """Return versions of pairs that rest on a recording's cuts, or on what was derived from it."""
    force = models.SensedForce
    its = force.cut.has(models.Cut.recording_id == row.id)
    its |= force.calibration_id.in_([one.id for one in calibrations])
    its |= force.estimator_id.in_([one.id for one in sensors])
    return resting_on(session, row.machine_id, models.CuttingParameters.forces.any(its))
