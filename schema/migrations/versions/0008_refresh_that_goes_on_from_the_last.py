"""Passes that go on from the last one; files that come in again; recordings no longer kept."""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None

KINDS = (sa.CheckConstraint("kind IN ('cuts', 'series')"),)
"""A check of the table that has no name: it is lost with the copy unless it is given."""
CONTINUES = "fk_recording_continues"
STATES = "ix_cutting_parameters_state"
RETENTION = ("compress_after_days", "drop_after_days")
OLD = (("ix_recording_stored", "stored_path"), ("ix_recording_dropped", "dropped_at"))
"""Indices that find what is old without looking at what was seen to."""


def upgrade() -> None:
    """Add what is not known of any row yet: the next pass looks at every cut once more."""
    op.add_column("refresh_pass", sa.Column("last_cut_id", sa.Integer(), nullable=True))
    op.add_column("refresh_pass", sa.Column("last_force_id", sa.Integer(), nullable=True))
    op.add_column("refresh_pass", sa.Column("basis", sa.JSON(), nullable=True))
    op.add_column("inbox_file", sa.Column("stamp", sa.String(), nullable=True))
    op.add_column("recording", sa.Column("delivered_as", sa.String(), nullable=True))
    op.add_column("recording", sa.Column("dropped_at", sa.String(), nullable=True))
    with op.batch_alter_table("recording", table_args=KINDS) as table:
        table.add_column(sa.Column("continues_id", sa.Integer(), nullable=True))
        table.create_foreign_key(CONTINUES, "recording", ["continues_id"], ["id"])
    op.create_index("ix_recording_delivered_as", "recording", ["machine_id", "delivered_as"])
    op.add_column("cut", sa.Column("superseded_at", sa.String(), nullable=True))
    for name in RETENTION:
        op.add_column("machine", sa.Column(name, sa.Double(), nullable=True))
    for index, column in OLD:
        op.create_index(index, "recording", ["machine_id", column, "imported_at"])
    op.create_index("ix_cut_superseded_at", "cut", ["superseded_at"])
    op.create_index(STATES, "cutting_parameters", ["machine_id", "pair_id", "state", "version"])


def downgrade() -> None:
    """Forget them; a cut whose place another took belongs to no pair any more."""
    op.execute("UPDATE cut SET pair_id = NULL WHERE superseded_at IS NOT NULL")
    op.drop_index(STATES, "cutting_parameters")
    for index, _ in OLD:
        op.drop_index(index, "recording")
    for name in RETENTION:
        op.drop_column("machine", name)
    op.drop_index("ix_cut_superseded_at", "cut")
    op.drop_column("cut", "superseded_at")
    op.drop_index("ix_recording_delivered_as", "recording")
    with op.batch_alter_table("recording", table_args=KINDS) as table:
        table.drop_constraint(CONTINUES, type_="foreignkey")
        table.drop_column("continues_id")
    op.drop_column("recording", "dropped_at")
    op.drop_column("recording", "delivered_as")
    op.drop_column("inbox_file", "stamp")
    op.drop_column("refresh_pass", "basis")
    op.drop_column("refresh_pass", "last_force_id")
    op.drop_column("refresh_pass", "last_cut_id")
