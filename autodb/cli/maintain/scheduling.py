"""`schedule`: what makes the computer refresh a machine by itself."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from autodb.cli._common import Database, MachineName, from_anywhere, opened_machine, say
from autodb.wording import phrase


def schedule(
    inbox: Annotated[
        Path, typer.Option("--inbox", metavar="DIR", help="Folder that recordings come into.")
    ],
    machine: MachineName = None,
    every: Annotated[int, typer.Option("--every", metavar="MIN", min=1, help="Minutes.")] = 15,
    cron: Annotated[
        bool, typer.Option("--cron", help="Print a line for cron in place of systemd's units.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Write systemd's units there, not only print."),
    ] = None,
    db: Database = None,
) -> None:
    """Write a systemd timer, or a line for cron, that refreshes a machine every so often."""
    from autodb.agent.operate.scheduling import cron_line, systemd_units
    from autodb.errors import UnusableInput
    from autodb.files.targets import needs_folder, write_text

    if cron and out is not None:
        raise UnusableInput(phrase("--out is for systemd's units; a line of cron is printed"))
    name, command = _command(machine, inbox, db)
    if cron:
        say(cron_line(command, every_min=every))
        return
    units = systemd_units(name, command, every_min=every)
    for name, text in units.files.items():
        if out is None:
            say(f"# {name}\n{text}")
        else:
            needs_folder(out / name)
            write_text(out / name, text)
            say(phrase("{file}: written", file=out / name))
    for line in units.to_do:
        say(f"# {line}" if out is None else line)


def _command(machine: str | None, inbox: Path, db: str | None) -> tuple[str, list[str]]:
    """Return the machine, and the command to be run by whole paths, where all of it is there."""
    from autodb.agent.rows.machines import find_machine
    from autodb.files.targets import expect_folder

    with opened_machine(db, machine) as (store, name), store.reading() as session:
        find_machine(session, name)
    expect_folder(inbox)
    run = [sys.executable, "-m", "autodb", "refresh"]
    where = ["--inbox", str(inbox.resolve()), "--db", from_anywhere(db)]
    return name, [*run, "--machine", name, *where]
