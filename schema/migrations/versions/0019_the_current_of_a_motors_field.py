"""Forms of a spindle's calibration that take out the current of the motor's field."""

from alembic import op

revision = "0019"
down_revision = "0018"
branch_labels = None
depends_on = None

CHECK = "ck_calibration_kind"
BEFORE = (
    "line", "line-of-speed", "power", "power-of-speed", "line-warmed", "power-warmed",
    "power-of-speed-warmed", "anfis",
)  # fmt: skip
ADDED = ("magnetised", "magnetised-of-speed")


def upgrade() -> None:
    """Let calibrations be of the new kinds: none that is there is."""
    _allow(*BEFORE, *ADDED)


def downgrade() -> None:
    """Take back calibrations of the new kinds: as lines they say nothing, and sense nothing."""
    op.execute(
        "UPDATE calibration SET undone_at = COALESCE(undone_at, created_at), kind = 'line' "
        f"WHERE {_one_of(*ADDED)}"
    )
    _allow(*BEFORE)


def _allow(*kinds: str) -> None:
    with op.batch_alter_table("calibration") as table:
        table.drop_constraint(CHECK, type_="check")
        table.create_check_constraint(CHECK, _one_of(*kinds))


def _one_of(*kinds: str) -> str:
    return f"kind IN ({', '.join(repr(kind) for kind in kinds)})"
