"""Checksums of an SQLite file's rows, by which a value that changed by itself is found."""

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add their table; autodb.store fills it, and puts its triggers on, after every migration."""
    if op.get_bind().dialect.name == "sqlite":
        op.create_table(
            "row_checksum",
            sa.Column("of_table", sa.String(), nullable=False),
            sa.Column("part", sa.Integer(), autoincrement=False, nullable=False),
            sa.Column("rows", sa.Integer(), nullable=False),
            sa.Column("digest", sa.BigInteger(), nullable=False),
            sa.PrimaryKeyConstraint("of_table", "part"),
            sqlite_with_rowid=False,
        )


def downgrade() -> None:
    """Do without."""
    if op.get_bind().dialect.name == "sqlite":
        op.drop_table("row_checksum")
