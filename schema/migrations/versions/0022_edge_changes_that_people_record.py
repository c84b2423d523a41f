"""Edge changes that people record, and for how long each edge had cut before a cut."""

import sqlalchemy as sa
from alembic import op

revision = "0022"
down_revision = "0021"
branch_labels = None
depends_on = None

OF_CUT = "fk_cut_edge_change"


def upgrade() -> None:
    """Add the changes, and what is counted of cuts since: of those that are there nothing is."""
    whole = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
    op.create_table(
        "edge_change",
        sa.Column("id", whole, primary_key=True),
        sa.Column("machine_id", whole, sa.ForeignKey("machine.id"), nullable=False),
        sa.Column("tool_id", whole, sa.ForeignKey("tool.id"), nullable=False),
        sa.Column("at", sa.String(), nullable=False),
        sa.Column("said_by", sa.String(), nullable=True),
        sa.Column("why", sa.String(), nullable=True),
        sa.Column("made_at", sa.String(), nullable=False),
        sa.Column("undone_at", sa.String(), nullable=True),
        sa.Column("after_cut_id", whole, nullable=True),
        sa.Column("recounts", whole, server_default="0", nullable=False),
    )
    op.create_index("ix_edge_change_tool", "edge_change", ["machine_id", "tool_id", "at"])
    op.create_index("ix_edge_change_tool_id", "edge_change", ["tool_id"])
    with op.batch_alter_table("cut") as table:
        table.add_column(sa.Column("edge_change_id", whole, nullable=True))
        table.add_column(sa.Column("edge_used_s", sa.Double(), nullable=True))
        table.create_foreign_key(OF_CUT, "edge_change", ["edge_change_id"], ["id"])
    op.create_index("ix_cut_edge_change_id", "cut", ["edge_change_id"])


def downgrade() -> None:
    """Forget the changes; what was learnt of wear by what was counted of cuts is taken back."""
    op.execute(
        "UPDATE cutting_parameters SET undone_at = created_at WHERE undone_at IS NULL AND terms IS "
        "NOT NULL AND EXISTS (SELECT 1 FROM cutting_parameters_force AS used JOIN sensed_force ON "
        "sensed_force.id = used.sensed_force_id JOIN cut ON cut.id = sensed_force.cut_id WHERE "
        "used.cutting_parameters_id = cutting_parameters.id AND cut.edge_change_id IS NOT NULL)"
    )
    op.drop_index("ix_cut_edge_change_id", "cut")
    with op.batch_alter_table("cut") as table:
        table.drop_constraint(OF_CUT, type_="foreignkey")
        table.drop_column("edge_used_s")
        table.drop_column("edge_change_id")
    op.drop_table("edge_change")
