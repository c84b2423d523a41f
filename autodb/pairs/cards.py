"""Tables of material cards, as CAM systems keep them: CSV, one row a material, read and written.

Columns: docs/formats.md, "Material cards". Numbers are written with six digits.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np

from autodb.cutting.kienzle import ViewRange
from autodb.errors import UnusableInput, near_words, no_such_file
from autodb.files import csvtext
from autodb.files.units import RAW, conversion
from autodb.pairs.card import STEEPEST, UNIT, Bounded, KienzleCard
from autodb.readers import Columns, open_bases
from autodb.wording import phrase

STEEPEST_RAKE_DEG = 60.0
"""Beyond any insert or mill. Chosen."""
USUAL = (100.0, 10_000.0)
"""What k_c1.1 of metals may be, N/mm². Chosen: magnesium and hardened steel are well within it."""
BOUND_SHARE = 0.25
"""Share by which k_c1.1 is taken to be off where a card states no bounds. Chosen: tables of other
makers differ by so much."""
MARK = "k_c1.1"
"""The column that a file is recognised by."""
LABELS = ("material", "k_c1.1_unit", "source")
NEEDED = ("k_c1.1", "m_c", "rake_deg")
OPTIONAL = ("lower", "upper", "m_c_lower", "m_c_upper", "speed_m_min", "thinnest_mm", "thickest_mm")
HOLDS = ("rake_deg", "speed_m_min", "thinnest_mm", "thickest_mm", "source")
COLUMNS = (
    "material", "k_c1.1", "k_c1.1_unit", "lower", "upper", "m_c", "m_c_lower", "m_c_upper", *HOLDS,
)  # fmt: skip


def cards_as_csv(cards: Sequence[KienzleCard]) -> str:
    """Return cards as a table: k_c1.1 in N/mm²."""
    return csvtext.rows_as_csv([COLUMNS, *map(_kienzle_row, cards)])


def _kienzle_row(card: KienzleCard) -> list[str]:
    k, bounds = card.k_c11, card.m_c_bounds
    m_c = ("", "") if bounds is None else (_number(bounds[0]), _number(bounds[1]))
    size = (_number(k.value), UNIT, _number(k.lower), _number(k.upper))
    return [card.material, *size, _number(card.m_c), *m_c, *_holds(card.at), card.source]


def _holds(at: ViewRange) -> list[str]:
    rake_deg = float(np.degrees(at.rake_rad))
    return [_number(v) for v in (rake_deg, at.speed_m_min, at.thinnest_mm, at.thickest_mm)]


def _number(value: float) -> str:
    return f"{value:.6g}"


def is_card(path: Path) -> bool:
    """Say whether a file is a table of Kienzle cards, by its header; one that is not there is none.

    Raises UnusableInput where a CSV file has no header that can be read.
    """
    return path.suffix == ".csv" and path.is_file() and MARK in open_bases(path)[0].columns


def read_cards(path: Path) -> tuple[KienzleCard, ...]:
    """Read a table of Kienzle cards.

    Raises UnusableInput naming file, column and row where a column is missing or unknown, a cell
    is empty or no number, k_c1.1 is not positive or outside its bounds, m_c is outside 0 to 0.9 or
    its bounds, or a material stands there twice.
    """
    if not path.is_file():
        raise no_such_file(path)
    base = open_bases(path)[0]
    _check_header(path, base.columns)
    stated = [name for name in OPTIONAL if name in base.columns]
    table = base.read((*NEEDED, *stated), LABELS)
    rows = [_Row(path, table, row) for row in range(len(table["material"]))]
    first: dict[str, int] = {}
    for row in rows:
        before = first.setdefault(row.text("material"), row.row)
        if before != row.row:
            row.refuse(
                "material", f"stands in row {before + 1} already", "write one row per material"
            )
    return tuple(_card_of(row) for row in rows)


def _check_header(path: Path, columns: tuple[str, ...]) -> None:
    for name in columns:
        if name not in COLUMNS:
            raise UnusableInput(
                phrase(
                    "{file}: unknown column '{name}'{hint}",
                    file=path,
                    name=name,
                    hint=near_words(name, COLUMNS),
                )
            )
    for name in (*LABELS, *NEEDED):
        if name not in columns:
            needed = ", ".join(n for n in COLUMNS if n in LABELS or n in NEEDED)
            raise UnusableInput(
                phrase(
                    "{file}: column '{name}' is missing; write {needed}",
                    file=path,
                    name=name,
                    needed=needed,
                )
            )


@dataclass(frozen=True)
class _Row:
    """A row of a table, counted from 0."""

    path: Path
    table: Columns
    row: int

    def refuse(self, name: str, what: str, works: str) -> NoReturn:
        """Raise the line that names the cell."""
        where = f"{self.path}: column '{name}', row {self.row + 1}"
        raise UnusableInput(f"{where}: {what}; {works}")

    def text(self, name: str) -> str:
        """Return a cell's text; raises UnusableInput where there is none."""
        cell = str(self.table[name][self.row]).strip(" ")
        return cell or self.refuse(name, "is empty", "write a text")

    def states(self, name: str) -> bool:
        """Say whether an optional cell is there and not empty."""
        return name in self.table and not np.isnan(float(self.table[name][self.row]))

    def between(self, name: str, low: float, high: float) -> float:
        """Return a number in [low, high]; raises UnusableInput where there is none."""
        works = f"use {low:g} to {high:g}"
        if not self.states(name):
            self.refuse(name, "is empty", works)
        value = float(self.table[name][self.row])
        return value if low <= value <= high else self.refuse(name, f"is {value:g}", works)

    def positive(self, name: str) -> float:
        """Return a finite number above 0; raises UnusableInput where there is none."""
        works = "use a number above 0"
        if not self.states(name):
            self.refuse(name, "is empty", works)
        value = float(self.table[name][self.row])
        return value if 0.0 < value < np.inf else self.refuse(name, f"is {value:g}", works)

    def otherwise(self, name: str, default: float) -> float:
        """Return a number above 0, or what a card that does not state it is taken for."""
        return self.positive(name) if self.states(name) else default


