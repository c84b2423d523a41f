"""Recordings, their channels, the cuts in them, and the edges that those were made with."""

from typing import Any

from sqlalchemy import (
    CheckConstraint,
    ColumnElement,
    Connection,
    ForeignKey,
    Index,
    Table,
    UniqueConstraint,
    event,
    func,
    text,
)
from sqlalchemy.orm import Mapped, mapped_column, relationship

from autodb.store.models._base import Base, now, table_of
from autodb.store.models.work import Pair, Tool

COUNTING = "uq_recording_counting"
"""The index that has a file count once, of the recordings that are not withdrawn."""


def counting_cut(superseded_at: Any) -> ColumnElement[bool]:
    """Return whether cuts count, for queries of one machine's: by no index of a database.

    Nearly all cuts count, and SQLite takes ``superseded_at IS NULL`` for rare: by its index it goes
    through the cuts of all machines.
    """
    return func.coalesce(superseded_at, "") == ""


class StoredRecording(Base):
    """One imported file, known by its checksum; the side file is kept as it was read.

    A file that was read again, as its side file said then, is there once more; only one counts.

    ``delivered_as``: the path that it came in under, ``path`` where it lies; NULL: the same.
    ``stored_path``: where our own copy lies, with its checksum; NULL: there is only ``path``.
    ``continues_id``: the first recording that the file came in as, where it came again with more.
    ``dropped_at``: since when no file of it is kept; what was derived from it stays.
    ``content``: by what one over time is known again, in whatever bytes.
    ``looked_at``: when it came in to be explained alone, so that its cuts do not count.
    ``withdrawn_at``: since when it does not count any more, and ``withdrawn_why``.
    ``timing``: by time base, what its stamps were found to be; NULL of cuts, and where nobody
    looked.
    """

    __tablename__ = "recording"
    __table_args__ = (
        Index(COUNTING, "machine_id", "sha256", unique=True),
        CheckConstraint("kind IN ('cuts', 'series')"),
        CheckConstraint(
            "(stored_path IS NULL) = (stored_sha256 IS NULL)", name="ck_recording_stored_copy"
        ),
        Index("ix_recording_content", "machine_id", "content"),
        Index("ix_recording_delivered_as", "machine_id", "delivered_as"),
        Index("ix_recording_stored", "machine_id", "stored_path", "imported_at"),
        Index("ix_recording_dropped", "machine_id", "dropped_at", "imported_at"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    sha256: Mapped[str]
    path: Mapped[str]
    kind: Mapped[str]
    rows: Mapped[int]
    units: Mapped[dict[str, Any]]
    side: Mapped[dict[str, Any]]
    imported_at: Mapped[str] = mapped_column(default=now)
    stored_path: Mapped[str | None]
    stored_sha256: Mapped[str | None]
    stored_bytes: Mapped[int | None]
    delivered_as: Mapped[str | None]
    continues_id: Mapped[int | None] = mapped_column(
        ForeignKey("recording.id", name="fk_recording_continues")
    )
    dropped_at: Mapped[str | None]
    content: Mapped[str | None]
    looked_at: Mapped[str | None]
    withdrawn_at: Mapped[str | None]
    withdrawn_why: Mapped[str | None]
    timing: Mapped[dict[str, Any] | None]
    cuts: Mapped[list["Cut"]] = relationship(back_populates="recording", order_by="Cut.number")
    channels: Mapped[list["RecordingChannel"]] = relationship(order_by="RecordingChannel.id")

    @property
    def first_id(self) -> int:
        """The recording that the file came in as first, which may be this."""
        return self.continues_id or self.id


@event.listens_for(table_of(StoredRecording), "before_create")
def _count_once(recordings: Table, connection: Connection, **_given: object) -> None:
    """Have the index hold what counts alone. Its condition has an option for each kind of database.

    Stated with the index, it would load the library of each, PostgreSQL's too, with the models.
    """
    (counting,) = (index for index in recordings.indexes if index.name == COUNTING)
    counting.dialect_kwargs[f"{connection.dialect.name}_where"] = text("withdrawn_at IS NULL")


class RecordingChannel(Base):
    """One channel of a recording on one time base; minimum to sd in ``unit``."""

    __tablename__ = "recording_channel"
    __table_args__ = (
        UniqueConstraint("recording_id", "time_base", "name", name="uq_recording_channel_key"),
        CheckConstraint("minimum <= maximum", name="ck_recording_channel_range"),
        CheckConstraint("rate_hz > 0", name="ck_recording_channel_rate"),
        Index("ix_recording_channel_name", "name"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    recording_id: Mapped[int] = mapped_column(ForeignKey("recording.id"), index=True)
    time_base: Mapped[str]
    name: Mapped[str]
    unit: Mapped[str]
    rows: Mapped[int]
    rate_hz: Mapped[float | None]
    minimum: Mapped[float | None]
    maximum: Mapped[float | None]
    mean: Mapped[float | None]
    sd: Mapped[float | None]


class Cut(Base):
    """One cut of a recording: its conditions, and its measured channels by name.

    ``state``: what the cutting was like, such as a built-up edge; NULL: not known.
    ``superseded_at``: since when its recording, which came in again with another content, has
    another in its place, or is withdrawn; it does not count any more.
    ``content``: by what a cut of a table is known again, in whatever bytes.
    ``lot``: of the work material, such as a bar or a heat number; NULL: nobody said.
    ``named``: its job, program, cut of the job and block of the program, as far as stated.
    ``edge_change_id``: the change that gave its tool the edge it was made with, and
    ``edge_used_s``: for how long that had cut before; NULL: no change was recorded before it, or
    the time is not known.
    """

    __tablename__ = "cut"
    __table_args__ = (
        UniqueConstraint("recording_id", "number"),
        Index("ix_cut_pair_operation", "pair_id", "operation"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    recording_id: Mapped[int] = mapped_column(ForeignKey("recording.id"), index=True)
    pair_id: Mapped[int | None] = mapped_column(ForeignKey("pair.id"), index=True)
    number: Mapped[float]
    operation: Mapped[str | None]
    conditions: Mapped[dict[str, Any]]
    measured: Mapped[dict[str, Any]]
    started_at: Mapped[str | None] = mapped_column(index=True)
    state: Mapped[str | None]
    superseded_at: Mapped[str | None] = mapped_column(index=True)
    content: Mapped[str | None] = mapped_column(index=True)
    named: Mapped[dict[str, Any] | None]
    lot: Mapped[str | None]
    edge_change_id: Mapped[int | None] = mapped_column(
        ForeignKey("edge_change.id", name="fk_cut_edge_change"), index=True
    )
    edge_used_s: Mapped[float | None]
    recording: Mapped[StoredRecording] = relationship(back_populates="cuts")
    pair: Mapped[Pair | None] = relationship()
    edge_change: Mapped["ChangedEdge | None"] = relationship()


class ChangedEdge(Base):
    """One change of a tool's edge on a machine, as a person recorded it.

    ``after_cut_id``: the last cut that had come in when the change was recorded as of now; NULL:
    its time was stated. ``recounts``: how often cuts were counted anew for it that had been
    examined; ``undone_at``: since when it does not count.
    """

    __tablename__ = "edge_change"
    __table_args__ = (Index("ix_edge_change_tool", "machine_id", "tool_id", "at"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"))
    tool_id: Mapped[int] = mapped_column(ForeignKey("tool.id"), index=True)
    at: Mapped[str]
    said_by: Mapped[str | None]
    why: Mapped[str | None]
    made_at: Mapped[str] = mapped_column(default=now)
    undone_at: Mapped[str | None]
    after_cut_id: Mapped[int | None]
    recounts: Mapped[int] = mapped_column(server_default="0", default=0)
    tool: Mapped[Tool] = relationship()
