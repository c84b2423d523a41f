"""How a text table is written, as it was detected or stated, and in words."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from autodb.files.channels import is_channel
from autodb.readers.text.cells import SPACE, bare_unit, is_unit, unit_within
from autodb.wording import listed, localized, msgid, phrase

WORDS = {
    ",": msgid("commas"),
    ";": msgid("semicolons"),
    "\t": msgid("tabs"),
    "|": msgid("bars"),
    ":": msgid("colons"),
    SPACE: msgid("spaces"),
}


@dataclass(frozen=True)
class TextLayout:
    """What is needed to read a text table, and what is shown of it.

    Lines are counted from 0: ``first`` is that of the first row, ``header`` and ``units_line`` are
    None where there is no such line. ``names``: of all columns of the file; ``units`` and
    ``steps_s`` (of columns without stamps) by place. ``times``: the places of columns of time,
    each of which those behind it belong to. ``ends``: the line behind the last row, where remarks
    stand below it; ``labelled``: names stand before the numbers of each row. ``clocks``: what the
    file itself calls its columns of time, where they differ.
    """

    names: tuple[str, ...]
    first: int = 1
    header: int | None = 0
    units_line: int | None = None
    encoding: str = "utf-8"
    separator: str = ","
    decimal: str = "."
    thousands: str = ""
    comment: str = ""
    short_rows: bool = False
    units: dict[int, str] = field(default_factory=dict)
    times: tuple[int, ...] = ()
    steps_s: dict[int, float] = field(default_factory=dict)
    title: str = ""
    ends: int | None = None
    labelled: bool = False
    clocks: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Return what differs from a plain table; empty where nothing does."""
        parts = [self.title] if self.title else []
        if self.separator != ",":
            marks = phrase(WORDS[self.separator]) if self.separator in WORDS else self.separator
            parts.append(phrase("{marks} between columns", marks=marks))
        parts += [phrase("decimal commas")] if self.decimal == "," else []
        if self.thousands:
            parts.append(phrase("'{mark}' between thousands", mark=self.thousands))
        parts += [self.encoding] if self.encoding != "utf-8" else []
        return listed([*parts, *self._lines_in_words()])

    def _lines_in_words(self) -> Iterator[str]:
        """Yield what is said of its lines, which are counted from 1."""
        first = self.first + 1
        if self.header is None and self.labelled:
            yield phrase(
                "line {line} is the first row, columns are called by what stands before them",
                line=first,
            )
        elif self.header is None:
            yield phrase(
                "line {line} is the first row, columns are called by their place", line=first
            )
        elif self.header:
            yield phrase("line {line} names the columns", line=self.header + 1)
        if self.units_line is not None:
            yield phrase("line {line} has units", line=self.units_line + 1)
        if self.comment:
            yield phrase("lines from '{mark}' on left out", mark=self.comment)
        if self.clocks:
            names = ", ".join(f"'{name}'" for name in self.clocks)
            yield phrase("{names} are times, each of the columns behind it", names=names)
        for step_s in dict.fromkeys(self.steps_s.values()):
            yield phrase("rows are {step} s apart", step=localized(f"{step_s:g}"))
        if self.ends is not None:
            yield phrase("remarks from line {line} on left out", line=self.ends + 1)


def column_names(names: Sequence[str], *, times: bool = True) -> tuple[str, ...]:
    """Return names of columns: one without a name is called by its place, others alike are counted.

    Of a channel's own name none is counted: which of two is meant, no one can know. With ``times``
    nor is the first name, which others that are alike share where each time base has its stamps.
    """
    found, counts = [], Counter[str]()
    for place, name in enumerate(names, start=1):
        counts[name] += 1
        shared = is_channel(name) or (times and name == names[0])
        again = counts[name] > 1 and not shared
        found.append(f"{name} ({counts[name]})" if name and again else name or f"column {place}")
    return tuple(found)


def stated_units(names: Sequence[str], row: Sequence[str]) -> dict[int, str]:
    """Return units that a row of units states, or names in brackets, by place: ours alone."""
    said = {place: bare_unit(cell) for place, cell in enumerate(row) if is_unit(bare_unit(cell))}
    return {place: unit for place, name in enumerate(names) if (unit := unit_within(name))} | said
