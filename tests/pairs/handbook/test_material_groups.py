"""A material that no source says values of begins from its group, by any of its names."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.agent.learn.starting import of_material
from autodb.cutting import shear
from autodb.cutting.shear import Edge
from autodb.errors import UnusableInput
from autodb.pairs.handbook.conventional import (
    alike_named,
    material_named,
    materials,
    posterior_of_material,
)
from autodb.pairs.handbook.material_groups import (
    GroupedNames,
    MaterialGroups,
    bare_name,
    grouped_names,
    material_groups,
    material_of_group,
)

CHIPS_MM = np.array([0.1, 0.2, 0.4])
GROUPS = material_groups()


def _specific(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return specific forces at CHIPS_MM, N/mm², and their relative sd by the law's coordinates."""
    law, one = posterior_of_material(name).law, np.ones(1)
    edge = Edge(CHIPS_MM, 150.0 * one, 0.0 * one, 0.0 * one)
    force = shear.per_width(law.mean, edge)[0]
    slope = shear.gradient(lambda t: shear.per_width(t, edge)[0], law.mean, axes=1)
    sd = np.sqrt(np.einsum("pn,pq,qn->n", slope, law.covariance, slope))
    return force / CHIPS_MM, sd / force


@pytest.mark.parametrize("group", GROUPS.group, ids=lambda group: str(group.number))
def test_a_group_s_forces_are_those_that_are_stated_and_fall_with_the_chip(group) -> None:  # type: ignore[no-untyped-def]
    """The law of the edge bends Kienzle's power by up to a tenth over chips of 0.1 to 0.4 mm."""
    found, sd = _specific(f"VDI {group.number}")
    assert_allclose(found, group.k_c11 * CHIPS_MM**-group.m_c, rtol=0.1)
    assert np.all(np.diff(found) < 0.0)
    assert np.all((sd > 0.1) & (sd < 0.3))


@pytest.mark.parametrize(
    ("names", "groups"),
    [
        (("1.4301", "AISI 304", "SUS304", "UNS S30400", "X5CrNi18-10"), (14,)),
        (("GG25", "EN-GJL-250", "JIS FC250", "HT 250"), (16,)),
        (("16MnCr5", "W.-Nr. 1.7131"), (6, 7, 8, 9)),
        (("EN AW-6082", "AlSi1MgMn", "6082"), (21, 22)),
        (("CuZn39Pb3", "CW614N"), (26,)),
        (("Inconel 718", "UNS N07718"), (33, 34)),
    ],
)
def test_names_of_one_material_are_of_the_same_groups(
    names: tuple[str, ...], groups: tuple[int, ...]
) -> None:
    values = [g for g in GROUPS.group if g.number in groups]
    for name in names:
        found = material_named(name)
        assert found.name == f"{name} (VDI 3323 group {', '.join(map(str, groups))})"
        assert found.kienzle is not None
        k_c11 = found.kienzle.k_c11
        assert_allclose(k_c11.value, np.median([g.k_c11 for g in values]))
        assert_allclose(k_c11.lower, 0.6 * min(g.k_c11 for g in values))
        assert_allclose(k_c11.upper, 1.4 * max(g.k_c11 for g in values))


def test_a_material_with_values_of_its_own_keeps_them_under_all_its_names() -> None:
    for names in (("C45", "AISI 1045", "SAE 1045", "S45C", "Ck45"), ("42CrMo4", "4140", "SCM 440"),
                  ("S235", "S235JR", "St 37-2"), ("Ti6Al4V", "TiAl6V4", "R56400")):  # fmt: skip
        assert {material_named(name).name for name in names} == {names[0]}
    own = {bare_name(name) for material in materials() for name in material.names}
    assert not own & {bare_name(name) for name in grouped_names()}


def test_values_of_a_group_hold_those_of_materials_in_it() -> None:
    """Four materials as other sources have them, over chips of 0.1 to 0.4 mm.

    A fifth, 42CrMo4, of a chuck maker's table, is up to 5 % above.
    """
    for name, groups in (
        ("C45", (2, 3)), ("AISI 4340", (6, 7, 8, 9)), ("S235", (1,)), ("Al 7075", (21, 22)),
    ):  # fmt: skip
        wide = [_specific(f"VDI {number}") for number in groups]
        least = np.min([force * (1.0 - 1.96 * sd) for force, sd in wide], axis=0)
        greatest = np.max([force * (1.0 + 1.96 * sd) for force, sd in wide], axis=0)
        own = _specific(name)[0]
        assert np.all((own > least) & (own < greatest))


