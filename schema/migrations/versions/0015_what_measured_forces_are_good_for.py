"""What is known of the errors of measured forces: of dynamometers, forces and calibrations."""

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"
branch_labels = None
depends_on = None

COLUMNS = (
    ("machine", "dynamometer"),
    ("sensed_force", "errors"),
    ("calibration", "reference_errors"),
)


def upgrade() -> None:
    """Add the columns: of what is there nothing was stated."""
    for table, column in COLUMNS:
        op.add_column(table, sa.Column(column, sa.JSON(), nullable=True))


def downgrade() -> None:
    """Forget the errors, and the forces that were measured: earlier versions sense all of them."""
    made = "SELECT id FROM sensed_force WHERE errors IS NOT NULL"
    op.execute(f"DELETE FROM cutting_parameters_force WHERE sensed_force_id IN ({made})")
    op.execute("DELETE FROM sensed_force WHERE errors IS NOT NULL")
    for table, column in reversed(COLUMNS):
        op.drop_column(table, column)
