"""Motion of the tool tip: where a block's coordinates lead, and by which move.

X may count diameters, U, V and W (or all, after G91) count from where the tip is. An arc has R, the
radius (negative above 180°), or I, J and K, where the centre lies from the start, or after G90.1 in
the program's coordinates. A lathe's plane is seen with z to the right and x up: G2 turns with the
clock, as on a lathe whose tool is behind the work; programs for one in front of it read the same.
"""

from collections.abc import Mapping
from math import atan2, cos, hypot, radians, sin, sqrt, tan

from autodb.nc.reading.blocks import ProgramBlock, Word
from autodb.nc.reading.controls import FANUC_A, LINUXCNC
from autodb.nc.reading.corners import CORNERS
from autodb.nc.reading.paths import Feed, FeedPerMinute, PerRev
from autodb.nc.reading.state import (
    AXES,
    Places,
    ProgramState,
    feed_in_force,
    speed_in_force,
    word_value,
)
from autodb.nc.reading.travels import PLANES, Circle, ProgramMove, Record, ToolPlace

OFF_CIRCLE_MM = 0.01
"""How far rounding may put the end of an arc off its circle. Chosen: ten steps of a thousandth."""
OFF_CIRCLE_SHARE = 1e-3
"""The same as a share of the radius, as LinuxCNC allows."""
LETTERS = {"x": ("X", "U"), "y": ("Y", "V"), "z": ("Z", "W")}
CENTRES = ("I", "J", "K")
RADIUS = ("R", "CR")
ROTARY = ("A", "B", "C")
_FLAT = 1e-9
_DECIMALS = 9
"""Places are rounded to these decimals of a mm: sums of increments meet absolute words again."""
_NUMBERS = ("N", "O")
_BY_ITSELF = {
    "R": "a radius belongs to G2 or G3; write out a rounded corner as an arc",
    "C": "this is a chamfer or a rotary axis; write out a chamfer as a G1 move",
    "A": "this states a direction by its angle; state the end by X and Z",
    "B": "this turns a rotary axis; only moves of X, Y and Z are read",
    "Y": "only moves of X and Z are read",
    "V": "only moves of X and Z are read",
}


def without(values: Mapping[str, Word], *letters: str) -> dict[str, Word]:
    """Return the values but those of some letters."""
    return {letter: word for letter, word in values.items() if letter not in letters}


def nothing_left(values: Mapping[str, Word], block: ProgramBlock, state: ProgramState) -> None:
    """Raise UnusableInput naming the first value that nothing has taken; N and O number only."""
    for letter, word in without(values, *_NUMBERS).items():
        why = _BY_ITSELF.get(letter, f"nothing in this block takes it (in force: {state.motion})")
        raise block.refusal(word.text, f"{why}; leave it out")


def targets(state: ProgramState, values: Mapping[str, Word], block: ProgramBlock) -> Places:
    """Return where each axis goes, mm; where it is if the block does not name it."""
    found: Places = {}
    for axis in AXES:
        found[axis] = _target(state, axis, values, block)
    if "@" in values or "^" in values:
        found |= _polar(state, values, block)
    return found


def _target(
    state: ProgramState, axis: str, values: Mapping[str, Word], block: ProgramBlock
) -> float | None:
    place, step = (values.get(letter) for letter in LETTERS[axis])
    before = state.place[axis]
    if place is None and step is None:
        return before
    if axis == "y" and state.lathe:
        raise block.refusal((place or step).text, _BY_ITSELF["Y"])  # type: ignore[union-attr]
    if step is not None and not (state.lathe and state.control in (FANUC_A,)):
        if state.control is not FANUC_A and not state.lathe:
            raise block.refusal(step.text, "this moves another axis; only X, Y and Z are read")
        raise block.refusal(
            step.text,
            "this is an increment of G-code system A, and other words of this program belong to "
            "other systems; use U and W with G98 and G99, or G91",
        )
    if place is not None and step is not None:
        raise block.refusal(step.text, f"'{place.text}' moves this axis too; use one of them")
    word = place or step
    assert word is not None
    counts = word.step if word.step is not None else word is step or not state.absolute
    if not counts:
        return round(state.factor(axis) * word_value(word) + state.shift[axis], _DECIMALS)
    if before is None:
        raise block.refusal(
            word.text,
            f"this is an increment from an unknown place; state {axis.upper()} in a G0 before it",
        )
    return round(before + state.factor(axis, step=True) * word_value(word), _DECIMALS)


