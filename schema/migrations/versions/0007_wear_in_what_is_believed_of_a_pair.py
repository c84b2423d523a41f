"""What a pair's parameters hold beside the law: terms that a person confirmed, and from where."""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None

LINK = "cutting_parameters_mismatch"


def upgrade() -> None:
    """Add the terms, and which mismatches they came from: no version before has any."""
    op.add_column("cutting_parameters", sa.Column("terms", sa.JSON(), nullable=True))
    op.create_table(
        LINK,
        sa.Column("cutting_parameters_id", sa.Integer(), primary_key=True),
        sa.Column("mismatch_id", sa.Integer(), primary_key=True),
        sa.ForeignKeyConstraint(
            ["cutting_parameters_id"], ["cutting_parameters.id"], ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(["mismatch_id"], ["mismatch.id"]),
    )
    op.create_index(f"ix_{LINK}_mismatch_id", LINK, ["mismatch_id"])


def downgrade() -> None:
    """Forget the versions that hold such terms, and what was predicted from them.

    Without its terms a version would be the law of fresh edges under the forces of worn ones. The
    mismatches stay confirmed.
    """
    held = "SELECT id FROM cutting_parameters WHERE terms IS NOT NULL"
    answered = (
        f"SELECT prediction_id FROM prediction_parameters WHERE cutting_parameters_id IN ({held})"
    )
    predictions = op.get_bind().execute(sa.text(answered)).scalars().all()
    op.drop_table(LINK)
    for name in ("prediction_parameters", "fleet_prior_parameters", "cutting_parameters_force"):
        op.execute(f"DELETE FROM {name} WHERE cutting_parameters_id IN ({held})")
    op.execute(f"UPDATE cutting_parameters SET relative_id = NULL WHERE relative_id IN ({held})")
    op.execute("DELETE FROM cutting_parameters WHERE terms IS NOT NULL")
    for number in set(predictions):
        statement = sa.text("DELETE FROM prediction_parameters WHERE prediction_id = :id")
        op.get_bind().execute(statement, {"id": number})
        op.get_bind().execute(sa.text("DELETE FROM prediction WHERE id = :id"), {"id": number})
    op.drop_column("cutting_parameters", "terms")
