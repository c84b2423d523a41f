"""Where the centre of an arc lies, by its radius or by I, J and K, and whether its end is on it."""

from collections.abc import Mapping
from math import hypot, sqrt

from autodb.nc.reading.blocks import ProgramBlock, Word
from autodb.nc.reading.controls import LINUXCNC, SINUMERIK
from autodb.nc.reading.state import AXES, ProgramState, word_value
from autodb.nc.reading.travels import PLANES, ToolPlace

OFF_CIRCLE_MM = 0.01
"""How far rounding may put the end of an arc off its circle. Chosen: ten steps of a thousandth."""
OFF_CIRCLE_SHARE = 1e-3
"""The same as a share of the radius, as LinuxCNC allows."""
SPIRAL_MM = 0.1
"""How far Fanuc's controls let an arc end off its circle, as a spiral. Chosen: their makers leave
it to a parameter, often to none at all; more is a slip of the program."""
CENTRES = ("I", "J", "K")
RADIUS = ("R", "CR")


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
