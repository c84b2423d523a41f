"""Where a block's coordinates lead: absolute places, increments, polar and turned ones; and where
the centre of an arc lies, by its radius or by I, J and K, and whether its end is on it.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import atan2, cos, hypot, radians, sin, sqrt

from autodb.nc.reading.controls import FANUC_A, LINUXCNC, SINUMERIK
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.state import AXES, Places, PolarPlace, ProgramState, word_value
from autodb.nc.reading.travels import PLANES, ToolPlace

LETTERS = {"x": ("X", "U"), "y": ("Y", "V"), "z": ("Z", "W")}
DECIMALS = 9
"""Places are rounded to these decimals of a mm: sums of increments meet absolute words again."""
ONLY_X_AND_Z = "only moves of X and Z are read"
DRIVEN = ", or end the program before what driven tools cut by last_line in the job"
"""What is told of a lathe's words that turn its work to a place, or go beside its axis."""
OFF_CIRCLE_MM = 0.01
"""How far rounding may put the end of an arc off its circle. Chosen: ten steps of a thousandth."""
OFF_CIRCLE_SHARE = 1e-3
"""The same as a share of the radius, as LinuxCNC allows."""
SPIRAL_MM = 0.1
"""How far Fanuc's controls let an arc end off its circle, as a spiral. Chosen: their makers leave
it to a parameter, often to none at all; more is a slip of the program."""
_WHOLE = 1000.0
"""A place without a decimal point from which a note says how it was taken. Chosen: 1 m."""
CENTRES = ("I", "J", "K")
RADIUS = ("R", "CR")


def without(values: Mapping[str, Word], *letters: str) -> dict[str, Word]:
    """Return the values but those of some letters."""
    return {letter: word for letter, word in values.items() if letter not in letters}


def targets(state: ProgramState, values: Mapping[str, Word], block: ProgramBlock) -> Places:
    """Return where each axis goes, mm; where it is if the block does not name it."""
    if state.turned is None:
        return _targets(state, values, block)
    kept, turned = state.place, state.turned
    state.place = {**kept, **_in_plane(kept, lambda x, y: turned.placed(x, y, back=True))}
    try:
        found = _targets(state, values, block)
    finally:
        state.place = kept
    if (found["x"] is None) != (found["y"] is None):
        raise block.refusal(
            block.words[0].text, "turned coordinates begin at an unknown place; state X and Y"
        )
    return {**found, **_in_plane(found, turned.placed)}


def _in_plane(
    places: Places, changed: Callable[[float, float], tuple[float, float]]
) -> dict[str, float | None]:
    """Return X and Y of places as they are changed, None where they are not known."""
    x, y = places["x"], places["y"]
    if x is None or y is None:
        return {"x": x, "y": y}
    made = changed(x, y)
    return {"x": round(made[0], DECIMALS), "y": round(made[1], DECIMALS)}


def _targets(state: ProgramState, values: Mapping[str, Word], block: ProgramBlock) -> Places:
    if state.polar and ("X" in values or "Y" in values):
        rest = without(values, "X", "Y")
        return _targets_of_axes(state, rest, block) | _by_radius_and_angle(state, values, block)
    found = _targets_of_axes(state, values, block)
    if "@" in values or "^" in values:
        found |= _polar(state, values, block)
    return found


def _targets_of_axes(
    state: ProgramState, values: Mapping[str, Word], block: ProgramBlock
) -> Places:
    return {axis: _target(state, axis, values, block) for axis in AXES}


def _by_radius_and_angle(
    state: ProgramState, values: Mapping[str, Word], block: ProgramBlock
) -> Places:
    """Return X and Y of Fanuc's polar words in G16: X the radius, Y the angle in degrees.

    The pole is the program's zero; of a radius that is an increment, where the tool is.
    """
    if state.plane != "G17":
        raise block.refusal(state.plane, "polar coordinates are read in the plane of X and Y; G17")
    zero = state.shift["x"], state.shift["y"]
    said = state.polar_place or PolarPlace(zero)
    if "X" in values:
        pole = zero
        if _counts_on(state, values["X"]):
            if state.place["x"] is None or state.place["y"] is None:
                raise block.refusal(values["X"].text, "the pole is not known; state it in G90")
            pole = state.known("x"), state.known("y")
        said = replace(said, pole=pole, radius_mm=state.unit_mm * word_value(values["X"]))
    if "Y" in values:
        before = (said.angle_deg or 0.0) if _counts_on(state, values["Y"]) else 0.0
        said = replace(said, angle_deg=before + word_value(values["Y"]))
    if said.radius_mm is None or said.angle_deg is None:
        raise block.refusal("G16", "radius or angle is missing; state X and Y once")
    state.polar_place = said
    angle = radians(said.angle_deg)
    return {
        "x": round(said.pole[0] + said.radius_mm * cos(angle), DECIMALS),
        "y": round(said.pole[1] + said.radius_mm * sin(angle), DECIMALS),
    }


