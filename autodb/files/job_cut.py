"""One cut of a job: its operation, the keys that this needs, and how large they may be."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import atan2, degrees, hypot, pi
from pathlib import Path
from typing import Annotated, Literal, get_args

from pydantic import AfterValidator, Field, model_validator

from autodb.errors import UnusableInput
from autodb.files.channels import largest_of
from autodb.files.toml import Finite, NotNegative, Positive, Section
from autodb.files.tool import ToolFile, ToolKind
from autodb.wording import listed, localized, msgid, phrase

Operation = Literal[
    "turn", "face", "taper", "contour", "bore", "groove", "thread",
    "slot", "side-up", "side-down", "ramp", "pocket", "drill",
]  # fmt: skip


OPERATIONS: tuple[str, ...] = get_args(Operation)


SPEEDS = ("speed_rpm", "speed_m_min")


ANY_CUT = ("name", "operation", *SPEEDS, "length_mm", "cutting_time_s", "flank_wear_mm")


@dataclass(frozen=True)
class Keys:
    """Of an operation: its kind of tool, the keys that a cut needs, and those that it may have."""

    kind: ToolKind
    needs: tuple[str, ...]
    may: tuple[str, ...] = ()

    @cached_property
    def known(self) -> frozenset[str]:
        """All that a cut may have."""
        return frozenset((*self.needs, *self.may, *ANY_CUT))


_TURNED = ("diameter_mm", "depth_mm", "feed_mm_rev")


_MILLED = ("depth_mm", "feed_mm_tooth")


_PROFILE = Keys("turning_insert", _TURNED, ("end_diameter_mm", "direction_deg"))


KEYS = {
    "turn": Keys("turning_insert", _TURNED),
    "face": Keys("turning_insert", _TURNED, ("end_diameter_mm",)),
    "taper": _PROFILE,
    "contour": _PROFILE,
    "bore": Keys("turning_insert", _TURNED),
    "groove": Keys("turning_insert", ("diameter_mm", "width_mm", "feed_mm_rev")),
    "thread": Keys("turning_insert", (*_TURNED, "width_mm")),
    "slot": Keys("end_mill", _MILLED, ("direction_deg",)),
    "side-up": Keys("end_mill", (*_MILLED, "width_mm"), ("direction_deg",)),
    "side-down": Keys("end_mill", (*_MILLED, "width_mm"), ("direction_deg",)),
    "ramp": Keys("end_mill", (*_MILLED, "ramp_deg"), ("direction_deg",)),
    "pocket": Keys("end_mill", (*_MILLED, "width_mm", "pocket_diameter_mm"), ("direction_deg",)),
    "drill": Keys("drill", ("feed_mm_rev",)),
}
"""Keys of a cut by its operation; a mill or drill has its diameter from the tool. The feed of a
thread is its pitch, its depth that of the pass, its width the height of the V after it."""


MOST_CUT: Mapping[ToolKind, Mapping[str, float]] = {
    "turning_insert": {"depth_mm": 30.0, "feed_mm_rev": 5.0},
    "end_mill": {"depth_mm": 200.0, "feed_mm_tooth": 5.0},
    "drill": {"feed_mm_rev": 5.0},
}
"""What a cut of a kind of tool goes beyond only by a slip of the unit. Chosen: the longest edges of
ISO 1832's inserts cut some 20 mm deep, heavy roughing feeds by 2 mm, drills by 1 mm a revolution,
mills of high feed by 3 mm a tooth."""


MOST_PITCH_MM = 25.0
"""The same of a thread's pitch. Chosen: trapezoidal threads of machines have up to 24 mm."""


LEAST = 1e-6
"""What a cut states is larger than this in its unit, where it cannot be nothing: an atom has some
10⁻⁷ mm, and a speed of 10⁻⁶ rpm is a turn in two years. Chosen."""


def _is_something(value: float) -> float:
    if value < LEAST:
        raise ValueError(
            phrase(
                "{value} is below any machine; use at least {least}",
                value=localized(f"{value:g}"), least=localized(f"{LEAST:g}"),
            )
        )  # fmt: skip
    return value


_Something = Annotated[Positive, AfterValidator(_is_something)]


Across = Annotated[_Something, Field(le=largest_of("cutting.depth"))]
"""Depth, width, feed, mm."""


Diameter = Annotated[_Something, Field(le=largest_of("work.diameter"))]


EndDiameter = Annotated[NotNegative, Field(le=largest_of("work.diameter"))]


