"""Drilling cycles: G81 to G89, G73, G74 and G76 of mills, and along the axis of lathes.

The tool goes over a hole, fast to R, at the feed to Z, and back: to R or to where it was before
(G98, G99). A cycle stays in force: each further block with a place is a hole. Pecks (Q) draw back
to R (G83) or a little (G73).
"""

from collections.abc import Mapping, Sequence

from autodb.nc.reading.codes import INCH_MM
from autodb.nc.reading.controls import LINUXCNC, OF_FANUC
from autodb.nc.reading.cycles.cycle_moves import (
    Carrying,
    feed_to,
    known_start,
    rapid_to,
    signed_depth,
    thousandths,
)
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.motions import nothing_left
from autodb.nc.reading.paths import PerRev
from autodb.nc.reading.state import word_value
from autodb.nc.reading.targets import targets, without
from autodb.nc.reading.travels import PLANES

PECK_BACK_MM = 0.01 * INCH_MM
"""How far a peck draws back that does not leave the hole, and how near to the last depth the next
one goes fast. Chosen: what LinuxCNC's G73 and G83 have."""
MOST_PECKS = 20_000
_FEED_OUT = frozenset({"G85", "G89"})
_TAPS = frozenset({"G84", "G74"})
_PECKS = frozenset({"G73", "G83"})
_NAMES = "xyz"
_TAKEN = tuple("RQPLKFSTNOHDIJECM")


def drill_on_lathe(m: Carrying, code: str, values: Mapping[str, Word], block: ProgramBlock) -> None:
    """Drill along the axis of a lathe: the tool's place in X is where it drills."""
    kept, m.state.plane = m.state.plane, "G17"
    try:
        drill_holes(m, code, values, block)
    finally:
        m.state.plane = kept


def drill_holes(m: Carrying, code: str, values: Mapping[str, Word], block: ProgramBlock) -> None:
    """Drill a hole, or as many as L or K say in steps of G91."""
    state = m.state
    if state.cycle != code:
        state.cycle, state.taken = code, {}
        if state.control is LINUXCNC:
            state.motion = None  # others go on as before the cycle once it is cancelled
        state.taken["before"] = _height(m, block, _NAMES[PLANES[state.plane][2]])
    deep = _NAMES[PLANES[state.plane][2]]
    axes = {n: w for n, w in values.items() if n in ("X", "Y", "Z", "@", "^")}
    nothing_left(without(values, *axes, *_TAKEN), block, state)
    over = {n: w for n, w in axes.items() if n.lower() != deep}
    depth = axes.get(deep.upper())
    times = 1
    for letter in ("L", "K") if state.control is LINUXCNC or not state.lathe else ("L",):
        if letter in values:
            times = int(word_value(values[letter]))
    for _ in range(max(times, 0)):
        to = targets(state, over, block)
        _take_levels(m, values, depth, deep, block)
        rapid_to(m, block, **{a: to[a] or 0.0 for a in _NAMES if a != deep and to[a] is not None})
        _hole(m, block, code, deep)


def _height(m: Carrying, block: ProgramBlock, deep: str) -> float:
    """Return where a cycle begins along the hole; raises UnusableInput where that is not known."""
    if m.state.place[deep] is None and m.state.control is not LINUXCNC:
        raise block.refusal(
            block.words[0].text,
            f"the cycle's start is not known in {deep.upper()}; state it in a G0 before",
        )
    return known_start(m, block)[deep] if m.state.place[deep] is None else m.state.known(deep)


def _take_levels(
    m: Carrying,
    values: Mapping[str, Word],
    depth: Word | None,
    deep: str,
    block: ProgramBlock,
) -> None:
    """Keep R, Z and Q of a cycle; in G91 R counts from where the tool is, and Z from R."""
    state, taken = m.state, m.state.taken
    here = _height(m, block, deep)
    unit, shift = state.unit_mm, state.shift[deep]
    if "R" in values:
        taken["R"] = _level(m, values["R"], shift)
    if depth is not None:
        said = unit * word_value(depth)
        steps = depth.step if depth.step is not None else not state.absolute
        taken["Z"] = taken.get("R", here) + said if steps else said + shift
    if "Q" in values:
        fine = state.lathe and state.control.name.startswith("fanuc")
        taken["Q"] = abs(
            thousandths(state, values["Q"]) if fine else unit * word_value(values["Q"])
        )
    if "Z" not in taken:
        raise block.refusal(block.words[0].text, "a cycle without a depth; state Z")
    if state.control is LINUXCNC and state.cycle in _PECKS and not taken.get("Q"):
        raise block.refusal(
            state.cycle or "", "LinuxCNC takes no pecks without their depth; state Q, or use G81"
        )


def _level(m: Carrying, word: Word, shift: float) -> float:
    """Return where R of a cycle lies, mm.

    On Fanuc's lathes R counts from the start towards the hole, thousandths where it is a large
    number without a point (Series 0i-TD, operator's manual B-64304EN-1, canned cycle for drilling);
    one that would go back from it is a place, as on Haas' lathes.
    """
    state, before = m.state, m.state.taken["before"]
    if state.lathe and state.control.name.startswith("fanuc"):
        said = signed_depth(state, word)
        return before + said if said <= 0 else min(said + shift, before)
    said = state.unit_mm * word_value(word)
    return said + shift if state.absolute else said + before


