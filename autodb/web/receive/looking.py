"""A file of whatever logger, looked at for a person who says what its columns are."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from autodb.files.channels import TEXT_COLUMNS, unit_of
from autodb.files.operation_words import suggested_operation
from autodb.files.side import Operation, SideFile, read_sidefile
from autodb.readers import READERS
from autodb.records.proposed.choices import (
    ROWS,
    ColumnChoice,
    SideChoices,
    chosen_now,
    with_choices,
)
from autodb.records.proposed.columns import ProposedBase
from autodb.records.proposed.cuts import ChannelProposal
from autodb.records.proposed.looked import LookedFile, look_with
from autodb.records.proposed.missing import missing_of_cuts, missing_of_moves
from autodb.records.proposed.written import side_text
from autodb.records.summary import BaseSummary
from autodb.store import Store
from autodb.wording import (
    Presentation,
    Worded,
    language_of,
    listed,
    localized,
    phrase,
    presentation,
    presented,
)
from autodb.wording.kept import said_again

LISTED = 200
"""Columns of a file that can be chosen one by one: beyond, those without a channel are not listed,
and the text of the side file says more. Chosen."""
FILE = "file"
TEXT_KEYS = ("separator", "decimal", "encoding", "header_line", "units_line", "first_line")


@dataclass(frozen=True)
class ColumnShown:
    """A column as the page has it: its first values, what was chosen, why, and what that gives.

    ``signed``: its sign may be turned round.
    """

    column: str
    first: str
    chosen: ColumnChoice
    unit: str
    because: str
    reaches: str
    signed: bool


@dataclass(frozen=True)
class BaseShown:
    """A time base as the page has it: what it is, its columns, and what it still lacks."""

    title: str
    layout: str
    rows: tuple[ColumnShown, ...]
    unlisted: int
    timing: str
    missing: tuple[str, ...]


@dataclass(frozen=True)
class FileToLook:
    """Look at a file that lies at ``path``, with its side file beside it; nothing is kept.

    Without a side file and ``choices``, which a person makes beyond it, channels are proposed.
    """

    path: Path
    choices: SideChoices | None = None

    def do(self, _store: Store, tell: Callable[[str], None]) -> bytes:
        """Return the piece of the page that shows it, as JSON; raises UnusableInput."""
        from autodb.reports.figures import fragment  # draws too, and is heavy

        beside = self.path.with_suffix(".toml")
        side = read_sidefile(beside) if beside.is_file() else SideFile()
        if self.choices is None:
            anew = not beside.is_file()
        else:
            side, anew = with_choices(side, self.choices)
        looked = look_with(self.path, side, propose=anew, progress=tell)
        with presented(Presentation(presentation().language)):  # a file's numbers in its units
            piece = fragment("site/_looked.html.j2", **_shown(looked))
        return json.dumps(str(piece)).encode()


def _shown(looked: LookedFile) -> dict[str, object]:
    """Return what the template shows of a file."""
    said = looked.side.csv
    text = {key: getattr(said, key) for key in _text_keys(looked.path)}
    means = looked.side.values.operation
    words = dict.fromkeys([*(w for base in looked.found for w in base.operations), *means])
    bases = [_base(looked, base) for base in looked.found]
    return {
        "bases": bases,
        "problems": [_problem(one) for one in looked.problems],
        "notes": looked.notes,
        "text": {key: "" if value is None else value for key, value in text.items()},
        "words": {word: means.get(word, "") for word in words},
        "suggested": {word: suggested_operation(word) for word in words},
        "operations": get_args(Operation),
        "side": side_text(looked.side),
        "plain": _is_plain(looked, bases),
    }


def _problem(said: str) -> Worded:
    """Return what keeps a file out, for the reader; sentences that are known begin with a file."""
    again = said_again(f"{FILE}: {said}")
    if language_of(again) == "en":
        return said_again(said)
    return Worded(again.removeprefix(f"{FILE}: "), language_of(again))


def _text_keys(path: Path) -> tuple[str, ...]:
    kind = READERS.get(path.suffix.lower())
    return {"text.reading": TEXT_KEYS, "workbook": ("sheet",)}.get(str(kind), ())


def _is_plain(looked: LookedFile, bases: Sequence[BaseShown]) -> bool:
    """Say whether there is nothing to ask: each column is a channel by its own name."""
    every = all(one.column in (one.chosen.channel, ROWS) for base in bases for one in base.rows)
    return every and not looked.problems and not looked.notes and not looked.side.channels


def _base(looked: LookedFile, found: ProposedBase) -> BaseShown:
    base = found.base
    chosen = chosen_now(base.columns, looked.side)
    summary = next((one for one in looked.summaries if one.name == base.name), None)
    listed_columns = _listed_columns(base.columns, chosen)
    channels = {one.channel for one in chosen.values()}
    missing = missing_of_cuts(channels) if found.holds_cuts else missing_of_moves(channels)
    counts = {"count": found.rows, "columns": len(base.columns)}
    if found.holds_cuts:
        what = phrase("{count} cuts, {columns} columns", **counts)
    elif found.goes_on:
        what = phrase("the first {count} rows, {columns} columns", **counts)
    else:
        what = phrase("{count} rows, {columns} columns", **counts)
    return BaseShown(
        title=listed([base.name, what], ": ") if base.name else what,
        layout=base.layout,
        rows=tuple(_rows(found, listed_columns, chosen, summary)),
        unlisted=len(base.columns) - len(listed_columns) + (ROWS in listed_columns),
        timing=str(summary.timing) if summary is not None and summary.timing is not None else "",
        missing=tuple(missing),
    )


def _listed_columns(columns: Sequence[str], chosen: dict[str, ColumnChoice]) -> list[str]:
    """Return the columns that are listed, after the count of rows where that is a channel."""
    first = {*columns[:LISTED], *chosen}
    return [*([ROWS] if ROWS in chosen else []), *(name for name in columns if name in first)]


def _rows(
    found: ProposedBase,
    columns: Sequence[str],
    chosen: dict[str, ColumnChoice],
    summary: BaseSummary | None,
) -> Iterator[ColumnShown]:
    places = {name: place for place, name in enumerate(found.base.columns)}
    proposals = {one.column: one for one in reversed(found.proposals)}
    for column in columns:
        one = chosen.get(column, ColumnChoice(column))
        values = [row[places[column]] for row in found.first] if column in places else []
        yield ColumnShown(
            column=column,
            first=" · ".join(_in_words(text) for text in dict.fromkeys(values)),
            chosen=one,
            unit=found.base.units.get(column) or _our_unit(one.channel),
            because=_because(one, proposals.get(column)),
            reaches=_reach(one.channel, summary),
            signed=column != ROWS and one.channel not in (*TEXT_COLUMNS, "t", "cut"),
        )


def _our_unit(channel: str) -> str:
    unit = unit_of(channel)
    return "" if unit in (None, "1") else str(unit)


def _in_words(text: str) -> str:
    """Return a value as the reader writes it, where it is a number."""
    try:
        float(text)
    except ValueError:
        return text
    return localized(text)


def _because(one: ColumnChoice, proposal: ChannelProposal | None) -> str:
    if proposal is None or proposal.channel == one.column:
        return ""
    if proposal.channel == one.channel:
        return proposal.because
    return phrase("{channel}? {why}", channel=proposal.channel, why=proposal.because)


def _reach(channel: str, summary: BaseSummary | None) -> str:
    """Return from where to where a channel goes as it would be imported."""
    known = None if summary is None else summary.channels.get(channel)
    if known is None or not known.finite:
        return ""
    unit = "" if known.unit == "1" else f" {known.unit}"
    low, high = (localized(f"{value:.4g}") for value in (known.minimum, known.maximum))
    return phrase("{low} to {high}{unit}", low=low, high=high, unit=unit)
