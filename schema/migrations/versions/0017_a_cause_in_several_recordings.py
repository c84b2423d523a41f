"""A mismatch may be found in several recordings together, and in the cuts of one pair alone."""

import sqlalchemy as sa
from alembic import op

revision = "0017"
down_revision = "0016"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the links and what a mismatch was found in: those that are there keep their recording."""
    op.add_column("mismatch", sa.Column("found_in", sa.JSON(), nullable=True))
    _link("recording")
    _link("pair")


def downgrade() -> None:
    """Keep each mismatch with the first of its recordings alone."""
    op.drop_table("mismatch_pair")
    op.drop_table("mismatch_recording")
    op.drop_column("mismatch", "found_in")


def _link(right: str) -> None:
    whole = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
    name = f"mismatch_{right}"
    op.create_table(
        name,
        sa.Column(
            "mismatch_id",
            whole,
            sa.ForeignKey("mismatch.id", ondelete="CASCADE"),
            primary_key=True,
        ),
        sa.Column(f"{right}_id", whole, sa.ForeignKey(f"{right}.id"), primary_key=True),
    )
    op.create_index(f"ix_{name}_{right}_id", name, [f"{right}_id"])
