"""Where dropped recordings go first: a dated folder, that is emptied once its time is surely over.

A clock that jumps ahead makes everything old at once. So nothing is dropped while imports lie
implausibly far apart, and what is dropped can be put back for a while: into the inbox, where it is
known again.
"""

import shutil
from datetime import UTC, date, datetime, timedelta
from pathlib import Path

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.ingest.entries import KEPT
from autodb.store import models

TRASH = ".trash"
STAYS_DAYS, STAYS_PASSES = 30, 7
"""Days by the clock, and days with passes, that dropped files stay. Chosen: a clock that jumped has
passes of one day behind it, and a week of them is examined by somebody."""
FAR_DAYS, SURE_DAYS = 90, 3
"""Days between two imports that may be a clock that jumped, and days with imports after which it
was none. Chosen: a shop is closed for weeks, and not for a quarter of a year."""


def jumped(session: Session, machine_id: int) -> str | None:
    """Say what looks as if the clock had jumped; None: nothing does."""
    day = func.substr(models.StoredRecording.imported_at, 1, 10)
    query = (
        select(day)
        .where(models.StoredRecording.machine_id == machine_id)
        .group_by(day)
        .order_by(func.min(models.StoredRecording.id))
    )
    days = [date.fromisoformat(one) for one in session.scalars(query)]
    for number in range(max(1, len(days) - SURE_DAYS + 1), len(days)):
        apart = (days[number] - days[number - 1]).days
        if apart > FAR_DAYS:
            return (
                f"imports of {days[number - 1]} and {days[number]} lie {apart} days apart, as if a "
                f"clock had jumped: nothing is dropped until {SURE_DAYS} days have imports again"
            )
    return None


def throw(path: Path) -> None:
    """Put a file that an inbox keeps into today's folder of its trash."""
    kept = next(folder for folder in path.parents if folder.name == KEPT)
    target = kept / TRASH / _today().isoformat() / path.relative_to(kept)
    target.parent.mkdir(parents=True, exist_ok=True)
    path.replace(target)


def empty_trash(session: Session, machine_id: int, kept: Path) -> None:
    """Delete what was dropped long ago."""
    dated = [folder for folder in (kept / TRASH).glob("????-??-??") if folder.is_dir()]
    if not dated:
        return
    day = func.substr(models.RefreshPass.finished_at, 1, 10)
    passes = set(
        session.scalars(select(day).where(models.RefreshPass.machine_id == machine_id).distinct())
    )
    before = (_today() - timedelta(days=STAYS_DAYS)).isoformat()
    for folder in dated:
        since = sum(one is not None and one > folder.name for one in passes)
        if folder.name <= before and since >= STAYS_PASSES:
            shutil.rmtree(folder)


def _today() -> date:
    return datetime.now(UTC).date()
