"""What handbooks and papers say of a work material, and the posterior of its pairs from it.

Specific forces become a `CardForces`, a reading of an orthogonal edge; their bounds say how far the
material at hand may be off all of them alike. The five numbers of the law are its own coordinates:

    r at h_0: ln r = ln r_0 + a_0 ln h_0      a = a_0      τ, β, K_te, K_re as they are
    growth with rake α: of β  ln(β(15°)/β(0°)) / 15°, of r at h_0 the same

exact at rakes of 0 and 15°; the lines' values are taken as independent, each with its bounds. What
a source does not say - speed, rake where there are no lines, scatter - is any metal's.
"""

from difflib import get_close_matches
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.assets import kit
from autodb.cutting import shear
from autodb.cutting.kienzle import ViewRange
from autodb.cutting.shear import THICKNESS_MM, Values
from autodb.errors import UnusableInput, near_words
from autodb.files.toml import read_toml
from autodb.fitting.gaussian import NORMAL_95, Gaussian
from autodb.pairs.card import SHAPE, Bounded, KienzleCard, level_of_bounds
from autodb.pairs.handbook.material_groups import (
    bare_name,
    grouped_names,
    material_of_group,
    spellings,
)
from autodb.pairs.handbook.stated import ForceTable, Kienzle, LinearEdge, Shear, StatedMaterial
from autodb.pairs.posterior import USUAL_SCATTER, PairPosterior
from autodb.pairs.prior import CardForces, any_metal, of_card
from autodb.wording import phrase

Array = NDArray[np.float64]

ALIKE = 0.75
"""How alike names have to be for one to be asked about. Chosen: a letter or two off."""
RAKE_DEG = 15.0
"""Lines in rake are kept at 0 and here. Chosen: the range of inserts and mills for titanium."""
PLACES = (
    shear.TAU, shear.BETA, shear.RATIO, shear.RATIO_H, shear.EDGE_T, shear.EDGE_R,
    shear.BETA_RAKE, shear.RATIO_RAKE,
)  # fmt: skip
"""Coordinates of the law that its five numbers along lines say."""


def materials(folder: Path | None = None) -> tuple[StatedMaterial, ...]:
    """Return the materials of a folder's files, or of those that ship.

    Raises UnusableInput naming file and key, and where two files have one name.
    """
    place = kit("calibration") / "conventional" if folder is None else folder
    known: dict[str, Path] = {}
    found = []
    for path in sorted(place.glob("*.toml")):
        material = read_toml(path, StatedMaterial)
        for name in material.names:
            other = known.setdefault(bare_name(name), path)
            if other != path:
                raise UnusableInput(
                    phrase(
                        "{file}: name: '{name}' is in {other} already; write one file per material",
                        file=path,
                        name=name,
                        other=other.name,
                    )
                )
        found.append(material)
    return tuple(found)


def material_named(name: str, folder: Path | None = None) -> StatedMaterial:
    """Return the material that has a name, written in any case, with or without blanks.

    Of those that ship one without values of its own has its group's (``material_groups``).

    Raises UnusableInput naming those there are.
    """
    there = materials(folder)
    for spelt in spellings(name):
        for material in there:
            if spelt in map(bare_name, material.names):
                return material
    grouped = material_of_group(name) if folder is None else None
    if grouped is not None:
        return grouped
    names = [material.name for material in there]
    names += [one for material in there for one in material.names[1:]]
    if folder is None:
        names += grouped_names()
    raise UnusableInput(
        phrase("no conventional values of '{name}'{hint}", name=name, hint=near_words(name, names))
    )


def alike_named(name: str) -> list[str]:
    """Return the names that ship most like one."""
    names = [*(one for material in materials() for one in material.names), *grouped_names()]
    by_bare = {bare_name(one): one for one in names}
    close = get_close_matches(bare_name(name), by_bare, n=3, cutoff=ALIKE)
    return [by_bare[one] for one in close]


def posterior_of_material(name: str, folder: Path | None = None) -> PairPosterior:
    """Return the posterior about pairs of a material; it counts as no cut."""
    return posterior_of_values(material_named(name, folder))


def posterior_of_values(material: StatedMaterial) -> PairPosterior:
    """Return the posterior that a material's values leave.

    Kienzle's numbers beside lines are readings of the law that these say.
    """
    if material.shear is None:
        return of_card(card_of_material(material))
    lines = along_lines(material.shear)
    if material.kienzle is None:
        return lines
    return of_card(kienzle_of(material.name, material.kienzle).card, start=lines)


