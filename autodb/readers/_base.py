"""A time base: columns of one length that are read together, in blocks.

Arrow tables become NumPy columns.

Damaged files make a library fail in any way: one line each.

Libraries of the extra `formats`, imported when a file needs them.
"""

import logging
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.wording import msgid, phrase, stored_msgid

Numbers = NDArray[np.float64]
Labels = NDArray[np.str_]
Columns = dict[str, Numbers | Labels]
Blocks = Callable[[Sequence[str], Sequence[str]], Iterator[Columns]]

BLOCK_ROWS = 1 << 17
"""Rows of a block: 1 MiB a column of float64."""
SEVERAL_VALUES = stored_msgid(
    "{file}: column '{column}', row {row}: several values in a cell ({text}); give each a column "
    "of its own"
)
USE_POINTS = stored_msgid(
    "{file}: column '{column}', row {row}: '{text}' is not a number; use points in numbers"
)
NOT_A_NUMBER = stored_msgid(
    "{file}: column '{column}', row {row}: '{text}' is not a number; write a number or leave the "
    "cell empty"
)
NOT_WHOLE = stored_msgid("{file}: not a whole {kind} file ({reason}); copy it again")


@dataclass(frozen=True)
class ColumnSet:
    """One set of columns of equal length; ``name`` is empty where the file has no other.

    ``blocks(numbers, labels)`` reads the columns ``numbers`` as float64 (missing: NaN) and
    ``labels`` as text, block by block, rows in the order of the file. ``units``: what the file
    itself states, by column. ``layout``: how the file is written, where that had to be found out.
    """

    name: str
    columns: tuple[str, ...]
    blocks: Blocks
    units: dict[str, str] = field(default_factory=dict)
    layout: str = ""

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
            phrase(
                "{file}: column '{twice}' stands in the {where} twice; give each column its "
                "own name",
                file=path,
                twice=min(twice),
                where=where,
            )
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
    """Return the line that says which cell is no number, with the remedy."""
    shown = str(value)[:40]
    if isinstance(value, list | tuple | dict | np.ndarray):
        sentence = SEVERAL_VALUES
    else:
        sentence = USE_POINTS if _has_decimal_comma(shown) else NOT_A_NUMBER
    return sentence.format(file=where, column=column, row=row, text=shown)


def _has_decimal_comma(text: str) -> bool:
    try:
        float(text.replace(",", ".", 1))
    except ValueError:
        return False
    return "," in text


def numpy_columns(
    where: str, table: Any, numbers: Sequence[str], labels: Sequence[str], first_row: int = 0
) -> Columns:
    """Return ``numbers`` of an Arrow table or batch as float64 (missing: NaN), ``labels`` as text.

    Raises UnusableInput naming the row where a number is none.
    """
    columns: Columns = {}
    for name in numbers:
        column = table.column(name)
        if pa.types.is_floating(column.type) or pa.types.is_integer(column.type):
            values = column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
            columns[name] = np.asarray(values, dtype=np.float64)
        elif pa.types.is_temporal(column.type):
            columns[name] = as_number(where, name, column.to_numpy(zero_copy_only=False), first_row)
        else:
            columns[name] = as_number(where, name, _objects(column), first_row)
    for name in labels:
        columns[name] = as_label(_objects(table.column(name)))
    return columns


def _objects(column: Any) -> Any:
    return np.array([*column.to_pylist(), None], dtype=object)[:-1]


T = TypeVar("T")


def damaged(path: Path, kind: str, reason: str) -> UnusableInput:
    """Return the line for a file that is not whole, or for which there is no memory."""
    if reason == NO_MEMORY:
        return UnusableInput(
            phrase(
                "{file}: this {kind} file {no_memory}; use CSV, Parquet or HDF5 ('-v7.3'), "
                "which are read in blocks",
                file=path,
                kind=kind,
                no_memory=phrase(NO_MEMORY),
            )
        )
    why = reason.rstrip(". ")
    return UnusableInput(NOT_WHOLE.format(file=path, kind=kind, reason=why))


NO_MEMORY = msgid("asks for more memory than there is")


def undamaged(path: Path, kind: str, read: Callable[[], T]) -> T:
    """Return what ``read`` gives; raises UnusableInput whatever went wrong in it."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the library's own doubts about damage
            return read()
    except UnusableInput:
        raise
    except Exception as error:
        raise damaged(path, kind, reason_of(error)) from None


def reason_of(error: BaseException) -> str:
    """Return the first line of what went wrong."""
    if isinstance(error, MemoryError):
        return NO_MEMORY
    return (str(error).splitlines() or [type(error).__name__])[0]


def library(path: Path, name: str) -> Any:
    """Return module ``name``; raises UnusableInput saying how to install it.

    What it would log of a damaged file is left to the one line that we say of it.
    """
    try:
        found = import_module(name)
    except ImportError:
        raise UnusableInput(
            phrase(
                "{file}: reading {suffix} needs {name}; run pip install 'autodb[formats]', or "
                "use CSV or Parquet",
                file=path,
                suffix=path.suffix,
                name=name,
            )
        ) from None
    for logger in logging.root.manager.loggerDict:
        if logger.split(".")[0] == name:
            logging.getLogger(logger).setLevel(logging.CRITICAL + 1)
    return found
