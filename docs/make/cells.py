"""Figures of proofs and of comparisons, by the cell that holds them: nothing on a page is typed.

A figure is a cell of a table that a proof, or a comparison with other methods, has kept. Its limit
is in parentheses in the head of its column, or what the table has under *must be*; whether it is
met is what the table says.
"""

import re
from dataclasses import dataclass

from autodb.proofs.runs.found import TextTable
from docs.make.kept import kept

MUST_BE = "must be"
VERDICTS = {"passed": "met", "FAILED": "**missed**"}
IN_HEAD = re.compile(r" ?\((.*)\)$")


class NoSuchCell(Exception):  # noqa: N818 - says what happened
    """A page asks for a cell that no table has."""


@dataclass(frozen=True)
class Cell:
    """A cell: the table and the column by how title and head begin, the row by its first cells.

    Where a head stands twice, the column is the first ``after`` another.
    """

    of: str
    table: str
    row: tuple[str, ...]
    column: str
    after: str = ""

    @property
    def text(self) -> str:
        """What stands in the cell; raises NoSuchCell naming the proof, table, row and column."""
        return self._row()[self._index()]

    def beside(self, column: str) -> "Cell":
        """Return the cell in another column of its row."""
        return Cell(self.of, self.table, self.row, column)

    @property
    def limit(self) -> str:
        """What the table asks of it; raises NoSuchCell where it asks nothing."""
        heads = [head.removeprefix(">") for head in self._found().heads]
        own = IN_HEAD.search(heads[self._index()])
        if own is not None:
            return own[1]
        for head, text in zip(heads, self._row(), strict=True):
            if head.startswith(MUST_BE):
                return f"{head.removeprefix(MUST_BE).strip()} {text}".strip()
        raise NoSuchCell(f"{self._place()}: no limit")

    @property
    def verdict(self) -> str:
        """Whether its limit is met: the next verdict in its row; raises NoSuchCell without one."""
        for text in self._row()[self._index() :]:
            if text in VERDICTS:
                return VERDICTS[text]
        raise NoSuchCell(f"{self._place()}: no verdict")

    def _found(self) -> TextTable:
        for table in kept(self.of).tables:
            if table.title.startswith(self.table):
                return table
        raise NoSuchCell(f"{self._place()}: no such table")

    def _row(self) -> tuple[str, ...]:
        for row in self._found().rows:
            if row[: len(self.row)] == self.row:
                return row
        raise NoSuchCell(f"{self._place()}: no such row")

    def _index(self) -> int:
        heads = [head.removeprefix(">") for head in self._found().heads]
        begin = 0
        while self.after and begin < len(heads) and not heads[begin].startswith(self.after):
            begin += 1
        for at in range(begin, len(heads)):
            if heads[at].startswith(self.column):
                return at
        raise NoSuchCell(f"{self._place()}: no such column")

    def _place(self) -> str:
        return f"{self.of}, '{self.table}', {', '.join(self.row)}, '{self.column}'"
