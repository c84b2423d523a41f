"""What is in force at a block of a turning program, and the words that change it, as tables."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from autodb.nc.reading.blocks import ProgramBlock, Word
from autodb.nc.reading.paths import CuttingSpeed, Feed, FeedPerMinute, PerRev, Revolutions, Speed

INCH_MM = 25.4
"""Millimetres in an inch (exact by definition)."""
_FOOT_M = 12 * INCH_MM / 1000
_NO_COMPENSATION = "this compensates the nose radius; program the contour itself without it"
_TWO_MEANINGS = (
    "this means inches or mm on some controls and a cycle on others; use G20 or G700 for "
    "inches, G21 or G710 for mm, or write out the cycle's moves"
)
_OTHER_PLANE = "this selects another plane than that of X and Z; use G18"
_OUTSIDE = "this calls a subprogram or macro; write its blocks into this file"

GROUPS: tuple[Mapping[str, Mapping[str, Any]], ...] = (
    {code: {"motion": code} for code in ("G0", "G1", "G2", "G3")},
    {"G90": {"absolute": True}, "G91": {"absolute": False}},
    {
        "G20": {"unit_mm": INCH_MM},
        "G700": {"unit_mm": INCH_MM},
        "G21": {"unit_mm": 1.0},
        "G710": {"unit_mm": 1.0},
    },
    {code: {"feed_word": code} for code in ("G94", "G95", "G98", "G99")},
    {"G96": {"surface": True}, "G97": {"surface": False}},
    {"DIAMON": {"diameter": True}, "DIAMOF": {"diameter": False}},
)
"""Groups of modal words, one of each group in a block, and what they change."""
PER_REV = frozenset({"G95", "G99"})
SYSTEM_A = frozenset({"G98", "G99", "U", "W"})
"""Words of Fanuc lathes in G-code system A only, as we read them."""
NOT_SYSTEM_A = frozenset({"G90", "G91", "G94", "G95"})
"""Words that mean a cycle on such lathes, or nothing."""
HARMLESS = frozenset(
    {"G9", "G18", "G40", "G60", "G61", "G64", "G80"}
    | {"M0", "M1", "M2", "M3", "M4", "M5", "M7", "M8", "M9", "M30"}
    | {f"M{gear}" for gear in range(40, 46)}
)
"""Words that move no axis and change nothing that is read here."""
OFFSETS = frozenset({"G54", "G55", "G56", "G57", "G58", "G59", "G500"})
MACHINE = frozenset({"G28", "G30", "G53", "SUPA"})
"""Words after which the place in the program's coordinates is not known."""
ONCE = frozenset({"G4", "G50", "G92"})
"""Words for their own block."""
REFUSED: Mapping[str, str] = {
    "G41": _NO_COMPENSATION,
    "G42": _NO_COMPENSATION,
    "G70": _TWO_MEANINGS,
    "G71": _TWO_MEANINGS,
    "G17": _OTHER_PLANE,
    "G19": _OTHER_PLANE,
    "G65": _OUTSIDE,
    "G66": _OUTSIDE,
    "M97": _OUTSIDE,
    "M98": _OUTSIDE,
    "M99": _OUTSIDE,
    "DIAM90": "X is a diameter in G90 and a radius in G91; use DIAMON or DIAMOF",
}


@dataclass(frozen=True)
class Modes:
    """What is in force: how numbers count, motion, feed, spindle, tool, and where the tip is.

    Places in mm, x as a radius, None where the program has not said it; ``feed`` in mm/rev or
    mm/min as ``feed_word`` says, ``speed`` in rpm or, with ``surface``, m/min; ``limit_rpm`` holds
    in G96, ``highest_rpm`` always; ``stopped``: line of the M5 since which the spindle stands;
    ``families``: word and line that first said which G-code system this is.
    """

    diameter: bool
    unit_mm: float
    absolute: bool = True
    motion: str | None = None
    feed_word: str | None = None
    feed: float | None = None
    surface: bool = False
    speed: float | None = None
    limit_rpm: float | None = None
    highest_rpm: float | None = None
    stopped: int | None = None
    tool: str | None = None
    offset: str | None = None
    edge: str | None = None
    x_mm: float | None = None
    z_mm: float | None = None
    families: tuple[tuple[str, int] | None, tuple[str, int] | None] = (None, None)

    @property
    def x_factor(self) -> float:
        """Return mm of radius for one programmed unit of X."""
        return self.unit_mm * (0.5 if self.diameter else 1.0)


