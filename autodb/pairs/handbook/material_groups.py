"""What group a work material is of, and what a tool maker says of the group.

Groups after VDI 3323, with the letters of ISO 513; materials by their names in the systems of
several countries. Where no source says values of a material itself its pairs begin from its group:
Kienzle's numbers over the groups of all conditions that it comes in, from below the least to above
the greatest of them.
"""

import re
from collections.abc import Iterator
from functools import cache
from statistics import median
from typing import Literal, TypeVar

from pydantic import Field, model_validator

from autodb.assets import kit
from autodb.files.toml import Positive, Section, read_toml
from autodb.pairs.handbook.designations import groups_by_designation
from autodb.pairs.handbook.stated import Kienzle, Size, StatedMaterial, StatedValue

BEYOND = 0.4
"""Share by which k_c1.1 may be below the least, or above the greatest, of a material's groups.
Chosen: of five materials that other sources have values of four lie within, one 5 % above."""
POWER = 0.05
"""The same of m_c, as a difference. Chosen."""
PREFIXES = (
    "aisi", "sae", "uns", "din", "jis", "w.nr.", "w.-nr.", "wnr.", "werkstoffnr.", "werkstoff-nr.",
    "astm", "en", "aw",
)  # fmt: skip
"""What may stand before a name, which says the system that it is of."""
READ = "2026-11-27"

Stated = TypeVar("Stated", bound=StatedValue)


class MaterialGroup(Section):
    """A group: its number by VDI 3323, its letter by ISO 513, k_c1.1 [N/mm²] and m_c."""

    number: int
    iso: Literal["P", "M", "K", "N", "S", "H"]
    name: str
    k_c11: Positive
    m_c: Positive


class GroupedNames(Section):
    """Names of materials that are of some groups, and the key of the source that says so."""

    groups: tuple[int, ...] = Field(min_length=1)
    source: str
    names: tuple[str, ...] = Field(min_length=1)


class GroupValues(Section):
    """Where the groups' values are from, and how sure they are."""

    source: str
    citation: str
    status: str


class MaterialGroups(Section):
    """All groups, and the materials that are known to be of them."""

    values: GroupValues
    sources: dict[str, str]
    group: tuple[MaterialGroup, ...]
    named: tuple[GroupedNames, ...]

    @model_validator(mode="after")
    def _known(self) -> "MaterialGroups":
        numbers = {one.number for one in self.group}
        names = [bare_name(name) for one in self.named for name in one.names]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"'{twice[0]}' is named twice")
        for one in self.named:
            if one.source not in self.sources or not numbers.issuperset(one.groups):
                raise ValueError(f"'{one.names[0]}' has an unknown source or group")
        return self


@cache
def material_groups() -> MaterialGroups:
    """Return the groups that ship."""
    return read_toml(
        kit("calibration") / "conventional" / "groups" / "vdi3323.toml", MaterialGroups
    )


def plain_name(name: str) -> str:
    """Return a name without case, blanks and dashes: Ti-6Al-4V is Ti6Al4V."""
    return "".join(c for c in name.casefold() if c not in " -_")


def bare_name(name: str) -> str:
    """Return a material's plain name without what says its system: AISI 304 is 304."""
    return _without_system(plain_name(name))


def _without_system(plain: str) -> str:
    for prefix in PREFIXES:
        british = prefix == "en" and _BRITISH.fullmatch(plain)
        plain = plain if british else plain.removeprefix(prefix).lstrip("-")
    return plain


def spellings(name: str) -> Iterator[str]:
    """Yield the bare names that a name may stand for: as it is, and without condition and country.

    A condition does not make another material here: 42CrMo4+QT, 42CrMo4V, 7075-T651, SUS304.
    """
    dashed = _without_system("".join(c for c in name.casefold() if c not in " _"))
    yield from dict.fromkeys(
        one.replace("-", "")
        for one in (dashed, *(pattern.sub("", dashed) for pattern in _CONDITIONS))
    )


_BRITISH = re.compile(r"en(?:\d{1,2}[a-z]?|35\d)")
"""Names of BS 970, whose EN is no European standard: EN8, EN24, EN353."""
_CONDITIONS = (
    re.compile(r"(?:\+[a-z0-9]+)+$"),
    re.compile(r"(?<=\d)(?:-?t\d{1,4}|-h\d{2,3})$"),
    re.compile(r"(?<=[a-z]\d)v$"),
    re.compile(r"^sus(?=\d)|^(?:aw|al|a|alu)-?(?=\d{4})"),
    re.compile(r"^(?:aw|al|a|alu)-?(?=\d{4})|(?<=\d)(?:-?t\d{1,4}|-h\d{2,3})$"),
    re.compile(r"(?<=^en\d)[a-z]$|(?<=^en\d\d)[a-z]$"),
)
"""Conditions by EN 10027-1, tempers by EN 515, quenched and tempered by DIN 17006; SUS of Japan,
and what says aluminium before four digits; the letter behind a name of BS 970 (EN24T)."""


def grouped_names() -> list[str]:
    """Return all names that are known to be of a group."""
    return [name for one in material_groups().named for name in one.names]


def material_of_group(name: str) -> StatedMaterial | None:
    """Return what the groups say of a material by its name, or of a group itself; else None.

    A group is `VDI 6`, all of a letter `ISO P`.
    """
    known, bare = material_groups(), bare_name(name)
    spelt = list(spellings(name))
    for one in known.named:
        if not set(spelt).isdisjoint(map(bare_name, one.names)):
            of = [group for group in known.group if group.number in one.groups]
            return _stated(name, of, f"; of the group: {known.sources[one.source]}")
    dashed = "".join(c for c in name.casefold() if c not in " _")
    of_series = dashed.removeprefix("en").removeprefix("-")
    for spelling in (_without_system(dashed), of_series, *spelt):
        told = groups_by_designation(spelling)
        if told is not None:
            of = [group for group in known.group if group.number in told.groups]
            return _stated(name, of, f"; of the group: by {told.by}")
    of = [
        group for group in known.group if bare in (f"vdi{group.number}", f"iso{group.iso.lower()}")
    ]
    return _stated(name, of, "") if of else None


def _stated(name: str, groups: list[MaterialGroup], said: str) -> StatedMaterial:
    """Return the values of groups, for a name."""
    values = material_groups().values
    k_c11, m_c = [group.k_c11 for group in groups], [group.m_c for group in groups]
    numbers = ", ".join(str(group.number) for group in groups)

    def bounded(kind: type[Stated], value: float, lower: float, upper: float, unit: str) -> Stated:
        return kind(
            value=value,
            lower=lower,
            upper=upper,
            unit=unit,
            source=values.source + said,
            citation=values.citation,
            status=values.status,
            date=READ,
        )

    least, greatest = (1.0 - BEYOND) * min(k_c11), (1.0 + BEYOND) * max(k_c11)
    return StatedMaterial(
        name=f"{name} (VDI 3323 group {numbers})",
        note="; ".join(dict.fromkeys(f"{group.iso}: {group.name}" for group in groups)),
        kienzle=Kienzle(
            k_c11=bounded(Size, median(k_c11), least, greatest, "N/mm²"),
            m_c=bounded(StatedValue, median(m_c), min(m_c) - POWER, max(m_c) + POWER, "1"),
        ),
    )