def _card_of(row: _Row) -> KienzleCard:
    bounded = row.states("lower") or row.states("upper")
    value = row.positive("k_c1.1")
    off = BOUND_SHARE * value
    low, high = (
        (row.positive(n) for n in ("lower", "upper")) if bounded else (value - off, value + off)
    )
    k_c11 = Bounded(value, low, high)
    for name, holds in (("lower", k_c11.lower < k_c11.value), ("upper", k_c11.value < k_c11.upper)):
        if not holds:
            row.refuse(name, "is on the wrong side of k_c1.1", "use lower < k_c1.1 < upper")
    scale = _scale(row)
    if not USUAL[0] <= scale * k_c11.value <= USUAL[1]:
        row.refuse(
            "k_c1.1",
            f"is {scale * k_c11.value:g} {UNIT}, and metals have {USUAL[0]:g} to {USUAL[1]:g}",
            "use another k_c1.1_unit, such as kN/mm²" if scale == 1.0 else f"use {UNIT}",
        )
    m_c = row.between("m_c", 0.0, STEEPEST)
    return KienzleCard(
        material=row.text("material"),
        k_c11=Bounded(scale * k_c11.value, scale * k_c11.lower, scale * k_c11.upper),
        m_c=m_c,
        m_c_bounds=_m_c_bounds(row, m_c),
        at=_planned(row),
        source=row.text("source") + ("" if bounded else "; no bounds stated: taken as ± 25 %"),
    )


def _scale(row: _Row) -> float:
    """Return how many N/mm² the unit of k_c1.1 is."""
    unit = row.text("k_c1.1_unit")
    if unit == RAW:
        row.refuse("k_c1.1_unit", "is 'raw'", f"use {UNIT}")
    where = f"{row.path}: column 'k_c1.1_unit', row {row.row + 1}"
    return conversion(unit, to=UNIT, where=where)[0]


def _m_c_bounds(row: _Row, m_c: float) -> tuple[float, float] | None:
    """Return the bounds of m_c, which a card states both or neither; they may leave 0 to 0.9."""
    if not (row.states("m_c_lower") or row.states("m_c_upper")):
        return None
    low, high = (row.between(name, -1.0, 2.0) for name in ("m_c_lower", "m_c_upper"))
    for name, holds in (("m_c_lower", low < m_c), ("m_c_upper", m_c < high)):
        if not holds:
            row.refuse(name, "is on the wrong side of m_c", "use m_c_lower < m_c < m_c_upper")
    return low, high


def _planned(row: _Row) -> ViewRange:
    """Return where a card holds; what it does not state is `ViewRange`'s."""
    usual = ViewRange()
    thinnest = row.otherwise("thinnest_mm", usual.thinnest_mm)
    thickest = row.otherwise("thickest_mm", usual.thickest_mm)
    if not thinnest < thickest:
        name = "thickest_mm" if row.states("thickest_mm") else "thinnest_mm"
        row.refuse(
            name, f"leaves chips of {thinnest:g} to {thickest:g} mm", "state the thinner first"
        )
    rake_deg = row.between("rake_deg", -STEEPEST_RAKE_DEG, STEEPEST_RAKE_DEG)
    speed = row.otherwise("speed_m_min", usual.speed_m_min)
    return ViewRange(thinnest, thickest, speed, float(np.radians(rake_deg)))
