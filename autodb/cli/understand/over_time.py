"""Recordings over time that commands are given: read, and what is said of their stamps."""

from pathlib import Path
from typing import TYPE_CHECKING

from autodb.cli._common import (
    read_one,
    say,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from autodb.records import tables

    Step = Callable[[str], None]


def moves_of(
    path: Path, axis: str | None, columns: Path | None, group: str | None, resample: float | None
) -> "tables.Recording":
    """Read moves of an axis over time, refused where a channel cannot be what it claims."""
    from autodb.agent.sense.identifying import check_moves

    return check_moves(read_over_time(path, columns, group, resample), axis)


def say_time(recording: "tables.Recording") -> None:
    """Say what a recording's stamps are, where they are not even."""
    if not recording.timing.is_even:
        say(f"time: {recording.path.name}: {recording.timing}")


def read_over_time(
    path: Path, columns: Path | None, group: str | None, resample: float | None
) -> "tables.Recording":
    """Read a recording over time."""
    from autodb.records.resample import only_over_time

    return only_over_time(read_one(path, columns=columns, group=group, resample_hz=resample))
