"""Threads: one pass (G32), and cycles of many (G76, CYCLE97), each pass with its depth.

Passes of Fanuc take equal cross-sections of the thread's V: the n-th is d √n deep, by no less than
a least step each. Those of LinuxCNC are J n^(1/R) deep.
Source: operator's manuals of these controls, as their makers describe the words.
"""

from collections.abc import Mapping, Sequence
from math import sqrt

from autodb.nc.reading.cycles.cycle_moves import (
    CLEAR_MM,
    Carrying,
    depth_of_cut,
    feed_to,
    known_start,
    rapid_to,
    thousandths,
)
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.motions import carry_out_motion
from autodb.nc.reading.paths import PerRev
from autodb.nc.reading.state import word_value
from autodb.nc.reading.targets import targets, without

MOST_PASSES = 500
METRIC_PITCH_MM = {
    3: 0.5, 4: 0.7, 5: 0.8, 6: 1.0, 8: 1.25, 10: 1.5, 12: 1.75, 14: 2.0, 16: 2.0, 18: 2.5,
    20: 2.5, 22: 2.5, 24: 3.0, 27: 3.0, 30: 3.5, 33: 3.5, 36: 4.0, 39: 4.0, 42: 4.5, 45: 4.5,
    48: 5.0, 52: 5.0, 56: 5.5, 60: 5.5,
}  # fmt: skip
"""Coarse pitch of a metric thread by its diameter, mm (ISO 261)."""


def thread_pass(m: Carrying, _code: str, values: Mapping[str, Word], block: ProgramBlock) -> None:
    """Cut a thread in one pass (G32); the word stays in force."""
    m.state.motion = "G33"
    carry_out_motion(m.state, without(values, "S", "T", "F"), block, m.record)


