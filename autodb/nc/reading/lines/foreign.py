"""Languages that are no G-code of the controls read here: refused in one line that says which.

Okuma's OSP has its own words beside G-code: a program without them is read (``OKUMA``).
"""

import re

from autodb.errors import UnusableInput

_COMMENT = re.compile(r"\([^()\n]*\)|;[^\n]*")
_LANGUAGES = (
    (
        "Heidenhain's own language",
        re.compile(
            r"^\s*\d*\s*(BEGIN PGM|TOOL CALL\s|CYCL DEF\s|BLK FORM\s|L\s+[XYZ][^\n]*\bF?MAX\b)"
        ),
        "post it as G-code of Fanuc, Haas, Sinumerik or LinuxCNC",
    ),
    (
        "APT, a tool path before any post-processor",
        re.compile(r"^\s*(PARTNO\b|GOTO\s*/|LOADTL\s*/|FEDRAT\s*/|CUTTER\s*/)"),
        "post it as G-code of Fanuc, Haas, Sinumerik or LinuxCNC",
    ),
    (
        "Philips' and MAHO's own language",
        re.compile(r"^\s*%PM\b|^\s*N9\d{3,6}\b(?![^\n]*[GXYZ]\d)"),
        "post it as G-code of Fanuc, Haas, Sinumerik or LinuxCNC",
    ),
)
"""Each with a word that nothing else has, at the begin of a line."""
_HEADER = re.compile(r"\s*\$[\w.+-]+\.(MIN|SSB|SUB|LIB)\s*%?\s*$")
_OSP = re.compile(
    r"\bV[A-Z]{1,5}(\d+|\[[^\]]*\])\s*=|^\s*N[A-Z][A-Z0-9]*\b|\bCALL\s+O[A-Z0-9]+|\bRTS\b|\bMOD(IN|OUT)\b"
    r"|\bG8[5-8]\s*N[A-Z0-9]+|^\s*O[A-Z][A-Z0-9]*\s*$|\bGOTO\s+N|\bIF\s*\[[^\n]*\]\s*N[A-Z0-9]"
    r"|^\s*(N\d+\s+)?[A-Z][A-Z0-9]{1,7}\s*=|\b[XYZCTSFHDUWP]\s*=|\bDEF\s+WORK\b|^\s*DRAW\s*$|^\s*CLEAR\s*$"
    r"|^\s*PT\s+L|\b[A-Z]{2}=\d"
)
_TELLS_OSP = re.compile(
    r"^\s*\$[\w.+-]+\.(MIN|SSB|SUB|LIB)\b|\bG8[5-8]\s*N[A-Z]?[A-Z0-9]+\s*[DUWF]|\bNLAP\d|\bVC\d+\s*="
    r"|\bG15\s*H\s*=?\s*[\dV]|\bCALL\s+O[A-Z0-9]+\b|\bVZOF[XZ]|\bRTS\s*$|\bNAT\d\d\b",
    re.MULTILINE,
)
_FIRST = 400
"""Lines in which another language tells itself. Chosen."""


def refuse_other_language(text: str, *, source: str) -> None:
    """Raise UnusableInput naming line, word and language of what is no G-code."""
    for number, raw in enumerate(text.upper().splitlines()[:_FIRST], 1):
        for language, words, remedy in _LANGUAGES:
            found = words.search(raw)
            if found is not None:
                word = " ".join(found[0].split())
                raise UnusableInput(
                    f"{source}: line {number}: '{word}': this is {language}, which is not read; "
                    f"{remedy}"
                )


def is_okuma(text: str, *, source: str) -> bool:
    """Return whether a program is written for Okuma's OSP: by its words, its head or its name."""
    own = source.lower().endswith((".min", ".ssb"))
    return own or _TELLS_OSP.search(_COMMENT.sub(" ", text.upper())) is not None


def okuma_plain(text: str, *, source: str) -> tuple[str, UnusableInput | None]:
    """Return a program of Okuma without its head, and the refusal of all its own words."""
    lines = text.splitlines()
    own: list[tuple[int, str]] = []
    for k, raw in enumerate(lines):
        plain = _COMMENT.sub(" ", raw.upper())
        if _HEADER.match(plain):
            lines[k] = ""
            continue
        found = _OSP.search(plain)
        if found is not None:
            own.append((k + 1, " ".join(found[0].split())))
    if not own:
        return "\n".join(lines), None
    others = ", ".join(str(number) for number, _ in own[1:7])
    also = f" (so in line {others}{' and more' if len(own) > 7 else ''})" if others else ""
    number, word = own[0]
    return "", UnusableInput(
        f"{source}: line {number}: '{word}': this is Okuma's own language, of which only moves, "
        f"feeds and speeds are read; write out variables, calls and contours as G0, G1, G2 and G3, "
        f"or post it for Fanuc{also}"
    )