def carry_out_motion(
    state: ProgramState, values: Mapping[str, Word], block: ProgramBlock, record: Record
) -> None:
    """Carry out the motion in force where the block has coordinates, and keep its move."""
    rest = without(values, *_NUMBERS)
    if not rest:
        return
    if state.motion is None:
        word = next(iter(rest.values()))
        raise block.refusal(word.text, "no motion is in force; use G0, G1, G2 or G3")
    to = targets(state, rest, block)
    rest = without(rest, "@", "^", *(letter for pair in LETTERS.values() for letter in pair))
    rest = _still_rotary(rest)
    match state.motion:
        case "G0":
            nothing_left(rest, block, state)
            go_rapid(state, to, block, record)
        case "G1":
            to, rest = _by_angle(state, to, rest, values)
            corner, rest = _corner(state, rest)
            nothing_left(rest, block, state)
            feed_straight(state, to, block, record, corner=corner)
        case "G33":
            _thread(state, to, rest, block, record)
        case _:
            _arc(state, to, rest, block, record)


def _corner(
    state: ProgramState, rest: dict[str, Word]
) -> tuple[tuple[str, float, str] | None, dict[str, Word]]:
    """Return the corner that a straight move states, and the words that are left."""
    name = next((one for one in CORNERS if one in rest), None)
    plain = name in ("R", "C")
    if name is None or (plain and not (state.lathe and state.control.system)):
        return None, rest
    size = abs(word_value(rest[name])) * state.unit_mm
    return (CORNERS[name], size, state.plane), without(rest, name)


def _by_angle(
    state: ProgramState, to: Places, rest: dict[str, Word], values: Mapping[str, Word]
) -> tuple[Places, dict[str, Word]]:
    """Return where a lathe's line at an angle A goes, of which X or Z is stated."""
    word = rest.get("A", rest.get(",A", rest.get("ANG")))
    stated = [axis for axis in ("x", "z") if values.keys() & set(LETTERS[axis])]
    here = state.place
    known = here["x"] is not None and here["z"] is not None
    if word is None or not state.lathe or not known or not stated:
        return to, rest
    slope = tan(radians(word_value(word)))
    if stated == ["z"]:
        across = ((to["z"] or 0.0) - (here["z"] or 0.0)) * slope
        to = {**to, "x": round((here["x"] or 0.0) + across, _DECIMALS)}
    elif stated == ["x"] and abs(slope) > _FLAT:
        along = ((to["x"] or 0.0) - (here["x"] or 0.0)) / slope
        to = {**to, "z": round((here["z"] or 0.0) + along, _DECIMALS)}
    return to, without(rest, "A", ",A", "ANG")


def _polar(state: ProgramState, values: Mapping[str, Word], block: ProgramBlock) -> Places:
    """Return X and Y of LinuxCNC's polar words: @ the radius, ^ the angle; the other as it is."""
    if state.place["x"] is None or state.place["y"] is None:
        raise block.refusal("@", "the start is not known; state X and Y in a G0 before it")
    x, y = (state.known(axis) - state.shift[axis] for axis in "xy")
    radius, angle = hypot(x, y), atan2(y, x)
    if "@" in values:
        said = word_value(values["@"]) * state.unit_mm
        radius = said if state.absolute else radius + said
    if "^" in values:
        said = radians(word_value(values["^"]))
        angle = said if state.absolute else angle + said
    return {
        "x": round(radius * cos(angle) + state.shift["x"], _DECIMALS),
        "y": round(radius * sin(angle) + state.shift["y"], _DECIMALS),
    }


def _still_rotary(values: dict[str, Word]) -> dict[str, Word]:
    """Return the values without rotary axes that go to 0, where they are."""
    return {n: w for n, w in values.items() if not (n in ROTARY and w.number == 0.0)}