def test_many_names_are_known_and_all_of_a_letter() -> None:
    assert len(grouped_names()) > 250
    assert len({one.iso for one in GROUPS.group}) == 5
    steel = material_of_group("ISO P")
    assert steel is not None
    assert steel.kienzle is not None
    assert (steel.kienzle.k_c11.lower, steel.kienzle.k_c11.upper) == (0.6 * 1350, 1.4 * 2500)
    assert material_of_group("steel bar") is None
    with pytest.raises(UnusableInput, match=r"'1\.430l' \(did you mean 1\.43"):
        material_named("1.430l")


DESIGNATIONS = {
    "P": "C35E C10 CK60 1.0536 S355J2+N E295 St44-2 25CrMo4 30CrNiMo8 60Si2Mn 1.6580 1.8509 "
    "AISI_1018 SAE8620H 12L14 G86200 S20C SCM420 SNCM220 SUJ2 SKD61 SS400 Q345B 45# X40CrMoV5-1 "
    "X210Cr12 1.2343 X20Cr13 1.4122 S41000 10SPb20 steel Vergütungsstahl EN8 P20",
    "M": "X2CrNi18-9 X5CrNi1810 1.4307 SUS316L S31803 1.4410 Edelstahl",
    "K": "EN-GJL-300 GG-35 GJS-400-15 0.7050 FCD700 EN-GJMB-350-10 GTS-35 Gusseisen",
    "N": "EN_AW-2007 AlMg4,5Mn AlSi12 G-AlSi10Mg EN_AC-43000 A5052 6082-T6 3.2315 CuSn8 CW453K "
    "C3604 C36000 Ms58 Aluminium",
    "S": "2.4856 N06625 NiCr22Mo9Nb 3.7164 R50400 1.4980 Waspaloy Titan",
}


@pytest.mark.parametrize("letter", DESIGNATIONS)
def test_a_designation_tells_its_group_by_how_it_is_built(letter: str) -> None:
    for one in DESIGNATIONS[letter].split():
        found = material_of_group(one.replace("_", " "))
        assert found is not None, one
        assert found.note is not None
        assert found.note.startswith(f"{letter}:") or letter == "M", one


@pytest.mark.parametrize(
    ("name", "groups"),
    [
        ("C10", "1"), ("C60R", "4, 5"), ("1.1181", "1, 2, 3"), ("1.7218", "6, 7, 8, 9"),
        ("X100CrMoV5", "10, 11"), ("X5CrNiCuNb16-4", "13"), ("GJL-150", "15, 16"), ("GGG-70", "18"),
        ("080M40", "2, 3"), ("070M55", "4, 5"), ("250A53", "6, 7, 8, 9"), ("316S16", "14"),
        ("416S21", "12, 13"), ("EN31", "6, 7, 8, 9"), ("EN24T", "6, 7, 8, 9"), ("EN58J", "14"),
        ("Hardox 500", "9, 11"), ("AlSi17Cu4Mg", "25"), ("EN AW-5083", "21, 22"), ("A3003", "21"),
        ("C3604", "26, 27, 28"),
    ],
)  # fmt: skip
def test_a_designation_s_groups(name: str, groups: str) -> None:
    assert material_named(name).name == f"{name} (VDI 3323 group {groups})"


@pytest.mark.parametrize(
    "name",
    ["42CrM04", "60 HRC", "hardened steel", "POM", "1.430", "C1", "X", "12 mm", "D10", "insert"],
)
def test_a_name_that_says_no_composition_is_of_no_group(name: str) -> None:
    assert material_of_group(name) is None


def test_a_condition_makes_no_other_material() -> None:
    for name, own in (("42CrMo4+QT", "42CrMo4"), ("42CrMo4V", "42CrMo4"), ("S235JR+N", "S235"),
                      ("7075-T651", "Al 7075"), ("Al 7075-T6", "Al 7075")):  # fmt: skip
        assert material_named(name).name == own


def test_a_name_stands_once_and_in_a_known_group() -> None:
    twice = GroupedNames(groups=(14,), source="minch", names=("AISI 304",))
    other = GroupedNames(groups=(99,), source="minch", names=("new",))
    for wrong in (twice, other):
        kept = GROUPS.model_dump() | {"named": (*GROUPS.named, wrong)}
        with pytest.raises(ValueError, match=r"named twice|unknown source or group"):
            MaterialGroups.model_validate(kept)


def test_a_name_that_is_nearly_known_is_asked_about() -> None:
    """Where none is alike, nothing is asked: a stranger's name is no slip."""
    assert "Ti6Al4V" in [one.replace("-", "").replace(" ", "") for one in alike_named("Ti6Al4")]
    assert alike_named("unobtainium") == []
    said = of_material("42CrM04").said or ""
    assert said.startswith("what any metal may have: no conventional values of '42CrM04'")
    assert "did you mean 42CrMo4" in said
