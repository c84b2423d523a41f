"""`look`: what an unknown file is, and which of its columns may be which channel."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from autodb.cli._common import Json, say, say_json, show, table, working

if TYPE_CHECKING:
    from autodb.readers import ColumnSet
    from autodb.records.proposed.columns import ProposedBase
    from autodb.records.summary import BaseSummary

AnyFile = Annotated[Path, typer.Argument(readable=False, help="Any file that a logger wrote.")]
Write = Annotated[
    bool, typer.Option("--write", help="Write the side file beside it; never over one.")
]
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
        raise UnusableInput(f"{target}: is there already; move it away to have it written")
    side = read_sidefile(target) if target.is_file() else SideFile()
    with working(f"reading {file.name}"):
        found = proposed_bases(file, side.csv)
    if json:
        say_json([_as_json(base) for base in found])
    else:
        for base in found:
            _show(file, base)
    if write:
        write_text(target, side_file_of(found, file.name))
    if write and not json:
        say(f"written: {target.name}; check it, then: autodb import {file.name}")


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
    what = "cuts" if found.holds_cuts else "rows"
    first = "the first " if found.goes_on else ""
    say(f"{title}: {first}{found.rows} {what}, {len(base.columns)} columns"
        + (f"; read as: {base.layout}" if base.layout else ""))  # fmt: skip
    _show_rows(base, found.first)
    if found.proposals:
        rows = table("Proposed channels", "column", "channel", "unit", "because")
        for one in found.proposals:
            column = "(rows counted)" if one.column == "*" else one.column
            rows.add_row(column, one.channel, one.unit, one.because)
        show(rows)
    used = {one.column for one in found.proposals}
    rest = [name for name in base.columns if name not in used]
    if rest:
        more = f" and {len(rest) - SHOWN} more" if len(rest) > SHOWN else ""
        say(f"no channel: {', '.join(rest[:SHOWN])}{more}")
    for sentence in found.missing:
        say(f"missing for {sentence}")


def _show_rows(base: "ColumnSet", first: tuple[tuple[str, ...], ...]) -> None:
    more = f" (of {len(base.columns)} columns)" if len(base.columns) > SHOWN else ""
    rows = table(f"First rows{more}", *base.columns[:SHOWN])
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
        say(remark)
    refuse_implausible(source, bases)


def _show_summary(title: str, base: "BaseSummary") -> None:
    what = f"{base.rows} cuts"
    if base.timing is not None:
        what = f"{base.rows} rows, {base.start_s:g} to {base.end_s:g} s; time: {base.timing}"
    rows = table(f"{title}: {what}", "channel", "unit", ">lowest", ">highest", ">mean", "gaps")
    for c in base.channels.values():
        numbers = [f"{v:.6g}" for v in (c.minimum, c.maximum, c.mean)] if c.finite else ["", "", ""]
        gaps = f"{c.rows - c.finite}, first in row {c.first_gap}" if c.first_gap else ""
        rows.add_row(c.name, c.unit, *numbers, gaps)
    show(rows)
