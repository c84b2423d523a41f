"""One machine of a database: what it learns from, and what it answers."""

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from autodb.agent.answer.bounds.lives import AskedLife, tool_lives
from autodb.agent.answer.bounds.stable import stable_cuts
from autodb.agent.answer.explaining import explain_with_machine
from autodb.agent.answer.looking_up import PairReader
from autodb.agent.answer.predicting import answer_of, followed_program, predict_job
from autodb.agent.ingest.framed import import_table, kept_table
from autodb.agent.ingest.importing import import_file
from autodb.agent.ingest.inbox import Inbox
from autodb.agent.operate.changed_edges import change_edge, edges_of_machine, undo_edge_change
from autodb.agent.operate.refreshing import refresh
from autodb.agent.operate.withdrawing import read_again
from autodb.agent.rows.machines import limits_of_machine
from autodb.agent.sense.calibrating import calibrate_machine
from autodb.agent.sense.identifying import check_moves, identify_on_machine
from autodb.errors import UnusableInput
from autodb.files.job import Job
from autodb.files.side import StatedColumns
from autodb.forward.stability.dynamics import read_tool_point
from autodb.library.answers import (
    CalibrateResult,
    ImportResult,
    LookupResult,
    PairsResult,
    PredictResult,
    RefreshResult,
)
from autodb.library.edges import EdgeChangeResult, EdgesResult
from autodb.library.found import ExplainResult, IdentifyResult
from autodb.library.given import (
    ColumnsGiven,
    Given,
    InMemory,
    OnDisk,
    Units,
    taken,
)
from autodb.library.jobs import asked_cut, asked_cuts, job_of
from autodb.library.planned import StabilityResult, ToolLifeResult
from autodb.records.resample import one_base, only_over_time
from autodb.standard import read_protocol
from autodb.store import Store, opened_database


