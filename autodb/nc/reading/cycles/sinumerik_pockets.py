"""Pockets of Sinumerik's mills: POCKET3, a rectangle with rounded corners, and POCKET4, a circle.

Each is cut in planes of one depth, at most _MID, and in each from the middle out in rings of one
step, at most _MIDA (0.8 of the tool's diameter where it is not said). The tool goes down in the
middle, straight or on a helix. Roughing leaves _FAL at the wall and _FALD at the floor; finishing
goes around the wall in each plane, and over the floor in the last. Names and order of the
arguments: Siemens, SINUMERIK 840D sl/828D, Programming Manual Cycles. How a control links its rings
is not told there: here they begin on the positive first axis of the pocket.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, cos, pi, radians, sin

from autodb.nc.reading.cycles.cycle_moves import SAME_MM, Carrying, go_along, known_start, rapid_to
from autodb.nc.reading.lines.blocks import ProgramBlock
from autodb.nc.reading.paths import Feed, FeedPerMinute
from autodb.nc.reading.state import feed_in_force, speed_in_force
from autodb.nc.reading.travels import Circle, ProgramMove, ToolPlace

_RECTANGLE = (
    "_RTP", "_RFP", "_SDIS", "_DP", "_LENG", "_WID", "_CRAD", "_PA", "_PO", "_STA", "_MID", "_FAL",
    "_FALD", "_FFP1", "_FFD", "_CDIR", "_VARI", "_MIDA", "_AP1", "_AP2", "_AD", "_RAD1", "_DP1",
)  # fmt: skip
_CIRCLE = (
    "_RTP", "_RFP", "_SDIS", "_DP", "_PRAD", "_PA", "_PO", "_MID", "_FAL", "_FALD", "_FFP1", "_FFD",
    "_CDIR", "_VARI", "_MIDA", "_AP1", "_AD", "_RAD1", "_DP1",
)  # fmt: skip
POCKETS = {"POCKET3": _RECTANGLE, "POCKET4": _CIRCLE}
"""Arguments of each cycle by name, in their order."""
WIDEST = 0.8
"""Step of rings where _MIDA is not said, in diameters of the tool."""
MOST_RINGS = 100_000
"""Rings of one pocket, in all planes. Chosen: more is a slip of _MID or _MIDA."""
WRITE_OUT = "write out its moves as G0, G1, G2 and G3"
_ROUGHS, _FINISHES = 1, 2
_FAST, _STRAIGHT, _HELIX = range(3)
CLOCKWISE = {0: False, 1: True, 2: True, 3: False}
"""_CDIR: with the cut and against it, of a spindle that turns to the right, G2 and G3."""


@dataclass(frozen=True)
class _Pocket:
    """A pocket as the tool's centre meets it, mm; ``half``: of the outermost ring, x and y.

    ``corner_mm``: radius of that ring's corners; ``step_mm`` of rings; ``levels``: each plane's
    depth, downwards; ``turned_rad``: about its middle.
    """

    middle: tuple[float, float]
    half: tuple[float, float]
    corner_mm: float
    step_mm: float
    levels: Sequence[float]
    turned_rad: float

    def rings(self) -> list[float]:
        """Return how far inside the outermost ring each is, from the middle out, mm."""
        inside = min(self.half)
        count = max(ceil(inside / self.step_mm - SAME_MM), 1)
        return [inside * (1.0 - k / count) for k in range(count + 1)]


def mill_sinumerik_pocket(
    m: Carrying, name: str, numbers: Sequence[float | None], block: ProgramBlock
) -> None:
    """Mill a pocket by POCKET3 or POCKET4; raises UnusableInput where it is not read or too small.

    ``numbers``: the call's arguments in order, mm, mm/min and degrees, None where left out.
    """
    state, names = m.state, POCKETS[name]
    given = dict(zip(names, (one or 0.0 for one in numbers), strict=False))
    said = {key: given.get(key, 0.0) for key in names}
    _refuse_others(m, name, numbers, said, block)
    pocket = _pocket(m, name, said, block)
    unit, top = state.unit_mm, said["_RFP"] * state.unit_mm + state.shift["z"]
    known_start(m, block)
    back = said["_RTP"] * unit + state.shift["z"]
    rapid_to(m, block, z=max(back, state.known("z")))
    rapid_to(m, block, x=pocket.middle[0], y=pocket.middle[1])
    rapid_to(m, block, z=top + abs(said["_SDIS"]) * unit)
    way = _Way(m, block, pocket, clockwise=CLOCKWISE.get(int(said["_CDIR"]), False))
    across, down = (feed_of_cycle(m, said[key] * unit, block) for key in ("_FFP1", "_FFD"))
    kind, enters = int(said["_VARI"]) % 10, int(said["_VARI"]) // 10 % 10
    helix = (said["_RAD1"] * unit, said["_DP1"] * unit) if enters == _HELIX else None
    for k, level in enumerate(pocket.levels):
        way.go_down(level, None if enters == _FAST else down, helix)
        last = k == len(pocket.levels) - 1
        whole = kind == _ROUGHS or last
        for inside in pocket.rings() if whole else [0.0]:
            way.go_around(inside, across)
        way.go_to((0.0, 0.0), across)
    rapid_to(m, block, z=back)


def _refuse_others(
    m: Carrying,
    name: str,
    numbers: Sequence[float | None],
    said: dict[str, float],
    block: ProgramBlock,
) -> None:
    """Raise UnusableInput for what of a pocket is not read."""
    names = POCKETS[name]
    kind, enters = int(said["_VARI"]) % 10, int(said["_VARI"]) // 10 % 10
    why = None
    if any(numbers[len(names) :]):
        why = f"more than {len(names)} arguments are not read"
    elif any(said.get(key) for key in ("_AP1", "_AP2", "_AD")):
        why = "a pocket that is there in part (_AP1, _AP2, _AD) is not read"
    elif kind not in (_ROUGHS, _FINISHES) or enters > _HELIX:
        why = "_VARI is not read; use 1 or 2 in its last digit and 0, 1 or 2 before it"
    elif said["_CDIR"] not in CLOCKWISE:
        why = "_CDIR is not read; use 0 to 3"
    elif enters == _HELIX and not (said["_RAD1"] > 0.0 and said["_DP1"] > 0.0):
        why = "a helix needs _RAD1 and _DP1 above 0"
    elif m.state.plane != "G17" or m.state.turned is not None:
        why = "a pocket is read in G17, and not in a turned plane"
    elif min(said.get(key, 0.0) for key in ("_LENG", "_WID", "_PRAD")) < 0.0:
        why = "a pocket that is measured from its corner is not read"
    if why is not None:
        raise block.refusal(name, f"{why}; {WRITE_OUT}")


def _pocket(m: Carrying, name: str, said: dict[str, float], block: ProgramBlock) -> _Pocket:
    """Return a pocket as the tool's centre meets it; raises UnusableInput where it does not fit."""
    state, unit = m.state, m.state.unit_mm
    tool_mm = tool_radius_mm(m, block)
    finishes = int(said["_VARI"]) % 10 == _FINISHES
    wall = 0.0 if finishes else abs(said["_FAL"]) * unit
    floor = 0.0 if finishes else abs(said["_FALD"]) * unit
    round_ = "_PRAD" in said
    sizes = (said["_PRAD"],) * 2 if round_ else (0.5 * said["_LENG"], 0.5 * said["_WID"])
    half = (sizes[0] * unit - wall - tool_mm, sizes[1] * unit - wall - tool_mm)
    if min(half) <= SAME_MM:
        raise block.refusal(
            name, f"a tool of radius {tool_mm:g} mm does not fit into this pocket; use a smaller"
        )
    corner = half[0] if round_ else max(said["_CRAD"] * unit - wall - tool_mm, 0.0)
    step = said["_MIDA"] * unit or WIDEST * 2.0 * tool_mm
    top, bottom = said["_RFP"] * unit, said["_DP"] * unit + floor
    if not step > 0.0:
        raise block.refusal(name, "_MIDA is above 0; state it so")
    levels = planes_between(m, name, block, (top, bottom), said["_MID"] * unit)
    if len(levels) * min(half) / step > MOST_RINGS:
        raise block.refusal(name, "_MID or _MIDA is far too small; make it larger")
    middle = (said["_PA"] * unit + state.shift["x"], said["_PO"] * unit + state.shift["y"])
    return _Pocket(middle, half, corner, step, levels, radians(said.get("_STA", 0.0)))


