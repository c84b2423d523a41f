"""Motion of the tool tip: where a block's coordinates lead, and by which move.

X may count diameters, U, V and W (or all, after G91) count from where the tip is. An arc has R, the
radius (negative above 180°), or I, J and K, where the centre lies from the start, or after G90.1 in
the program's coordinates. A lathe's plane is seen with z to the right and x up: G2 turns with the
clock, as on a lathe whose tool is behind the work; programs for one in front of it read the same.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import radians, tan

from autodb.errors import UnusableInput
from autodb.nc.reading.codes import REFUSED
from autodb.nc.reading.controls import FANUC_A, LINUXCNC, OKUMA
from autodb.nc.reading.corners import CORNERS, PROFILE_CORNERS
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.paths import Feed, FeedPerMinute, PerRev
from autodb.nc.reading.state import (
    AXES,
    Places,
    ProgramState,
    feed_in_force,
    speed_in_force,
    word_value,
)
from autodb.nc.reading.targets import (
    CENTRES,
    DECIMALS,
    DRIVEN,
    LETTERS,
    ONLY_X_AND_Z,
    RADIUS,
    arc_centre,
    by_opening,
    targets,
    without,
)
from autodb.nc.reading.travels import Circle, ProgramMove, Record, ToolPlace

ROTARY = ("A", "B", "C")
TURNS_ROTARY = (
    "this turns a rotary axis; only moves of X, Y and Z are read: state the angle to look at as "
    "angles in the job, or give what is cut at each as a program of its own"
)
_FLAT = 1e-9
_NUMBERS = ("N", "O")
_OF_DRIVEN = frozenset("BCYV")
_BY_ITSELF = {
    "R": "a radius belongs to G2 or G3; write out a rounded corner as an arc",
    "C": "this is a chamfer or a rotary axis; write out a chamfer as a G1 move",
    "A": "this states a direction by its angle; state the end by X and Z",
    "B": "this turns a rotary axis or moves a second spindle; only moves of X, Y and Z are read",
    "Y": ONLY_X_AND_Z,
    "V": ONLY_X_AND_Z,
}


def nothing_left(values: Mapping[str, Word], block: ProgramBlock, state: ProgramState) -> None:
    """Raise UnusableInput naming the first value that nothing has taken; N and O number only."""
    for letter, word in without(values, *_NUMBERS).items():
        if letter in ROTARY and (not state.lathe or state.control is LINUXCNC):
            raise block.refusal(word.text, TURNS_ROTARY)
        why = _BY_ITSELF.get(letter, f"nothing in this block takes it (in force: {state.motion})")
        ends = DRIVEN if state.lathe and letter in _OF_DRIVEN else ""
        raise block.refusal(word.text, f"{why}; leave it out{ends}")


def word_not_read(word: Word, block: ProgramBlock, state: ProgramState) -> UnusableInput:
    """Return the error of a word that is not read, with its reason and remedy."""
    if word.code in REFUSED:
        return block.refusal(word.text, REFUSED[word.code])
    if word.code in ("G98", "G99") and state.control is not FANUC_A:
        return block.refusal(word.text, "this belongs to G-code system A; use G94 and G95 here")
    if word.code in ("G90", "G91", "G95") and state.control is FANUC_A:
        return block.refusal(
            word.text,
            "this belongs to the G-code systems B and C, other words of this program to A; use U, "
            "W, G98, G99 alone, or G90, G91, G94, G95 alone",
        )
    why = {
        "G": "this G is not read; write out the moves of a cycle as G0, G1, G2 and G3",
        "M": "this M is not read; leave it out if it moves no axis and calls nothing",
    }
    return block.refusal(
        word.text, why.get(word.name, "this is not read; write out moves as G0, G1, G2 and G3")
    )


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
            corner, rest = _corner(state, _chamfer_named(state, rest, values))
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
    kinds = PROFILE_CORNERS if state.in_profile else CORNERS
    name = next((one for one in kinds if one in rest), None)
    plain = name in ("R", "C") and not state.in_profile
    if name is None or (plain and not (state.lathe and state.control.system)):
        return None, rest
    size = abs(word_value(rest[name])) * state.unit_mm
    return (kinds[name], size, state.plane), without(rest, name)


def _chamfer_named(
    state: ProgramState, rest: dict[str, Word], values: Mapping[str, Word]
) -> dict[str, Word]:
    """Return the words with a chamfer of Fanuc's lathes as C: X with K, Z with I.

    The other axis follows; the sign only says to which side (Series 0i-TD, operator's manual
    B-64304EN-1, chamfering and corner R; Haas' lathes the same).
    """
    if not (state.lathe and state.control.system):
        return rest
    for letter, own, other in (("K", "x", "z"), ("I", "z", "x")):
        alone = values.keys() & set(LETTERS[own]) and not values.keys() & set(LETTERS[other])
        if letter in rest and alone:
            return {**without(rest, letter), "C": rest[letter]}
    return rest


def _by_angle(
    state: ProgramState, to: Places, rest: dict[str, Word], values: Mapping[str, Word]
) -> tuple[Places, dict[str, Word]]:
    """Return where a lathe's line at an angle A goes, of which X or Z is stated."""
    word = rest.get("A", rest.get(",A", rest.get("ANG")))
    stated = [axis for axis in ("x", "z") if values.keys() & set(LETTERS[axis])]
    here = state.place
    known = here["x"] is not None and here["z"] is not None
    if word is None or not state.lathe or state.control is LINUXCNC or not known or not stated:
        return to, rest
    slope = tan(radians(word_value(word)))
    if stated == ["z"]:
        across = ((to["z"] or 0.0) - (here["z"] or 0.0)) * slope
        to = {**to, "x": round((here["x"] or 0.0) + across, DECIMALS)}
    elif stated == ["x"] and abs(slope) > _FLAT:
        along = ((to["x"] or 0.0) - (here["x"] or 0.0)) / slope
        to = {**to, "z": round((here["z"] or 0.0) + along, DECIMALS)}
    return to, without(rest, "A", ",A", "ANG")


def _still_rotary(values: dict[str, Word]) -> dict[str, Word]:
    """Return the values without rotary axes that go to 0, where they are."""
    return {n: w for n, w in values.items() if not (n in ROTARY and w.number == 0.0)}


def go_rapid(state: ProgramState, to: Places, block: ProgramBlock, record: Record) -> None:
    """Go to a place fast; no move is kept until both its ends are known."""
    start = {**state.place}
    state.place.update(to)
    if None in start.values() or None in to.values() or start == to:
        return
    record(
        ProgramMove(
            _place(start), _place(to), None, None, block.line, state.tool, beside=state.beside
        )
    )


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
    """Go straight to a place at a feed, that in force where none is given.

    A way that nothing says the begin of, to a place that is stated, is none of a cut: not kept; nor
    is one with the spindle stopped.
    """
    if _comes_from_outside(state, to, block) or _only_handles(state, block):
        state.place.update(to)
        return
    start, end = ends(state, to, block)
    if state.control is LINUXCNC and state.lathe and not state.diameter_said:
        counts = "diameters" if state.diameter else "radii"
        state.note(f"neither G7 nor G8 says what X counts: taken as {counts}")
    state.place.update(to)
    rate = _feed(state, block, start, end) if feed is None else feed
    speed = speed_in_force(state, block)
    if start != end:
        record(
            ProgramMove(
                start, end, rate, speed, block.line, state.tool, None, thread, corner, state.beside
            )
        )


def _comes_from_outside(state: ProgramState, to: Places, block: ProgramBlock) -> bool:
    """Return whether a straight move begins where the machine is after a tool change or at home.

    So where it states the axes whose place is not known, or the height of a mill's tool is not.
    """
    unknown = [axis for axis in AXES if state.place[axis] is None]
    if not unknown or state.control is LINUXCNC:
        return False
    above = not state.lathe and "z" in unknown
    if not above and any(to[axis] is None for axis in unknown):
        return False
    names = " and ".join(axis.upper() for axis in unknown)
    state.note(
        f"line {block.line}: nothing says where {names} is before this move at a feed: taken "
        "through air, its time is not counted"
    )
    return True


def _only_handles(state: ProgramState, block: ProgramBlock) -> bool:
    """Return whether a lathe moves at a feed a minute with its spindle stopped: it pulls a bar."""
    handles = state.lathe and state.stopped is not None and state.feed_word == "G94"
    if handles:
        state.note(
            f"line {block.line}: the spindle stands since line {state.stopped}: moves at a feed a "
            "minute cut nothing and their time is not counted"
        )
    return handles


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


def _turned_centre(
    state: ProgramState, rest: Mapping[str, Word], block: ProgramBlock
) -> Mapping[str, Word]:
    """Return an arc's words with the way to its centre as it is in turned coordinates."""
    if state.turned is None or not rest.keys() & {"I", "J"}:
        return rest
    if state.centre_absolute or state.plane != "G17":
        raise block.refusal(
            state.plane, "turned coordinates are read in G17 with I and J counted from the start"
        )
    way = (word_value(rest[name]) if name in rest else 0.0 for name in ("I", "J"))
    turned = dict(zip(("I", "J"), state.turned.along(*way), strict=True))
    return {**rest, **{n: Word(n, f"{mm:.9g}", mm) for n, mm in turned.items()}}


def _arc(
    state: ProgramState, to: Places, rest: Mapping[str, Word], block: ProgramBlock, record: Record
) -> None:
    if state.control.system and not rest.keys() & {*CENTRES, *RADIUS}:
        state.note("arcs without R, I, J and K are straight lines, as Fanuc's controls take them")
        nothing_left(without(rest, "F"), block, state)
        feed_straight(state, to, block, record)
        return
    if state.control is OKUMA and "L" in rest:  # its radius
        rest = {**without(rest, "L"), "R": replace(rest["L"], name="R")}
    left, plane = state.motion == "G3", state.plane
    start, end = ends(state, to, block)
    words = _turned_centre(state, rest, block)
    end, rest = by_opening(state, (start, end), words, block, left=left)
    state.place.update(zip(AXES, end, strict=True))
    if state.lathe and plane != "G18":
        raise block.refusal(plane, "this selects another plane than that of X and Z; use G18")
    centre = arc_centre(state, (start, end), rest, block, left=left)
    turns = int(word_value(rest["TURN"])) if "TURN" in rest else 0
    if "P" in rest and not state.lathe:
        turns = max(int(word_value(rest["P"])) - 1, 0)
    nothing_left(without(rest, *CENTRES, *RADIUS, "TURN", "P", "F"), block, state)
    feed, speed = feed_in_force(state, block), speed_in_force(state, block)
    arc = ProgramMove(
        start, end, feed, speed, block.line, state.tool, Circle(plane, centre, left, turns),
        beside=state.beside,
    )  # fmt: skip
    if state.feed_word == "G93":
        arc = replace(arc, feed=FeedPerMinute(arc.length_mm * feed.mm / state.unit_mm))
    record(arc)
