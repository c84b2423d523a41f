"""What every command shares: the database option, tables, progress, and how errors end."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from autodb.wording import phrase

if TYPE_CHECKING:
    from rich.table import Table
    from rich.tree import Tree

    from autodb.records.tables import CutTable, Recording
    from autodb.store import Store

Database = Annotated[
    str | None,
    typer.Option("--db", help="Database URL [default: AUTODB_DB or sqlite:///autodb.sqlite3]"),
]
Columns = Annotated[
    Path | None,
    typer.Option(
        "--columns", readable=False, help="TOML file that names the foreign columns and units."
    ),
]
Group = Annotated[
    str | None,
    typer.Option("--group", help="Time base to read, where the file has several."),
]
Resample = Annotated[
    float | None,
    typer.Option(
        "--resample", metavar="HZ", help="Bring all time bases of the file onto one of this rate."
    ),
]
MachineName = Annotated[
    str | None,
    typer.Option("--machine", help="Name of the machine [default: the only one]"),
]
MachineAlone = Annotated[str | None, typer.Argument(metavar="NAME", hidden=True)]
"""A machine's name behind a command, as it stood before version 0.3."""
Json = Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")]
SelfContained = Annotated[
    bool,
    typer.Option(
        "--self-contained",
        help="Put the script of plots into the page (5 MB), in place of beside it.",
    ),
]
OptionalMachine = Annotated[
    str | None,
    typer.Option("--machine", help="Name of the machine; without it nothing is stored."),
]


def check_page(path: Path | None, *, option: str, self_contained: bool) -> None:
    """Raise UnusableInput where a page could not be written to ``path``, or none is asked for."""
    from autodb.errors import UnusableInput
    from autodb.files.targets import check_target

    if path is not None:
        check_target(path, suffix=".html", option=option)
    elif self_contained:
        raise UnusableInput(phrase("--self-contained goes with {option} FILE.html", option=option))


@contextmanager
def opened_store(db: str | None) -> "Iterator[Store]":
    """Open the database of ``--db`` and close it again."""
    from autodb.store import database_url, opened_database

    with opened_database(database_url(db)) as store:
        yield store


@contextmanager
def opened_machine(db: str | None, name: str | None) -> "Iterator[tuple[Store, str]]":
    """Open the database of ``--db``; give it with the machine that is meant, by default the only.

    Raises UnusableInput where there is not just one.
    """
    with opened_store(db) as store:
        yield store, name or only_machine(store)


def only_machine(store: "Store") -> str:
    """Return the name of the only machine; raises UnusableInput where there is not just one."""
    from autodb.agent.rows.machines import the_machine

    with store.reading() as session:
        return the_machine(session, None)


def default_machine(db: str | None) -> str | None:
    """Return the name of the only machine; None without a database, or with none or several."""
    from autodb.agent.rows.machines import machines_at_work
    from autodb.store import database_url, file_of, on_server

    url = database_url(db)
    if not on_server(url) and not file_of(url).exists():
        return None
    with opened_store(db) as store, store.reading() as session:
        names = machines_at_work(session)
    return names[0] if len(names) == 1 else None


def named_machine(name: str | None, alone: str | None) -> str | None:
    """Return the name of a machine, which stood ``alone`` behind a command before version 0.3."""
    if alone is not None:
        typer.echo(f"autodb: '{alone}' alone goes in the next version; use --machine", err=True)
    return name or alone


class Stopped(Exception):  # noqa: N818 - the end that was asked for, no error
    """What goes on until Ctrl-C was stopped by it."""


@contextmanager
def until_stopped() -> Iterator[None]:
    """Run what ends once it is told to, and say that it stopped; raises Stopped for Ctrl-C."""
    try:
        yield
    except KeyboardInterrupt:
        typer.echo("autodb: stopped", err=True)
        raise Stopped from None
    typer.echo("autodb: stopped", err=True)


def from_anywhere(db: str | None) -> str:
    """Return the URL of ``--db`` as a command may say it that another program runs.

    Raises UnusableInput for one with a password, which others could read.
    """
    from sqlalchemy.engine import make_url

    from autodb.errors import UnusableInput
    from autodb.store import database_url, on_server, shown_url, whole_url

    url = database_url(db)
    if on_server(url) and make_url(url).password is not None:
        raise UnusableInput(
            phrase(
                "{url}: others can read a command's password; put it into ~/.pgpass",
                url=shown_url(url),
            )
        )
    return whole_url(url)


def read_one(
    path: Path,
    *,
    columns: Path | None,
    group: str | None,
    resample_hz: float | None,
    like: "Recording | CutTable | None" = None,
) -> "Recording | CutTable":
    """Read one time base of a file, or all of them at one rate, or at the times of ``like``.

    Where its stamps are those of ``like``, its rows are laid out alike.
    """
    from autodb.records.resample import one_base
    from autodb.records.source import open_source

    source = open_source(path, columns=columns)
    return one_base(source, group=group, resample_hz=resample_hz, like=like)


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


@contextmanager
def progress_bar(what: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show a bar of how many of ``total`` are done, on a terminal only; gone when done."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
    from rich.progress import TimeRemainingColumn as Remaining

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), Remaining())
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task(what, total=total)
        yield lambda done: bar.update(task, completed=done)


def say(text: str) -> None:
    """Print one line as it is."""
    typer.echo(text)


def complain(text: str) -> None:
    """Print one line beside an answer that a program reads."""
    typer.echo(text, err=True)


def say_json(answer: object) -> None:
    """Print plain data, and dataclasses in it, as JSON."""
    from pydantic_core import to_json

    typer.echo(to_json(answer, indent=1, inf_nan_mode="null").decode())


WIDE = 200
"""Columns where the output goes to a file or a pipe, which do not say how wide they are."""


def show(printed: "Table | Tree") -> None:
    """Print a table or a tree, as wide as the terminal, or `COLUMNS`, or else WIDE."""
    from rich.console import Console

    unsaid = not sys.stdout.isatty() and "COLUMNS" not in os.environ
    Console(width=WIDE if unsaid else None, markup=False, highlight=False).print(printed)


def table(title: str, *columns: str) -> "Table":
    """Return an empty table; columns that begin with > are right-aligned."""
    from rich import box
    from rich.table import Table

    made = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD)
    for name in columns:
        right = name.startswith(">")
        justify: Literal["left", "right"] = "right" if right else "left"
        made.add_column(name.removeprefix(">"), justify=justify, overflow="fold")
    return made
