"""Text tables: one time base, or one for each column of time."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa

from autodb.errors import UnusableInput
from autodb.files.csvtext import restored
from autodb.files.text import TextSection
from autodb.readers._base import Columns, ColumnSet, Labels, Numbers, refuse_twice
from autodb.readers.text.detect import detected
from autodb.readers.text.layout import TextLayout
from autodb.readers.text.pieces import TextPiece
from autodb.readers.text.source import whole_lines
from autodb.wording import phrase, stored_msgid

TIME = "t"
NO_ROWS_BELOW = stored_msgid("{file}: no rows of data below the header line")


@dataclass(frozen=True)
class _Part:
    """The columns of one time base, by place.

    ``step_s``: of rows without stamps. ``clocks``: places of stamps, all of them the same, or of
    columns that tell where such rows end; none where the file has one part.
    """

    places: tuple[int, ...]
    step_s: float | None = None
    clocks: tuple[int, ...] = ()


def open_file(path: Path, stated: TextSection) -> tuple[ColumnSet, ...]:
    """Open a text table by its first lines."""
    layout = detected(path, stated)
    parts = _parts(path, layout)
    return tuple(_base(path, layout, part, several=len(parts) > 1) for part in parts)


def _parts(path: Path, layout: TextLayout) -> list[_Part]:
    every = range(len(layout.names))
    if layout.steps_s:
        steps = [*dict.fromkeys(layout.steps_s.values())]
        if not layout.short_rows:
            return [_Part(tuple(every), steps[0])]
        alike = [tuple(k for k, s in layout.steps_s.items() if s == step) for step in steps]
        return [_Part(places, step, places) for places, step in zip(alike, steps, strict=True)]
    times = layout.times or tuple(k for k in every if layout.names[k] == layout.names[0])
    if len(times) < 2:
        return [_Part(tuple(every))]
    ends = [*times[1:], len(every)]
    spans = [tuple(range(begin, end)) for begin, end in zip((0, *times[1:]), ends, strict=True)]
    spans[0] = (times[0], *(place for place in spans[0] if place != times[0]))
    spans = [span for span in spans if len(span) > 1]
    return _joined(path, layout, spans) if spans else [_Part(tuple(every))]


def _joined(path: Path, layout: TextLayout, spans: list[tuple[int, ...]]) -> list[_Part]:
    """Return spans of columns as parts, those with the same times in the first piece as one."""
    firsts = [span[0] for span in spans]
    piece = TextPiece(
        path, next(whole_lines(path, layout.encoding, layout.first, layout.ends), b""), layout, 0
    )
    table = piece.parse(firsts, ())
    alike: dict[bytes, list[tuple[int, ...]]] = {}
    for span in spans:
        alike.setdefault(_numbers(table, span[0]).tobytes(), []).append(span)
    return [
        _Part(
            (one[0][0], *(place for span in one for place in span[1:])),
            clocks=tuple(span[0] for span in one),
        )
        for one in alike.values()
    ]


def _base(path: Path, layout: TextLayout, part: _Part, *, several: bool) -> ColumnSet:
    names = {layout.names[place]: place for place in part.places}
    refuse_twice(path, [layout.names[place] for place in part.places], "header")
    made, step_s = part.step_s is not None, part.step_s or 0.0

    def blocks(numbers: Sequence[str], labels: Sequence[str]) -> Iterator[Columns]:
        rows = lines = 0
        for text in whole_lines(path, layout.encoding, layout.first, layout.ends):
            wanted = [name for name in numbers if name in names]
            piece = TextPiece(path, text, layout, lines)
            columns, kept, there = _columns(piece, part, names, wanted, labels)
            if made and TIME in numbers:
                columns[TIME] = np.asarray((rows + np.arange(kept)) * step_s, np.float64)
            rows, lines = rows + kept, lines + there
            yield columns
        if not rows:
            raise UnusableInput(NO_ROWS_BELOW.format(file=path))

    return ColumnSet(
        layout.names[part.places[0 if made else 1]] if several else "",
        (TIME, *names) if made else tuple(names),
        blocks,
        {layout.names[k]: unit for k, unit in layout.units.items() if k in part.places},
        str(layout),
    )


def _columns(
    piece: TextPiece,
    part: _Part,
    names: dict[str, int],
    numbers: Sequence[str],
    labels: Sequence[str],
) -> tuple[Columns, int, int]:
    """Return columns of a piece, how many rows the part has in it, and how many lines there are.

    Where a file has several parts, rows end where the part's stamps end.
    """
    clocks = part.clocks
    table = piece.parse([*(names[n] for n in numbers), *clocks], [names[n] for n in labels])
    columns: Columns = {name: _numbers(table, names[name]) for name in numbers}
    columns |= {name: _labels(table, names[name]) for name in labels}
    if not clocks:
        return columns, table.num_rows, table.num_rows
    said = [_numbers(table, place) for place in clocks]
    if part.step_s is None and not all(np.array_equal(said[0], t, equal_nan=True) for t in said):
        raise UnusableInput(
            phrase(
                "{file}: columns of time that begin alike differ later; give each time base a "
                "file of its own",
                file=piece.path,
            )
        )
    kept = np.any(np.isfinite(said), axis=0, keepdims=False)
    return {name: values[kept] for name, values in columns.items()}, int(kept.sum()), len(kept)


def _numbers(table: pa.Table, place: int) -> Numbers:
    values = table.column(str(place)).to_numpy(zero_copy_only=False)
    return np.asarray(values, dtype=np.float64)


def _labels(table: pa.Table, place: int) -> Labels:
    """Return texts as they were before a formula among them was made neutral."""
    texts = [restored(text or "") for text in table.column(str(place)).to_pylist()]
    return np.array(texts, dtype=np.str_)
