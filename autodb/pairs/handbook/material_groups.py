"""What group a work material is of, and what a tool maker says of the group.

Groups after VDI 3323, with the letters of ISO 513; materials by their names in the systems of
several countries. Where no source says values of a material itself its pairs begin from its group:
Kienzle's numbers over the groups of all conditions that it comes in, from below the least to above
the greatest of them.
"""

from functools import cache
from statistics import median
from typing import Literal, TypeVar

from pydantic import Field, model_validator

from autodb.assets import kit
from autodb.files.toml import Positive, Section, read_toml
from autodb.pairs.handbook.stated import Kienzle, Size, StatedMaterial, StatedValue

BEYOND = 0.4
"""Share by which k_c1.1 may be below the least, or above the greatest, of a material's groups.
Chosen: of five materials that other sources have values of four lie within, one 5 % above."""
POWER = 0.05
"""The same of m_c, as a difference. Chosen."""
PREFIXES = ("aisi", "sae", "uns", "din", "jis", "w.nr.", "wnr.", "astm", "en", "aw")
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
    bare = plain_name(name)
    for prefix in PREFIXES:
        bare = bare.removeprefix(prefix)
    return bare


def grouped_names() -> list[str]:
    """Return all names that are known to be of a group."""
    return [name for one in material_groups().named for name in one.names]


def material_of_group(name: str) -> StatedMaterial | None:
    """Return what the groups say of a material by its name, or of a group itself; else None.

    A group is `VDI 6`, all of a letter `ISO P`.
    """
    known, bare = material_groups(), bare_name(name)
    for one in known.named:
        if bare in map(bare_name, one.names):
            of = [group for group in known.group if group.number in one.groups]
            return _stated(name, of, f"; of the group: {known.sources[one.source]}")
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
