"""For how long each edge had cut before a cut, counted from the change that a person recorded.

A tool's cuts on a machine, in the order of time, belong to the last change before them; before the
first nothing is counted. A counter in the log that nobody set back counts from the first cut since
the change, one that was set back as it is. Where there is none, the cuts' durations are added up.
What changes of cuts that were there has the versions taken back that learnt wear of them.
"""

from collections.abc import Iterable, Sequence

from sqlalchemy import Select, select
from sqlalchemy.orm import Session

from autodb.agent.rows.posteriors import resting_on
from autodb.agent.rows.recordings import made_at
from autodb.agent.rows.refresh_cursor import last_mark
from autodb.files.channels import DURATION
from autodb.pairs.engaged import CUTTING_TIME
from autodb.pairs.posterior import WEAR
from autodb.store import models

LOOKED_BACK = 200
"""Cuts of an edge among which its last one is looked for. Chosen: more than a day's."""
AT_ONCE = 500
"""Cuts that are asked for at once."""
Counted = tuple[float | None, float | None]
"""What a cut states: its counter before it, and how long it took, s; None: nothing."""


def ages_s(cuts: Iterable[Counted], *, before: float | None = None) -> list[float | None]:
    """Return for how long an edge had cut before each of its cuts, s; None: it is not known.

    ``before``: what the counter said of the last cut of the edge before; None: nothing.
    """
    known: float | None = 0.0
    offset: float | None = None
    found = []
    for stated, lasted in cuts:
        if stated is not None:
            if before is not None and stated < before:
                offset = 0.0
            elif offset is None and known is not None:
                offset = stated - known
            known = None if offset is None else stated - offset
            before = stated
        found.append(known)
        known = None if known is None or lasted is None else known + lasted
    return found


def changes_of(session: Session, machine_id: int, tool_id: int) -> list[models.ChangedEdge]:
    """Return the changes of a tool's edge on a machine that count, in the order of time."""
    made = models.ChangedEdge
    query = select(made).where(
        made.machine_id == machine_id, made.tool_id == tool_id, made.undone_at.is_(None)
    )
    return list(session.scalars(query.order_by(made.at, made.id)))


def of_change(
    machine_id: int, tool_id: int, change: models.ChangedEdge | None
) -> Select[models.Cut]:
    """Return what asks for the cuts of a tool on a machine that count and are of a change.

    None: of none.
    """
    counting = select(models.Cut).where(models.counting_cut(models.Cut.superseded_at))
    if change is not None:
        return counting.where(models.Cut.edge_change_id == change.id)
    return counting.where(
        models.Cut.edge_change_id.is_(None),
        models.Cut.recording.has(machine_id=machine_id),
        models.Cut.pair.has(tool_id=tool_id),
    )


def count_edges(
    session: Session, machine_id: int, cuts: Sequence[models.Cut]
) -> list[models.CuttingParameters]:
    """Count the edges of a machine's cuts that came in, went, or are of another change now.

    Only those of changes that they are or were of. Return the versions of pairs that are taken
    back.
    """
    session.flush()
    tools = _tools(session, cuts)
    back = list[models.CuttingParameters]()
    for tool_id in sorted(set(tools.values())):
        own = [cut for cut in cuts if tools.get(cut.pair_id or 0) == tool_id]
        changes = changes_of(session, machine_id, tool_id)
        if changes or any(cut.edge_change_id is not None for cut in own):
            back += _ToolEdges(session, machine_id, tool_id, changes).count(own)
    return back


def _tools(session: Session, cuts: Sequence[models.Cut]) -> dict[int, int]:
    """Return the tools of cuts, by id, by their pairs'."""
    pairs = {cut.pair_id for cut in cuts if cut.pair_id is not None}
    rows = session.execute(
        select(models.Pair.id, models.Pair.tool_id).where(models.Pair.id.in_(pairs))
    )
    return {pair: tool for pair, tool in rows}  # noqa: C416 - rows are no pairs to mypy


