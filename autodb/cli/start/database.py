"""`init` and `machine`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import Database, Json, opened_store, say, say_json, show, table
from autodb.cli._reader import headed, in_english, shown_again
from autodb.wording import day, listed, msgid, phrase, presentation

if TYPE_CHECKING:
    from autodb.store import models

RETIRED = msgid("machine '{machine}': retired")
RETIRED_ALREADY = msgid("machine '{machine}': retired already")
WORKS = msgid("machine '{machine}': works again")
WORKS_ALREADY = msgid("machine '{machine}': works again already")
CARRIES = {"tool": msgid("tool"), "work": msgid("work")}
"""What an axis moves."""
machine = typer.Typer(
    help="Machines: their axes and what their files state.",
    no_args_is_help=True,
)


def init(db: Database = None) -> None:
    """Create the database, or bring it to this version's schema."""
    from autodb.store import create_store, database_url, shown_url

    url = database_url(db)
    done = create_store(url)
    url = shown_url(url)
    if not done.changed:
        say(phrase("{url}: already there, schema {now}", url=url, now=done.now))
    elif done.was is None:
        say(phrase("{url}: ready, schema {now}", url=url, now=done.now))
    else:
        say(
            phrase(
                "{url}: upgraded from schema {was} to {now}", url=url, was=done.was, now=done.now
            )
        )


@machine.command("add")
def add_machine_command(
    name: Annotated[str, typer.Argument(help="Name of the machine.")],
    file: Annotated[
        Path | None,
        typer.Option(
            "--file", readable=False, help="Machine file (TOML) with its axes; default: a lathe."
        ),
    ] = None,
    db: Database = None,
) -> None:
    """Add a machine with its axes."""
    from autodb.agent.rows.machines import add_machine
    from autodb.files.machine import LATHE, read_machine_file

    axes = LATHE if file is None else read_machine_file(file)
    with opened_store(db) as store:
        new = add_machine(store, name, axes)
    called = {"machine": name, "axes": ", ".join(axes.axes)}
    added = msgid("machine '{machine}': added ({axes})")
    say(phrase(added if new else msgid("machine '{machine}': already there ({axes})"), **called))


@machine.command("update")
def update_machine_command(
    name: Annotated[str, typer.Argument(help="Name of the machine.")],
    file: Annotated[Path, typer.Option("--file", help="Machine file (TOML): all of the machine.")],
    db: Database = None,
) -> None:
    """Make a machine what its file says, and print what changed."""
    from autodb.agent.rows.machines import update_machine
    from autodb.files.machine import read_machine_file

    wanted = read_machine_file(file)
    with in_english(), opened_store(db) as store:
        changes = update_machine(store, name, wanted)
    if changes:
        say(phrase("machine '{machine}': {count} changes", machine=name, count=len(changes)))
    else:
        say(phrase("machine '{machine}': already there", machine=name))
    for line in changes:
        say(shown_again(line))


@machine.command("rename")
def rename(
    name: Annotated[str, typer.Argument(help="Name of the machine.")],
    new: Annotated[str, typer.Argument(help="Its name from now on.")],
    db: Database = None,
) -> None:
    """Give a machine another name; agent and side files that state the old one need it too."""
    from autodb.agent.rows.machines import rename_machine

    with opened_store(db) as store:
        rename_machine(store, name, new)
    say(phrase("machine '{name}': is '{new}' now", name=name, new=new))


@machine.command("retire")
def retire(
    name: Annotated[str, typer.Argument(help="Name of the machine.")],
    undo: Annotated[bool, typer.Option("--undo", help="Have it work again.")] = False,
    db: Database = None,
) -> None:
    """Take in no more recordings of a machine; its data stay and are still used in answers."""
    from autodb.agent.rows.machines import retire_machine

    with opened_store(db) as store:
        changed = retire_machine(store, name, back=undo)
    said = (RETIRED, WORKS)[undo] if changed else (RETIRED_ALREADY, WORKS_ALREADY)[undo]
    say(phrase(said, machine=name))


@machine.command("list")
def list_machines_command(json: Json = False, db: Database = None) -> None:
    """List the machines."""
    if json:
        from autodb.agent.answer.overview import every_machine

        with in_english(), opened_store(db) as store, store.reading() as session:
            say_json(every_machine(session))
        return
    from sqlalchemy import select

    from autodb.store.models import Machine

    heads = (phrase("name"), phrase("axes"), phrase("since"), phrase("retired"))
    rows = table(phrase("Machines"), *heads)
    with opened_store(db) as store, store.reading() as session:
        for row in session.scalars(select(Machine).order_by(Machine.name)):
            axes = ", ".join(axis.name for axis in row.axes)
            retired = _day(row.retired_at) if row.retired_at else ""
            rows.add_row(row.name, axes, _day(row.created_at), retired)
    show(rows)


def _day(at: str) -> str:
    """Return a stored time for the reader; in English as it is stored."""
    return at if presentation().language == "en" else day(at)


@machine.command("show")
def show_machine_command(
    name: Annotated[str, typer.Argument(help="Name of the machine.")],
    json: Json = False,
    db: Database = None,
) -> None:
    """Show a machine's axes, the forces that they sense, and all that its file states."""
    if json:
        from autodb.agent.answer.overview import machine_said

        with in_english(), opened_store(db) as store, store.reading() as session:
            say_json(machine_said(session, name))
        return
    from autodb.agent.rows.calibrations import current_calibrations
    from autodb.agent.rows.machines import as_file, find_machine
    from autodb.files.machine import flat

    heads = (phrase("axis"), phrase("carries"), headed(phrase("current sign")), phrase("senses"))
    rows = table(phrase("Machine {machine}", machine=name), *heads)
    with opened_store(db) as store, store.reading() as session:
        owner = find_machine(session, name)
        for axis in owner.axes:
            current = current_calibrations(session, owner.id, axis.name)
            senses = listed(map(_senses, current), "; ") or phrase("not calibrated")
            carries = phrase(CARRIES[axis.carries]) if axis.carries in CARRIES else axis.carries
            rows.add_row(axis.name, carries, f"{axis.current_sign:+d}", senses)
        stated = flat(as_file(owner))
    show(rows)
    for key, value in stated.items():
        if not key.endswith((".carries", ".current_sign")):
            say(f"{key} = {value}")  # as its file has it


def _senses(row: "models.CalibrationVersion") -> str:
    from autodb.agent.rows.calibrations import holds_for

    force, holds = f"force.{row.component}", holds_for(row).stated
    if holds:
        force = phrase("{force} ({what})", force=force, what=listed(map(shown_again, holds)))
    return phrase("{force}: {verdict}", force=force, verdict=shown_again(row.verdict))
