"""What several machines know of a material, and what each pair's own cuts added to that."""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None

COMPONENT = "ck_fleet_prior_component"
PRIOR = "fk_prediction_prior"


def upgrade() -> None:
    """Add the columns: of earlier versions it is not known what they began with.

    A server's integers become long ones: a fleet has more forces than 2^31, and a file more bytes.
    """
    op.add_column("cutting_parameters", sa.Column("start", sa.JSON(), nullable=True))
    op.add_column("machine", sa.Column("shares", sa.String(), nullable=True))
    with op.batch_alter_table("fleet_prior") as table:
        table.drop_constraint(COMPONENT, type_="check")
        table.add_column(sa.Column("known", sa.JSON(), nullable=True))
    with op.batch_alter_table("prediction") as table:
        table.add_column(sa.Column("prior_id", sa.Integer(), nullable=True))
        table.create_foreign_key(PRIOR, "fleet_prior", ["prior_id"], ["id"])
    _whole_numbers(sa.INTEGER, sa.BIGINT)


def downgrade() -> None:
    """Forget priors for all components; what began from them keeps its words for it."""
    _whole_numbers(sa.BIGINT, sa.INTEGER)
    with op.batch_alter_table("prediction") as table:
        table.drop_constraint(PRIOR, type_="foreignkey")
        table.drop_column("prior_id")
    gone = "SELECT id FROM fleet_prior WHERE component = 'every'"
    op.execute(f"UPDATE cutting_parameters SET prior_id = NULL WHERE prior_id IN ({gone})")
    op.execute(f"DELETE FROM fleet_prior_parameters WHERE fleet_prior_id IN ({gone})")
    op.execute("DELETE FROM fleet_prior WHERE component = 'every'")
    with op.batch_alter_table("fleet_prior") as table:
        table.drop_column("known")
        table.create_check_constraint(COMPONENT, sa.text("component IN ('x', 'y', 'z')"))
    op.drop_column("machine", "shares")
    op.drop_column("cutting_parameters", "start")


def _whole_numbers(old: type[sa.Integer], new: type[sa.Integer]) -> None:
    """Change the type of a server's whole numbers, and of what numbers its rows."""
    bind = op.get_bind()
    if bind.dialect.name != "postgresql":
        return
    look = sa.inspect(bind)
    name = new().compile(bind.dialect)
    for table in look.get_table_names():
        of_type = [c["name"] for c in look.get_columns(table) if type(c["type"]) is old]
        changes = ", ".join(f'ALTER COLUMN "{column}" TYPE {name}' for column in of_type)
        if changes:
            op.execute(f'ALTER TABLE "{table}" {changes}')
    for sequence in look.get_sequence_names():
        op.execute(f'ALTER SEQUENCE "{sequence}" AS {name}')
