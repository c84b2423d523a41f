"""Proposed channels of a time base: what speaks for each, and what is still missing."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np

from autodb.errors import UnusableInput
from autodb.files.channels import is_channel
from autodb.files.operation_words import suggested_operation
from autodb.files.side import Operation
from autodb.readers import ColumnSet
from autodb.records.proposed.cut_names import has_unit_of, of_a_cut
from autodb.records.proposed.cuts import ChannelProposal, with_told_units
from autodb.records.proposed.missing import missing_of_cuts
from autodb.records.proposed.motion import FEWEST, Array
from autodb.records.proposed.moves import proposed_moves, rises, steps_evenly
from autodb.records.proposed.names import is_time, said_by
from autodb.timing.dates import is_date
from autodb.wording import phrase

MOST_ROWS = 40_000
"""Rows that are looked at: those in which most moves. Chosen: some seconds to minutes."""
MOST_CUTS = 5000
"""A table of more rows holds moments, not cuts. Chosen."""


@dataclass(frozen=True)
class ProposedBase:
    """What a time base may hold.

    ``rows``: those that were looked at, after which it ``goes_on``. ``operations``: texts that are
    no operation of ours. ``first``: its first rows as text.
    """

    base: ColumnSet
    rows: int
    goes_on: bool
    holds_cuts: bool
    proposals: tuple[ChannelProposal, ...]
    missing: tuple[str, ...]
    operations: tuple[str, ...]
    first: tuple[tuple[str, ...], ...]


def propose_channels(base: ColumnSet) -> ProposedBase:
    """Return what the columns of a time base may be.

    Raises UnusableInput where nothing can be read.
    """
    numbers, texts = _columns(base)
    rows = len(next(iter([*numbers.values(), *texts.values()]), ()))
    goes_on = rows > MOST_CUTS and _goes_on(base)
    first = tuple(
        tuple(_shown(numbers, texts, name, row) for name in base.columns)
        for row in range(min(3, rows))
    )
    if _are_cuts(base.columns, rows, numbers):
        found = tuple(with_told_units(_cut_columns(base, numbers, texts), numbers))
        column = next((one.column for one in found if one.channel == "operation"), "")
        channels = {one.channel for one in found}
        odd = dict.fromkeys(v for v in texts.get(column, ()) if v and v not in get_args(Operation))
        return ProposedBase(
            base, rows, goes_on, True, found, tuple(missing_of_cuts(channels)), tuple(odd), first
        )
    moves = proposed_moves(_busiest(numbers), _dates(texts), base.units)
    found = tuple(ChannelProposal(*one) for one in moves.found)
    return ProposedBase(base, rows, goes_on, False, found, moves.missing, (), first)


def _goes_on(base: ColumnSet) -> bool:
    """Say whether there are more rows than those of the first block."""
    blocks = base.blocks((), base.columns[:1])
    next(blocks)
    return next(blocks, None) is not None


def _columns(base: ColumnSet) -> tuple[dict[str, Array], dict[str, Sequence[str]]]:
    """Return the first block of all columns, as numbers where they are, else as texts."""
    try:
        return _first(base, list(base.columns)), {}
    except UnusableInput:
        pass
    numbers: dict[str, Array] = {}
    texts: dict[str, Sequence[str]] = {}
    for name in base.columns:
        try:
            numbers |= _first(base, [name])
        except UnusableInput:
            block = next(base.blocks((), (name,)))
            texts[name] = [str(text) for text in block[name].tolist()]
    return numbers, texts


def _first(base: ColumnSet, names: list[str]) -> dict[str, Array]:
    block = next(base.blocks(names, ()))
    return {name: np.asarray(block[name], dtype=np.float64) for name in names}


def _shown(
    numbers: Mapping[str, Array], texts: Mapping[str, Sequence[str]], name: str, row: int
) -> str:
    return f"{numbers[name][row]:.6g}" if name in numbers else texts[name][row]


def _busiest(numbers: Mapping[str, Array]) -> dict[str, Array]:
    """Return MOST_ROWS rows of the columns: those in which they change the most."""
    rows = len(next(iter(numbers.values()), ()))
    if rows <= MOST_ROWS:
        return dict(numbers)
    change = np.zeros(rows - 1)
    for values in numbers.values():
        known = values[np.isfinite(values)]
        spread = float(np.std(known)) if known.size else 0.0
        if spread > 0:
            change += np.nan_to_num(np.minimum(np.abs(np.diff(values)) / spread, 1.0))
    starts = np.arange(0, rows - MOST_ROWS, MOST_ROWS // 2)
    sums = np.concatenate([[0.0], np.cumsum(change)])
    start = int(starts[np.argmax(sums[starts + MOST_ROWS - 1] - sums[starts])])
    return {name: values[start : start + MOST_ROWS] for name, values in numbers.items()}


def _dates(texts: Mapping[str, Sequence[str]]) -> list[str]:
    return [name for name, values in texts.items() if len(values) and is_date(values[0])]


def _are_cuts(names: Sequence[str], rows: int, numbers: Mapping[str, Array]) -> bool:
    """Say whether a row is a cut: two conditions of cutting at least, and no even time."""
    said = {of_a_cut(name) for name in names}
    conditions = {channel for channel in said if channel.startswith("cutting.")}
    conditions |= said & {"work.diameter", "operation", "spindle.speed"}
    even = any(is_time(n) and rises(v) and steps_evenly(v) for n, v in numbers.items())
    timed = even and rows >= FEWEST and "operation" not in said
    return rows <= MOST_CUTS and len(conditions) >= 2 and not timed


def _cut_columns(
    base: ColumnSet, numbers: Mapping[str, Array], texts: Mapping[str, Sequence[str]]
) -> Iterator[ChannelProposal]:
    taken: set[str] = set()
    for name in base.columns:
        channel = of_a_cut(name) or ("t" if is_time(name) else "") or _current_of_cut(name)
        unit = base.units.get(name, "")
        if not channel or channel in taken or (unit and not has_unit_of(channel, unit)):
            continue
        why = phrase("its name")
        if channel == "cut":
            values = numbers.get(name)
            if values is None or len(np.unique(values)) < len(values):
                continue
            why = phrase("its name, and every row has its own")
        if channel == "t" and not rises(numbers.get(name, np.zeros(2))):
            continue
        taken.add(channel)
        yield ChannelProposal(name, channel, unit, why)
    if "operation" not in taken:
        told = [name for name, values in texts.items() if _all_operations(values)]
        for name in told[:1]:
            yield ChannelProposal(name, "operation", "", phrase("its words are operations"))
    if "cut" not in taken:
        why = phrase("rows are counted: no column numbers them")
        yield ChannelProposal("*", "cut", "", why)


def _all_operations(values: Sequence[str]) -> bool:
    said = {value for value in values if value}
    return bool(said) and all(suggested_operation(value) for value in said)


def _current_of_cut(name: str) -> str:
    """Return the current that a column of a cut table holds: in air where its name says so."""
    said = said_by(name)
    if said.quantity != "current" or not said.axis:
        return ""
    air = {"luft", "air", "leerlauf", "idle", "vide", "vuoto", "vacío"}
    ending = "air" if air & set(name.casefold().replace("_", " ").split()) else "range"
    channel = f"{said.axis}.current.{ending}"
    return channel if is_channel(channel) else ""
