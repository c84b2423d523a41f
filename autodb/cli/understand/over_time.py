"""Recordings over time, and names of terms, that commands are given."""

from pathlib import Path
from typing import TYPE_CHECKING

from autodb.cli._common import (
    read_one,
    say,
)
from autodb.cli._reader import shown_again
from autodb.wording import phrase

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
        say(
            phrase(
                "time: {file}: {timing}",
                file=recording.path.name,
                timing=shown_again(str(recording.timing)),
            )
        )


def read_over_time(
    path: Path, columns: Path | None, group: str | None, resample: float | None
) -> "tables.Recording":
    """Read a recording over time."""
    from autodb.records.resample import only_over_time

    return only_over_time(read_one(path, columns=columns, group=group, resample_hz=resample))


def term_names(terms: str | None) -> tuple[str, ...] | None:
    """Return the names of ``--terms``, each once; None where the option is not given."""
    from autodb.errors import UnusableInput

    if terms is None:
        return None
    names = tuple(name.strip() for name in terms.split(",") if name.strip())
    if not names:
        raise UnusableInput(phrase("--terms: names no term; use inertia,viscous,coulomb,gravity"))
    for name in names:
        if names.count(name) > 1:
            raise UnusableInput(phrase("--terms: '{name}' is named twice; name it once", name=name))
    return names
