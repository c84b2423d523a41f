"""Decisions on mismatches have a reason and a history; what they changed can be taken back."""

import sqlalchemy as sa
from alembic import op

revision = "0018"
down_revision = "0017"
branch_labels = None
depends_on = None

STATES = ("open", "confirmed", "rejected")
RUNOUT = ("runout_mm", "runout_deg", "runout_sd_mm")


def upgrade() -> None:
    """Add the history, lots of material, run-out and corrections: of decisions that stand no reason
    is known.
    """
    op.add_column("mismatch", sa.Column("applied", sa.JSON(), nullable=True))
    op.add_column("cut", sa.Column("lot", sa.String(), nullable=True))
    for name in RUNOUT:
        op.add_column("tool", sa.Column(name, sa.Double(), nullable=True))
    op.add_column("calibration", sa.Column("corrections", sa.JSON(), nullable=True))
    whole = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
    op.create_table(
        "mismatch_decision",
        sa.Column("id", whole, primary_key=True),
        sa.Column(
            "mismatch_id", whole, sa.ForeignKey("mismatch.id", ondelete="CASCADE"), nullable=False
        ),
        sa.Column("status", sa.String(), nullable=False),
        sa.Column("term", sa.String(), nullable=True),
        sa.Column("why", sa.String(), nullable=True),
        sa.Column("decided_by", sa.String(), nullable=True),
        sa.Column("decided_at", sa.String(), nullable=False),
        sa.CheckConstraint(
            f"status IN ({', '.join(repr(one) for one in STATES)})",
            name="ck_mismatch_decision_status",
        ),
    )
    op.create_index("ix_mismatch_decision_mismatch_id", "mismatch_decision", ["mismatch_id"])
    op.create_table(
        "calibration_mismatch",
        sa.Column(
            "calibration_id",
            whole,
            sa.ForeignKey("calibration.id", ondelete="CASCADE"),
            primary_key=True,
        ),
        sa.Column("mismatch_id", whole, sa.ForeignKey("mismatch.id"), primary_key=True),
    )
    op.create_index("ix_calibration_mismatch_mismatch_id", "calibration_mismatch", ["mismatch_id"])


def downgrade() -> None:
    """Forget history and lots; take back versions with what the schema before cannot hold."""
    held = "CAST(terms AS TEXT) LIKE '%built_up_edge%' OR CAST(terms AS TEXT) LIKE '%hard_spot%'"
    for table, holds in (("cutting_parameters", held), ("calibration", "corrections IS NOT NULL")):
        op.execute(
            f"UPDATE {table} SET undone_at = created_at WHERE undone_at IS NULL AND ({holds})"
        )
    op.drop_table("calibration_mismatch")
    op.drop_table("mismatch_decision")
    for name in RUNOUT:
        op.drop_column("tool", name)
    op.drop_column("calibration", "corrections")
    op.drop_column("cut", "lot")
    op.drop_column("mismatch", "applied")
