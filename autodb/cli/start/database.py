"""`init` and `machine`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import Database, Json, opened_store, say, say_json, show, table

if TYPE_CHECKING:
    from autodb.store import models

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
        say(f"{url}: already there, schema {done.now}")
    elif done.was is None:
        say(f"{url}: ready, schema {done.now}")
    else:
        say(f"{url}: upgraded from schema {done.was} to {done.now}")


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
    say(f"machine '{name}': {'added' if new else 'already there'} ({', '.join(axes.axes)})")


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
    with opened_store(db) as store:
        changes = update_machine(store, name, wanted)
    say(f"machine '{name}': {f'{len(changes)} changes' if changes else 'already there'}")
    for line in changes:
        say(line)


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
    say(f"machine '{name}': is '{new}' now")


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
    what = "works again" if undo else "retired"
    say(f"machine '{name}': {what if changed else f'{what} already'}")


@machine.command("list")
def list_machines_command(json: Json = False, db: Database = None) -> None:
    """List the machines."""
    if json:
        from autodb.agent.answer.overview import every_machine

        with opened_store(db) as store, store.reading() as session:
            say_json(every_machine(session))
        return
    from sqlalchemy import select

    from autodb.store.models import Machine

    rows = table("Machines", "name", "axes", "since", "retired")
    with opened_store(db) as store, store.reading() as session:
        for row in session.scalars(select(Machine).order_by(Machine.name)):
            axes = ", ".join(axis.name for axis in row.axes)
            rows.add_row(row.name, axes, row.created_at, row.retired_at or "")
    show(rows)


@machine.command("show")
def show_machine_command(
    name: Annotated[str, typer.Argument(help="Name of the machine.")],
    json: Json = False,
    db: Database = None,
) -> None:
    """Show a machine's axes, the forces that they sense, and all that its file states."""
    if json:
        from autodb.agent.answer.overview import machine_said

        with opened_store(db) as store, store.reading() as session:
            say_json(machine_said(session, name))
        return
    from autodb.agent.rows.calibrations import current_calibrations
    from autodb.agent.rows.machines import as_file, find_machine
    from autodb.files.machine import flat

    rows = table(f"Machine {name}", "axis", "carries", ">current sign", "senses")
    with opened_store(db) as store, store.reading() as session:
        owner = find_machine(session, name)
        for axis in owner.axes:
            current = current_calibrations(session, owner.id, axis.name)
            senses = "; ".join(map(_senses, current)) or "not calibrated"
            rows.add_row(axis.name, axis.carries, f"{axis.current_sign:+d}", senses)
        stated = flat(as_file(owner))
    show(rows)
    for key, value in stated.items():
        if not key.endswith((".carries", ".current_sign")):
            say(f"{key} = {value}")


def _senses(row: "models.CalibrationVersion") -> str:
    from autodb.agent.rows.calibrations import holds_for

    holds = holds_for(row).words()
    return f"force.{row.component}{f' ({holds})' if holds else ''}: {row.verdict}"