def go_rapid(state: ProgramState, to: Places, block: ProgramBlock, record: Record) -> None:
    """Go to a place fast; no move is kept until both its ends are known."""
    start = {**state.place}
    state.place.update(to)
    if None in start.values() or None in to.values() or start == to:
        return
    record(ProgramMove(_place(start), _place(to), None, None, block.line, state.tool))


def feed_straight(
    state: ProgramState,
    to: Places,
    block: ProgramBlock,
    record: Record,
    *,
    feed: Feed | None = None,
    thread: bool = False,
    corner: tuple[str, float, str] | None = None,
) -> None:
    """Go straight to a place at a feed, that in force where none is given."""
    start, end = ends(state, to, block)
    if state.control is LINUXCNC and state.lathe and not state.diameter_said:
        counts = "diameters" if state.diameter else "radii"
        state.note(f"neither G7 nor G8 says what X counts: taken as {counts}")
    state.place.update(to)
    rate = _feed(state, block, start, end) if feed is None else feed
    speed = speed_in_force(state, block)
    if start != end:
        record(ProgramMove(start, end, rate, speed, block.line, state.tool, None, thread, corner))


def _feed(state: ProgramState, block: ProgramBlock, start: ToolPlace, end: ToolPlace) -> Feed:
    rate = feed_in_force(state, block)
    if state.feed_word != "G93":
        return rate
    length_mm = ProgramMove(start, end, None, None, block.line, None).length_mm
    return FeedPerMinute(max(length_mm, 1e-9) * rate.mm / state.unit_mm)


def _thread(
    state: ProgramState, to: Places, rest: Mapping[str, Word], block: ProgramBlock, record: Record
) -> None:
    """Cut a thread in one pass (G32, G33): F, or K and I, its pitch."""
    leads = [word_value(rest[name]) for name in ("K", "I", "J") if name in rest]
    nothing_left(without(rest, "K", "I", "J", "SF", "Q", "L", "M", "E"), block, state)
    pitch_mm = max(map(abs, leads)) * state.unit_mm if leads else state.feed or 0.0
    if pitch_mm <= 0:
        raise block.refusal(block.words[0].text, "a thread without a pitch; state F or K")
    feed_straight(state, to, block, record, feed=PerRev(pitch_mm), thread=True)


def ends(state: ProgramState, to: Places, block: ProgramBlock) -> tuple[ToolPlace, ToolPlace]:
    """Return start and end; raises UnusableInput naming the axis whose place is not known."""
    for axis in AXES:
        if state.place[axis] is None and state.control is LINUXCNC:
            state.note(f"nothing says where {axis.upper()} is before line {block.line}: taken as 0")
            state.place[axis] = 0.0
            to[axis] = 0.0 if to[axis] is None else to[axis]
        if state.place[axis] is None:
            state.place.update(to)
            raise block.refusal(
                state.motion or block.words[0].text,
                f"the start is not known in {axis.upper()} (nothing states it, or a tool, an "
                "offset or a machine position came after); state it in a G0 before it",
            )
    return _place(state.place), _place(to)


def _place(places: Places) -> ToolPlace:
    x, y, z = (places[axis] for axis in AXES)
    assert x is not None and y is not None and z is not None
    return ToolPlace(x, y, z)


def _arc(
    state: ProgramState, to: Places, rest: Mapping[str, Word], block: ProgramBlock, record: Record
) -> None:
    start, end = ends(state, to, block)
    state.place.update(to)
    left = state.motion == "G3"
    plane = state.plane
    if state.lathe and plane != "G18":
        raise block.refusal(plane, "this selects another plane than that of X and Z; use G18")
    centre = _centre(state, (start, end), rest, block, left=left)
    turns = int(word_value(rest["TURN"])) if "TURN" in rest else 0
    if "P" in rest and not state.lathe:
        turns = max(int(word_value(rest["P"])) - 1, 0)
    nothing_left(without(rest, *CENTRES, *RADIUS, "TURN", "P", "F"), block, state)
    feed, speed = feed_in_force(state, block), speed_in_force(state, block)
    arc = ProgramMove(
        start, end, feed, speed, block.line, state.tool, Circle(plane, centre, left, turns)
    )
    if state.feed_word == "G93":
        feed = FeedPerMinute(arc.length_mm * feed.mm / state.unit_mm)
        arc = ProgramMove(start, end, feed, speed, block.line, state.tool, arc.circle)
    record(arc)


