"""The audit log as a chain: each entry holds a SHA-256 of what it says and of the one before it.

Who changes, takes out or puts in an entry afterwards has to change all that follow; what does not
fit is found. Entries that are taken away from the end are not: who keeps the last hash elsewhere
sees that they are gone.
"""

import hashlib
import json

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.store import lock_audit, models

ROWS_AT_ONCE = 1000
SAID = ("at", "access_token_id", "who", "action", "row_kind", "row_id", "detail")


def add_to_chain(session: Session, entry: models.AuditEntry) -> None:
    """Add an entry behind the last one; nobody else adds one until this commits."""
    lock_audit(session)
    session.flush()
    newest = select(models.AuditEntry.sha256).order_by(models.AuditEntry.id.desc()).limit(1)
    entry.at = models.now()
    entry.sha256 = _digest(session.scalar(newest) or "", entry)
    session.add(entry)
    session.flush()


def first_broken(session: Session) -> int | None:
    """Return the first entry, by id, that does not fit what is before it; None: all do."""
    every = select(models.AuditEntry).order_by(models.AuditEntry.id)
    before = ""
    for entry in session.scalars(every.execution_options(yield_per=ROWS_AT_ONCE)):
        if entry.sha256 != _digest(before, entry):
            return entry.id
        before = entry.sha256
    return None


def _digest(before: str, entry: models.AuditEntry) -> str:
    said = json.dumps([before, *(getattr(entry, name) for name in SAID)], sort_keys=True)
    return hashlib.sha256(said.encode()).hexdigest()
