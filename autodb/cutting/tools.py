"""A tool from what is stated of its geometry; what nobody stated is assumed, and how far it is off.

The usual tool stands in for what is not known, with a standard deviation of what shops use. Forces
are worked out with the usual value and with one a standard deviation off; the difference is an
error that all cuts of the tool share (``autodb.pairs``).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, Generic, TypeVar

from autodb.cutting.drill import WEB_SHARE, Drill
from autodb.cutting.endmill import EndMill
from autodb.cutting.insert import Insert
from autodb.errors import UnusableInput
from autodb.fitting.gaussian import NORMAL_95
from autodb.wording import listed, localized, phrase, shop_amount

Tool = TypeVar("Tool", Insert, EndMill, Drill)


@dataclass(frozen=True)
class Usual:
    """What a quantity of a tool's geometry is taken for where it is not stated, and its sd.

    ``error``: what that error is called among those of a posterior, if not by the name: posteriors
    of before a quantity was taken for something else keep one by its name.
    """

    name: str
    value: float
    sd: float
    unit: str
    error: str | None = None

    @property
    def key(self) -> str:
        """What the error is called."""
        return self.error or self.name

    @property
    def words(self) -> str:
        """What it is taken for, with 95 %."""
        value, sd = (shop_amount(one, self.unit)[0] for one in (self.value, NORMAL_95 * self.sd))
        unit = self.unit if self.unit == "°" else f" {shop_amount(1.0, self.unit)[1]}"
        return f"{self.name} {localized(f'{value:g}')} ± {localized(f'{sd:.2g}')}{unit}"


INSERT = (
    Usual("nose_radius_mm", 0.8, 0.4, "mm"),
    Usual("kappa_deg", 77.0, 22.0, "°", error="entering angle of any holder"),
    Usual("rake_deg", -3.0, 6.0, "°"),
    Usual("inclination_deg", -4.0, 4.0, "°", error="inclination, ISO 3002"),
    Usual("included_deg", 75.0, 15.0, "°"),
)
"""Chosen: inserts of 55 to 80°, double-sided or single-sided; the repeated cut of P1 has 0.8 mm.
The entering angle is that of any holder: styles A to Y of ISO 5608, as Sumitomo's catalogue of 2019
lists them on page 175, have 45 to 95°, 77° in the mean with an sd of 17°. Passive force over feed
force goes as cot κ, so that two sds of 22°, in lines, reach what an edge at 45° has."""
FOLLOWS_DEG = 4.0
"""Angle to a path that an edge has at least whose holder nobody stated: a shop takes one that can
follow. Chosen: one of 93 to 95° up a shoulder."""
END_MILL = (
    Usual("helix_deg", 35.0, 6.0, "°"),
    Usual("corner_radius_mm", 0.1, 0.1, "mm"),
    Usual("rake_deg", 8.0, 5.0, "°"),
)
"""Chosen: solid carbide end mills of catalogues have helices of 30 to 45° and rakes of 4 to 14°."""
DRILL = (
    Usual("point_angle_deg", 130.0, 10.0, "°"),
    Usual("helix_deg", 30.0, 4.0, "°"),
    Usual("web_share", WEB_SHARE, 0.04, "of the diameter"),
)
"""Chosen: points of 118° (high-speed steel) to 140° (carbide)."""


INSERTS_KEPT = 256
"""Inserts that are kept once they are made: a shop's, and some of another's. Chosen."""


@dataclass(frozen=True)
class Assumed(Generic[Tool]):
    """A tool, and what of it is assumed, or ``measured`` only so well; ``made`` makes one of other
    numbers.
    """

    tool: Tool
    usual: tuple[Usual, ...]
    numbers: dict[str, float]
    made: Callable[[Mapping[str, float]], Tool]
    measured: tuple[Usual, ...] = ()

    @cached_property
    def variants(self) -> tuple[tuple[Usual, Tool], ...]:
        """The tool with each of what is not exactly known a standard deviation off."""
        return tuple(
            (one, self.made({**self.numbers, one.name: one.value + one.sd}))
            for one in (*self.usual, *self.measured)
        )


def insert_of(stated: Mapping[str, float]) -> Assumed[Insert]:
    """Return an insert in its holder from what is stated of it, by name."""
    return _insert_of(tuple(stated.items()))


@lru_cache(INSERTS_KEPT)
def _insert_of(said: tuple[tuple[str, float], ...]) -> Assumed[Insert]:
    stated = dict(said)
    least = None if "kappa_deg" in stated else FOLLOWS_DEG

    def made(n: Mapping[str, float]) -> Insert:
        return Insert(**{one.name: n[one.name] for one in INSERT}, least_deg=least)

    return _assumed(stated, INSERT, made)


def end_mill_of(stated: Mapping[str, float]) -> Assumed[EndMill]:
    """Return an end mill; raises UnusableInput without its diameter and number of teeth."""
    _need(stated, "diameter_mm", "teeth")

    def made(n: Mapping[str, float]) -> EndMill:
        return EndMill(
            diameter_mm=n["diameter_mm"],
            teeth=int(n["teeth"]),
            helix_deg=n["helix_deg"],
            corner_radius_mm=min(n["corner_radius_mm"], 0.5 * n["diameter_mm"]),
            rake_deg=n["rake_deg"],
            runout_mm=n.get("runout_mm", 0.0),
            runout_deg=n.get("runout_deg", 0.0),
        )

    found = _assumed(stated, END_MILL, made)
    if not stated.get("runout_sd_mm"):
        return found
    out = Usual("runout_mm", stated["runout_mm"], stated["runout_sd_mm"], "mm")
    return replace(found, measured=(out,))


def drill_of(stated: Mapping[str, float]) -> Assumed[Drill]:
    """Return a two-lip drill; raises UnusableInput without its diameter, or with other lips."""
    _need(stated, "diameter_mm")
    if stated.get("teeth", 2) != 2:
        raise UnusableInput(
            phrase(
                "a drill with {stated} lips is not modelled; use one with 2",
                stated=localized(f"{stated['teeth']:g}"),
            )
        )

    def made(n: Mapping[str, float]) -> Drill:
        web_mm = n["web_share"] * n["diameter_mm"]
        return Drill(n["diameter_mm"], n["point_angle_deg"], n["helix_deg"], web_mm)

    return _assumed(stated, DRILL, made)


OF_KIND: dict[str, Callable[[Mapping[str, float]], Assumed[Any]]] = {
    "turning_insert": insert_of, "end_mill": end_mill_of, "drill": drill_of,
}  # fmt: skip


def assumed_of(kind: str, stated: Mapping[str, float]) -> tuple[Usual, ...]:
    """Return what is assumed of a tool of a kind, of which some numbers are stated."""
    return OF_KIND[kind](stated).usual


def _assumed(
    stated: Mapping[str, float],
    usual: tuple[Usual, ...],
    made: Callable[[Mapping[str, float]], Tool],
) -> Assumed[Tool]:
    numbers = {**{one.name: one.value for one in usual}, **stated}
    return Assumed(
        made(numbers), tuple(one for one in usual if one.name not in stated), numbers, made
    )


def _need(stated: Mapping[str, float], *names: str) -> None:
    lacking = [name for name in names if name not in stated]
    if lacking:
        raise UnusableInput(
            phrase(
                "the tool's {names} is not known; state it in a tool file",
                names=listed(lacking, phrase(" and ")),
            )
        )