@dataclass(frozen=True, repr=False)
class ShopMachine:
    """A machine by its name and its database's URL. It holds nothing open."""

    url: str = field(repr=False)
    name: str

    def import_(
        self,
        recording: Given,
        *,
        columns: ColumnsGiven = None,
        units: Units | None = None,
        name: str | None = None,
        folder: str | os.PathLike[str] | None = None,
        again: bool = False,
    ) -> ImportResult:
        """Import a recording or a table of cuts: a file, or a data frame.

        A file enters once. A data frame is kept as a Parquet file in ``folder``, beside the
        database without it, from which later answers read it again; of one with the ``name`` of an
        earlier one only what is new counts, as of a file that grows. ``columns``: which column is
        which channel, or all that a side file says; ``units``: by column or channel. ``again``:
        what was read of it with another side file is withdrawn, and it is read as that says now.

        Raises UnusableInput with the column and row; then nothing is stored.
        """
        instead = read_again if again else None
        one = taken(recording, columns=columns, units=units, name=name or "frame")
        with opened_database(self.url) as store:
            if isinstance(one, OnDisk):
                _refuse_name(one.path, name, folder)
                done = import_file(
                    store, one.path, machine=self.name, columns=one.columns, instead=instead
                )
            else:
                done = import_table(
                    store, one.table, machine=self.name, side=one.side, name=name,
                    folder=None if folder is None else Path(folder), instead=instead,
                )  # fmt: skip
        return ImportResult(done)

    def calibrate(
        self, recordings: Sequence[int] | None = None, *, protocol: str | None = None
    ) -> CalibrateResult:
        """Fit current to force for each axis on imported cuts, and keep what is usable.

        ``recordings``: the numbers of those to use, instead of all; ``protocol``: standard cuts
        whose reference forces count. Raises UnusableInput where no axis can be calibrated.
        """
        chosen = None if protocol is None else read_protocol(protocol)
        numbers = None if recordings is None else list(recordings)
        with opened_database(self.url) as store:
            done = calibrate_machine(store, self.name, recordings=numbers, protocol=chosen)
        return CalibrateResult(done, self.name, chosen)

    def refresh(self, *, inbox: str | os.PathLike[str] | None = None) -> RefreshResult:
        """Sense the forces of new cuts and update the parameters of their pairs.

        ``inbox``: a folder whose recordings are imported first.
        """
        folder = None if inbox is None else Inbox(Path(inbox), None)
        with opened_database(self.url) as store:
            return RefreshResult(refresh(store, self.name, inbox=folder))

    def predict(
        self,
        job: Given,
        *,
        material: str | None = None,
        tool: str | None = None,
        lot: str | None = None,
    ) -> PredictResult:
        """Predict forces, torque and power of a job's cuts, with 95 % intervals, and keep them.

        ``job``: a job file, or a data frame with a row a cut and the keys of a job's cut as columns
        (`operation`, `diameter_mm`, `depth_mm`, `feed_mm_rev`, `speed_m_min`, …), or the channels
        of a table of cuts. Its ``material`` and ``tool`` are given, or are columns. Raises
        UnusableInput with the key or row.
        """
        asked = job_of(job, material=material, tool=tool, lot=lot)
        with opened_database(self.url) as store:
            answer = predict_job(store, self.name, asked)
            return PredictResult(answer, limits_of_machine(store, self.name))

    def lookup(
        self,
        material: str,
        tool: str,
        cuts: Given = None,
        *,
        lot: str | None = None,
        **cut: Any,
    ) -> LookupResult:
        """Return what one cut takes, or each of a data frame's, and store nothing.

        The cut is said by the keys of a job's cut: ``depth_mm=2.0, diameter_mm=50.0, …``. Raises
        UnusableInput where the tool cannot make it.
        """
        if (cuts is None) == (not cut):
            raise UnusableInput("give either a data frame of cuts, or one cut by its keys")
        asked = (asked_cut(cut, where="cut"),) if cuts is None else asked_cuts(cuts, name="cuts")
        job = Job(name="cuts", material=material, tool=tool, lot=lot, cut=asked)
        with opened_database(self.url) as store, store.reading() as session:
            basis = PairReader(session, self.name).basis(material, tool)
            return LookupResult(answer_of(basis, job), basis.limits)

    def pairs(self, material: str | None = None, tool: str | None = None) -> PairsResult:
        """Return the work-tool pairs that the machine has learnt, or those of one of the two."""
        with opened_database(self.url) as store, store.reading() as session:
            return PairsResult(tuple(PairReader(session, self.name).pairs(material, tool)))

    def tool_life(
        self,
        *jobs: Given,
        limits: Mapping[str, float] | None = None,
        sure: float = 0.95,
        material: str | None = None,
        tool: str | None = None,
        lot: str | None = None,
    ) -> ToolLifeResult:
        """Return how many parts and minutes edges last until a force or power passes a limit.

        ``jobs``: the cuts of one part, as of ``predict``; several, each of one tool, that make it
        together. Each tool, also of a program, is an edge. ``limits``: by channel (``force.x``,
        ``torque.spindle``, ``spindle.power``), in place of the machine's, with an edge before it
        (``0303:force.x``) of that one alone. ``sure``: the probability
        with which they are kept by the parts that are surely made. Nothing is stored. Raises
        UnusableInput where there is no limit, or lengths are missing.
        """
        asked = [job_of(job, material=material, tool=tool, lot=lot) for job in jobs]
        with opened_database(self.url) as store:
            programs = [followed_program(store, self.name, one) for one in asked]
            with store.reading() as session:
                reader = PairReader(session, self.name)
                some = [
                    AskedLife(reader.basis(one.material, one.tool), one, program)
                    for one, program in zip(asked, programs, strict=True)
                ]
                found = tool_lives(some, limits=limits, sure=sure)
        return ToolLifeResult(found)

    def stability(
        self,
        job: Given,
        dynamics: str | os.PathLike[str],
        *,
        material: str | None = None,
        tool: str | None = None,
        lot: str | None = None,
    ) -> StabilityResult:
        """Return to what depth a job's cuts are stable with a tool point that gives way.

        ``job``: as of ``predict``; ``dynamics``: a file of the tool point's modes (TOML), or its
        measured receptance (CSV). Nothing is stored. Raises UnusableInput with the key or row.
        """
        asked = job_of(job, material=material, tool=tool, lot=lot)
        point = read_tool_point(Path(dynamics))
        with opened_database(self.url) as store, store.reading() as session:
            basis = PairReader(session, self.name).basis(asked.material, asked.tool)
            return StabilityResult(stable_cuts(basis, asked, point), asked)

    def explain(
        self,
        recording: Given,
        *,
        columns: ColumnsGiven = None,
        units: Units | None = None,
        name: str | None = None,
        folder: str | os.PathLike[str] | None = None,
    ) -> ExplainResult:
        """Explain a recording by the machine's own models; causes are kept as open mismatches.

        The recording is kept too, to be explained alone: nothing is learnt from it.
        """
        one = taken(recording, columns=columns, units=units, name=name or "frame")
        with opened_database(self.url) as store, _as_file(store, one, name, folder) as (path, own):
            found = explain_with_machine(store, self.name, path, columns=own)
        return ExplainResult(found.explained, found.kept)

    def identify(
        self,
        recording: Given,
        *,
        axis: str | None = None,
        terms: Sequence[str] | None = None,
        columns: ColumnsGiven = None,
        units: Units | None = None,
        name: str | None = None,
        folder: str | os.PathLike[str] | None = None,
    ) -> IdentifyResult:
        """Identify the terms of an axis from its moves; they are the next version of its model."""
        one = taken(recording, columns=columns, units=units, name=name or "frame")
        moves = check_moves(only_over_time(one_base(one.source())), axis)
        with opened_database(self.url) as store, _as_file(store, one, name, folder) as (path, own):
            kept = identify_on_machine(
                store, self.name, path, moves, columns=own, axis=axis, terms=terms
            )
        return IdentifyResult(kept.model, moves, kept.version)

    def change_edge(
        self,
        tool: str,
        *,
        at: str | datetime | None = None,
        by: str | None = None,
        why: str | None = None,
    ) -> EdgeChangeResult:
        """Record that a tool has a new edge, now or ``at`` a time; what it cuts is counted.

        A time without a zone is this computer's. ``by``: who says so. Raises UnusableInput for a
        tool that the machine has no cuts of, or a time that is none or to come.
        """
        moment = at.isoformat() if isinstance(at, datetime) else at
        with opened_database(self.url) as store:
            done = change_edge(store, self.name, tool, at=moment, by=by, why=why)
        return EdgeChangeResult(done)

    def undo_edge_change(self, number: int) -> EdgeChangeResult:
        """Have a recorded change count no more: its cuts are those of the edge before again.

        Raises NotThere where there is none of that number.
        """
        with opened_database(self.url) as store:
            return EdgeChangeResult(undo_edge_change(store, number))

    def edges(self, *, every: bool = False) -> EdgesResult:
        """Return the last recorded change of each tool's edge, or ``every`` one, and what the edge
        has cut since.
        """
        with opened_database(self.url) as store, store.reading() as session:
            return EdgesResult(edges_of_machine(session, self.name, every=every))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.name!r})"


@contextmanager
def _as_file(
    store: Store,
    one: InMemory | OnDisk,
    name: str | None,
    folder: str | os.PathLike[str] | None,
) -> Iterator[tuple[Path, StatedColumns]]:
    """Give the file of a recording with what is stated of it; a data frame is kept as one."""
    if isinstance(one, InMemory):
        where = None if folder is None else Path(folder)
        with kept_table(store, one.table, name=name, folder=where) as kept:
            yield kept.path, one.side
        return
    _refuse_name(one.path, name, folder)
    yield one.path, one.columns


def _refuse_name(path: Path, *given: object) -> None:
    if any(one is not None for one in given):
        raise UnusableInput(f"{path}: name and folder go with a data frame; leave them out")