def changed_modes(modes: Modes, words: Mapping[str, Word], block: ProgramBlock) -> Modes:
    """Return the modes with a block's modal words, by code, in force.

    Raises UnusableInput naming the word that is not read, or the second one of a group. A feed or
    speed said under another unit or way of counting is not known any more.
    """
    changes: dict[str, Any] = {}
    for group in GROUPS:
        said = [code for code in words if code in group]
        if len(said) > 1:
            raise block.refusal(
                words[said[1]].text,
                f"'{words[said[0]].text}' stands in this block too; use one of them",
            )
        changes |= group[said[0]] if said else {}
    known = _family(modes, words, block)
    if not changes:
        return known
    after = replace(known, **changes)
    counts_as_before = modes.feed_word in {None, after.feed_word}
    if modes.unit_mm != after.unit_mm or not counts_as_before:
        after = replace(after, feed=None)
    if modes.surface != after.surface or (modes.unit_mm != after.unit_mm and modes.surface):
        after = replace(after, speed=None)
    return after


def _family(modes: Modes, words: Mapping[str, Word], block: ProgramBlock) -> Modes:
    """Refuse words of two G-code systems in one program: one of them means something else."""
    before = list(modes.families)
    for mine, family in enumerate((SYSTEM_A, NOT_SYSTEM_A)):
        said = next((word for code, word in words.items() if {code, word.name} & family), None)
        if said is not None and before[mine] is None:
            before[mine] = (said.text, block.line)
        other = before[1 - mine]
        if said is not None and other is not None:
            raise block.refusal(
                said.text,
                f"this word and '{other[0]}' of line {other[1]} belong to two G-code systems; "
                "use U, W, G98, G99 (Fanuc lathes, system A) or G90, G91, G94, G95 alone",
            )
    families = (before[0], before[1])
    return modes if families == modes.families else replace(modes, families=families)


def feed_in_force(modes: Modes, block: ProgramBlock) -> Feed:
    """Return the feed of a cutting move; raises UnusableInput saying what is not stated."""
    word = modes.motion or ""
    if modes.feed_word is None:
        raise block.refusal(
            word,
            "the unit of the feed is not stated before; use G95 or G99 (mm/rev), G94 or G98 "
            "(mm/min)",
        )
    if modes.feed is None:
        raise block.refusal(
            word, f"no feed before this cutting move; state F after {modes.feed_word}"
        )
    if modes.feed_word == "G94" and modes.surface:
        raise block.refusal(
            "G96",
            "G94 means feed per minute on some controls and per revolution on others; use G95",
        )
    return PerRev(modes.feed) if modes.feed_word in PER_REV else FeedPerMinute(modes.feed)


def speed_in_force(modes: Modes, block: ProgramBlock) -> Speed:
    """Return the spindle speed of a cutting move; raises UnusableInput where there is none."""
    word = modes.motion or ""
    if modes.stopped is not None:
        raise block.refusal(
            word, f"the spindle stopped with M5 in line {modes.stopped}; start it with M3 or M4"
        )
    if not modes.speed:
        raise block.refusal(
            word, "no spindle speed before this cutting move; state S with G97 or G96"
        )
    highest = [limit for limit in (modes.limit_rpm, modes.highest_rpm) if limit is not None]
    if modes.surface:
        return CuttingSpeed(modes.speed, min(highest, default=None))
    return Revolutions(min(modes.speed, modes.highest_rpm or modes.speed))


def surface_m_min(modes: Modes, said: float) -> float:
    """Return a speed S of G96 in m/min; with inches it counts feet."""
    return said * (_FOOT_M if modes.unit_mm == INCH_MM else 1.0)
