"""Slots of Sinumerik's mills on a circle: SLOT1 and LONGHOLE along its radii, SLOT2 along it.

Each is cut in planes of one depth, at most MID. Where the tool is narrower than the slot it goes
once around in each plane, and covers the slot if it is as wide as half of it at least; where it is
as wide, as LONGHOLE's always is, to the other end. Roughing leaves FAL at the edge and _FALD at the
floor; what is left is finished in planes of MIDF, or at once. A slot begins at RAD: four of 30 by
15 mm at a radius of 20 mm, a usual example, would meet in the middle else. That of SLOT2 has its
middle there, and AFSL is the angle between the middles of its round ends. Names and order of the
arguments: Siemens, SINUMERIK 840D sl/828D, Programming Manual Cycles. Where a control goes down
and how it goes on to the next slot is not told there: here at the begin of each, over SDIS.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import cos, radians, sin

from autodb.nc.reading.cycles.cycle_moves import (
    SAME_MM,
    Carrying,
    go_along,
    known_start,
    rapid_to,
)
from autodb.nc.reading.cycles.sinumerik_pockets import (
    CLOCKWISE,
    MOST_RINGS,
    WRITE_OUT,
    feed_of_cycle,
    planes_between,
    tool_radius_mm,
)
from autodb.nc.reading.lines.blocks import ProgramBlock
from autodb.nc.reading.paths import Feed, Revolutions, Speed
from autodb.nc.reading.state import speed_in_force
from autodb.nc.reading.travels import Circle, ToolPlace

_LEVELS = ("RTP", "RFP", "SDIS", "DP", "DPR", "NUM")
_RING = ("CPA", "CPO", "RAD", "STA1", "INDA", "FFD", "FFP1", "MID")
_FINISH = ("CDIR", "FAL", "VARI", "MIDF", "FFP2", "SSF")
SLOTS = {
    "SLOT1": (*_LEVELS, "LENG", "WID", *_RING, *_FINISH, "_FALD", "_STA2"),
    "SLOT2": (*_LEVELS, "AFSL", "WID", *_RING, *_FINISH, "_FFCP"),
    "LONGHOLE": (*_LEVELS, "LENG", *_RING),
}
"""Arguments of each cycle by name, in their order."""
_WHOLE, _ROUGHS, _FINISHES = range(3)
_STRAIGHT = 1
_Place = tuple[float, float]


@dataclass(frozen=True)
class _Leg:
    """A straight leg to a place, or an arc about a centre, to the left or not."""

    end: _Place
    centre: _Place | None = None
    left: bool = True


@dataclass(frozen=True)
class _Path:
    """Where the tool's centre goes in a plane; ``closed``: it ends where it begins."""

    begin: _Place
    legs: Sequence[_Leg]
    closed: bool

    def reversed(self) -> "_Path":
        """Return the way back."""
        places = [self.begin, *(leg.end for leg in self.legs)]
        back = [
            _Leg(place, leg.centre, not leg.left)
            for place, leg in zip(places[:-1], self.legs, strict=True)
        ]
        return _Path(places[-1], back[::-1], self.closed)


@dataclass(frozen=True)
class _Pass:
    """One way of cutting a slot: ``wall_mm`` and ``levels`` (downwards) that it leaves, its feed
    and speed.
    """

    wall_mm: float
    levels: Sequence[float]
    feed: Feed
    speed: Speed


def mill_sinumerik_slots(
    m: Carrying, name: str, numbers: Sequence[float | None], block: ProgramBlock
) -> None:
    """Mill slots by SLOT1, SLOT2 or LONGHOLE; raises UnusableInput where they are not read, or the
    tool does not fit.

    ``numbers``: the call's arguments in order, mm, mm/min and degrees, None where left out.
    """
    state, names = m.state, SLOTS[name]
    given = dict(zip(names, numbers, strict=False))
    said = {key: given.get(key) or 0.0 for key in names}
    _refuse_others(m, name, numbers, said, block)
    known_start(m, block)
    unit, shift = state.unit_mm, state.shift["z"]
    top = said["RFP"] * unit
    bottom = top - abs(said["DPR"]) * unit if said["DPR"] else said["DP"] * unit
    if given.get("DP") is None and not said["DPR"]:
        raise block.refusal(name, "the depth is missing; state DP or DPR")
    radius = tool_radius_mm(m, block)
    wide = 2.0 * radius if name == "LONGHOLE" else said["WID"] * unit
    if not radius - SAME_MM <= 0.5 * wide <= 2.0 * radius + SAME_MM:
        raise block.refusal(
            name,
            f"a tool of radius {radius:g} mm is not between a quarter and half of this slot's "
            "width; use one that is",
        )
    over, back = top + abs(said["SDIS"]) * unit + shift, said["RTP"] * unit + shift
    down = feed_of_cycle(m, said["FFD"] * unit, block)
    straight = int(said.get("VARI", 0.0)) // 10 == _STRAIGHT or said["FFD"] > 0.0
    clockwise = CLOCKWISE[int(said.get("CDIR", 0.0))]
    passes = list(_passes(m, name, said, block, (top, bottom)))
    rapid_to(m, block, z=max(back, state.known("z")))
    for turn in _turns(said):
        for one in passes:
            path = _path(m, name, said, turn, (wide, 0.5 * wide - one.wall_mm - radius))
            path = path.reversed() if clockwise else path
            rapid_to(m, block, x=path.begin[0], y=path.begin[1])
            rapid_to(m, block, z=over)
            for level in one.levels:
                x, y = path.begin
                go_along(m, block, ToolPlace(x, y, level), down if straight else None, one.speed)
                for leg in path.legs:
                    circle = None if leg.centre is None else Circle("G17", leg.centre, leg.left)
                    go_along(
                        m, block, ToolPlace(*leg.end, level), one.feed, one.speed, circle=circle
                    )
                path = path if path.closed else path.reversed()
            rapid_to(m, block, z=over)
    rapid_to(m, block, z=back)