def tool_radius_mm(m: Carrying, block: ProgramBlock) -> float:
    """Return the radius of the tool that is in use; raises UnusableInput where nobody says it."""
    if m.radius_of is None:
        raise block.refusal(
            block.words[0].text, "the tool's diameter is not known; state diameter_mm"
        )
    here = ToolPlace(*known_start(m, block).values())
    return m.radius_of(ProgramMove(here, here, None, None, block.line, m.state.tool))


def planes_between(
    m: Carrying, name: str, block: ProgramBlock, ends: tuple[float, float], most_mm: float
) -> list[float]:
    """Return levels from the upper end down to the lower, equally deep and each at most so.

    ``ends`` and ``most_mm`` as the program says them, mm; 0: at once. Raises UnusableInput where
    they do not go down.
    """
    top, bottom = ends
    deep = most_mm or top - bottom
    if not (bottom < top and deep > 0.0):
        raise block.refusal(
            name, "DP is not below RFP, or the depth of a plane not above 0; state them so"
        )
    planes = max(ceil((top - bottom) / deep - SAME_MM), 1)
    if planes > MOST_RINGS:
        raise block.refusal(name, "the depth of a plane is far too small; make it larger")
    shift = m.state.shift["z"]
    return [top + (bottom - top) * (k + 1) / planes + shift for k in range(planes)]