def _hole(m: Carrying, block: ProgramBlock, code: str, deep: str) -> None:
    taken = m.state.taken
    here = m.state.known(deep)
    top = taken.get("R", here)
    if here < top:
        rapid_to(m, block, **{deep: top})
    rapid_to(m, block, **{deep: top})
    if code in ("G73", "G83", "G83.1") and taken.get("Q", 0.0) > 0:
        pecks(m, block, deep, (top, taken["Z"], taken["Q"]), leaves=code == "G83")
    elif code in _TAPS:
        _tap(m, block, deep, (top, taken["Z"]))
    else:
        feed_to(m, block, {deep: taken["Z"]})
        if code in _FEED_OUT:
            feed_to(m, block, {deep: top})
    back = max(taken["before"], top) if m.state.to_start else top
    rapid_to(m, block, **{deep: back})


def _tap(m: Carrying, block: ProgramBlock, deep: str, levels: tuple[float, float]) -> None:
    """Tap a hole and come back; Fanuc's and Haas' cycles start a spindle that stands."""
    state, (top, bottom) = m.state, levels
    feed = PerRev(state.feed) if state.feed_word == "G95" and state.feed else None
    kept = state.turning, state.stopped
    if state.control in OF_FANUC:
        state.turning, state.stopped = True, None
    feed_to(m, block, {deep: bottom}, feed=feed)
    feed_to(m, block, {deep: top}, feed=feed)
    state.turning, state.stopped = kept


def rigid_tap(m: Carrying, code: str, values: Mapping[str, Word], block: ProgramBlock) -> None:
    """Tap with LinuxCNC's G33.1: to a place by K a revolution, and back to where that began."""
    state = m.state
    if not values.get("K") or not word_value(values["K"]):
        raise block.refusal(code, "a thread without a pitch; state K")
    axes = {n: w for n, w in values.items() if n in ("X", "Y", "Z", "@", "^")}
    nothing_left(without(values, *axes, "K", "F", "S", "N", "I", "$"), block, state)
    begin, to = known_start(m, block), targets(state, axes, block)
    pitch = PerRev(abs(word_value(values["K"])) * state.unit_mm)
    state.motion = None  # each further one states its K anew
    feed_to(m, block, {a: mm for a, mm in to.items() if mm is not None}, feed=pitch)
    feed_to(m, block, begin, feed=pitch)


def pecks(
    m: Carrying,
    block: ProgramBlock,
    deep: str,
    levels: tuple[float, float, float],
    *,
    leaves: bool,
) -> None:
    """Drill from one level to another by pecks; they leave the hole, or draw back a little."""
    top, bottom, peck = levels
    if abs(top - bottom) / peck > MOST_PECKS:
        raise block.refusal("Q", "a peck is far too small; make it larger")
    sign = 1.0 if bottom < top else -1.0
    at = top
    while sign * (at - bottom) > 1e-9:
        following = at - sign * peck
        following = bottom if sign * (bottom - following) > -1e-9 else following
        feed_to(m, block, {deep: following})
        if sign * (following - bottom) > 1e-9:
            if leaves:
                rapid_to(m, block, **{deep: top})
                rapid_to(m, block, **{deep: following + sign * min(PECK_BACK_MM, peck)})
            else:
                rapid_to(m, block, **{deep: following + sign * PECK_BACK_MM})
        at = following


def sinumerik(m: Carrying, name: str, numbers: Sequence[float | None], block: ProgramBlock) -> None:
    """Drill one hole by CYCLE81 to CYCLE89(RTP, RFP, SDIS, DP, DPR, …) where the tool is."""
    given = [*numbers, *([None] * 13)][:13]
    rtp, rfp, sdis, dp, dpr = given[:5]
    shift = m.state.shift["z"]
    if rtp is None or (dp is None and not dpr):
        raise block.refusal(name, "levels are missing; state RTP, RFP and DP or DPR")
    surface = (rfp or 0.0) + shift
    bottom = dp + shift if dp is not None else surface - abs(dpr or 0.0)
    top = surface + abs(sdis or 0.0)
    known_start(m, block)
    rapid_to(m, block, z=top)
    if name == "CYCLE83":
        _deep_hole(m, block, given, (surface, top, bottom))
    elif name in ("CYCLE84", "CYCLE840"):
        pit = abs(given[8] or 0.0) if name == "CYCLE84" else abs(given[9] or 0.0)
        feed = PerRev(pit) if pit else None
        feed_to(m, block, {"z": bottom}, feed=feed)
        feed_to(m, block, {"z": top}, feed=feed)
    else:
        feed_to(m, block, {"z": bottom})
        if name in ("CYCLE85", "CYCLE89"):
            feed_to(m, block, {"z": top})
    rapid_to(m, block, z=rtp + shift)


def _deep_hole(
    m: Carrying,
    block: ProgramBlock,
    given: Sequence[float | None],
    levels: tuple[float, float, float],
) -> None:
    """Peck: first to FDEP or by FDPR, each further one shorter by DAM; VARI 1 leaves the hole."""
    surface, top, bottom = levels
    fdep, fdpr, dam = given[5:8]
    first = surface - (fdep + m.state.shift["z"]) if fdep is not None else abs(fdpr or 0.0)
    if first <= 0:
        raise block.refusal("CYCLE83", "the first peck is missing; state FDEP or FDPR")
    leaves = bool(given[11])
    at, peck, less = surface, first, abs(dam or 0.0)
    while at - bottom > 1e-9:
        following = max(at - peck, bottom)
        feed_to(m, block, {"z": following})
        if following - bottom > 1e-9:
            rapid_to(m, block, z=top if leaves else following + 1.0)
            if leaves:
                rapid_to(m, block, z=following + PECK_BACK_MM)
        at, peck = following, max(peck - less, less or peck, 1e-3)
