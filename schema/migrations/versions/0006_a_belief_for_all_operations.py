"""A pair's parameters become one belief for all its operations and components."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None

RELATIVE = "fk_cutting_parameters_relative"
LAW = "thin_shear_zone"
"""The law whose belief the new columns hold; what an earlier law's rows say stays as it is."""


def upgrade() -> None:
    """Add what the belief holds beside mean and covariance; a per-component law has none of it."""
    with op.batch_alter_table("cutting_parameters") as table:
        table.alter_column("process_share", existing_type=sa.Double(), nullable=True)
        table.alter_column("misfit_N", existing_type=sa.Double(), nullable=True)
        table.add_column(sa.Column("shared", sa.JSON(), nullable=True))
        table.add_column(sa.Column("scatter", sa.JSON(), nullable=True))
        table.add_column(sa.Column("started_from", sa.String(), nullable=True))
        table.add_column(sa.Column("relative_id", sa.Integer(), nullable=True))
        table.create_foreign_key(RELATIVE, "cutting_parameters", ["relative_id"], ["id"])
    op.add_column("tool", sa.Column("included_deg", sa.Double(), nullable=True))
    op.add_column("prediction", sa.Column("started_from", sa.String(), nullable=True))


def downgrade() -> None:
    """Forget the beliefs, what was predicted from them, and the insert's included angle."""
    beliefs = "SELECT id FROM cutting_parameters WHERE law = :law"
    answered = (
        "SELECT prediction_id FROM prediction_parameters "
        f"WHERE cutting_parameters_id IN ({beliefs})"
    )
    predictions = op.get_bind().execute(sa.text(answered), {"law": LAW}).scalars().all()
    for statement in (
        f"DELETE FROM prediction_parameters WHERE cutting_parameters_id IN ({beliefs})",
        f"DELETE FROM fleet_prior_parameters WHERE cutting_parameters_id IN ({beliefs})",
        f"DELETE FROM cutting_parameters_force WHERE cutting_parameters_id IN ({beliefs})",
        "DELETE FROM cutting_parameters WHERE law = :law",
    ):
        op.get_bind().execute(sa.text(statement), {"law": LAW})
    for number in set(predictions):
        op.get_bind().execute(sa.text("DELETE FROM prediction WHERE id = :id"), {"id": number})
    op.execute("DELETE FROM prediction WHERE started_from IS NOT NULL")
    op.drop_column("prediction", "started_from")
    op.drop_column("tool", "included_deg")
    with op.batch_alter_table("cutting_parameters") as table:
        table.drop_constraint(RELATIVE, type_="foreignkey")
        for name in ("relative_id", "started_from", "scatter", "shared"):
            table.drop_column(name)
        table.alter_column("misfit_N", existing_type=sa.Double(), nullable=False)
        table.alter_column("process_share", existing_type=sa.Double(), nullable=False)
