"""A file that is read again, as its side file says now: its recordings before are withdrawn."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0021"
down_revision = "0020"
branch_labels = None
depends_on = None

COUNTING = "uq_recording_counting"
COLUMNS = ("machine_id", "sha256")
OF_SERVER, OF_FILE = "recording_machine_id_sha256_key", "uq_recording_machine_id"
"""What PostgreSQL calls the key, and what is made for SQLite's, which has no name of its own."""


def upgrade() -> None:
    """Let a file be there once more, where what it was before is withdrawn."""
    if _on_server():
        op.drop_constraint(OF_SERVER, "recording", type_="unique")
    else:
        named = {"uq": "uq_%(table_name)s_%(column_0_name)s"}
        with _recordings(naming_convention=named) as table:
            table.drop_constraint(OF_FILE, type_="unique")
    counting = sa.text("withdrawn_at IS NULL")
    op.create_index(
        COUNTING, "recording", list(COLUMNS), unique=True, sqlite_where=counting,
        postgresql_where=counting,
    )  # fmt: skip


def downgrade() -> None:
    """Have each file be there once: one that was withdrawn and read again is no file's any more."""
    op.drop_index(COUNTING, "recording")
    op.execute(
        "UPDATE recording SET sha256 = sha256 || '-' || id WHERE withdrawn_at IS NOT NULL AND "
        "EXISTS (SELECT 1 FROM recording AS other WHERE other.machine_id = recording.machine_id "
        "AND other.sha256 = recording.sha256 AND other.id <> recording.id)"
    )
    if _on_server():
        op.create_unique_constraint(OF_SERVER, "recording", list(COLUMNS))
    else:
        with _recordings(sa.UniqueConstraint(*COLUMNS), recreate="always"):
            pass


def _on_server() -> bool:
    return bool(op.get_bind().dialect.name == "postgresql")


@contextmanager
def _recordings(*also: sa.Constraint, **more: Any) -> Iterator[Any]:
    """Copy the table, with the check that has no name, which a copy of it would be without."""
    kinds = sa.CheckConstraint("kind IN ('cuts', 'series')")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Unnamed CHECK constraint", UserWarning)
        with op.batch_alter_table("recording", table_args=(kinds, *also), **more) as table:
            yield table
