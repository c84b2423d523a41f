"""A person says that a tool's edge was changed: from then on the machine counts what the new one
cuts. Cuts that came in since are counted at once, and can be counted as before again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from sqlalchemy import ColumnElement, func, select
from sqlalchemy.orm import Session

from autodb.agent.rows.counted_edges import changes_of, count_edges, of_change
from autodb.agent.rows.machines import find_machine, working_machine
from autodb.agent.rows.posteriors import taken_back_words
from autodb.errors import NotThere, UnusableInput, near_words
from autodb.files.channels import DURATION
from autodb.store import Also, Store, models, nothing_else
from autodb.wording import day, phrase


@dataclass(frozen=True)
class EdgeChanged:
    """What recording a change did, or undoing it; ``at``: when it was, ISO 8601 in UTC.

    ``cuts``: those that came in since and count for its edge, or did; ``taken_back``: versions that
    had learnt wear of them, in words. ``already``: it was so before.
    """

    number: int
    machine: str
    tool: str
    at: str
    cuts: int
    taken_back: tuple[str, ...] = ()
    already: bool = False


@dataclass(frozen=True)
class EdgeOfTool:
    """A recorded change of a tool's edge, and what the edge has cut since.

    ``at``: when it was, ISO 8601 in UTC; ``cut_s``: for how long its ``cuts`` have cut, s; None: it
    is not known of each. ``undone_at``: since when it does not count.
    """

    number: int
    tool: str
    at: str
    by: str | None
    why: str | None
    cuts: int
    cut_s: float | None
    undone_at: str | None


@dataclass(frozen=True)
class EdgesOfMachine:
    """The ``tools`` that a machine has cuts of, by name, and recorded changes of their edges."""

    machine: str
    tools: list[str]
    edges: list[EdgeOfTool]


def change_edge(
    store: Store,
    machine: str,
    tool: str,
    *,
    at: str | None = None,
    by: str | None = None,
    why: str | None = None,
    also: Also = nothing_else,
) -> EdgeChanged:
    """Record that a tool's edge was changed on a machine, now or ``at`` an ISO 8601 time.

    A time without a zone is this computer's. ``also``: what else is written then. Raises
    UnusableInput for a tool that the machine has no cuts of, or a time that is none or to come.
    """
    moment = models.now() if at is None else _moment(at)
    with store.writing(machine) as session:
        owner = working_machine(session, machine)
        of_tool = _tool(session, owner, tool)
        changes = changes_of(session, owner.id, of_tool.id)
        same = next((one for one in changes if one.at == moment), None)
        if same is not None:
            cuts = _how_many(session, same)
            return EdgeChanged(same.id, machine, tool, moment, cuts, already=True)
        row = models.ChangedEdge(
            machine_id=owner.id, tool=of_tool, at=moment, said_by=by, why=why,
            after_cut_id=_newest_cut(session) if at is None else None,
        )  # fmt: skip
        session.add(row)
        before = next((one for one in reversed(changes) if one.at < moment), None)
        since = models.StoredRecording.imported_at >= moment
        later = of_change(owner.id, of_tool.id, before).where(models.Cut.recording.has(since))
        back = _counted_anew(session, owner.id, session.scalars(later).all())
        also(session, row.id)
        return EdgeChanged(row.id, machine, tool, moment, _how_many(session, row), back)


def undo_edge_change(store: Store, number: int, *, also: Also = nothing_else) -> EdgeChanged:
    """Have a recorded change count no more: its cuts are those of the edge before again.

    Raises NotThere where there is none of that number.
    """
    with store.writing() as session:
        row = session.get(models.ChangedEdge, number)
        if row is None:
            raise NotThere(
                phrase(
                    "there is no edge change {number}; list a machine's with "
                    "'autodb edge list --machine NAME'",
                    number=number,
                )
            )
        machine = session.get_one(models.Machine, row.machine_id).name
        done = EdgeChanged(row.id, machine, row.tool.name, row.at, _how_many(session, row))
        if row.undone_at is not None:
            return replace(done, already=True)
        row.undone_at = models.now()
        cuts = session.scalars(of_change(row.machine_id, row.tool_id, row)).all()
        back = _counted_anew(session, row.machine_id, cuts)
        also(session, number)
        return replace(done, taken_back=back)


def edges_of_machine(session: Session, machine: str, *, every: bool = False) -> EdgesOfMachine:
    """Return the last change of each tool that counts, tools by name; or ``every`` change.

    Raises NotThere where there is no such machine.
    """
    owner, made = find_machine(session, machine), models.ChangedEdge
    query = select(made).join(models.Tool).where(made.machine_id == owner.id)
    rows = session.scalars(query.order_by(models.Tool.name, made.at, made.id)).all()
    if not every:
        rows = [*{row.tool_id: row for row in rows if row.undone_at is None}.values()]
    edges = [_of_tool(session, row) for row in rows]
    return EdgesOfMachine(owner.name, _tools(session, owner), edges)


def _tools(session: Session, owner: models.Machine) -> list[str]:
    own = models.Cut.recording.has(machine_id=owner.id)
    cut = select(models.Pair.tool_id).where(
        select(models.Cut.id).where(models.Cut.pair_id == models.Pair.id, own).exists()
    )
    query = select(models.Tool.name).where(models.Tool.id.in_(cut))
    return list(session.scalars(query.order_by(models.Tool.name)))


def _tool(session: Session, owner: models.Machine, name: str) -> models.Tool:
    known = _tools(session, owner)
    if not known:
        raise UnusableInput(
            phrase(
                "machine '{machine}' has no cuts of a tool; import some that name theirs",
                machine=owner.name,
            )
        )
    if name not in known:
        raise UnusableInput(
            phrase(
                "machine '{machine}' has no cuts of tool '{tool}'{hint}",
                machine=owner.name,
                tool=name,
                hint=near_words(name, known),
            )
        )
    return session.scalars(select(models.Tool).where(models.Tool.name == name)).one()


def _moment(text: str) -> str:
    """Return a stated time as it is kept; raises UnusableInput for none, or one to come."""
    try:
        moment = datetime.fromisoformat(text).astimezone(UTC).isoformat(timespec="seconds")
    except (ValueError, OverflowError, OSError):
        raise UnusableInput(
            phrase("time '{at}' is none; write it as 2026-03-01T07:30", at=text)
        ) from None
    if moment > models.now():
        raise UnusableInput(
            phrase(
                "time '{at}' is still to come ({day} UTC); record a change once it was made",
                at=text,
                day=day(moment),
            )
        )
    return moment


def _newest_cut(session: Session) -> int:
    return session.scalar(select(func.max(models.Cut.id))) or 0


def _counted_anew(session: Session, machine_id: int, cuts: Sequence[models.Cut]) -> tuple[str, ...]:
    """Count cuts as changes have it now; return in words what was taken back."""
    return tuple(taken_back_words(one) for one in count_edges(session, machine_id, cuts))


def _counts(row: models.ChangedEdge) -> tuple[ColumnElement[bool], ...]:
    return models.Cut.edge_change_id == row.id, models.counting_cut(models.Cut.superseded_at)


def _how_many(session: Session, row: models.ChangedEdge) -> int:
    query = select(func.count()).select_from(models.Cut).where(*_counts(row))
    return session.scalar(query) or 0


def _of_tool(session: Session, row: models.ChangedEdge) -> EdgeOfTool:
    lasted = func.coalesce(models.Cut.conditions[DURATION].as_float(), 0.0)
    used = models.Cut.edge_used_s
    query = select(func.count(), func.count(used), func.max(used + lasted))
    cuts, known, cut_s = session.execute(query.where(*_counts(row))).one()
    return EdgeOfTool(
        row.id, row.tool.name, row.at, row.said_by, row.why, cuts,
        float(cut_s or 0.0) if known == cuts else None, row.undone_at,
    )  # fmt: skip
