"""`agent`: reads a machine while it runs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import Database, Stopped, opened_store, say, show, table
from autodb.files.excuses import excuse

if TYPE_CHECKING:
    from autodb.agent.operate.checking import Checked


def agent(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="An agent file (TOML).")],
    check: Annotated[
        bool, typer.Option("--check", help="Only say what each item of the file says now.")
    ] = False,
    offered: Annotated[
        bool, typer.Option("--list", help="Only list the items that the machine offers.")
    ] = False,
    health: Annotated[
        bool, typer.Option("--health", help="Only say how the agent of this file is; exit 1: ill.")
    ] = False,
    db: Database = None,
) -> None:
    """Read a machine over OPC UA or MTConnect: record each cut, and refresh, until Ctrl-C."""
    from autodb.errors import UnusableInput
    from autodb.live.agentfile import read_agentfile

    if check + offered + health > 1:
        raise UnusableInput("--check, --list and --health: use one of them")
    plan = read_agentfile(file)
    if health:
        _health(file)
    elif offered or check:
        from autodb.agent.operate.checking import check_machine

        found = check_machine(plan, listing=offered)
        if offered:
            _list(found)
        else:
            _check(found)
    else:
        from autodb.agent.operate.running import Agent

        try:
            Agent(file, plan, lambda: opened_store(db), say=say, excuse=excuse).run()
        except KeyboardInterrupt:  # it has said that it stopped
            raise Stopped from None


def _health(file: Path) -> None:
    from autodb.agent.operate.health import is_stale, read_health
    from autodb.agent.operate.running import health_of

    found = read_health(health_of(file))
    say(found.line())
    if is_stale(found):
        say("it has said nothing for a while: it is not running")
    if is_stale(found) or not found.well:
        raise typer.Exit(1)


def _list(found: "Checked") -> None:
    from autodb.agent.operate.checking import text_of

    printed = table("What the machine offers", "item", "called", "kind", "unit", "now")
    for one in found.offered:
        printed.add_row(one.item, one.called, one.kind, one.unit, text_of(one.value))
    show(printed)


def _check(found: "Checked") -> None:
    printed = table("Items of the file", "item", "for", "now")
    for row in found.items:
        printed.add_row(row.item, row.role, row.said)
    show(printed)
    say("it cuts now" if found.cuts else "it does not cut now")
    for sentence in found.never:
        say(sentence)
    if found.unknown:
        say(f"{len(found.unknown)} of {len(found.items)} say nothing: {', '.join(found.unknown)}")
    if found.unknown or found.never:
        raise typer.Exit(1)
