"""What every command shares: the database option, tables, progress, and how errors end."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.table import Table

    from autodb.store import Store

Database = Annotated[
    str | None,
    typer.Option("--db", help="Database URL [default: AUTODB_DB or sqlite:///autodb.sqlite3]"),
]
Columns = Annotated[
    Path | None,
    typer.Option("--columns", help="TOML file that names the foreign columns and units."),
]
MachineName = Annotated[str, typer.Option("--machine", help="Name of the machine.")]
OptionalMachine = Annotated[
    str | None,
    typer.Option("--machine", help="Name of the machine; without it nothing is stored."),
]


@contextmanager
def opened(db: str | None) -> "Iterator[Store]":
    """Open the database of ``--db`` and close it again."""
    from autodb.store import database_url, open_store

    store = open_store(database_url(db))
    try:
        yield store
    finally:
        store.close()


@contextmanager
def working(what: str) -> Iterator[Callable[[str], None]]:
    """Show a moving bar with the step at work, on a terminal only; gone when done."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(pulse_style="cyan"), TimeElapsedColumn())
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task(what, total=None)
        yield lambda step: bar.update(task, description=f"{what}: {step}")


def say(text: str) -> None:
    """Print one line as it is."""
    typer.echo(text)


def show(table: "Table") -> None:
    """Print a table."""
    from rich.console import Console

    Console(soft_wrap=False).print(table)


def table(title: str, *columns: str) -> "Table":
    """Return an empty table; columns that begin with > are right-aligned."""
    from rich import box
    from rich.table import Table

    made = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD)
    for name in columns:
        right = name.startswith(">")
        made.add_column(name.removeprefix(">"), justify="right" if right else "left")
    return made