def _refuse_others(
    m: Carrying,
    name: str,
    numbers: Sequence[float | None],
    said: dict[str, float],
    block: ProgramBlock,
) -> None:
    """Raise UnusableInput for what of slots is not read."""
    kind, enters = int(said.get("VARI", 0.0)) % 10, int(said.get("VARI", 0.0)) // 10
    count, angle = said["NUM"], said.get("AFSL", 1.0)
    why = None
    if any(numbers[len(SLOTS[name]) :]):
        why = f"more than {len(SLOTS[name])} arguments are not read"
    elif kind > _FINISHES or enters > _STRAIGHT:
        why = "VARI is not read; use 0, 1 or 2 in its last digit and 0 or 1 before it"
    elif said.get("CDIR", 0.0) not in CLOCKWISE:
        why = "CDIR is not read; use 0 to 3"
    elif m.state.plane != "G17" or m.state.turned is not None:
        why = "slots are read in G17, and not in a turned plane"
    elif not (count >= 1.0 and count == int(count) and count <= MOST_RINGS):
        why = "NUM is not a number of slots; state a whole one from 1 on"
    elif not 0.0 < angle < 360.0:
        why = "AFSL is between 0 and 360; state it so"
    if why is not None:
        raise block.refusal(name, f"{why}; {WRITE_OUT}")


def _turns(said: dict[str, float]) -> Iterator[float]:
    """Yield the angle of each slot, rad."""
    count = int(said["NUM"])
    step = said["INDA"] or 360.0 / count
    yield from (radians(said["STA1"] + step * k) for k in range(count))


def _passes(
    m: Carrying,
    name: str,
    said: dict[str, float],
    block: ProgramBlock,
    ends: tuple[float, float],
) -> Iterator[_Pass]:
    """Yield how a slot between two levels is cut: roughed, finished, or both where any is left."""
    unit, kind = m.state.unit_mm, int(said.get("VARI", 0.0)) % 10
    wall, floor = (abs(said.get(key, 0.0)) * unit for key in ("FAL", "_FALD"))
    feed, speed = feed_of_cycle(m, said["FFP1"] * unit, block), speed_in_force(m.state, block)
    top, bottom = ends
    if kind != _FINISHES:
        rough = planes_between(m, name, block, (top, bottom + floor), said["MID"] * unit)
        yield _Pass(wall, rough, feed, speed)
    if kind == _FINISHES or (kind == _WHOLE and wall + floor > 0.0):
        fine = planes_between(m, name, block, (top, bottom), said["MIDF"] * unit)
        finely = feed_of_cycle(m, said["FFP2"] * unit, block) if said["FFP2"] > 0.0 else feed
        yield _Pass(0.0, fine, finely, Revolutions(said["SSF"]) if said["SSF"] > 0.0 else speed)


def _path(
    m: Carrying, name: str, said: dict[str, float], turn: float, sizes: tuple[float, float]
) -> _Path:
    """Return the tool's path in a slot, against the clock.

    ``sizes``: the slot's width, and how far beside its middle line the path is; 0: along it.
    """
    wide, beside = sizes
    unit, shift = m.state.unit_mm, m.state.shift
    x, y = said["CPA"] * unit + shift["x"], said["CPO"] * unit + shift["y"]
    out = said["RAD"] * unit

    def at(angle: float, far: float, left: float = 0.0) -> _Place:
        c, s = cos(angle), sin(angle)
        return x + c * far - s * left, y + s * far + c * left

    if name == "SLOT2":
        end, middle = turn + radians(said["AFSL"]), (x, y)
        first, last = at(turn, out), at(end, out)
        if beside <= SAME_MM:
            return _Path(first, [_Leg(last, middle)], closed=False)
        return _Path(
            at(turn, out + beside),
            [
                _Leg(at(end, out + beside), middle),
                _Leg(at(end, out - beside), last),
                _Leg(at(turn, out - beside), middle, left=False),
                _Leg(at(turn, out + beside), first),
            ],
            closed=True,
        )
    near, far = out + 0.5 * wide, out + said["LENG"] * unit - 0.5 * wide
    if beside <= SAME_MM:
        return _Path(at(turn, near), [_Leg(at(turn, far))], closed=False)
    return _Path(
        at(turn, near, -beside),
        [
            _Leg(at(turn, far, -beside)),
            _Leg(at(turn, far, beside), at(turn, far)),
            _Leg(at(turn, near, beside)),
            _Leg(at(turn, near, -beside), at(turn, near)),
        ],
        closed=True,
    )
