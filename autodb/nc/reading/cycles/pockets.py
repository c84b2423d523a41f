"""Round pockets of Haas' mills: G12 with the clock, G13 against it.

The tool goes down in the middle at the feed to Z, by a half circle to the first circle, of radius
I, around it, and on by steps of Q to the last, of radius K, or around I alone; then back to the
middle by a half circle. I and K are of the pocket: the tool's centre goes its radius inside. In G91
Z is a step, and L says how often all of it is made.
"""

from collections.abc import Mapping

from autodb.nc.reading.cycles.cycle_moves import Carrying, feed_to, known_start
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.motions import nothing_left
from autodb.nc.reading.state import feed_in_force, speed_in_force, word_value
from autodb.nc.reading.targets import without
from autodb.nc.reading.travels import Circle, ProgramMove, ToolPlace

POCKETS = frozenset({"G12", "G13"})
MOST_CIRCLES = 2_000
"""Circles of one pocket. Chosen: more is a slip of Q."""
_SAME_MM = 1e-6


def mill_pocket(m: Carrying, code: str, values: Mapping[str, Word], block: ProgramBlock) -> None:
    """Mill a round pocket about where the tool is; raises UnusableInput where it does not fit."""
    state = m.state
    nothing_left(without(values, *"IKQZFDLN"), block, state)
    if "I" not in values or ("K" in values) != ("Q" in values):
        raise block.refusal(code, "state the radius I, or I, the last radius K and the step Q")
    if state.plane != "G17":
        raise block.refusal(state.plane, "a round pocket is read in G17; select it before")
    known_start(m, block)
    radii = _radii(m, code, values, block)
    step = "Z" in values and not state.absolute
    times = int(word_value(values["L"])) if "L" in values and step else 1
    for _ in range(times):
        if "Z" in values:
            said = state.unit_mm * word_value(values["Z"])
            feed_to(m, block, {"z": state.known("z") + said if step else said + state.shift["z"]})
        _circles(m, radii, block, left=code == "G13")


def _radii(m: Carrying, code: str, values: Mapping[str, Word], block: ProgramBlock) -> list[float]:
    """Return the radii of the circles that the tool's centre makes, mm."""
    state = m.state
    first, last, by = (
        state.unit_mm * abs(word_value(values[name])) if name in values else None for name in "IKQ"
    )
    assert first is not None
    place = ToolPlace(*known_start(m, block).values())
    if m.radius_of is None:
        raise block.refusal(code, "the tool's diameter is not known; state diameter_mm")
    inside = m.radius_of(ProgramMove(place, place, None, None, block.line, state.tool))
    found = [first]
    while last is not None and by is not None and last - found[-1] > _SAME_MM:
        if by <= 0.0 or len(found) > MOST_CIRCLES:
            raise block.refusal(values["Q"].text, "this step is too small; make it larger")
        found.append(min(found[-1] + by, last))
    if found[0] - inside <= _SAME_MM:
        raise block.refusal(
            values["I"].text,
            f"a tool of radius {inside:g} mm does not fit into this circle; use a larger I",
        )
    return [one - inside for one in found]


def _circles(m: Carrying, radii: list[float], block: ProgramBlock, *, left: bool) -> None:
    """Go from the middle to each circle, around it, and back to the middle."""
    state = m.state
    feed, speed = feed_in_force(state, block), speed_in_force(state, block)
    x, y, z = known_start(m, block).values()
    middle = ToolPlace(x, y, z)
    at = middle

    def go(to: ToolPlace, centre_mm: float | None) -> None:
        nonlocal at
        circle = None if centre_mm is None else Circle("G17", (x + centre_mm, y), left)
        m.record(ProgramMove(at, to, feed, speed, block.line, state.tool, circle))
        at = to

    for k, radius_mm in enumerate(radii):
        out = ToolPlace(x + radius_mm, y, z)
        go(out, 0.5 * radius_mm if k == 0 else None)
        go(out, 0.0)
    go(middle, 0.5 * radii[-1])
