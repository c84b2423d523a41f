"""What words change, as tables: modal groups of each family of controls, and what moves nothing.

A lathe's letters mean something else in G-code system A of Fanuc (Haas too) than in B and C, and in
C the cycles are numbered otherwise: ``SYSTEM_C`` gives the words of A that they stand for.
"""

from collections.abc import Mapping
from functools import cache
from typing import Any

from autodb.nc.reading.controls import LINUXCNC, OKUMA, SINUMERIK, Control
from autodb.nc.reading.lines.names import REFUSED_NAMES

INCH_MM = 25.4
"""Millimetres in an inch (exact by definition)."""
Group = Mapping[str, Mapping[str, Any]]

_MOTION: Group = {code: {"motion": code} for code in ("G0", "G1", "G2", "G3", "G33")}
_PLANE: Group = {"G17": {"plane": "G17"}, "G18": {"plane": "G18"}, "G19": {"plane": "G19"}}
_COUNT: Group = {"G90": {"absolute": True}, "G91": {"absolute": False}}
_INCH, _MM = {"unit_mm": INCH_MM}, {"unit_mm": 1.0}
_UNITS: Group = {"G20": _INCH, "G21": _MM, "G700": _INCH, "G710": _MM}
_SURFACE: Group = {"G96": {"surface": True}, "G97": {"surface": False}}
_DIAMETER: Group = {
    "DIAMON": {"diameter": True, "step_diameter": None},
    "DIAMOF": {"diameter": False, "step_diameter": None},
    "DIAM90": {"diameter": True, "step_diameter": False},
}
_SIDE: Group = {
    "G40": {"side": None}, "G41": {"side": "left"}, "G42": {"side": "right"},
    "G41.1": {"side": "left"}, "G42.1": {"side": "right"},
}  # fmt: skip
_FEED: Group = {code: {"feed_word": code} for code in ("G93", "G94", "G95")}
_FEED_A: Group = {"G98": {"feed_word": "G94"}, "G99": {"feed_word": "G95"}}
_RETURN: Group = {"G98": {"to_start": True}, "G99": {"to_start": False}}
_TURNED: Group = {"G69": {"turned": None, "tilt": ()}}
_POLAR: Group = {
    "G15": {"polar": False, "polar_place": None}, "G16": {"polar": True, "polar_place": None},
}  # fmt: skip
_CENTRE: Group = {"G90.1": {"centre_absolute": True}, "G91.1": {"centre_absolute": False}}