Length = Annotated[NotNegative, Field(le=largest_of("x.position"))]


Coordinate = Annotated[Finite, Field(ge=-largest_of("x.position"), le=largest_of("x.position"))]


Direction = Annotated[
    Finite, Field(ge=-largest_of("cutting.direction"), le=largest_of("cutting.direction"))
]


Ramp = Annotated[_Something, Field(le=largest_of("cutting.ramp"))]


CuttingTime = Annotated[NotNegative, Field(le=largest_of("tool.cutting_time"))]


FlankWear = Annotated[NotNegative, Field(le=largest_of("tool.flank_wear"))]


Rpm = Annotated[_Something, Field(le=largest_of("spindle.speed"))]


CuttingSpeed = Annotated[_Something, Field(le=largest_of("cutting.speed"))]


class JobCut(Section):
    """One cut; give the spindle speed or the cutting speed. What no machine does is refused.

    Turning: ``diameter_mm`` is the machined diameter at the tool tip, ``end_diameter_mm`` the one
    at the end of a cut whose radius changes, ``length_mm`` how far it goes (of a taper or contour
    along the axis), from which its time and energy follow;
    ``depth_mm`` lies across the feed. Milling: ``direction_deg`` of the feed from +x towards +y.
    ``cutting_time_s`` on the edge before the cut and ``flank_wear_mm`` give the state of the edge.
    """

    name: str = ""
    operation: Operation = "turn"
    diameter_mm: Diameter | None = None
    end_diameter_mm: EndDiameter | None = None
    length_mm: Length | None = None
    depth_mm: Across | None = None
    width_mm: Across | None = None
    feed_mm_rev: Across | None = None
    feed_mm_tooth: Across | None = None
    direction_deg: Direction | None = None
    ramp_deg: Ramp | None = None
    pocket_diameter_mm: Diameter | None = None
    cutting_time_s: CuttingTime | None = None
    flank_wear_mm: FlankWear | None = None
    speed_rpm: Rpm | None = None
    speed_m_min: CuttingSpeed | None = None

    @model_validator(mode="after")
    def _keys_of_its_operation(self) -> "JobCut":
        keys = KEYS[self.operation]
        given = [name for name, value in vars(self).items() if value is not None]
        lacking = [name for name in keys.needs if name not in given]
        if lacking:
            raise ValueError(
                phrase(
                    "operation '{operation}' needs {keys}",
                    operation=self.operation,
                    keys=listed(lacking, phrase(" and ")),
                )
            )
        unknown = [name for name in given if name not in keys.known]
        if unknown:
            raise ValueError(
                phrase(
                    "operation '{operation}' has no {keys}; it takes {others}",
                    operation=self.operation,
                    keys=listed(unknown, phrase(" or ")),
                    others=", ".join((*keys.needs, *keys.may)),
                )
            )
        return self

    @model_validator(mode="after")
    def _plausible(self) -> "JobCut":
        for key, most in MOST_CUT[KEYS[self.operation].kind].items():
            value = getattr(self, key)
            limit = MOST_PITCH_MM if (self.operation, key) == ("thread", "feed_mm_rev") else most
            if value is not None and value > limit:
                raise ValueError(
                    phrase(
                        "{key} {value} is beyond what a tool of operation '{operation}' cuts; "
                        "use at most {most}",
                        key=key,
                        value=localized(f"{value:g}"),
                        operation=self.operation,
                        most=localized(f"{limit:g}"),
                    )
                )
        return self

    @model_validator(mode="after")
    def _one_speed(self) -> "JobCut":
        if (self.speed_rpm is None) == (self.speed_m_min is None):
            raise ValueError(phrase("give either speed_rpm or speed_m_min, and only one of them"))
        return self

    @model_validator(mode="after")
    def _a_profile_has_a_direction(self) -> "JobCut":
        if self.operation in ("taper", "contour") and self.inward_deg is None:
            raise ValueError(
                f"operation '{self.operation}' needs direction_deg (of the feed, from along the "
                "axis to the chuck towards the centre), or end_diameter_mm and length_mm"
            )
        return self

    @property
    def inward_deg(self) -> float | None:
        """Direction of a turning tool's feed: 0 along the axis to the chuck, 90 to the centre.

        A face whose end is the larger diameter is cut away from the centre, at -90.
        """
        if self.operation == "face":
            outward = (self.end_diameter_mm or 0.0) > (self.diameter_mm or 0.0)
            return -90.0 if outward else 90.0
        if self.direction_deg is not None:
            return self.direction_deg
        if self.diameter_mm is None or self.end_diameter_mm is None or self.length_mm is None:
            return None
        return degrees(atan2(0.5 * (self.diameter_mm - self.end_diameter_mm), self.length_mm))

    def conditions(self, tool_diameter_mm: float | None) -> dict[str, float]:
        """Return what is stated of the cut by channel of a cut table, both speeds with it.

        A mill's or drill's cutting speed is that at its rim. Raises UnusableInput where its
        diameter is not known.
        """
        diameter = self._cutting_diameter_mm(tool_diameter_mm)
        per_rev_m = pi * diameter / 1000.0
        rpm = self.speed_rpm or (self.speed_m_min or 0.0) / per_rev_m
        turns = KEYS[self.operation].kind == "turning_insert"
        stated = {
            "cutting.feed": self.feed_mm_rev or self.feed_mm_tooth,
            "cutting.depth": self.depth_mm,
            "cutting.width": self.width_mm,
            "cutting.direction": self.inward_deg if turns else self.direction_deg,
            "cutting.ramp": self.ramp_deg,
            "pocket.diameter": self.pocket_diameter_mm,
            "tool.cutting_time": self.cutting_time_s,
            "tool.flank_wear": self.flank_wear_mm,
            "work.diameter": diameter if turns else None,
            "spindle.speed": rpm,
            "cutting.speed": rpm * per_rev_m,
        }
        return {name: value for name, value in stated.items() if value is not None}

    @property
    def path_mm(self) -> float | None:
        """How far the tool goes along its feed; None where that is not stated.

        A face and a profile that state where they end also go as far across the axis.
        """
        if self.operation in ("face", "taper", "contour"):
            if self.end_diameter_mm is None or self.diameter_mm is None:
                return self.length_mm if self.operation == "face" else None
            along = 0.0 if self.operation == "face" else self.length_mm
            across = 0.5 * (self.diameter_mm - self.end_diameter_mm)
            return None if along is None else hypot(along, across)
        return self.length_mm

    @property
    def changes_diameter(self) -> bool:
        """Whether it goes from one diameter to another, so that torque and speed change."""
        return self.end_diameter_mm not in (None, self.diameter_mm)

    def conditions_at(self, share: float, tool_diameter_mm: float | None) -> dict[str, float]:
        """Return ``conditions`` at a share of its time, 0 at its start, 1 at its end.

        At one feed a revolution and one spindle speed the diameter changes evenly.
        """
        stated = self.conditions(tool_diameter_mm)
        start_mm = self.diameter_mm or 0.0
        now_mm = start_mm + share * ((self.end_diameter_mm or 0.0) - start_mm)
        speed = stated["cutting.speed"] * now_mm / stated["work.diameter"]
        return stated | {"work.diameter": now_mm, "cutting.speed": speed}

    def ranges(self, tool_diameter_mm: float | None) -> Mapping[str, tuple[float, float]]:
        """Return lowest and highest of what is stated, by channel: the same in one cut."""
        stated = self.conditions(tool_diameter_mm)
        return {channel: (value, value) for channel, value in stated.items()}

    def _cutting_diameter_mm(self, tool_diameter_mm: float | None) -> float:
        if self.diameter_mm is not None:
            return max(self.diameter_mm, self.end_diameter_mm or 0.0)
        if tool_diameter_mm is None:
            what = "mill" if KEYS[self.operation].kind == "end_mill" else "drill"
            raise UnusableInput(
                phrase(
                    "cut '{it}': the {what}'s diameter is not known; state diameter_mm in a tool "
                    "file",
                    it=self.name,
                    what=what,
                )
            )
        return tool_diameter_mm


OF_KIND = {
    "turning_insert": msgid("an insert"), "end_mill": msgid("an end mill"),
    "drill": msgid("a drill"),
}  # fmt: skip
"""What a tool of each kind is, in words."""


def refuse_other_kind(path: Path, tool: ToolFile, operations: Iterable[str]) -> None:
    """Raise UnusableInput where a tool that a file is of makes no cut of one of some operations."""
    for operation in operations:
        needed = KEYS[operation].kind
        if needed != tool.kind:
            raise UnusableInput(
                phrase(
                    "{file}: is of {kind}, which makes no '{operation}'; name a file of {other}",
                    file=path,
                    kind=phrase(OF_KIND[tool.kind]),
                    operation=operation,
                    other=phrase(OF_KIND[needed]),
                )
            )