def _centre(
    state: ProgramState,
    places: tuple[ToolPlace, ToolPlace],
    rest: Mapping[str, Word],
    block: ProgramBlock,
    *,
    left: bool,
) -> tuple[float, float]:
    """Return an arc's centre in its plane by R, or by the two of I, J and K in the plane."""
    start, end = places
    u, v, _ = PLANES[state.plane]
    radius = next((rest[name] for name in RADIUS if name in rest), None)
    names = [CENTRES[u], CENTRES[v]]
    offsets = [rest[name] for name in names if name in rest]
    if (radius is None) == (not offsets):
        word = offsets[0].text if offsets else state.motion or ""
        raise block.refusal(word, f"state an arc with either R, or {' and '.join(sorted(names))}")
    if radius is not None:
        size = state.unit_mm * word_value(radius)
        found = centre_by_radius((start[u], start[v]), (end[u], end[v]), radius_mm=size, left=left)
        return found or _no_radius(radius, (start, end), (u, v), block)
    centre = tuple(_offset(state, rest.get(CENTRES[k]), AXES[k], start[k]) for k in (u, v))
    if (start[u], start[v]) == centre:
        raise block.refusal(
            offsets[0].text, "the arc's centre is its start; use an I or K other than 0"
        )
    off_mm = abs(
        hypot(end[u] - centre[0], end[v] - centre[1])
        - hypot(start[u] - centre[0], start[v] - centre[1])
    )
    radius_mm = hypot(start[u] - centre[0], start[v] - centre[1])
    if off_mm > max(OFF_CIRCLE_MM, OFF_CIRCLE_SHARE * radius_mm):
        raise block.refusal(
            offsets[0].text,
            f"the arc's end is {off_mm:.3f} mm off its circle; correct it to within "
            f"{OFF_CIRCLE_MM:g} mm",
        )
    return centre[0], centre[1]


def _offset(state: ProgramState, word: Word | None, axis: str, start_mm: float) -> float:
    """Return where a centre lies along an axis; I of a lathe counts a radius from the start."""
    if word is None:
        return start_mm
    if word.step is False or (state.centre_absolute and word.step is None):
        return state.factor(axis) * word_value(word) + state.shift[axis]
    return start_mm + state.unit_mm * word_value(word)


def centre_by_radius(
    start: tuple[float, float], end: tuple[float, float], *, radius_mm: float, left: bool
) -> tuple[float, float] | None:
    """Return the centre of the arc of a radius R over a chord, or None where none reaches.

    R > 0 takes the arc up to 180°, R < 0 the one above. With half chord l: the centre lies
    √(R² − l²) off the middle of the chord, to the left of it for a short arc to the left. None
    where start is end and where l exceeds |R| by more than OFF_CIRCLE_MM.
    """
    along_u, along_v = end[0] - start[0], end[1] - start[1]
    half_mm = hypot(along_u, along_v) / 2
    if half_mm == 0 or half_mm > abs(radius_mm) + OFF_CIRCLE_MM:
        return None
    off_mm = sqrt(max(radius_mm**2 - half_mm**2, 0.0))
    share = off_mm / (2 * half_mm) * (1 if left == (radius_mm > 0) else -1)
    return (start[0] + end[0]) / 2 - share * along_v, (start[1] + end[1]) / 2 + share * along_u


def _no_radius(
    word: Word, places: tuple[ToolPlace, ToolPlace], plane: tuple[int, int], block: ProgramBlock
) -> tuple[float, float]:
    (start, end), (u, v) = places, plane
    if (start[u], start[v]) == (end[u], end[v]):
        raise block.refusal(
            word.text, "the arc ends where it begins; program a full circle with I and K"
        )
    half_mm = hypot(end[u] - start[u], end[v] - start[v]) / 2
    raise block.refusal(
        word.text,
        "the radius is shorter than half the distance from start to end; use at least "
        f"{half_mm:.3f} mm",
    )
