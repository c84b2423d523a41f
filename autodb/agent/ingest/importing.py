"""A file enters the database once, known by its checksum."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.cuts_in_file import cuts_in, made_cuts
from autodb.agent.ingest.redelivered import (
    ROWS_ALIKE,
    SortedCuts,
    as_it_was,
    earlier,
    rows_alike,
    sorted_cuts,
    twins,
)
from autodb.agent.ingest.uncounted import counted
from autodb.agent.rows.content import of_series
from autodb.agent.rows.counted_edges import count_edges
from autodb.agent.rows.machines import find_machine, working_machine
from autodb.agent.rows.recordings import counted_cuts
from autodb.errors import UnusableInput
from autodb.files.checksums import checksum
from autodb.files.side import SideFile, StatedColumns
from autodb.records import source as records
from autodb.records.plausible import left_out_operations, refuse_implausible
from autodb.records.source import RecordingSource
from autodb.records.summary import BaseSummary, summarise
from autodb.records.tables import CutTable
from autodb.store import Store, models
from autodb.timing import Timing
from autodb.wording import phrase

TakeBack = Callable[[Session, models.StoredRecording], object]
"""Has a recording count no more, with what was derived from it."""


@dataclass(frozen=True)
class Imported:
    """What an import did; ``other_side``: it was there already, with another side file.

    ``withdrawn``: it was there, and does not count, for this reason; ``looked_at``: it was there,
    and was only looked at.

    ``timing``: what its stamps are, a sentence for each time base.

    ``cuts`` are new; ``again`` were there, of a file that came in before under its name or with the
    same content, and ``replaced`` had another content then. ``unpaired`` new ones say no work
    material or no tool: nothing is learnt of them. ``notes``: how the file is written,
    what of it is not read, and what was left out of the averages of a raw recording's cut.
    """

    recording_id: int
    kind: str
    rows: int
    cuts: int
    already_there: bool
    other_side: bool = False
    notes: tuple[str, ...] = ()
    again: int = 0
    replaced: int = 0
    withdrawn: str | None = None
    looked_at: bool = False
    timing: tuple[str, ...] = ()
    unpaired: int = 0


@dataclass(frozen=True)
class KeepAt:
    """Where a file lies from now on, and what else is written in the import's transaction.

    ``came_as``: the path that it counts as having come in under; None: the one that it is read at.
    """

    path: Path
    also: Callable[[Session, Imported], None]
    came_as: Path | None = None


def import_file(
    store: Store,
    path: Path,
    *,
    machine: str,
    columns: StatedColumns = None,
    progress: Callable[[str], None] | None = None,
    kept: KeepAt | None = None,
    looked_at: bool = False,
    instead: TakeBack | None = None,
) -> Imported:
    """Import one recording or cut table of a machine; a second time says it is already there.

    The file is read in blocks, its checksum taken and its channels checked; a table of cuts is
    kept cut by cut, raw phase currents give the cut they hold, and of any other recording over time
    the cut is kept that its side file states. Currents take the axis' sign
    from the machine. Of a file that came in before under its name only what is new counts
    (``redelivered``). What is only ``looked_at`` does not count, until it is imported.
    ``instead``: takes back what is there of the file with another side file, in the transaction
    that has it in as it is read now; None: what is there holds, where it is not withdrawn.

    Raises UnusableInput, SetAside of a raw cut that nothing can be learned from; then nothing is
    written.
    """
    source = records.open_source(path, columns=columns)
    sha256 = checksum(path)
    came_as = path if kept is None or kept.came_as is None else kept.came_as
    with store.reading() as session:
        machine_id = working_machine(session, machine).id
        known = _known(session, machine_id, sha256, source.side)
        again = known is not None and _is_read_again(known, instead)
        before = None if known else _same_series(session, machine_id, source, came_as)
    if known is not None and not again:
        return _once_more(store, machine, known, kept, looked_at=looked_at)
    _refuse_of_another(source, path, machine)
    row, cuts, notes = _read_in(source, sha256, progress)
    with store.writing(machine) as session:
        owner = find_machine(session, machine)
        # another agent may have been faster, or it was there in other bytes
        done = _known(session, owner.id, sha256, source.side, row.content)
        if done is not None and _is_read_again(done, instead):
            if instead is not None and done.withdrawn is None:
                instead(session, session.get_one(models.StoredRecording, done.recording_id))
                session.flush()
            done = None
        if done is None:
            row.delivered_as = str(came_as.resolve())
            if kept is not None:
                row.path = str(kept.path.resolve())
            if looked_at:
                row.looked_at = models.now()
            done = replace(_keep(session, owner, row, cuts, before), notes=notes)
        elif not looked_at:
            counted(session, done.recording_id)
        if kept is not None:
            kept.also(session, done)
        return done


def _read_in(
    source: RecordingSource, sha256: str, progress: Callable[[str], None] | None
) -> tuple[models.StoredRecording, CutTable | None, tuple[str, ...]]:
    """Return a file's recording and cuts, and what is to be said of how it was read."""
    summary = summarise(source, progress=progress)
    refuse_implausible(source, summary)
    cuts, notes = cuts_in(source, progress)
    unknown = [sentence for base in summary for sentence in left_out_operations(base)]
    return _row(source, summary, sha256), cuts, (*source.remarks, *unknown, *notes)


