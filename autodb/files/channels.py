"""Names of channels and the unit that each name carries (docs/formats.md)."""

import re
from functools import cache
from math import inf

from autodb.wording import phrase

LINEAR_AXES = ("x", "y", "z", "u", "v", "w")
ROTARY_AXES = ("a", "b", "c")
FORCES = ("force.x", "force.y", "force.z")

_AXIS = f"[{''.join(LINEAR_AXES)}]"
_CURRENT = r"\.current(\.(u|v|w|(range|air)(\.sd)?))?"
_UNITS: tuple[tuple[str, str], ...] = (
    (r"t", "s"),
    (rf"{_AXIS}\.position", "mm"),
    (rf"{_AXIS}\.velocity", "mm/s"),
    (rf"{_AXIS}\.acceleration", "mm/s²"),
    (rf"({_AXIS}|[abc]|spindle){_CURRENT}", "A"),
    (rf"({_AXIS})\.drive_force", "N"),
    (rf"({_AXIS}|[abc])\.drive_torque", "N·m"),
    (r"spindle\.speed", "rpm"),
    (r"(spindle|a|b|c)\.angle", "deg"),
    (r"[abc]\.velocity", "deg/s"),
    (r"[abc]\.acceleration", "deg/s²"),
    (r"spindle\.power", "W"),
    (r"torque\.spindle", "N·m"),
    (r"force\.[xyz]", "N"),
    (rf"({_AXIS}|lubricant|spindle)\.temperature", "°C"),
    (r"cutting\.speed", "m/min"),
    (r"cutting\.(feed|depth|width)", "mm"),
    (r"cutting\.(direction|ramp)", "deg"),
    (r"pocket\.diameter", "mm"),
    (r"(work\.diameter|tool\.flank_wear|chip\.thickness)", "mm"),
    (r"(tool\.cutting_time|cut\.duration)", "s"),
    (r"(cut|tool\.edge|job\.block)", "1"),
)
_OF_CURRENTS = ("current.u", "current.v", "current.w", "current.range", "current.air")
_OF_NO_AXIS = (
    "spindle.speed", "spindle.power", "torque.spindle", *FORCES, "lubricant.temperature", "cut",
    "cutting.speed", "cutting.feed", "cutting.depth", "cutting.width", "cutting.direction",
    "cutting.ramp", "pocket.diameter", "work.diameter", "tool.flank_wear", "chip.thickness",
    "tool.cutting_time", "cut.duration", "tool.edge", "job.block",
)  # fmt: skip
OUR_UNITS = tuple(dict.fromkeys(unit for _, unit in _UNITS if unit != "1"))
"""Every unit that a channel's name carries."""
_LARGEST: tuple[tuple[str, float], ...] = (
    (r"spindle\.speed", 5e5),
    (r".\.position", 2e5),
    (r".\.velocity", 1e5),
    (r".*\.current(\..+)?", 1e5),
    (r"(force\..|.\.drive_force)", 1e7),
    (r"(torque\.spindle|.\.drive_torque)", 1e6),
    (r"spindle\.power", 1e8),
    (r".*\.temperature", 3e3),
    (r"cutting\.speed", 1e5),
    (r"cutting\.(feed|depth|width)|tool\.flank_wear|chip\.thickness", 1e3),
    (r"(work|pocket)\.diameter", 1e5),
    (r"cutting\.(direction|ramp)", 1e3),
    (r"(tool\.cutting_time|cut\.duration)", 1e8),
)
"""Beyond what machine tools do by a factor: the fastest air-bearing spindles reach some 350 000 rpm
and the longest portal mills some 100 m; the others are ten times and more over what is built."""
JOB, JOB_CUT, JOB_BLOCK = "job", "job.cut", "job.block"
"""Columns that say which job a cut is of, which of its cuts, and which line of its program."""
DURATION = "cut.duration"
"""Column of how long a cut took, from its entry to its exit."""
LOT = "work.lot"
"""Column of the lot of material that a cut was made in: a bar, a heat number."""
TEXT_COLUMNS = ("operation", "work.material", LOT, "tool", JOB, JOB_CUT)


def axis_words(axis: str) -> str:
    """Return what an axis is called: linear and rotary ones by their letters."""
    return phrase("spindle") if axis == "spindle" else axis


def unit_of(name: str) -> str | None:
    """Return the unit that channel ``name`` carries, or None where the name is not one of ours.

    >>> unit_of("z.current.range")
    'A'
    """
    return next((unit for pattern, unit in _UNITS if re.fullmatch(pattern, name)), None)


@cache
def largest_of(name: str) -> float:
    """Return what channel ``name`` exceeds on no machine, in its unit; infinity where any may be.

    >>> largest_of("cutting.depth")
    1000.0
    """
    return next((most for pattern, most in _LARGEST if re.fullmatch(pattern, name)), inf)


def is_channel(name: str) -> bool:
    """Say whether ``name`` is a channel or a column of a cut table."""
    return unit_of(name) is not None or name in TEXT_COLUMNS


def channel_names() -> list[str]:
    """Return every channel that a person may choose: standard errors of means are not among them.

    >>> channel_names()[:3]
    ['t', 'x.position', 'x.velocity']
    """
    ends = ("position", "velocity", "acceleration", "current", *_OF_CURRENTS, "drive_force",
            "drive_torque", "temperature", "angle")  # fmt: skip
    of_axes = [f"{axis}.{end}" for axis in (*LINEAR_AXES, *ROTARY_AXES, "spindle") for end in ends]
    names = ["t", *of_axes, *_OF_NO_AXIS, *TEXT_COLUMNS]
    return [name for name in names if is_channel(name)]


def axis_of(name: str) -> str:
    """Return the axis that channel ``name`` belongs to: the part before the first dot."""
    return name.split(".", 1)[0]


def effort_channels(names: list[str]) -> list[str]:
    """Return the drive efforts of feed axes among ``names``, those of linear axes first."""
    return [*linear_efforts(names), *rotary_efforts(names)]


def linear_efforts(names: list[str]) -> list[str]:
    """Return the drive efforts of linear axes among ``names``: force, torque or current."""
    pattern = rf"{_AXIS}\.(drive_force|drive_torque|current)"
    return [n for n in names if re.fullmatch(pattern, n)]


def place_channel(axis: str) -> str:
    """Return the channel of where an axis is: its angle where it is rotary.

    >>> place_channel("c")
    'c.angle'
    """
    return f"{axis}.{'angle' if axis in ROTARY_AXES else 'position'}"


def way_unit(axis: str) -> str:
    """Return the unit of an axis' ways: deg where it is rotary, else mm."""
    return "deg" if axis in ROTARY_AXES else "mm"


def rotary_efforts(names: list[str]) -> list[str]:
    """Return the drive efforts of rotary axes among ``names``: torque or current."""
    return [n for n in names if re.fullmatch(r"[abc]\.(drive_torque|current)", n)]