def _counts_on(state: ProgramState, word: Word) -> bool:
    """Return whether a word is an increment."""
    return not state.absolute if word.step is None else word.step


def _target(
    state: ProgramState, axis: str, values: Mapping[str, Word], block: ProgramBlock
) -> float | None:
    place, step = (values.get(letter) for letter in LETTERS[axis])
    before = state.place[axis]
    if place is None and step is None:
        return before
    if axis == "y" and state.lathe:
        said = place or step
        if said is not None and word_value(said) == 0.0:  # there it stands
            return before
        raise block.refusal(said.text if said else "Y", f"{ONLY_X_AND_Z}{DRIVEN}")
    of_a = state.lathe and state.control is FANUC_A
    if step is not None and not (of_a or state.in_profile):
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
    if abs(word_value(word)) >= _WHOLE and state.control.system and "." not in word.written:
        state.note(
            "places of 1000 and more without a decimal point are taken as they stand, not in "
            "thousandths as some controls count them"
        )
    counts = word.step if word.step is not None else word is step or not state.absolute
    if not counts:
        return round(state.factor(axis) * word_value(word) + state.shift[axis], DECIMALS)
    if before is None:
        raise block.refusal(
            word.text,
            f"this is an increment from an unknown place; state {axis.upper()} in a G0 before it",
        )
    return round(before + state.factor(axis, step=True) * word_value(word), DECIMALS)


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
        "x": round(radius * cos(angle) + state.shift["x"], DECIMALS),
        "y": round(radius * sin(angle) + state.shift["y"], DECIMALS),
    }


def by_opening(
    state: ProgramState,
    places: tuple[ToolPlace, ToolPlace],
    rest: Mapping[str, Word],
    block: ProgramBlock,
    *,
    left: bool,
) -> tuple[ToolPlace, Mapping[str, Word]]:
    """Return an arc's end and words without its opening angle AR, degrees.

    With an end AR says the radius: of a chord l it is l/(2 sin(AR/2)). With a centre it says the
    end: the start, turned about it.
    """
    start, end = places
    word = rest.get("AR")
    if word is None:
        return end, rest
    said, words = word_value(word), without(rest, "AR")
    if not 0.0 < said < 360.0:
        raise block.refusal(word.text, "use an angle between 0 and 360°")
    u, v, _ = PLANES[state.plane]
    if words.keys() & {CENTRES[u], CENTRES[v]}:
        if (start[u], start[v]) != (end[u], end[v]):
            raise block.refusal(word.text, "state AR with the arc's end or with its centre")
        cu, cv = (_offset(state, words.get(CENTRES[k]), AXES[k], start[k]) for k in (u, v))
        turn = radians(said if left else -said)
        du, dv = start[u] - cu, start[v] - cv
        made = list(end)
        made[u] = round(cu + du * cos(turn) - dv * sin(turn), DECIMALS)
        made[v] = round(cv + du * sin(turn) + dv * cos(turn), DECIMALS)
        return ToolPlace(*made), words
    chord = hypot(end[u] - start[u], end[v] - start[v])
    radius = chord / (2.0 * sin(radians(said) / 2.0)) / state.unit_mm
    radius *= -1.0 if said > 180.0 else 1.0
    return end, {**words, "CR": Word("CR", f"{radius:.9g}", radius)}


def arc_centre(
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
    allowed_mm = max(OFF_CIRCLE_MM, OFF_CIRCLE_SHARE * radius_mm)
    if allowed_mm < off_mm <= SPIRAL_MM and state.control not in (LINUXCNC, SINUMERIK):
        state.note(f"arcs that end up to {SPIRAL_MM:g} mm off their circles are taken as spirals")
    elif off_mm > allowed_mm:
        other = "" if state.centre_absolute else _as_places(state, places, rest)
        raise block.refusal(
            offsets[0].text,
            f"the arc's end is {off_mm:.3f} mm off its circle; correct it to within "
            f"{OFF_CIRCLE_MM:g} mm{other}",
        )
    return centre[0], centre[1]


def _as_places(
    state: ProgramState, places: tuple[ToolPlace, ToolPlace], rest: Mapping[str, Word]
) -> str:
    """Return the remedy of an arc whose I, J and K fit as places, nothing where they do not."""
    u, v, _ = PLANES[state.plane]
    at = [
        state.factor(AXES[k]) * word_value(rest[CENTRES[k]]) + state.shift[AXES[k]]
        for k in (u, v)
        if CENTRES[k] in rest
    ]
    if len(at) < 2:
        return ""
    far = [hypot(place[u] - at[0], place[v] - at[1]) for place in places]
    fits = min(far) > 0.0 and abs(far[1] - far[0]) <= OFF_CIRCLE_MM
    return ', or state centres = "places" in the job: as such they fit' if fits else ""


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
