"""Limits of a spindle's power, and what its motor gives over speed."""

import sqlalchemy as sa
from alembic import op

revision = "0020"
down_revision = "0019"
branch_labels = None
depends_on = None

ADDED = {
    "limit_power_W": sa.Double,
    "limit_torque_curve": sa.JSON,
    "limit_power_curve": sa.JSON,
    "limit_efficiency": sa.Double,
}


def upgrade() -> None:
    """Add the columns: no machine that is there states them."""
    for name, kind in ADDED.items():
        op.add_column("axis", sa.Column(name, kind(), nullable=True))


def downgrade() -> None:
    """Drop what machines state of them."""
    for name in ADDED:
        op.drop_column("axis", name)
