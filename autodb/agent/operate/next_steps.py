"""What there is to do next in a database, by what it holds."""

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.rows.machines import machines_at_work
from autodb.store import models

Step = tuple[str, str]
"""A command, and why."""


def next_steps(session: Session) -> tuple[str, list[Step]]:
    """Return what the database holds, in a line, and the commands that go on from there."""
    machines = machines_at_work(session)
    if not machines:
        return "the database has no machine yet", [
            ("autodb machine add NAME", "add a machine, by default a lathe with x, z and spindle")
        ]
    recordings = _count(session, models.StoredRecording)
    calibrations = _count(session, models.CalibrationVersion)
    pairs = _count(session, models.CuttingParameters)
    waiting = session.scalar(
        select(func.count(models.Mismatch.id)).where(models.Mismatch.status == "open")
    )
    option = "" if len(machines) == 1 else " --machine NAME"
    there = (
        f"{_of(len(machines), 'machine')} ({', '.join(machines[:3])}"
        f"{', …' if len(machines) > 3 else ''}), {_of(recordings, 'recording')}, "
        f"{_of(calibrations, 'calibration')}, {_of(pairs, 'version')} of parameters"
    )
    steps: list[Step] = []
    if not recordings:
        steps.append(("autodb look FILE", "which column of a recording may be which channel"))
        steps.append(("autodb import FILE --machine NAME", "recordings and tables of cuts"))
    elif not calibrations and _has_currents(session):
        steps.append((f"autodb calibrate{option}", "from currents to forces, on standard cuts"))
    if recordings:
        steps.append((f"autodb refresh{option}", "sense new cuts, update what is learnt"))
    if pairs:
        steps.append((f"autodb predict JOB.toml{option}", "forces of the next job"))
        steps.append((f"autodb lookup{option}", "the pairs that are learnt, or one cut"))
    if waiting:
        steps.append((f"autodb mismatch list{option}", f"{waiting} causes wait for a decision"))
    return there, steps


def _has_currents(session: Session) -> bool:
    """Say whether a current of an axis was recorded: without one there is nothing to calibrate."""
    name = models.RecordingChannel.name
    return session.scalar(select(name).where(name.contains(".current")).limit(1)) is not None


def _count(session: Session, rows: type[models.Base]) -> int:
    return int(session.scalar(select(func.count()).select_from(rows)) or 0)


def _of(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
