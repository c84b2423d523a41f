"""Which control a program is written for, told by its words, and how it is taken apart then."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

from autodb.nc.reading.lines.flow import (
    fanuc_instructions,
    linuxcnc_instructions,
    okuma_instructions,
)
from autodb.nc.reading.lines.foreign import is_okuma
from autodb.nc.reading.lines.instructions import Instructions
from autodb.nc.reading.lines.sinumerik_flow import sinumerik_instructions


@dataclass(frozen=True)
class Control:
    """A family of controls: what a lathe's feed counts where nothing says it, and its words.

    ``feed_word``: G95 a revolution, G94 a minute. ``system``: of the G-codes of
    Fanuc's lathes, "A", "B" or "C".
    """

    name: str
    instructions: Callable[..., Instructions]
    feed_word: str = "G95"
    system: str = ""


FANUC_A = Control("fanuc-a", fanuc_instructions, "G95", "A")
FANUC_B = Control("fanuc-b", fanuc_instructions, "G95", "B")
FANUC_C = Control("fanuc-c", fanuc_instructions, "G95", "C")
LINUXCNC = Control("linuxcnc", linuxcnc_instructions, "G94")
SINUMERIK = Control("sinumerik", sinumerik_instructions, "G95")
OKUMA = Control("okuma", okuma_instructions, "G95")
PLAIN = Control("plain", fanuc_instructions)
"""A program that tells no control: in words that all of them share. Lathes of
all but LinuxCNC count feeds a revolution when they are switched on."""
OF_FANUC = (FANUC_A, FANUC_B, FANUC_C, PLAIN)
"""Controls with Fanuc's words. The last word of a group counts where a block has several (Series
0i, operator's manual, preparatory functions), and tapping turns the spindle itself (rigid tapping;
Haas' G84)."""
CONTROLS = {one.name: one for one in (FANUC_A, FANUC_B, FANUC_C, LINUXCNC, OKUMA, SINUMERIK)}

_SINUMERIK = re.compile(
    r"^%_N_|^;\$PATH|\bMSG\b|\bDIAM(ON|OF|90)\b|\bCYCLE\d+\b|\bMCALL\b|\bG500\b|\bG7[01]0\b|\bSUPA\b"
    r"|\bLIMS\s*=|\bR\d+\s*=|\bT\s*=\s*\"|\bCR\s*=|\bM17\b|\bTRAFOOF\b|\bA?TRANS\b|\bDEF (REAL|INT)"
    r"|\b(POCKET|HOLES|SLOT)\d\s*\(|\bTRAORI\b|\bEXTCALL\b|\bSTOPRE\b|\bGOTO[FB]\b|\b[XYZ]\s*=\s*I?A?C\b|\bWORKPIECE\b|\bFFWON\b|^\s*(N\d+\s*)?PROC\b",
    re.MULTILINE | re.IGNORECASE,
)
_LINUXCNC = re.compile(
    r"^\s*(N\d+)?\s*O\s*(<|\d+\s*(SUB|CALL|IF|WHILE|REPEAT|DO)\b)|#<|\bG0*[78]\b(?!\.\d|\s*P)|\bG9[01]\.1"
    r"|\bG96[^\n;(]*D|\bG64\s*P|\(\s*(DEBUG|AXIS|PRINT)\s*,|\bG7[0-2](\.\d)?\s*Q|\bM6[2-5]\s*P\d"
    r"|\bM61\s*Q|\bM66\s*[PEL]\d|\bM6[78]\s*E\d"
    r"|\bG76\s*P[^\n]*\bZ[^\n]*\bI[^\n]*\bJ",
    re.MULTILINE | re.IGNORECASE,
)
_FANUC = re.compile(
    r"^\s*O\d{1,8}\b|^\s*:\d{2,8}\b|\bG7[789]\s*[XU]|\bT\d{4}\b|\bG28\s*U|\bG50\s*S|\bG7[0-6]\s*[PURD]\d|\bM9[89]\b|\bG65\b|^#\d"
    r"|\bG28\s*W|\bG0*[23][^\n]*,R",
    re.MULTILINE | re.IGNORECASE,
)
_PLACES = re.compile(r"\s*(?:N\d+)?(?:\s*[XYZIJKF][-+]?[\d.]+)+\s*", re.IGNORECASE)
"""Lines with places alone, most of a long program: they tell no control."""
_SYSTEM_A = re.compile(r"\bG9[89]\b|(?<![A-Z])[UW][-+]?[\d.#\[]", re.IGNORECASE)
_NOT_OF_A = re.compile(r"\bG(?:28|30|53|7[0-6])\b[^\n]*", re.IGNORECASE)
"""The way to the machine's reference, where posts for system B write U and W too, and cycles, whose
allowances they are in every system."""
_SYSTEM_B = re.compile(r"\bG91\b|\bG95\b|\bG7[789]\s*X", re.IGNORECASE)


@lru_cache(maxsize=4)
def control_of(text: str, *, source: str = "") -> Control:
    """Return the control that a program's words tell, or its name's end; else ``PLAIN``."""
    if source.lower().endswith(".ngc"):
        return LINUXCNC
    text = "\n".join(line for line in text.splitlines() if not _PLACES.fullmatch(line))
    if is_okuma(text, source=source):
        return OKUMA
    plain = re.sub(r"\(\s*(?!(?:DEBUG|AXIS|PRINT))[^()]*\)", " ", text, flags=re.IGNORECASE)
    if _SINUMERIK.search(re.sub(r"(?m)^;(?!\$PATH).*|(?<!^);.*$", "", plain)):
        return SINUMERIK
    if _LINUXCNC.search(plain):
        return LINUXCNC
    return _of_fanuc(plain)


def _of_fanuc(plain: str) -> Control:
    """Return the control of Fanuc that the words of a program without comments tell."""
    if _SYSTEM_A.search(_NOT_OF_A.sub(" ", plain)):
        return FANUC_A
    if not _FANUC.search(plain):
        return PLAIN
    return FANUC_B if _SYSTEM_B.search(plain) else FANUC_A