def _is_read_again(known: Imported, instead: TakeBack | None) -> bool:
    """Say whether a file that is there is read as another side file says now."""
    return known.other_side and (instead is not None or known.withdrawn is not None)


def _refuse_of_another(source: RecordingSource, path: Path, machine: str) -> None:
    """Refuse a file whose side file names another machine."""
    named = source.side.recording.machine
    if named is not None and named != machine:
        raise UnusableInput(
            phrase(
                "{file}: its side file says machine '{named}', not '{machine}'",
                file=path,
                named=named,
                machine=machine,
            )
        )


def _once_more(
    store: Store, machine: str, known: Imported, kept: KeepAt | None, *, looked_at: bool
) -> Imported:
    """Have a recording that is there count, where it was only looked at before."""
    begins = known.looked_at and not looked_at
    if begins or kept is not None:
        with store.writing(machine) as session:
            if begins:
                counted(session, known.recording_id)
            if kept is not None:
                kept.also(session, known)
    return known


@dataclass(frozen=True)
class _Again:
    """The recording over time, by id, that came in again; ``cut_off``: it is shorter now."""

    recording: int
    cut_off: bool


def _same_series(
    session: Session, machine_id: int, source: RecordingSource, came_as: Path
) -> _Again | None:
    before = earlier(session, machine_id, came_as)
    if not before or before[0].kind != "series":
        return None
    for path, sha256 in files_of(before[0]).items():
        there = as_it_was(path, sha256, SideFile.model_validate(before[0].side))
        if there is not None:
            share, cut_off = rows_alike(there, source)
            return _Again(before[0].id, cut_off) if share >= ROWS_ALIKE else None
    return None


def _row(
    source: RecordingSource, summary: Sequence[BaseSummary], sha256: str
) -> models.StoredRecording:
    channels = [row for base in summary for row in _channel_rows(base)]
    cuts = any(base.holds_cuts for base in summary)
    return models.StoredRecording(
        sha256=sha256,
        path=str(source.path.resolve()),
        kind="cuts" if cuts else "series",
        rows=max(base.rows for base in summary),
        units={n: u for base in source.usable() for n, u in base.conversion.units.items()},
        side=_said(source.side),
        channels=channels,
        content=None if cuts else of_series(channels),
        timing=_timings(summary),
    )


def _timings(summary: Sequence[BaseSummary]) -> dict[str, Any] | None:
    """Return by time base what its stamps are: kinds, sentence, rate and pieces."""
    found = {base.name: base.timing for base in summary if base.timing is not None}
    return {name: _verdict(timing) for name, timing in found.items()} or None


def _verdict(timing: Timing) -> dict[str, Any]:
    """Return a verdict on stamps as it is kept."""
    return {
        "kinds": list(timing.kinds),
        "said": str(timing),
        "rate_hz": timing.rate_hz,
        "pieces": len(timing.pieces),
    }


def _said(side: SideFile) -> dict[str, Any]:
    return side.model_dump(mode="json", exclude_defaults=True)


