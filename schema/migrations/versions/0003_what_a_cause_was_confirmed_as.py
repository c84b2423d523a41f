"""The term that a mismatch was confirmed as, which may be one of its alternatives."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column: nothing could be confirmed before, so that no row lacks it."""
    op.add_column("mismatch", sa.Column("confirmed_term", sa.String(), nullable=True))


def downgrade() -> None:
    """Forget it: 0002 knows only that a mismatch was confirmed."""
    op.drop_column("mismatch", "confirmed_term")
