"""Cuts and recordings known by what they hold; recordings only looked at, or withdrawn."""

import json
from collections.abc import Sequence
from hashlib import blake2b
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"
branch_labels = None
depends_on = None

ADDED = (
    ("cut", "content"),
    ("recording", "content"),
    ("recording", "looked_at"),
    ("recording", "withdrawn_at"),
    ("recording", "withdrawn_why"),
    ("machine", "retired_at"),
    ("calibration", "undone_at"),
    ("channel_model", "undone_at"),
    ("drive_scale", "undone_at"),
    ("estimator", "undone_at"),
)
CUTS = """
SELECT cut.id, cut.number, cut.operation, material.name, tool.name, cut.conditions, cut.measured
FROM cut JOIN recording ON recording.id = cut.recording_id
LEFT JOIN pair ON pair.id = cut.pair_id
LEFT JOIN material ON material.id = pair.material_id LEFT JOIN tool ON tool.id = pair.tool_id
WHERE recording.kind = 'cuts' ORDER BY cut.id
"""
CHANNELS = """
SELECT recording_id, channel.name, unit, channel.rows, minimum, maximum, mean, sd
FROM recording_channel AS channel JOIN recording ON recording.id = channel.recording_id
WHERE recording.kind = 'series' ORDER BY recording_id
"""
DIGITS, SHARE_DIGITS = 12, 8


def upgrade() -> None:
    """Add the columns, and fill what tells cuts and recordings that are there."""
    for table, column in ADDED:
        op.add_column(table, sa.Column(column, sa.String(), nullable=True))
    op.create_index("ix_cut_content", "cut", ["content"])
    op.create_index("ix_recording_content", "recording", ["machine_id", "content"])
    bind = op.get_bind()
    for number, *row in bind.execute(sa.text(CUTS)).all():
        _keep("cut", number, _of_cut(row))
    series: dict[int, list[list[str]]] = {}
    for number, *row in bind.execute(sa.text(CHANNELS)).all():
        series.setdefault(number, []).append(_of_channel(row))
    for number, channels in series.items():
        _keep("recording", number, _digest(sorted(channels)))


def downgrade() -> None:
    """Forget them: what was only looked at, or withdrawn, had no cuts that count."""
    op.drop_index("ix_recording_content", "recording")
    op.drop_index("ix_cut_content", "cut")
    for table, column in reversed(ADDED):
        op.drop_column(table, column)


def _keep(table: str, number: int, content: str) -> None:
    statement = sa.text(f"UPDATE {table} SET content = :content WHERE id = :number")
    op.get_bind().execute(statement, {"content": content, "number": number})


def _of_cut(row: Sequence[Any]) -> str:
    number, operation, material, tool, *values = row
    named = [_shown(number), operation, material or "", tool or ""]
    return _digest([*named, *(_all(one) for one in values)])


def _of_channel(row: Sequence[Any]) -> list[str]:
    name, unit, rows, *ends, mean, sd = row
    largest = max((abs(end) for end in ends if end is not None), default=0.0) or 1.0
    spread = (mean, sd)
    shares = [None if one is None else round(one / largest, SHARE_DIGITS) + 0.0 for one in spread]
    return [name, unit, str(rows), *map(_shown, ends), *map(_shown, shares)]


def _all(stored: Any) -> list[list[str]]:
    values = json.loads(stored) if isinstance(stored, str) else stored
    return [[name, _shown(values[name])] for name in sorted(values)]


def _shown(value: Any) -> str:
    return str(value) if value is None or isinstance(value, str) else f"{value + 0.0:.{DIGITS}g}"


def _digest(values: Sequence[Any]) -> str:
    return blake2b(json.dumps(values).encode(), digest_size=16).hexdigest()
