"""Numbers of a form: how who typed them wrote them, and what they are in our units.

A form says itself how its numbers are written, by its field ``typed``: language and system of
units. So an address that is sent to somebody else, or opened after another choice, means the same.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from autodb.files.cut_words import FIELDS
from autodb.files.job_cut import JobCut
from autodb.files.units import SI, SYSTEMS, shop_units, shown_system, typed_number
from autodb.web.routes.asked import as_cut
from autodb.wording import localized, presentation, shop_amount
from autodb.wording.amounts import decimal_mark
from autodb.wording.catalogues import LANGUAGES

FIELD = "typed"
DIGITS = 12
"""Digits that are kept of a number which was typed in another unit. Chosen: none is seen to be off;
all of them would make 2.5400000000000005 mm of 0.1 in."""
_UNITS = {one.key: one.unit for one in FIELDS}


@dataclass(frozen=True)
class Typed:
    """How numbers of a form are written: the language, whose decimal mark they have, and units."""

    language: str = "en"
    system: str = SI

    def __str__(self) -> str:
        """Return it as the form's field has it."""
        return f"{self.language}.{self.system}"

    def number(self, name: str, text: str, unit: str = "1") -> float:
        """Return what was typed of a number, in our unit; raises UnusableInput."""
        value = typed_number(name, text, mark=decimal_mark(self.language))
        own = shop_units(self.system).get(unit)
        return value if own is None else float(f"{value / own.factor:.{DIGITS}g}")

    def length(self, name: str, text: str) -> float:
        """Return what was typed of a length, mm; raises UnusableInput."""
        return self.number(name, text, "mm")

    def cut(self, row: Mapping[str, str]) -> JobCut:
        """Return the cut that a row of a form states; raises UnusableInput naming the key."""
        return as_cut(row, lambda key, text: self.number(key, text, _UNITS.get(key, "1")))


def typed_now() -> Typed:
    """Return how the page's reader writes numbers."""
    return Typed(presentation().language, shown_system())


def typed_as(stated: str) -> Typed:
    """Return how a form says that its numbers are written; by default as programs write them."""
    language, _, system = stated.partition(".")
    known = language in LANGUAGES and system in SYSTEMS
    return Typed(language, system) if known else Typed()


def as_typed(value: float, unit: str) -> str:
    """Return a number in one of our units as a form shows it to the page's reader."""
    return localized(f"{shop_amount(value, unit)[0]:g}").replace("\u202f", "")


def written_cut(cut: JobCut) -> dict[str, str]:
    """Return what a form shows of a cut: texts by key."""
    return {
        key: as_typed(value, _UNITS.get(key, "1")) if isinstance(value, float) else str(value)
        for key, value in cut.model_dump(exclude_none=True).items()
    }
