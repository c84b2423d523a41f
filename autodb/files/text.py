"""How a text table is written, where a side file states it: what is not stated is detected."""

from typing import Literal

from pydantic import Field, NonNegativeInt, PositiveInt

from autodb.files.toml import Section


class TextSection(Section):
    """Part `[csv]` of a side file.

    Lines are counted from 1 in the file. ``header_line`` 0: no line names the columns, they are
    called by their place or by ``names``. ``comment``: lines that begin so are no rows.
    ``short_rows``: cells at the end of a row may be left out. ``times``: the columns of time, each
    of the columns behind it; none: all columns are of one. ``sheet``: of a workbook.
    """

    separator: str | None = Field(default=None, pattern=r"^(.|tab|space)$")
    decimal: Literal[".", ","] | None = None
    thousands: str | None = Field(default=None, min_length=1, max_length=1)
    encoding: str | None = None
    header_line: NonNegativeInt | None = None
    units_line: PositiveInt | None = None
    first_line: PositiveInt | None = None
    names: tuple[str, ...] | None = None
    comment: str | None = Field(default=None, min_length=1)
    short_rows: bool | None = None
    times: tuple[str, ...] | None = None
    sheet: str | None = None
