"""A time base: columns of one length that are read together, in blocks."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput

Numbers = NDArray[np.float64]
Labels = NDArray[np.str_]
Columns = dict[str, Numbers | Labels]
Blocks = Callable[[Sequence[str], Sequence[str]], Iterator[Columns]]

BLOCK_ROWS = 1 << 17
"""Rows of a block: 1 MiB a column of float64."""


@dataclass(frozen=True)
class ColumnSet:
    """One set of columns of equal length; ``name`` is empty where the file has no other.

    ``blocks(numbers, labels)`` reads the columns ``numbers`` as float64 (missing: NaN) and
    ``labels`` as text, block by block, rows in the order of the file. ``units``: what the file
    itself states, by column.
    """

    name: str
    columns: tuple[str, ...]
    blocks: Blocks
    units: dict[str, str] = field(default_factory=dict)

    def read(self, numbers: Sequence[str], labels: Sequence[str] = ()) -> Columns:
        """Read whole columns: float64, and text of those in ``labels``."""
        parts = list(self.blocks(numbers, labels))
        if len(parts) == 1:
            return parts[0]
        names = [*numbers, *labels]
        return {n: np.concatenate([p[n] for p in parts]) for n in names} if parts else {}


def refuse_twice(path: Path, names: Iterable[str], where: str) -> None:
    """Raise UnusableInput where a column's name stands twice."""
    twice = [name for name, times in Counter(names).items() if times > 1]
    if twice:
        raise UnusableInput(
            f"{path}: column '{min(twice)}' stands in the {where} twice; its own "
            "name for each column would work"
        )


def as_number(where: str, column: str, values: NDArray[np.generic], first_row: int = 0) -> Numbers:
    """Return ``values`` as float64; times and durations in seconds, text where all of it can.

    Raises UnusableInput naming the first row that is no number.
    """
    if values.dtype.kind in "fiub":
        with np.errstate(over="ignore"):  # beyond float64: no finite number
            return values.astype(np.float64, copy=False)
    if values.dtype.kind in "mM":
        return _seconds(values)
    numbers = np.empty(len(values))
    for i, value in enumerate(values.tolist()):
        try:
            numbers[i] = float(value) if value not in ("", None) else np.nan
        except (ValueError, TypeError):
            raise UnusableInput(not_a_number(where, column, first_row + i + 1, value)) from None
    return numbers


def _seconds(values: NDArray[np.generic]) -> Numbers:
    """Return times since 1970, or durations, in s; NaN where there is none."""
    nanoseconds = values.astype(f"{values.dtype.kind}8[ns]")
    return np.where(np.isnat(nanoseconds), np.nan, nanoseconds.astype(np.int64) / 1e9)


def as_label(values: NDArray[np.generic]) -> Labels:
    """Return ``values`` as text; whole numbers without a decimal point."""
    if values.dtype.kind in "fiub":
        return np.array([f"{v:.15g}" if v == v else "" for v in values.tolist()], dtype=np.str_)  # noqa: PLR0124 - NaN
    return np.array(["" if v is None else str(v) for v in values.tolist()], dtype=np.str_)


def not_a_number(where: str, column: str, row: int, value: object) -> str:
    """Return the line that says which cell is no number, with what would work."""
    shown = str(value)[:40]
    works = "points in numbers" if _has_decimal_comma(shown) else "a number or an empty cell"
    return f"{where}: column '{column}', row {row}: '{shown}' is not a number; {works} would work"


def _has_decimal_comma(text: str) -> bool:
    try:
        float(text.replace(",", ".", 1))
    except ValueError:
        return False
    return "," in text