def feed_of_cycle(m: Carrying, mm_min: float, block: ProgramBlock) -> Feed:
    """Return a feed that a cycle says, mm/min; that in force where it says none."""
    return FeedPerMinute(mm_min) if mm_min > 0.0 else feed_in_force(m.state, block)


class _Way:
    """Moves of the tool's centre in a pocket, by places from its middle along its own axes."""

    def __init__(
        self, m: Carrying, block: ProgramBlock, pocket: _Pocket, *, clockwise: bool
    ) -> None:
        self._m, self._block, self._pocket = m, block, pocket
        self._clockwise = clockwise
        self._speed = speed_in_force(m.state, block)

    def go_to(self, place: tuple[float, float], feed: Feed) -> None:
        """Go straight to a place of the plane."""
        self._go(*self._there(place), self._m.state.known("z"), feed, None)

    def go_down(self, level: float, feed: Feed | None, helix: tuple[float, float] | None) -> None:
        """Go down in the middle: straight, fast where there is no feed, or by (radius, pitch)."""
        x, y = self._pocket.middle
        if helix is None or feed is None:
            self._go(x, y, level, feed, None)
            return
        radius_mm, pitch_mm = helix
        out = self._there((radius_mm, 0.0))
        deep = self._m.state.known("z") - level
        turns = max(ceil(deep / pitch_mm - SAME_MM), 1)
        self._go(*out, self._m.state.known("z"), feed, None)
        for turn in (turns, 1):  # down, and once around at the level
            whole = Circle("G17", (x, y), not self._clockwise, turn - 1)
            self._go(*out, level, feed, whole)
        self._go(x, y, level, feed, None)

    def go_around(self, inside_mm: float, feed: Feed) -> None:
        """Go to a ring so far inside the outermost, and around it; the innermost may be a line."""
        a, b = (half - inside_mm for half in self._pocket.half)
        if min(a, b) <= SAME_MM:
            end = (a, b) if max(a, b) > SAME_MM else None
            for side in (1.0, -1.0) if end else ():
                self.go_to((side * max(a, 0.0), side * max(b, 0.0)), feed)
            return
        corner = min(max(self._pocket.corner_mm - inside_mm, 0.0), a, b)
        self.go_to((a, 0.0), feed)
        for to, centre in _ring(a, b, corner):
            mirrored = -1.0 if self._clockwise else 1.0
            x, y = self._there((to[0], mirrored * to[1]))
            middle = None if centre is None else self._there((centre[0], mirrored * centre[1]))
            circle = None if middle is None else Circle("G17", middle, not self._clockwise)
            self._go(x, y, self._m.state.known("z"), feed, circle)

    def _there(self, place: tuple[float, float]) -> tuple[float, float]:
        (x, y), turned = self._pocket.middle, self._pocket.turned_rad
        u, v = place
        return x + u * cos(turned) - v * sin(turned), y + u * sin(turned) + v * cos(turned)

    def _go(self, x: float, y: float, z: float, feed: Feed | None, circle: Circle | None) -> None:
        go_along(self._m, self._block, ToolPlace(x, y, z), feed, self._speed, circle=circle)


_Place = tuple[float, float]


def _ring(a: float, b: float, corner: float) -> Iterator[tuple[_Place, _Place | None]]:
    """Yield ends, and centres of corners, of a ring against the clock from (a, 0) on.

    ``a`` and ``b``: half its length and width, mm.
    """
    for k in range(4):
        u, v = (a, b) if k % 2 == 0 else (b, a)
        turn = 0.5 * pi * k

        def at(x: float, y: float, turn: float = turn) -> _Place:
            return x * cos(turn) - y * sin(turn), x * sin(turn) + y * cos(turn)

        yield at(u, v - corner), None
        if corner > SAME_MM:
            yield at(u - corner, v), at(u - corner, v - corner)
    yield (a, 0.0), None