def _keep(
    session: Session,
    owner: models.Machine,
    recording: models.StoredRecording,
    cuts: CutTable | None,
    before: _Again | None,
) -> Imported:
    """Add a recording with its cuts, of a file that came in again those that are new.

    Not where all of them are in one that is there.
    """
    made = [] if cuts is None else made_cuts(session, owner, cuts)
    recording.machine_id = owner.id
    if recording.looked_at is not None:
        return _aside(session, recording, made)
    if recording.kind == "cuts":
        with session.no_autoflush:
            there = twins(session, owner.id, made)
            holding = {there[one.content].recording_id for one in made if one.content in there}
            if len(holding) == 1 and len(there) == len(made):
                return _as_known(
                    session.get_one(models.StoredRecording, *holding), other_side=False
                )
            found = sorted_cuts(made, earlier(session, owner.id, Path(str(recording.delivered_as))))
        new = [cut for cut in found.new if cut.content not in there]
        found = replace(found, new=new, there=found.there + len(found.new) - len(new))
    elif before is None:
        found = SortedCuts(made, 0, [])
    else:
        last = session.get_one(models.StoredRecording, before.recording)
        old, first = counted_cuts(last), last.first_id
        cut_off = before.cut_off
        found = SortedCuts([], len(old), [], first) if cut_off else SortedCuts(made, 0, old, first)
    recording.continues_id = found.continues
    session.add(recording)
    session.flush()
    for cut in found.replaced:
        cut.superseded_at = models.now()
    for cut in found.new:
        cut.recording_id = recording.id
    session.add_all(found.new)
    count_edges(session, owner.id, [*found.replaced, *found.new])
    return Imported(
        recording.id,
        recording.kind,
        recording.rows,
        len(found.new),
        already_there=False,
        again=found.there,
        replaced=len(found.replaced),
        timing=time_sentences(recording),
        unpaired=sum(cut.pair_id is None and cut.pair is None for cut in found.new),
    )


def _aside(session: Session, recording: models.StoredRecording, cuts: list[models.Cut]) -> Imported:
    """Add a recording whose cuts do not count."""
    session.add(recording)
    session.flush()
    for cut in cuts:
        cut.recording_id, cut.superseded_at = recording.id, recording.looked_at
    session.add_all(cuts)
    return Imported(
        recording.id,
        recording.kind,
        recording.rows,
        len(cuts),
        already_there=False,
        timing=time_sentences(recording),
    )


def time_sentences(row: models.StoredRecording, *, but_even: bool = False) -> tuple[str, ...]:
    """Return what a recording's stamps are, a sentence for each time base.

    ``but_even``: of those alone that are not even.
    """
    bases = {
        name: one
        for name, one in (row.timing or {}).items()
        if not but_even or one["kinds"] != ["even"]
    }
    return tuple(f"{name}: {one['said']}".removeprefix(": ") for name, one in bases.items())


def _channel_rows(base: BaseSummary) -> list[models.RecordingChannel]:
    return [
        models.RecordingChannel(
            time_base=base.name,
            name=channel.name,
            unit=channel.unit,
            rows=channel.rows,
            rate_hz=base.rate_hz,
            minimum=channel.minimum if channel.finite else None,
            maximum=channel.maximum if channel.finite else None,
            mean=channel.mean if channel.finite else None,
            sd=channel.sd if channel.finite else None,
        )
        for channel in base.channels.values()
    ]


def _known(
    session: Session, machine_id: int, sha256: str, side: SideFile, content: str | None = None
) -> Imported | None:
    """Return what is there of a file: by its bytes, or by its ``content`` where that is known."""
    alike = models.StoredRecording.sha256 == sha256
    if content is not None:
        alike |= models.StoredRecording.content == content
    found = session.scalar(
        select(models.StoredRecording)
        .where(models.StoredRecording.machine_id == machine_id, alike)
        .order_by(
            models.StoredRecording.sha256 != sha256,
            models.StoredRecording.withdrawn_at.is_not(None),
            models.StoredRecording.id.desc(),
        )
        .limit(1)
    )
    return None if found is None else _as_known(found, other_side=found.side != _said(side))


def _as_known(row: models.StoredRecording, *, other_side: bool) -> Imported:
    return Imported(
        row.id,
        row.kind,
        row.rows,
        len(row.cuts),
        True,
        other_side,
        withdrawn=row.withdrawn_why,
        looked_at=row.looked_at is not None,
        timing=time_sentences(row),
    )


def files_of(row: models.StoredRecording) -> dict[Path, str]:
    """Return the files of a recording that are there, with the checksum that each must have."""
    said = {Path(row.path): row.sha256}
    if row.stored_path is not None and row.stored_sha256 is not None:
        said[Path(row.stored_path)] = row.stored_sha256
    return {path: sha256 for path, sha256 in said.items() if path.is_file()}


def whole_file(row: models.StoredRecording, *, but: Collection[Path] = ()) -> Path | None:
    """Return a file of a recording that is there as it came in, beside some; None: there is none.

    ``but``: whole paths of files that do not count.
    """
    for path, sha256 in files_of(row).items():
        if path not in but and checksum(path) == sha256:
            return path
    return None