class _ToolEdges:
    """One tool on one machine, and the changes of its edge."""

    def __init__(
        self,
        session: Session,
        machine_id: int,
        tool_id: int,
        changes: Sequence[models.ChangedEdge],
    ) -> None:
        self._session, self._machine_id, self._tool_id = session, machine_id, tool_id
        self._changes = changes
        self._was: dict[models.Cut, tuple[int | None, float | None]] = {}

    def count(self, cuts: Sequence[models.Cut]) -> list[models.CuttingParameters]:
        """Count what cuts are or were of; return the versions that are taken back."""
        touched = set[models.ChangedEdge | None]()
        for cut in cuts:
            change = self._change_of(cut) if cut.superseded_at is None else None
            touched |= {change} if cut.edge_change is None else {cut.edge_change, change}
            self._keep(cut, change, cut.edge_used_s if change is cut.edge_change else None)
        self._session.flush()
        for before, change in zip((None, *self._changes), self._changes, strict=False):
            if {before, change} & touched:
                self._count(change)
        self._session.flush()
        other = [c for c, was in self._was.items() if was != (c.edge_change_id, c.edge_used_s)]
        return self._learnt_anew(other, [one for one in touched if one is not None])

    def _change_of(self, cut: models.Cut) -> models.ChangedEdge | None:
        """Return the last change before a cut."""
        at = made_at(cut)
        return next((one for one in reversed(self._changes) if _is_since(one, cut, at)), None)

    def _keep(
        self, cut: models.Cut, change: models.ChangedEdge | None, used_s: float | None
    ) -> None:
        self._was.setdefault(cut, (cut.edge_change_id, cut.edge_used_s))
        cut.edge_change, cut.edge_used_s = change, used_s

    def _count(self, change: models.ChangedEdge) -> None:
        """Count the cuts of a change."""
        query = of_change(self._machine_id, self._tool_id, change)
        cuts = _in_time(self._session.scalars(query))
        rows = [_counted(cut) for cut in cuts]
        began = next((stated for stated, _ in rows if stated is not None), 0.0)
        before = self._counter_before(change) if began > 0.0 else None
        for cut, age in zip(cuts, ages_s(rows, before=before), strict=True):
            self._keep(cut, change, age)

    def _counter_before(self, change: models.ChangedEdge) -> float | None:
        """Return what the counter said of the last cut before a change; None: nothing."""
        earlier = self._changes[: self._changes.index(change)]
        for one in (*reversed(earlier), None):
            query = of_change(self._machine_id, self._tool_id, one)
            newest = query.order_by(models.Cut.id.desc()).limit(LOOKED_BACK)
            for cut in reversed(_in_time(self._session.scalars(newest))):
                stated, _ = _counted(cut)
                if stated is not None:
                    return stated
        return None

    def _learnt_anew(
        self, cuts: Sequence[models.Cut], changes: Sequence[models.ChangedEdge]
    ) -> list[models.CuttingParameters]:
        """Have the next refresh examine cuts anew that passes have, and learn wear of them anew."""
        mark = last_mark(self._session, self._machine_id)
        examined = [cut.id for cut in cuts if mark is None or cut.id <= mark.cut]
        if examined and mark is not None:
            for one in changes:
                one.recounts += 1
        return self._with_wear(examined)

    def _with_wear(self, cuts: Sequence[int]) -> list[models.CuttingParameters]:
        """Take back the versions that learnt wear of cuts, by id; return them."""
        found = dict[int, models.CuttingParameters]()
        for begin in range(0, len(cuts), AT_ONCE):
            its = models.SensedForce.cut_id.in_(cuts[begin : begin + AT_ONCE])
            learnt = models.CuttingParameters.forces.any(its)
            found |= {one.id: one for one in resting_on(self._session, self._machine_id, learnt)}
        worn = [one for one in found.values() if WEAR in (one.terms or {})]
        for one in worn:
            one.undone_at = models.now()
        return worn


def _is_since(change: models.ChangedEdge, cut: models.Cut, at: str) -> bool:
    """Say whether a cut that was made at a time was made after a change."""
    if change.at == at and change.after_cut_id is not None:
        return cut.id > change.after_cut_id
    return change.at <= at


def _in_time(cuts: Iterable[models.Cut]) -> list[models.Cut]:
    return sorted(cuts, key=lambda cut: (made_at(cut), cut.id))


def _counted(cut: models.Cut) -> Counted:
    stated, lasted = (cut.conditions.get(name) for name in (CUTTING_TIME, DURATION))
    return None if stated is None else float(stated), None if lasted is None else float(lasted)
