"""`import`: recordings, cut tables and material cards on their way into the database."""

import shlex
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
from autodb.cli._reader import for_reader, in_english
from autodb.cli.start.looking import show_file
from autodb.wording import phrase, phrase_many
from autodb.wording.kept import said_again

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from autodb.agent.ingest.importing import Imported
    from autodb.agent.rows.imported_cards import ImportedCard
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
    from autodb.agent.rows.imported_cards import keep_cards
    from autodb.pairs.cards import is_card, read_cards

    cards = [file for file in files if is_card(file)]
    recordings = [file for file in files if file not in cards]
    if cards:
        with in_english(), opened_store(db) as store:
            kept = [(file, card) for file in cards for card in keep_cards(store, read_cards(file))]
        for file, card in kept:
            _say_card(file, card)
    machine = machine or (default_machine(db) if recordings else None)
    if machine is None:
        for file in recordings:
            show_file(file, columns)
        if recordings:
            say(phrase("not stored: give --machine NAME to keep it"))
    elif recordings:
        tell = for_reader(complain if json else say)

        def said(done: "Imported", file: Path) -> None:
            if not json:
                for line in _lines(file, done):
                    tell(line)

        with in_english(), opened_store(db) as store:
            done = each_used(
                recordings,
                lambda file: _import(store, file, machine, columns, again=again, tell=said),
                tell=tell,
            )
        if json:
            say_json([{"file": str(file), **asdict(one)} for file, one in done])


def _say_card(file: Path, card: "ImportedCard") -> None:
    """Say what became of a card of material."""
    what = phrase("already there") if card.already_there else phrase("imported")
    if card.replaced:
        what = phrase("replaces the one of this source: {what}", what="; ".join(card.replaced))
    said = phrase(
        "{file}: card of {material} ({source}): {what}",
        file=file.name, material=card.material, source=card.source, what=what
    )  # fmt: skip
    say(said)


def _import(
    store: "Store",
    file: Path,
    machine: str,
    columns: Path | None,
    *,
    again: bool,
    tell: "Callable[[Imported, Path], None]",
) -> "tuple[Path, Imported]":
    """Import one file, tell what became of it, and return it."""
    from autodb.agent.ingest.importing import import_file
    from autodb.agent.operate.withdrawing import read_again

    with working(f"importing {file.name}") as progress:
        done = import_file(
            store, file, machine=machine, columns=columns, progress=progress,
            instead=read_again if again else None,
        )  # fmt: skip
    tell(done, file)
    return file, done


def _lines(file: Path, done: "Imported") -> "Iterator[str]":
    """Yield what became of a file, and what there is to say of how it was read."""
    what = phrase("imported")
    if done.withdrawn is not None:
        what = phrase("withdrawn ({why}), it does not count", why=done.withdrawn)
    elif done.already_there and not done.looked_at:
        what = phrase("already there")
    if done.other_side:
        what = phrase(
            "{what} (with another side file, which still holds; --again reads it with this one)",
            what=what,
        )
    counted = phrase_many("{rows} rows, {count} cut", "{rows} rows, {count} cuts", done.cuts,
                          rows=done.rows)  # fmt: skip
    if done.again:
        counted = phrase("{counted}, {again} more are there already", counted=counted,
                         again=done.again)  # fmt: skip
    yield phrase(
        "recording {number}: {file}: {what}, {counted}",
        number=done.recording_id, file=file.name, what=what, counted=counted
    )  # fmt: skip
    if done.unpaired:
        yield phrase(
            "{file}: nothing is learnt of {count} cuts that say no work material or no tool: state "
            "[recording] work and [tool] name in {side}, then: autodb import {again} --again",
            file=file.name, again=shlex.quote(file.name), count=done.unpaired,
            side=file.with_suffix(".toml").name
        )  # fmt: skip
    for sentence in done.timing:
        yield phrase("{file}: time: {what}", file=file.name, what=said_again(sentence))
    for note in done.notes:
        yield phrase("{file}: {note}", file=file.name, note=said_again(note))