def card_of_material(material: StatedMaterial) -> CardForces:
    """Return a material's specific forces as a card.

    Raises UnusableInput where its values are the law's own numbers.
    """
    if material.linear_edge is not None:
        return _linear(material.linear_edge)
    if material.table is not None:
        return _tabled(material.table)
    if material.shear is None and material.kienzle is not None:
        return kienzle_of(material.name, material.kienzle).card
    raise UnusableInput(
        phrase(
            "'{material}' states the parameters of the law and no specific forces; use a "
            "card of its posterior",
            material=material.name,
        )
    )


def _tabled(table: ForceTable) -> CardForces:
    """Return a table's forces at chips h = f sin κ."""
    chips = np.array(table.feed_mm) * np.sin(np.radians(table.entering_deg))
    forces = table.specific_force
    return CardForces(
        thickness_mm=chips,
        tangential=np.array(forces.value) * chips,
        thrust=None,
        level=level_of_bounds(np.array(forces.lower), np.array(forces.upper)),
        shape=SHAPE,
        rake_rad=float(np.radians(table.rake_deg)),
    )


def kienzle_of(name: str, stated: Kienzle) -> KienzleCard:
    """Return Kienzle's numbers as a card, over chips that a planner asks for."""
    k_c11, m_c = stated.k_c11, stated.m_c
    return KienzleCard(
        material=name,
        k_c11=Bounded(k_c11.value, k_c11.lower, k_c11.upper),
        m_c=m_c.value,
        m_c_bounds=(m_c.lower, m_c.upper),
        at=ViewRange(rake_rad=float(np.radians(stated.rake_deg))),
        source=f"{k_c11.source}; {k_c11.citation}",
    )


def fitted_kienzle(table: ForceTable) -> tuple[float, float]:
    """Return k_c1.1 [N/mm²] and m_c of a table: a line through its rows in logarithms."""
    card = _tabled(table)
    logs = np.log(card.thickness_mm)
    slope, height = np.polyfit(logs, np.log(table.specific_force.value), 1)
    return float(np.exp(height)), float(-slope)


def _linear(edge: LinearEdge) -> CardForces:
    """Return a linear edge's forces over chips that a planner asks for.

    Its coefficients' bounds are taken as reached together: what makes one mill's chip dearer makes
    its edge so.
    """
    chips = ViewRange().edge.thickness_mm
    bounds = ("value", "lower", "upper")
    along = {end: getattr(edge.K_tc, end) * chips + getattr(edge.K_te, end) for end in bounds}
    across = {end: getattr(edge.K_rc, end) * chips + getattr(edge.K_re, end) for end in bounds}
    return CardForces(
        thickness_mm=chips,
        tangential=along["value"],
        thrust=across["value"],
        level=level_of_bounds(along["lower"], along["upper"]),
        shape=SHAPE,
        rake_rad=float(np.radians(edge.rake_deg)),
        thrust_level=level_of_bounds(across["lower"], across["upper"]),
    )


def along_lines(stated: Shear) -> PairPosterior:
    """Return the posterior that the law's own numbers leave."""
    start, places = any_metal(), np.array(PLACES)
    value = np.array([one.value for one in stated.read])
    sd = np.array([one.upper - one.lower for one in stated.read]) / (2.0 * NORMAL_95)
    slope = shear.gradient(_coordinates, value, axes=0)
    mean, covariance = start.law.mean.copy(), start.law.covariance.copy()
    mean[places] = np.real(_coordinates(value))
    covariance[places] = covariance[:, places] = 0.0
    covariance[np.ix_(places, places)] = slope.T @ np.diag(sd**2) @ slope
    return PairPosterior(Gaussian(mean, covariance), (), USUAL_SCATTER, 0)


def _coordinates(read: Values) -> Values:
    """Return the coordinates at PLACES (…, k) of what was read (9, …)."""
    stress, friction, friction_slope, ratio, ratio_slope, power, power_slope, edge_t, edge_r = read
    far, log_h = np.radians(RAKE_DEG), np.log(THICKNESS_MM)
    degree = np.radians(1.0)
    flat = np.log(np.tan(degree * friction))
    of_friction = np.log(np.tan(degree * (friction + RAKE_DEG * friction_slope))) - flat
    of_ratio = np.log1p(RAKE_DEG * ratio_slope / ratio) + RAKE_DEG * power_slope * log_h
    return np.stack(
        [
            np.log(stress),
            flat,
            np.log(ratio) + power * log_h,
            power,
            np.log(edge_t),
            np.log(edge_r),
            of_friction / far,
            of_ratio / far,
        ],
        axis=-1,
    )