def fanuc_threads(m: Carrying, code: str, values: Mapping[str, Word], block: ProgramBlock) -> None:
    """Cut a thread by G76, in two blocks (P Q R, then X Z R P Q F) or in one (X Z K D F)."""
    state = m.state
    if not any(letter in values for letter in "XZUW"):
        number = word_value(values["P"]) if "P" in values else 0.0
        least = thousandths(state, values["Q"]) if "Q" in values else 0.0
        left = _length(m, values["R"]) if "R" in values else 0.0
        state.taken = {"springs": number // 10000, "least": least, "left": left}
        return
    start = known_start(m, block)
    to = targets(state, {n: w for n, w in values.items() if n in "XZUW"}, block)
    taken = state.taken if "springs" in state.taken else {}
    height, first = _height_and_first(m, values, block)
    taper = _length(m, values["R"]) if "R" in values else 0.0
    taper = _length(m, values["I"]) if "I" in values else taper
    if not state.feed:
        raise block.refusal(code, "a thread without a pitch; state F")
    least = taken.get("least", 0.0)
    left = min(taken.get("left", 0.0), height)
    depths = equal_sections(height - left, first, least, block)
    depths += [height] * max(int(taken.get("springs", 1.0)), 1 if left else 0)
    outside = start["x"] > (to["x"] or 0.0)
    crest = (to["x"] or 0.0) + (height if outside else -height)
    roots = [crest - d if outside else crest + d for d in depths]
    thread_passes(m, block, roots, (start["z"], to["z"] or 0.0), pitch_mm=state.feed, taper=taper)
    rapid_to(m, block, x=start["x"])


def _height_and_first(
    m: Carrying, values: Mapping[str, Word], block: ProgramBlock
) -> tuple[float, float]:
    """Return a thread's height and the depth of its first pass, mm, as radii."""
    if "K" in values and "D" in values:
        height = word_value(values["K"]) * m.state.unit_mm
        return height, depth_of_cut(m.state, values["D"])
    if "P" in values and "Q" in values:
        return thousandths(m.state, values["P"]), thousandths(m.state, values["Q"])
    raise block.refusal("G76", "height and first depth are missing; state P and Q, or K and D")


def _length(m: Carrying, word: Word) -> float:
    return (
        thousandths(m.state, word)
        if "." not in word.written
        else (word_value(word) * m.state.unit_mm)
    )


def equal_sections(height: float, first: float, least: float, block: ProgramBlock) -> list[float]:
    """Return the depths of passes with equal cross-sections, d √n, at least ``least`` apart."""
    if first <= 0 or height <= 0:
        raise block.refusal(
            block.words[0].text, "a thread needs a height and a first depth above 0"
        )
    depths = [min(first, height)]
    while depths[-1] < height - 1e-9:
        if len(depths) > MOST_PASSES:
            raise block.refusal(
                block.words[0].text, f"more than {MOST_PASSES} passes; make the first one deeper"
            )
        deeper = max(first * sqrt(len(depths) + 1), depths[-1] + least)
        depths.append(min(deeper, height))
    return depths


def thread_passes(
    m: Carrying,
    block: ProgramBlock,
    roots: Sequence[float],
    along: tuple[float, float],
    *,
    pitch_mm: float,
    taper: float = 0.0,
) -> None:
    """Cut passes at radii from one z to another, back above the thread between them."""
    back = m.state.known("x")
    for root in roots:
        rapid_to(m, block, z=along[0])
        rapid_to(m, block, x=root + taper)
        feed_to(m, block, {"x": root, "z": along[1]}, feed=PerRev(pitch_mm), thread=True)
        rapid_to(m, block, x=back)
    rapid_to(m, block, z=along[0])


def linuxcnc_threads(
    m: Carrying, code: str, values: Mapping[str, Word], block: ProgramBlock
) -> None:
    """Cut a thread by LinuxCNC's G76: P pitch, Z end, I crest, J first depth, K depth, R, H."""
    missing = [letter for letter in "PZIJK" if letter not in values]
    if missing:
        raise block.refusal(code, f"{' and '.join(missing)} missing; state P, Z, I, J and K")
    start = known_start(m, block)
    to = targets(m.state, {"Z": values["Z"]}, block)
    number = {n: word_value(w) for n, w in values.items() if w.number is not None}
    radial = m.state.factor("x")
    crest, first, height = (number[letter] * radial for letter in "IJK")
    power = 1.0 / max(number.get("R", 1.0), 1.0)
    if first <= 0 or height <= 0:
        raise block.refusal(code, "J and K are depths; use numbers above 0")
    depth = first
    depths: list[float] = []
    while depth < height - 1e-9 and len(depths) < MOST_PASSES:
        depths.append(depth)
        depth = first * (len(depths) + 1) ** power
    depths += [height] * (1 + int(number.get("H", 0.0)))
    sign = -1.0 if crest < 0 else 1.0
    roots = [start["x"] + crest + sign * d for d in depths]
    pitch_mm = number["P"] * m.state.unit_mm
    thread_passes(m, block, roots, (start["z"], to["z"] or 0.0), pitch_mm=pitch_mm)


def cycle97(m: Carrying, block: ProgramBlock, numbers: Sequence[float | None]) -> None:
    """Cut a thread by CYCLE97(PIT, MPIT, SPL, FPL, DM1, DM2, APP, ROP, TDEP, FAL, …)."""
    given = [*numbers, *([None] * 16)][:16]
    pit, mpit, spl, fpl, dm1, dm2, app, rop, tdep, fal, _, _, nrc, nid, vari, _ = (
        one or 0.0 for one in given
    )
    pitch = abs(pit) or METRIC_PITCH_MM.get(round(mpit), 0.0)
    if pitch <= 0 or tdep == 0:
        raise block.refusal("CYCLE97", "pitch and depth are missing; state PIT or MPIT, and TDEP")
    depth, left, cuts = abs(tdep), abs(fal), max(int(nrc), 1)
    even = vari in (1.0, 2.0)
    rough = depth - left
    shares = [(n + 1) / cuts if even else sqrt((n + 1) / cuts) for n in range(cuts)]
    depths = [rough * share for share in shares] + ([depth] if left else []) + [depth] * int(nid)
    inside = vari in (2.0, 4.0)
    half = 0.5 if m.state.diameter else 1.0
    taper = (dm1 - dm2) * half
    crest = dm2 * half
    roots = [crest + d if inside else crest - d for d in depths]
    rapid_to(m, block, z=spl + app)
    rapid_to(m, block, x=crest + (-1 if inside else 1) * (CLEAR_MM + abs(taper)))
    thread_passes(m, block, roots, (spl + app, fpl - rop), pitch_mm=pitch, taper=taper)
