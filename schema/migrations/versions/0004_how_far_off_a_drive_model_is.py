"""How far off a drive model is, by what the axis does and up to which frequency."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column: of earlier versions it is not known."""
    op.add_column("channel_model", sa.Column("errors", sa.JSON(), nullable=True))


def downgrade() -> None:
    """Forget it: it can be counted again on the recording."""
    op.drop_column("channel_model", "errors")
