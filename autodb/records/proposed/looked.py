"""A file looked at with a side file: what it is, and all that an import would say of it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from autodb.errors import UnusableInput
from autodb.files.side import SideFile
from autodb.files.text import TextSection
from autodb.readers import open_bases
from autodb.records.plausible import left_out_operations, refuse_implausible
from autodb.records.proposed.columns import ProposedBase, propose_channels
from autodb.records.proposed.written import proposed_side
from autodb.records.source import ChannelSet, open_as_stored
from autodb.records.summary import BaseSummary, summarise


@dataclass(frozen=True)
class LookedFile:
    """A file and the side file that it was looked at with, which is proposed where none was stated.

    ``found``: its time bases; none where it could not be opened. ``sets``: these with the channels
    of the side file, ``summaries``: what was read of those that can be. ``problems``: why it would
    be refused, all that is wrong; ``notes``: what else an import would say.
    """

    path: Path
    side: SideFile
    found: tuple[ProposedBase, ...] = ()
    sets: tuple[ChannelSet, ...] = ()
    summaries: tuple[BaseSummary, ...] = ()
    problems: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def proposed_bases(path: Path, stated: TextSection) -> tuple[ProposedBase, ...]:
    """Return the time bases of a file with what their columns may be; raises UnusableInput."""
    return tuple(propose_channels(base) for base in open_bases(path, stated))


def look_with(
    path: Path,
    side: SideFile,
    *,
    propose: bool,
    progress: Callable[[str], None] | None = None,
) -> LookedFile:
    """Look at a file with a side file, to whose channels what is proposed is added, if wanted."""
    try:
        found = proposed_bases(path, side.csv)
    except UnusableInput as fault:
        return LookedFile(path, side, problems=_of(path, fault))
    if propose:
        proposed = proposed_side(found)
        side = side.model_copy(update={"channels": proposed.channels, "values": proposed.values})
    sets: tuple[ChannelSet, ...] = ()
    summaries: tuple[BaseSummary, ...] = ()
    problems: tuple[str, ...] = ()
    try:
        source = open_as_stored(path, side)
        sets = source.bases
        summaries = summarise(source, progress=progress)
        refuse_implausible(source, summaries)
    except UnusableInput as fault:
        problems = _of(path, fault)
    notes = tuple(said for one in summaries for said in left_out_operations(one))
    return LookedFile(path, side, found, sets, summaries, problems, notes)


def _of(path: Path, fault: UnusableInput) -> tuple[str, ...]:
    """Return the problems of a file, each without the file's name."""
    said = fault.problems or (str(fault),)
    return tuple(one.removeprefix(f"{path}: ") for one in said)
