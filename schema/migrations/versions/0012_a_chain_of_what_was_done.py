"""Each entry of the audit log holds a hash of itself and of the one before."""

import hashlib
import json

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None

ENTRY = sa.table(
    "audit_entry",
    sa.column("id", sa.Integer),
    sa.column("at", sa.String),
    sa.column("access_token_id", sa.Integer),
    sa.column("who", sa.String),
    sa.column("action", sa.String),
    sa.column("row_kind", sa.String),
    sa.column("row_id", sa.Integer),
    sa.column("detail", sa.JSON),
    sa.column("sha256", sa.String),
)
SAID = ("at", "access_token_id", "who", "action", "row_kind", "row_id", "detail")


def upgrade() -> None:
    """Add the column, and chain what is there as it is."""
    op.add_column("audit_entry", sa.Column("sha256", sa.String(), nullable=True))
    bind, before = op.get_bind(), ""
    for row in bind.execute(sa.select(ENTRY).order_by(ENTRY.c.id)).mappings().all():
        said = json.dumps([before, *(row[name] for name in SAID)], sort_keys=True)
        before = hashlib.sha256(said.encode()).hexdigest()
        bind.execute(sa.update(ENTRY).where(ENTRY.c.id == row["id"]).values(sha256=before))
    with op.batch_alter_table("audit_entry") as table:
        table.alter_column("sha256", existing_type=sa.String(), nullable=False)


def downgrade() -> None:
    """Forget the hashes."""
    with op.batch_alter_table("audit_entry") as table:
        table.drop_column("sha256")
