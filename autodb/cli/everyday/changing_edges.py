"""`edge`: a person says that a tool's edge was changed; what each edge has cut since is counted."""

from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Database,
    Json,
    MachineName,
    opened_machine,
    opened_store,
    say,
    say_json,
    show,
    table,
)
from autodb.cli._reader import headed, in_english, shown_again
from autodb.wording import day, localized, msgid, phrase, phrase_many

if TYPE_CHECKING:
    from autodb.agent.operate.changed_edges import EdgeChanged, EdgeOfTool

edge = typer.Typer(
    help="Changes of tools' edges: record one, list them, undo one.", no_args_is_help=True
)

RELEARN = msgid("{what}; 'autodb refresh' learns it anew")


@edge.command("changed")
def changed_command(
    tool: Annotated[str, typer.Option("--tool", metavar="NAME", help="Whose edge was changed.")],
    machine: MachineName = None,
    at: Annotated[
        str | None,
        typer.Option("--at", metavar="TIME", help="When, such as 2026-03-01T07:30 [default: now]."),
    ] = None,
    by: Annotated[str | None, typer.Option("--by", metavar="WHO", help="Who says so.")] = None,
    why: Annotated[
        str | None, typer.Option("--why", metavar="TEXT", help="Why; kept with the change.")
    ] = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Record that a tool has a new edge: what it cuts is counted from then on."""
    from autodb.agent.operate.changed_edges import change_edge

    with in_english(), opened_machine(db, machine) as (store, name):
        done = change_edge(store, name, tool, at=at, by=by, why=why)
    if json:
        say_json(done)
        return
    said = (
        msgid("edge change {number}: {tool} on {day} UTC, already there; {cuts}")
        if done.already
        else msgid("edge change {number}: {tool} on {day} UTC; {cuts}")
    )
    _say_done(done, said, _cuts_since(done))


def _cuts_since(done: "EdgeChanged") -> str:
    if not done.cuts:
        return phrase("cuts that come in from now on count for the new edge")
    return phrase_many(
        "{count} cut that came in since counts for the new edge",
        "{count} cuts that came in since count for the new edge",
        done.cuts,
    )


def _say_done(done: "EdgeChanged", sentence: str, cuts: str) -> None:
    """Print what was done with a change, and which versions are taken back."""
    say(phrase(sentence, number=done.number, tool=done.tool, day=day(done.at), cuts=cuts))
    for line in done.taken_back:
        say(phrase(RELEARN, what=shown_again(line)))


@edge.command("list")
def list_edges_command(
    machine: MachineName = None,
    all_: Annotated[bool, typer.Option("--all", help="Every change, also those undone.")] = False,
    json: Json = False,
    db: Database = None,
) -> None:
    """List each tool's last edge change: when, by whom, and what the edge has cut since."""
    from autodb.agent.operate.changed_edges import edges_of_machine

    with (
        in_english(json),
        opened_machine(db, machine) as (store, name),
        store.reading() as session,
    ):
        found = edges_of_machine(session, name, every=all_)
    if json:
        say_json(found)
        return
    if not found.edges:
        say(
            phrase(
                "machine '{machine}': no edge change is recorded; 'autodb edge changed --tool NAME "
                "--machine {machine}' records one",
                machine=name,
            )
        )
        return
    rows = table(
        phrase("Edges of {machine}", machine=name),
        *(headed(phrase("number")), phrase("tool"), phrase("changed, UTC"), phrase("who")),
        *(phrase("why"), headed(phrase("cuts since")), headed(phrase("has cut"), "s")),
        phrase("status"),
    )
    for one in found.edges:
        rows.add_row(*_cells(one))
    show(rows)


def _cells(one: "EdgeOfTool") -> tuple[str, ...]:
    cut_s = phrase("not known") if one.cut_s is None else localized(f"{one.cut_s:.0f}")
    status = phrase("counts") if one.undone_at is None else phrase("undone")
    return (
        str(one.number), one.tool, day(one.at), one.by or "", one.why or "", str(one.cuts), cut_s,
        status,
    )  # fmt: skip


@edge.command("undo")
def undo_command(
    number: Annotated[int, typer.Argument(help="Number of the change.", min=1, max=2**63 - 1)],
    json: Json = False,
    db: Database = None,
) -> None:
    """Undo a recorded change: its cuts count for the edge before it again."""
    from autodb.agent.operate.changed_edges import undo_edge_change

    with in_english(), opened_store(db) as store:
        done = undo_edge_change(store, number)
    if json:
        say_json(done)
        return
    said = (
        msgid("edge change {number}: {tool} on {day} UTC, already undone")
        if done.already
        else msgid("edge change {number}: {tool} on {day} UTC, undone; {cuts}")
    )
    cuts = phrase_many(
        "{count} cut counts as before it", "{count} cuts count as before it", done.cuts
    )
    _say_done(done, said, cuts)
