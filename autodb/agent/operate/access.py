"""Who may do what through the service: access tokens, kept as hashes, and what was done by whom.

A token is 32 random bytes, so one SHA-256 of it is enough: there is nothing to guess.

The audit log as a chain: each entry holds a SHA-256 of what it says and of the one before it.

Who changes, takes out or puts in an entry afterwards has to change all that follow; what does not
fit is found. Entries that are taken away from the end are not: who keeps the last hash elsewhere
sees that they are gone.
"""

import hashlib
import json
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from enum import IntEnum
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.errors import UnusableInput, near_words
from autodb.store import Also, Store, lock_audit, models
from autodb.wording import phrase

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


BEGINS = "autodb_"
"""What a token begins with, so that one that leaked is recognised."""
RANDOM_BYTES = 32
LENGTH = len(BEGINS) + len(secrets.token_urlsafe(RANDOM_BYTES))


class Role(IntEnum):
    """What a token allows: each role what those below it allow, too."""

    READ = 1
    OPERATE = 2
    ADMIN = 3

    @property
    def word(self) -> str:
        """How a role is written."""
        return self.name.lower()


ROLES = {role.word: role for role in Role}


@dataclass(frozen=True)
class Access:
    """Who asks: a name, what it may do, and its token's row; None: no token was needed."""

    who: str
    role: Role
    token_id: int | None


@dataclass(frozen=True)
class Token:
    """A token as it is listed: never its secret."""

    name: str
    role: str
    created_at: str
    expires_at: str | None
    revoked_at: str | None
    valid: bool


def add_token(store: Store, name: str, role: str, *, days: int | None) -> str:
    """Make a token and return its secret, which is nowhere kept.

    ``days``: how long it is valid; None: until it is revoked. Raises UnusableInput for a role that
    there is not, a name that is taken, or none.
    """
    if role not in ROLES:
        raise UnusableInput(
            phrase("--role '{role}': there is none{hint}", role=role, hint=near_words(role, ROLES))
        )
    if not name.strip() or not name.isprintable() or name != name.strip():
        raise UnusableInput(
            phrase(
                "token '{name}': has blanks at its ends, or control characters; use a name "
                "without them",
                name=name,
            )
        )
    secret = BEGINS + secrets.token_urlsafe(RANDOM_BYTES)
    until = None if days is None else _text(datetime.now(UTC) + timedelta(days=days))
    with store.writing() as session:
        if _named(session, name) is not None:
            raise UnusableInput(
                phrase("token '{name}': this name is taken; use another", name=name)
            )
        row = models.AccessToken(name=name, sha256=_hash(secret), role=role, expires_at=until)
        session.add(row)
        session.flush()
        note(session, COMMAND_LINE, "token added", row=("access_token", row.id), name=name)
    return secret


def revoke_token(store: Store, name: str) -> bool:
    """Revoke a token; False where it was already. Raises UnusableInput where there is none."""
    with store.writing() as session:
        row = _named(session, name)
        if row is None:
            every = list(session.scalars(select(models.AccessToken.name)))
            raise UnusableInput(
                phrase(
                    "no token '{name}'{hint}",
                    name=name,
                    hint=near_words(name, every) if every else "",
                )
            )
        if row.revoked_at is not None:
            return False
        row.revoked_at = models.now()
        note(session, COMMAND_LINE, "token revoked", row=("access_token", row.id), name=name)
        return True


def tokens(session: Session) -> list[Token]:
    """Return all tokens, oldest first."""
    rows = session.scalars(select(models.AccessToken).order_by(models.AccessToken.id))
    return [
        Token(row.name, row.role, row.created_at, row.expires_at, row.revoked_at, valid=_valid(row))
        for row in rows
    ]


def is_token(secret: str) -> bool:
    """Return whether a text has the shape of a token: any other needs no look at the database."""
    return len(secret) == LENGTH and secret.startswith(BEGINS)


def access_of(session: Session, secret: str) -> Access | None:
    """Return who a token is of; None where there is none such, or it is valid no more."""
    kept = models.AccessToken.sha256 == _hash(secret)
    row = session.scalar(select(models.AccessToken).where(kept))
    if row is None or not _valid(row):
        return None
    return Access(row.name, ROLES[row.role], row.id)


def note(
    session: Session,
    access: Access,
    action: str,
    *,
    row: tuple[str, int] | None = None,
    **detail: Any,
) -> None:
    """Keep who did what, to which row, with the change itself."""
    kind, number = row or (None, None)
    add_to_chain(
        session,
        models.AuditEntry(
            access_token_id=access.token_id,
            who=access.who,
            action=action,
            row_kind=kind,
            row_id=number,
            detail=detail or None,
        ),
    )


def noting(access: Access, action: str, row_kind: str, **detail: Any) -> Also:
    """Return what keeps who did what to a row, in the transaction that writes it."""

    def also(session: Session, number: int) -> None:
        note(session, access, action, row=(row_kind, number), **detail)

    return also


@dataclass(frozen=True)
class Noted:
    """One thing that someone did; ``sha256``: of it and of what was done before."""

    at: str
    who: str
    action: str
    row_kind: str | None
    row_id: int | None
    detail: Mapping[str, Any] | None
    sha256: str


def noted(session: Session, *, most: int, before: int | None = None) -> list[tuple[int, Noted]]:
    """Return what was done last, newest first, by number; of that, what was ``before`` one."""
    entry = models.AuditEntry
    query = select(entry).order_by(entry.id.desc()).limit(most)
    if before is not None:
        query = query.where(entry.id < before)
    return [
        (
            row.id,
            Noted(row.at, row.who, row.action, row.row_kind, row.row_id, row.detail, row.sha256),
        )
        for row in session.scalars(query)
    ]


COMMAND_LINE = Access("command line", Role.ADMIN, None)


def _named(session: Session, name: str) -> models.AccessToken | None:
    return session.scalar(select(models.AccessToken).where(models.AccessToken.name == name))


def _valid(row: models.AccessToken) -> bool:
    expired = row.expires_at is not None and row.expires_at <= models.now()
    return row.revoked_at is None and not expired


def _text(at: datetime) -> str:
    return at.isoformat(timespec="seconds")


def _hash(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()
