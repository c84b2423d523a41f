"""A file that came in before under its name, with another content: what of it counts.

A table of cuts that has grown, or whose damaged rows were mended, is the same table where at least
half of the cuts that both number alike are equal: equal ones stay with the recording that brought
them, a changed one takes the place of the one before, others are new. A recording over time is the
same where nine tenths of the rows that both have are equal: it takes the earlier one's place.
One that is shorter than what was there is taken for cut off, and changes nothing. Anything else
that a logger writes under one name is a recording of its own. Under any name, cuts that are there
with the same content (autodb.agent.rows.content) are not counted again.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import or_, select
from sqlalchemy.orm import Session

from autodb.errors import UnusableInput
from autodb.files.checksums import checksum
from autodb.files.side import SideFile
from autodb.records.source import RecordingSource, open_as_stored
from autodb.store import models

CUTS_ALIKE, ROWS_ALIKE = 0.5, 0.9
"""Share of cuts and of rows from which on two files hold the same. Chosen: two cuts' noise is never
equal but while the machine stands; damage or a missing end leaves more."""
ASKED_AT_ONCE = 500
Array = NDArray[np.float64]


def earlier(session: Session, machine_id: int, path: Path) -> list[models.StoredRecording]:
    """Return the recordings of a machine that came in under a path, newest first."""
    under = str(path.resolve())
    lies_there = models.StoredRecording.delivered_as.is_(None) & (
        models.StoredRecording.path == under
    )
    query = (
        select(models.StoredRecording)
        .where(
            models.StoredRecording.machine_id == machine_id,
            or_(models.StoredRecording.delivered_as == under, lies_there),
        )
        .order_by(models.StoredRecording.id.desc())
    )
    return list(session.scalars(query))


@dataclass(frozen=True)
class SortedCuts:
    """Cuts that came in: ``new`` ones; how many were there; those whose place new ones take.

    ``continues``: the first recording, by id, of the same table; None: it is another.
    """

    new: list[models.Cut]
    there: int
    replaced: list[models.Cut]
    continues: int | None = None


def twins(session: Session, machine_id: int, cuts: Sequence[models.Cut]) -> dict[str, models.Cut]:
    """Return the cuts of a machine that count and are the same as some, by their content."""
    found: dict[str, models.Cut] = {}
    wanted = [cut.content for cut in cuts]
    for begin in range(0, len(wanted), ASKED_AT_ONCE):
        query = (
            select(models.Cut)
            .join(models.StoredRecording)
            .where(
                models.StoredRecording.machine_id == machine_id,
                models.counting_cut(models.Cut.superseded_at),
                models.Cut.content.in_(wanted[begin : begin + ASKED_AT_ONCE]),
            )
        )
        found |= {str(cut.content): cut for cut in session.scalars(query)}
    return found


def sorted_cuts(cuts: list[models.Cut], before: Sequence[models.StoredRecording]) -> SortedCuts:
    """Return which cuts of a table are new beside those of what came in under its name before."""
    known = {
        cut.number: cut
        for recording in reversed(before)
        for cut in recording.cuts
        if cut.superseded_at is None
    }
    twins = [cut for cut in cuts if cut.number in known]
    equal = {cut.number for cut in twins if _content(cut) == _content(known[cut.number])}
    if not twins or len(equal) < CUTS_ALIKE * len(twins):
        return SortedCuts(cuts, 0, [])
    if len(cuts) < len(known):
        equal = {cut.number for cut in twins}
    new = [cut for cut in cuts if cut.number not in equal]
    replaced = [known[cut.number] for cut in twins if cut.number not in equal]
    return SortedCuts(new, len(equal), replaced, known[twins[0].number].recording.first_id)


def _content(cut: models.Cut) -> tuple[object, ...]:
    return cut.operation, cut.pair_id, cut.conditions, cut.measured


def rows_alike(before: RecordingSource, now: RecordingSource) -> tuple[float, bool]:
    """Return the share of equal rows that two recordings over time both have, and whether the later
    is shorter; nothing where one cannot be read.
    """
    try:
        old, new = (_first_base(source) for source in (before, now))
    except UnusableInput:
        return 0.0, False
    names = sorted(old.keys() & new.keys())
    if not names:
        return 0.0, False
    lengths = [min(len(one[name]) for name in names) for one in (old, new)]
    pairs = [(old[name][: min(lengths)], new[name][: min(lengths)]) for name in names]
    alike = np.all([np.isclose(a, b, rtol=1e-9, atol=0.0, equal_nan=True) for a, b in pairs], 0)
    return float(np.mean(alike)) if min(lengths) else 0.0, lengths[1] < lengths[0]


def _first_base(source: RecordingSource) -> dict[str, Array]:
    """Return a file's first time base, by channel."""
    blocks = [channels for channels, _ in source.usable()[0].blocks()]
    return {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0]}


def as_it_was(path: Path, sha256: str, side: SideFile) -> RecordingSource | None:
    """Open a recording that came in before, with what its side file said; None: not there."""
    if not path.is_file() or checksum(path) != sha256:
        return None
    return open_as_stored(path, side)
