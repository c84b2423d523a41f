"""Motion of the tool tip: where a block's coordinates lead, and by which move.

X may count diameters, U and W (or all, after G91) count from where the tip is. An arc has R, the
radius (negative above 180°), or I and K, where the centre lies from the start, I as a radius.

The centre of an arc, from its radius or from where the centre lies.

The plane is seen with z to the right and x up: G2 turns with the clock, G3 against it, as on a
lathe whose tool is behind the work; programs for one in front of it read the same.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from math import hypot, sqrt

from autodb.nc.reading.blocks import ProgramBlock, Word
from autodb.nc.reading.modes import Modes, feed_in_force, speed_in_force
from autodb.nc.reading.paths import Arc, Linear, Move, Point, Rapid, distance_mm
from autodb.nc.reading.values import AXES, CENTRE, RADIUS, nothing_left, without, word_value

OFF_CIRCLE_MM = 0.01
"""How far rounding may put the end of an arc off its circle. Chosen: ten steps of a thousandth."""


def centre_by_radius(start: Point, end: Point, *, radius_mm: float, left: bool) -> Point | None:
    """Return the centre of the arc of a radius R over a chord, or None where none reaches.

    R > 0 takes the arc up to 180°, R < 0 the one above. With half chord l: the centre lies
    √(R² − l²) off the middle of the chord, to the left of it for a short arc to the left. None
    where start is end and where l exceeds |R| by more than OFF_CIRCLE_MM.
    """
    along_x, along_z = end.x_mm - start.x_mm, end.z_mm - start.z_mm
    half_mm = hypot(along_x, along_z) / 2
    if half_mm == 0 or half_mm > abs(radius_mm) + OFF_CIRCLE_MM:
        return None
    off_mm = sqrt(max(radius_mm**2 - half_mm**2, 0.0))
    share = off_mm / (2 * half_mm) * (1 if left == (radius_mm > 0) else -1)
    return Point(
        (start.x_mm + end.x_mm) / 2 + share * along_z,
        (start.z_mm + end.z_mm) / 2 - share * along_x,
    )


def off_circle_mm(start: Point, end: Point, centre: Point) -> float:
    """Return how far the end lies off the circle through the start, mm."""
    radius_mm = hypot(start.x_mm - centre.x_mm, start.z_mm - centre.z_mm)
    return abs(hypot(end.x_mm - centre.x_mm, end.z_mm - centre.z_mm) - radius_mm)


_DECIMALS = 9
"""Places are rounded to these decimals of a mm: sums of increments meet absolute words again."""


def carry_out_motion(
    modes: Modes, values: Mapping[str, Word], block: ProgramBlock, moves: list[Move]
) -> Modes:
    """Carry out the motion in force where the block has coordinates, and append its move."""
    if not values:
        return modes
    axes = {letter: word for letter, word in values.items() if letter in AXES}
    x_mm = _target(modes, axes, ("X", "U"), block)
    z_mm = _target(modes, axes, ("Z", "W"), block)
    if modes.motion is None:
        word = next(iter(values.values()))
        raise block.refusal(word.text, "no motion is in force; use G0, G1, G2 or G3")
    rest = without(values, *AXES)
    _MOTIONS[modes.motion](modes, (x_mm, z_mm), rest, block, moves)
    return replace(modes, x_mm=x_mm, z_mm=z_mm)


def _target(
    modes: Modes, axes: Mapping[str, Word], letters: tuple[str, str], block: ProgramBlock
) -> float | None:
    """Return where an axis goes, mm; where it is if the block does not name it."""
    place, step = (axes.get(letter) for letter in letters)
    before = modes.x_mm if letters[0] == "X" else modes.z_mm
    factor = modes.x_factor if letters[0] == "X" else modes.unit_mm
    if place is not None and step is not None:
        raise block.refusal(step.text, f"'{place.text}' moves this axis too; use one of them")
    word = place or step
    if word is None:
        return before
    if word is place and modes.absolute:
        return round(factor * word_value(word), _DECIMALS)
    if before is None:
        raise block.refusal(
            word.text,
            f"this is an increment from an unknown place; state {letters[0]} in a G0 before it",
        )
    return round(before + factor * word_value(word), _DECIMALS)


_Target = tuple[float | None, float | None]
_Motion = Callable[[Modes, _Target, Mapping[str, Word], ProgramBlock, list[Move]], None]


def _rapid(
    modes: Modes, to: _Target, rest: Mapping[str, Word], block: ProgramBlock, moves: list[Move]
) -> None:
    nothing_left(rest, block, modes)
    if None in (modes.x_mm, modes.z_mm, *to):
        return
    start, end = _ends(modes, to, block)
    if start != end:
        moves.append(Rapid(start, end, block.line, modes.tool))


def _linear(
    modes: Modes, to: _Target, rest: Mapping[str, Word], block: ProgramBlock, moves: list[Move]
) -> None:
    nothing_left(rest, block, modes)
    start, end = _ends(modes, to, block)
    feed, speed = feed_in_force(modes, block), speed_in_force(modes, block)
    if start != end:
        moves.append(Linear(start, end, feed, speed, block.line, modes.tool))


def _arc(
    modes: Modes,
    to: _Target,
    rest: Mapping[str, Word],
    block: ProgramBlock,
    moves: list[Move],
    *,
    left: bool,
) -> None:
    start, end = _ends(modes, to, block)
    centre = _centre(modes, (start, end), rest, block, left=left)
    nothing_left(without(rest, *CENTRE, *RADIUS), block, modes)
    feed, speed = feed_in_force(modes, block), speed_in_force(modes, block)
    moves.append(Arc(start, end, centre, left, feed, speed, block.line, modes.tool))


_MOTIONS: dict[str, _Motion] = {
    "G0": _rapid,
    "G1": _linear,
    "G2": partial(_arc, left=False),
    "G3": partial(_arc, left=True),
}


def _ends(modes: Modes, to: _Target, block: ProgramBlock) -> tuple[Point, Point]:
    """Return start and end; raises UnusableInput naming the axis whose place is not known."""
    x_mm, z_mm = to
    for name, before in (("X", modes.x_mm), ("Z", modes.z_mm)):
        if before is None:
            raise block.refusal(
                modes.motion or "",
                f"the start is not known in {name} (nothing states it, or a tool, an offset or "
                f"a machine position came after); state {name} in a G0 before it",
            )
    assert modes.x_mm is not None and modes.z_mm is not None
    assert x_mm is not None and z_mm is not None
    return Point(modes.x_mm, modes.z_mm), Point(x_mm, z_mm)


def _centre(
    modes: Modes,
    ends: tuple[Point, Point],
    rest: Mapping[str, Word],
    block: ProgramBlock,
    *,
    left: bool,
) -> Point:
    """Return an arc's centre by R, or by I and K: increments from the start, I as a radius."""
    radius = next((rest[name] for name in RADIUS if name in rest), None)
    offsets = [rest[name] for name in CENTRE if name in rest]
    if (radius is None) == (not offsets):
        word = offsets[0].text if offsets else modes.motion or ""
        raise block.refusal(word, "state an arc with either R, or I and K")
    if radius is not None:
        return _by_radius(ends, radius, modes.unit_mm * word_value(radius), block, left=left)
    i, k = (modes.unit_mm * word_value(rest[n]) if n in rest else 0.0 for n in CENTRE)
    start, end = ends
    centre = Point(start.x_mm + i, start.z_mm + k)
    if start == centre:
        raise block.refusal(
            offsets[0].text, "the arc's centre is its start; use an I or K other than 0"
        )
    off_mm = off_circle_mm(start, end, centre)
    if off_mm > OFF_CIRCLE_MM:
        raise block.refusal(
            offsets[0].text,
            f"the arc's end is {off_mm:.3f} mm off its circle; correct it to within "
            f"{OFF_CIRCLE_MM:g} mm",
        )
    return centre


def _by_radius(
    ends: tuple[Point, Point], word: Word, radius_mm: float, block: ProgramBlock, *, left: bool
) -> Point:
    start, end = ends
    centre = centre_by_radius(start, end, radius_mm=radius_mm, left=left)
    if centre is not None:
        return centre
    if start == end:
        raise block.refusal(
            word.text, "the arc ends where it begins; program a full circle with I and K"
        )
    half_mm = distance_mm(start, end) / 2
    raise block.refusal(
        word.text,
        "the radius is shorter than half the distance from start to end; use at least "
        f"{half_mm:.3f} mm",
    )
