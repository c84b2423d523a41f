"""Cuts say which of a job they are; predictions are linked with the cuts that were then made."""

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"
branch_labels = None
depends_on = None

MATCHES = ("name", "conditions", "stated")


def upgrade() -> None:
    """Add what cuts are called, what widened a prediction, and the links: of none it is known."""
    op.add_column("cut", sa.Column("named", sa.JSON(), nullable=True))
    op.add_column("prediction", sa.Column("width", sa.JSON(), nullable=True))
    whole = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
    op.create_table(
        "predicted_cut",
        sa.Column("id", whole, primary_key=True),
        sa.Column("prediction_id", whole, sa.ForeignKey("prediction.id"), nullable=False),
        sa.Column("number", whole, nullable=False),
        sa.Column("name", sa.String(), nullable=False),
        sa.Column("cut_id", whole, sa.ForeignKey("cut.id", ondelete="CASCADE"), nullable=False),
        sa.Column("matched_by", sa.String(), nullable=False),
        sa.Column("expected", sa.JSON(), nullable=False),
        sa.Column("made", sa.JSON(), nullable=True),
        sa.Column("created_at", sa.String(), nullable=False),
        sa.UniqueConstraint("cut_id", name="uq_predicted_cut_cut"),
        sa.CheckConstraint("number > 0", name="ck_predicted_cut_number"),
        sa.CheckConstraint(
            f"matched_by IN ({', '.join(repr(one) for one in MATCHES)})",
            name="ck_predicted_cut_matched_by",
        ),
    )
    op.create_index("ix_predicted_cut_prediction_id", "predicted_cut", ["prediction_id"])


def downgrade() -> None:
    """Forget the links and the names; intervals that were stored stay as wide as they were."""
    op.drop_table("predicted_cut")
    op.drop_column("prediction", "width")
    op.drop_column("cut", "named")
