"""`refresh`: what came in becomes forces and parameters, once or for as long as it runs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Columns,
    Database,
    MachineName,
    opened_machine,
    opened_store,
    say,
    until_stopped,
    working,
)
from autodb.cli._reader import in_english, shown_again
from autodb.files.excuses import excuse
from autodb.wording import day, phrase, presentation, presented

if TYPE_CHECKING:
    from autodb.agent.learn.passes import RefreshReport


def refresh_command(
    machine: MachineName = None,
    inbox: Annotated[
        Path | None,
        typer.Option(
            "--inbox",
            metavar="DIR",
            help="Import what lies in this folder first; it is then kept in its folder 'kept'.",
        ),
    ] = None,
    columns: Columns = None,
    watch: Annotated[
        bool, typer.Option("--watch", help="Go on until Ctrl-C: files are taken as they come in.")
    ] = False,
    every: Annotated[
        float, typer.Option("--every", metavar="S", min=0.1, help="With --watch: s between looks.")
    ] = 5.0,
    report: Annotated[
        bool, typer.Option("--report", help="Only print what the last pass did.")
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
    db: Database = None,
) -> None:
    """Sense the forces of new cuts and update the cutting parameters of their pairs."""
    from autodb.errors import UnusableInput

    if inbox is None and (columns is not None or watch):
        raise UnusableInput(phrase("--columns and --watch go with --inbox DIR"))
    if report:
        if inbox is not None:
            raise UnusableInput(phrase("--report only prints what was done; leave out --inbox"))
        _report(machine, db, json=json)
    elif watch and inbox is not None:
        _watch(machine, db, inbox, columns, every, json=json)
    else:
        _once(machine, db, inbox, columns, json=json)


def _once(
    machine: str | None, db: str | None, inbox: Path | None, columns: Path | None, *, json: bool
) -> None:
    from autodb.agent.ingest.inbox import Inbox
    from autodb.agent.operate.refreshing import refresh

    folder = None if inbox is None else Inbox(inbox, columns)
    with (
        in_english(),
        opened_machine(db, machine) as (store, name),
        working(f"refreshing {name}") as progress,
    ):
        done = refresh(store, name, inbox=folder, progress=progress)
    _print(done, json=json)


def _watch(
    machine: str | None,
    db: str | None,
    inbox: Path,
    columns: Path | None,
    every_s: float,
    *,
    json: bool,
) -> None:
    from autodb.agent.ingest.inbox import Inbox
    from autodb.agent.operate.refreshing import watch as run

    reader = presentation()

    def tell(done: "RefreshReport") -> None:
        with presented(reader):
            _print(done, json=json)

    with opened_machine(db, machine) as (_, name):
        pass
    with until_stopped(), in_english():
        run(
            lambda: opened_store(db),
            name,
            Inbox(inbox, columns),
            tell=tell,
            say=lambda line: say(f"autodb: {line}"),
            excuse=excuse,
            every_s=every_s,
        )


def _report(machine: str | None, db: str | None, *, json: bool) -> None:
    from autodb.agent.learn.passes import last_pass

    with opened_machine(db, machine) as (store, name):
        found = last_pass(store, name)
    if not json:
        at = day(found.finished_at)
        say(phrase("pass {number}, {at} UTC", number=found.number, at=at))
    _print(found.done, json=json)


def _print(done: "RefreshReport", *, json: bool) -> None:
    """Print what was done: lines, or one line of JSON."""
    from dataclasses import asdict
    from json import dumps

    for line in [dumps(asdict(done))] if json else map(shown_again, done.lines()):
        say(line)
