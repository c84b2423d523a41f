"""Stored recordings: what they state of themselves, and which of their cuts count, as a table."""

from collections.abc import Mapping
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from autodb.records.tables import EDGE, CutTable, edge_codes
from autodb.sensing.ranges.validity import STATED
from autodb.store import models


def stated_start(row: models.StoredRecording) -> datetime | None:
    """Return when a recording began, as its side file states; None: it does not, or not so that
    it is read. A start without an offset is this computer's.
    """
    said = row.side.get("recording", {}).get("start")
    try:
        return datetime.fromisoformat(said).astimezone(UTC) if said else None
    except (ValueError, OverflowError):
        return None


def made_at(cut: models.Cut) -> str:
    """Return when a cut was made, by its recording's start and its `t`, or when it came in."""
    came_in = cut.recording.imported_at
    start = stated_start(cut.recording)
    try:
        at = start and start + timedelta(seconds=float(cut.conditions.get("t", 0.0)))
    except (ValueError, OverflowError):  # of a time that is no number of seconds
        return came_in
    return came_in if at is None else min(at.isoformat(timespec="seconds"), came_in)


def counted_cuts(recording: models.StoredRecording) -> list[models.Cut]:
    """Return the cuts of a recording whose place no other took; of one looked at, all."""
    return [cut for cut in recording.cuts if cut.superseded_at == recording.looked_at]


def cuts_as_table(
    cuts: list[models.Cut],
    *,
    path: Path,
    conditions: Mapping[int, Mapping[str, Any]] | None = None,
) -> CutTable:
    """Return stored cuts as one cut table; NaN where a cut lacks a channel that another has.

    ``conditions``: of cuts, by id, in place of those written down.
    """
    known = conditions or {}
    rows = [
        {**known.get(cut.id, cut.conditions), **cut.measured, "cut": cut.number} for cut in cuts
    ]
    names = sorted(set().union(*rows) - {EDGE}) if rows else ["cut"]
    channels = {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}
    texts = {
        "operation": [cut.operation or "" for cut in cuts],
        "work.material": [cut.pair.material.name if cut.pair else "" for cut in cuts],
        **{name: [_stated(cut.recording, name) for cut in cuts] for name in STATED},
    }
    labels = [row.get(EDGE) for row in rows]
    if None not in labels:
        texts[EDGE] = [v if isinstance(v, str) else f"{v:g}" for v in labels]
        channels[EDGE] = edge_codes(texts[EDGE])
    units = {name: unit for cut in cuts for name, unit in cut.recording.units.items()}
    return CutTable(path=path, channels=channels, texts=texts, units=units)


def _stated(row: models.StoredRecording, key: str) -> str:
    """Return what a recording's side file states in [recording]; empty: nothing."""
    value = row.side.get("recording", {}).get(key)
    return "" if value is None else str(value)