HARMLESS = frozenset(
    {
        "G9",
        "G49",
        "G60",
        "G60.1",
        "G61",
        "G61.1",
        "G64",
        "G64.1",
        "G80",
        "G5.1",
        "G8.1",
        "G8",
        "G15",
    }
    | {"G50.1", "G69", "G67", "G22", "G23", "G25", "G26", "G40.1", "G54.4", "G601", "G602", "G603"}
    | {
        "G641",
        "G642",
        "G643",
        "G644",
        "G645",
        "G450",
        "G451",
        "G13.1",
        "G113",
        "G187",
        "G103",
        "M66",
        "M71",
    }
    | {"G62", "G63", "G14", "G290", "G94.1", "G141", "G97.1", "G64.2", "G40.2", "G347"}
    | {"M0", "M1", "M2", "M3", "M4", "M5", "M6", "M7", "M8", "M9", "M10", "M11", "M12", "M13"}
    | {"M14", "M15", "M16", "M17", "M19", "M21", "M22", "M23", "M24", "M25", "M26", "M29", "M30"}
    | {"M31", "M32", "M33", "M35", "M36", "M37", "M38", "M39", "M46", "M48", "M49", "M50", "M51"}
    | {
        "M52",
        "M53",
        "M59",
        "M60",
        "M61",
        "M67",
        "M68",
        "M69",
        "M70",
        "M72",
        "M73",
        "M82",
        "M83",
        "M85",
    }
    | {"M86", "M87", "M88", "M89", "M93", "M97", "M98", "M99", "M64", "M65", "M62", "M63"}
    | {f"M{gear}" for gear in range(40, 46)}
)
"""Words that move no axis and change nothing that is read here: exact stops and path modes,
coolant, gear, chuck, tailstock, chip conveyor, parts catcher, overrides, ends and calls (which are
run elsewhere)."""
OF_OKUMA = frozenset({"G136", "G140"})
"""Okuma's words that the C axis is no coordinate any more, and that the first spindle's side
cuts."""
CALLS_OUTSIDE = frozenset({198.0})
"""M that call a program from outside of the control."""
NOT_OF_BUILDERS = frozenset({91.0, 92.0, 96.0})
"""M of two digits that are not taken for the builder's: some mirror axes (Mazak) or jump (Haas)."""
MODE_LETTERS: Mapping[str, str] = {
    "G64": "PQ", "G61.1": "PQR", "G187": "PE", "G5": "PR", "G5.1": "QRP", "G8": "P", "G62": "PQ",
    "G103": "P", "M66": "PQLE", "M67": "EQ", "M68": "EQ", "M62": "P", "M63": "P",
    "M64": "P", "M65": "P", "G64.1": "PQ", "G41.1": "D", "G42.1": "D",
    "M3": "P", "M4": "P", "M5": "P",
}  # fmt: skip
"""Letters that words of path modes take beside them: tolerances, smoothness, look-ahead; P of M3
chooses a spindle."""
OFFSETS = frozenset(
    {f"G{number}" for number in range(54, 60)}
    | {f"G59.{number}" for number in range(1, 4)}
    | {f"G{number}" for number in range(505, 549)}
    | {f"G{number}" for number in range(110, 130)}
    | {"G500", "G54.1"}
)
MACHINE = frozenset({"G28", "G30", "G53", "SUPA", "G28.1", "G30.1", "G153"})
"""Words after which the place in the program's coordinates is not known."""
LENGTHS = frozenset({"G43", "G44", "G49", "G43.1", "G43.2", "G43.4", "G43.5"})
"""Words of a tool's length: the programmed place of its tip counts."""
REFUSED: Mapping[str, str] = {
    "G68": "this turns coordinates; it is read on mills of Fanuc and Haas",
    "G68.2": "this tilts coordinates; it is read on mills of Fanuc and Haas",
    "G51": "this scales coordinates; program without it",
    "G51.1": "this mirrors coordinates; program without it",
    "G16": "this counts polar coordinates; it is read on mills of Fanuc and Haas",
    "G66": "this calls a macro at every move; write its blocks into the program",
    "G12.1": "this moves in polar coordinates of a rotary axis; only X, Y and Z are read",
    "G112": "this moves in polar coordinates of a rotary axis; only X, Y and Z are read",
    "G7.1": "this winds the path around a cylinder; only X, Y and Z are read",
    "G107": "this winds the path around a cylinder; only X, Y and Z are read",
    "G31": "this probes until the work is touched; leave out probing",
    "G34": "this cuts a thread of changing pitch; only constant ones are read",
    "G5": "this is a spline; program lines and arcs",
    "G5.2": "this is a spline; program lines and arcs",
    "G6": "this is a spline; program lines and arcs",
    "G6.2": "this is a spline; program lines and arcs",
    **REFUSED_NAMES,
    "G38.2": "this probes until the work is touched; leave out probing",
    "G38.3": "this probes until the work is touched; leave out probing",
    "G38.4": "this probes until the work is touched; leave out probing",
    "G38.5": "this probes until the work is touched; leave out probing",
}
SYSTEM_C: Mapping[str, str] = {
    "G20": "G90", "G21": "G92", "G24": "G94", "G70": "G20", "G71": "G21", "G72": "G70",
    "G73": "G71", "G74": "G72", "G75": "G73", "G76": "G74", "G77": "G75", "G78": "G76",
    "G33": "G32",
}  # fmt: skip
SYSTEM_B: Mapping[str, str] = {"G77": "G90", "G78": "G92", "G79": "G94", "G33": "G32"}
"""Cycles of the systems B and C by what system A calls them."""
ROUGHING = frozenset({"G70", "G71", "G72", "G73"})
GROOVING = frozenset({"G74", "G75"})
BOXES = frozenset({"G90", "G92", "G94"})
"""Cycles of one pass of system A: along the axis, a thread, a face."""
DRILLED = frozenset({f"G{number}" for number in range(81, 90)} | {"G73", "G74", "G76", "G83.1"})


def is_builders(number: float, control: Control) -> bool:
    """Return whether an M that is in no table is one of the machine's builder.

    Fanuc's and Siemens' controls hand all but M0 to M2, M30, M98, M99 and M198 over to the machine
    (Series 0i-D, operator's manual B-64304EN, auxiliary function); LinuxCNC knows M below 100.
    """
    first = 100 if control is LINUXCNC else 18
    return first <= number <= 999 and number not in CALLS_OUTSIDE | NOT_OF_BUILDERS


@cache
def groups_of(control: Control, *, lathe: bool) -> tuple[Group, ...]:
    """Return the groups of modal words of a control, and what they change."""
    shared = [_MOTION, _PLANE, _UNITS, _SURFACE, _SIDE, _DIAMETER]
    if control is SINUMERIK:
        units = {**_UNITS, "G70": _INCH, "G71": _MM}
        return (_MOTION, _PLANE, _COUNT, units, {**_FEED, **_SURFACE_S}, _SIDE, _DIAMETER)
    if control is LINUXCNC:
        diameter = {"G7": {"diameter": True}, "G8": {"diameter": False}}
        return (*shared[:5], _COUNT, _FEED, diameter, _CENTRE, _RETURN)
    if control is OKUMA:
        return (_MOTION, _PLANE, _SURFACE, _SIDE, _COUNT, _FEED)
    if not lathe:
        return (*shared, _COUNT, _FEED, _RETURN, _CENTRE, _TURNED, _POLAR)
    if control.system == "A":
        return (*shared, _FEED_A)
    return (*shared, _COUNT, _FEED)


_SURFACE_S: Group = {"G96": {"surface": True, "feed_word": "G95"}, "G97": {"surface": False}}
"""In Sinumerik G96 is one of the words of the feed: it counts a revolution."""
