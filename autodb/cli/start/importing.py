"""`import`: recordings, cut tables and material cards on their way into the database."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Columns,
    Database,
    Json,
    MachineName,
    complain,
    default_machine,
    opened_store,
    say,
    say_json,
    working,
)
from autodb.cli.start.looking import show_file

if TYPE_CHECKING:
    from autodb.agent.ingest.importing import Imported
    from autodb.store import Store

Again = Annotated[
    bool,
    typer.Option(
        "--again",
        help="Read a file that is there once more, where its side file says something else now: "
        "what was read of it before is withdrawn.",
    ),
]
Files = Annotated[
    list[Path], typer.Argument(readable=False, help="Recordings, cut tables or material cards.")
]


def import_(
    files: Files,
    machine: MachineName = None,
    columns: Columns = None,
    again: Again = False,
    json: Json = False,
    db: Database = None,
) -> None:
    """Import recordings and cut tables; each file enters once.

    Where the database has several machines, or none, and --machine says none, it only looks.
    Material cards (CSV) belong to no machine.
    """
    from autodb.agent.ingest.gathering import each_used
    from autodb.pairs.cards import is_card

    cards = [file for file in files if is_card(file)]
    recordings = [file for file in files if file not in cards]
    if cards:
        with opened_store(db) as store:
            for file in cards:
                _import_cards(store, file)
    machine = machine or (default_machine(db) if recordings else None)
    if machine is None:
        for file in recordings:
            show_file(file, columns)
        if recordings:
            say("not stored: give --machine NAME to keep it")
    elif recordings:
        with opened_store(db) as store:
            done = each_used(
                recordings,
                lambda file: _import(store, file, machine, columns, again=again, quiet=json),
                tell=complain if json else say,
            )
        if json:
            say_json([{"file": str(file), **asdict(one)} for file, one in done])


def _import_cards(store: "Store", file: Path) -> None:
    """Import a table of material cards and say what became of each."""
    from autodb.agent.rows.imported_cards import keep_cards
    from autodb.pairs.cards import read_cards

    for card in keep_cards(store, read_cards(file)):
        what = "already there" if card.already_there else "imported"
        if card.replaced:
            what = f"replaces the one of this source: {'; '.join(card.replaced)}"
        say(f"{file.name}: card of {card.material} ({card.source}): {what}")


def _import(
    store: "Store", file: Path, machine: str, columns: Path | None, *, again: bool, quiet: bool
) -> "tuple[Path, Imported]":
    """Import one file, say what became of it unless ``quiet``, and return it."""
    from autodb.agent.ingest.importing import import_file
    from autodb.agent.operate.withdrawing import read_again

    with working(f"importing {file.name}") as progress:
        done = import_file(
            store, file, machine=machine, columns=columns, progress=progress,
            instead=read_again if again else None,
        )  # fmt: skip
    if not quiet:
        _say_imported(file, done)
    return file, done


def _say_imported(file: Path, done: "Imported") -> None:
    what = "already there" if done.already_there and not done.looked_at else "imported"
    if done.withdrawn is not None:
        what = f"withdrawn ({done.withdrawn}), it does not count"
    if done.other_side:
        what += " (with another side file, which still holds; --again reads it with this one)"
    again = f", {done.again} more are there already" if done.again else ""
    counted = f"{done.rows} rows, {done.cuts} cuts{again}"
    say(f"recording {done.recording_id}: {file.name}: {what}, {counted}")
    if done.unpaired:
        beside = file.with_suffix(".toml").name
        say(
            f"{file.name}: nothing is learnt of {done.unpaired} cuts that say no work material or "
            f"no tool: state [recording] work and [tool] name in {beside}, then: autodb import "
            f"{file.name} --again"
        )
    for note in (*(f"time: {sentence}" for sentence in done.timing), *done.notes):
        say(f"{file.name}: {note}")
