"""`look`: what an unknown file is, and which of its columns may be which channel."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from autodb.cli._common import Json, say, say_json, show, table, working
from autodb.cli._reader import headed, in_english, shown_again
from autodb.wording import localized, msgid, phrase, shop_amount

if TYPE_CHECKING:
    from autodb.readers import ColumnSet
    from autodb.records.proposed.columns import ProposedBase
    from autodb.records.summary import BaseSummary

AnyFile = Annotated[Path, typer.Argument(readable=False, help="Any file that a logger wrote.")]
Write = Annotated[
    bool, typer.Option("--write", help="Write the side file beside it; never over one.")
]
CUTS = msgid("{file}: {count} cuts, {columns} columns")
ROWS = msgid("{file}: {count} rows, {columns} columns")
FIRST_CUTS = msgid("{file}: the first {count} cuts, {columns} columns")
FIRST_ROWS = msgid("{file}: the first {count} rows, {columns} columns")
SHOWN = 6
"""Columns of the first rows, and unused ones, that are shown."""


def look_command(file: AnyFile, write: Write = False, json: Json = False) -> None:
    """Show what a file is: its rows, and which column may be which channel, with the reason.

    A velocity is known by its position, an effort by the motion that it follows. Nothing is stored.
    """
    from autodb.errors import UnusableInput
    from autodb.files.side import SideFile, read_sidefile
    from autodb.files.targets import write_text
    from autodb.records.proposed.looked import proposed_bases
    from autodb.records.proposed.written import side_file_of

    target = file.parent / f"{file.stem}.toml"
    if write and target.exists():
        raise UnusableInput(
            phrase("{target}: is there already; move it away to have it written", target=target)
        )
    side = read_sidefile(target) if target.is_file() else SideFile()
    with working(f"reading {file.name}"), in_english():
        found = proposed_bases(file, side.csv)
    if json:
        say_json([_as_json(base) for base in found])  # found in English
    else:
        for base in found:
            _show(file, base)
    if write:
        write_text(target, side_file_of(found, file.name))
    if write and not json:
        say(
            phrase(
                "written: {target}; check it, then: autodb import {file}",
                target=target.name,
                file=shlex.quote(file.name),
            )
        )


def _as_json(found: "ProposedBase") -> dict[str, Any]:
    return {
        "name": found.base.name,
        "rows": found.rows,
        "goes_on": found.goes_on,
        "holds_cuts": found.holds_cuts,
        "read_as": found.base.layout,
        "columns": found.base.columns,
        "channels": found.proposals,
        "missing": found.missing,
    }


def _show(file: Path, found: "ProposedBase") -> None:
    base = found.base
    title = f"{file.name} {base.name}".rstrip()
    sentence = ROWS
    if found.holds_cuts:
        sentence = FIRST_CUTS if found.goes_on else CUTS
    elif found.goes_on:
        sentence = FIRST_ROWS
    said = phrase(sentence, file=title, count=found.rows, columns=len(base.columns))
    if base.layout:
        said = phrase("{what}; read as: {layout}", what=said, layout=shown_again(base.layout))
    say(said)
    _show_rows(base, found.first)
    if found.proposals:
        heads = (phrase("column"), phrase("channel"), phrase("unit"), phrase("because"))
        rows = table(phrase("Proposed channels"), *heads)
        for one in found.proposals:
            column = phrase("(rows counted)") if one.column == "*" else one.column
            rows.add_row(column, one.channel, one.unit, shown_again(one.because))
        show(rows)
    used = {one.column for one in found.proposals}
    rest = [name for name in base.columns if name not in used]
    if rest:
        said = phrase("no channel: {names}", names=", ".join(rest[:SHOWN]))
        if len(rest) > SHOWN:
            said = phrase("{what} and {count} more", what=said, count=len(rest) - SHOWN)
        say(said)
    for sentence in found.missing:
        say(phrase("missing for {what}", what=shown_again(sentence)))


def _show_rows(base: "ColumnSet", first: tuple[tuple[str, ...], ...]) -> None:
    title = phrase("First rows")
    if len(base.columns) > SHOWN:
        title = phrase("First rows (of {count} columns)", count=len(base.columns))
    rows = table(title, *base.columns[:SHOWN])
    for row in first:
        rows.add_row(*row[:SHOWN])
    show(rows)


def show_file(file: Path, columns: Path | None) -> None:
    """Show what a file holds, and refuse it as an import would."""
    from autodb.records.plausible import refuse_implausible
    from autodb.records.source import open_source
    from autodb.records.summary import summarise

    with working(f"reading {file.name}") as progress:
        source = open_source(file, columns=columns)
        bases = summarise(source, progress=progress)
    for base in bases:
        _show_summary(f"{file.name} {base.name}".rstrip(), base)
    for remark in source.remarks:
        say(shown_again(remark))
    refuse_implausible(source, bases)


def _show_summary(title: str, base: "BaseSummary") -> None:
    said = phrase("{file}: {count} cuts", file=title, count=base.rows)
    if base.timing is not None:
        said = phrase(
            "{file}: {count} rows, {low} to {high} s; time: {timing}",
            file=title, count=base.rows, low=localized(f"{base.start_s:g}"),
            high=localized(f"{base.end_s:g}"), timing=shown_again(str(base.timing))
        )  # fmt: skip
    rows = table(
        said,
        *(phrase("channel"), phrase("unit"), headed(phrase("lowest")), headed(phrase("highest"))),
        *(headed(phrase("mean")), phrase("gaps")),
    )
    for c in base.channels.values():
        factor, unit = shop_amount(1.0, c.unit)
        values = (factor * v for v in (c.minimum, c.maximum, c.mean))
        numbers = [localized(f"{v:.6g}") for v in values] if c.finite else ["", "", ""]
        gaps = ""
        if c.first_gap:
            gaps = phrase("{count}, first in row {row}", count=c.rows - c.finite, row=c.first_gap)
        rows.add_row(c.name, unit, *numbers, gaps)
    show(rows)
