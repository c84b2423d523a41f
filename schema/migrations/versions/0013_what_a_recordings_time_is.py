"""What the stamps of a recording were found to be, and what was done about it."""

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column: of recordings that are there nobody has looked."""
    op.add_column("recording", sa.Column("timing", sa.JSON(), nullable=True))


def downgrade() -> None:
    """Forget it: the file says it again."""
    op.drop_column("recording", "timing")
