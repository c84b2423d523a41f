"""What went on: refresh passes, files that came in, who may do what and who did."""

from typing import Any

from sqlalchemy import CheckConstraint, ForeignKey, Index, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from autodb.store.models._base import Base, now, one_of

PASS_STATUSES = ("running", "done", "failed")
INBOX_STATUSES = ("waiting", "imported", "refused")
ROLES = ("read", "operate", "admin")


class RefreshPass(Base):
    """One pass of the refresh: when, how it ended, what it did; ``report`` is what it said.

    ``last_cut_id``: it and those before it looked at every cut up to this one, and at every sensed
    force up to ``last_force_id``, with the sensors and by the decisions of ``basis``; that holds,
    as ``asked``, what was explained and of what evidence, too.
    """

    __tablename__ = "refresh_pass"
    __table_args__ = (
        one_of("status", PASS_STATUSES, name="ck_refresh_pass_status"),
        CheckConstraint(
            "(status = 'running') = (finished_at IS NULL)", name="ck_refresh_pass_finished"
        ),
        Index("ix_refresh_pass_machine_started", "machine_id", "started_at"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    started_at: Mapped[str] = mapped_column(default=now)
    finished_at: Mapped[str | None]
    status: Mapped[str]
    imported: Mapped[int | None]
    sensed: Mapped[int | None]
    not_sensed: Mapped[int | None]
    versions: Mapped[int | None]
    report: Mapped[dict[str, Any] | None]
    last_cut_id: Mapped[int | None]
    last_force_id: Mapped[int | None]
    basis: Mapped[dict[str, Any] | None]


class InboxFile(Base):
    """One file that came into a machine's inbox, and what became of it.

    ``stamp``: sizes and times of the file and its side file, by which it is known unread.
    """

    __tablename__ = "inbox_file"
    __table_args__ = (
        UniqueConstraint("machine_id", "path", "sha256", name="uq_inbox_file_key"),
        one_of("status", INBOX_STATUSES, name="ck_inbox_file_status"),
        CheckConstraint("status <> 'refused' OR reason IS NOT NULL", name="ck_inbox_file_why"),
        Index("ix_inbox_file_machine_status", "machine_id", "status"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    path: Mapped[str]
    sha256: Mapped[str] = mapped_column(index=True)
    status: Mapped[str]
    reason: Mapped[str | None]
    seen_at: Mapped[str] = mapped_column(default=now)
    refresh_pass_id: Mapped[int | None] = mapped_column(ForeignKey("refresh_pass.id"), index=True)
    recording_id: Mapped[int | None] = mapped_column(ForeignKey("recording.id"), index=True)
    stamp: Mapped[str | None]


class AccessToken(Base):
    """One access token, kept only as its hash."""

    __tablename__ = "access_token"
    __table_args__ = (
        UniqueConstraint("name", name="uq_access_token_name"),
        UniqueConstraint("sha256", name="uq_access_token_sha256"),
        one_of("role", ROLES, name="ck_access_token_role"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str]
    sha256: Mapped[str]
    role: Mapped[str]
    created_at: Mapped[str] = mapped_column(default=now)
    expires_at: Mapped[str | None]
    revoked_at: Mapped[str | None]


class AuditEntry(Base):
    """One thing that someone did: ``row_kind`` and ``row_id`` say to which row.

    ``sha256``: of this entry and of the one before.
    """

    __tablename__ = "audit_entry"
    __table_args__ = (Index("ix_audit_entry_row", "row_kind", "row_id"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    at: Mapped[str] = mapped_column(default=now, index=True)
    access_token_id: Mapped[int | None] = mapped_column(ForeignKey("access_token.id"), index=True)
    who: Mapped[str]
    action: Mapped[str]
    row_kind: Mapped[str | None]
    row_id: Mapped[int | None]
    detail: Mapped[dict[str, Any] | None]
    sha256: Mapped[str]
