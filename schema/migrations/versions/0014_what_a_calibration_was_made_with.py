"""What a calibration was made with, and the laws that were nearly as good."""

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column: of calibrations that are there nobody has kept it."""
    op.add_column("calibration", sa.Column("domain", sa.JSON(), nullable=True))


def downgrade() -> None:
    """Forget it: intervals beyond the range are as they were."""
    op.drop_column("calibration", "domain")
