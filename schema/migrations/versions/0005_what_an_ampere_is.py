"""What an ampere of a drive is, told by known loads; what friction is off its laws."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the table, and the column: earlier versions were their terms alone."""
    op.add_column("channel_model", sa.Column("off_law", sa.JSON(), nullable=True))
    op.create_table(
        "drive_scale",
        sa.Column("id", sa.Integer(), primary_key=True),
        sa.Column("machine_id", sa.Integer(), sa.ForeignKey("machine.id"), nullable=False),
        sa.Column("axis", sa.String(), nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("kind", sa.String(), nullable=False),
        sa.Column("per_ampere", sa.Double(), nullable=False),
        sa.Column("share", sa.Double(), nullable=False),
        sa.Column("source", sa.String(), nullable=False),
        sa.Column("recording_id", sa.Integer(), sa.ForeignKey("recording.id"), nullable=False),
        sa.Column("created_at", sa.String(), nullable=False),
        sa.UniqueConstraint("machine_id", "axis", "version", name="uq_drive_scale_key"),
        sa.CheckConstraint(
            "kind IN ('added-mass', 'force', 'standard-cut')", name="ck_drive_scale_kind"
        ),
        sa.CheckConstraint("per_ampere > 0", name="ck_drive_scale_per_ampere"),
    )
    op.create_index("ix_drive_scale_machine_id", "drive_scale", ["machine_id"])


def downgrade() -> None:
    """Forget them: both can be told again from the recordings."""
    op.drop_table("drive_scale")
    op.drop_column("channel_model", "off_law")
