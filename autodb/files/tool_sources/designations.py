"""Codes in names of tools: what they tell of its geometry.

Those of inserts (ISO 1832, and the inch sizes of ANSI B212.4), external holders (ISO 5608), boring
bars (ISO 6261) and holders with a polygonal shank (prefix C3 to C10, ISO 26623). Neither rake nor
edge preparation is in a code: they stay assumed. Angles as these standards define the letters.
"""

import re

_SHAPES_DEG = {
    "A": 85.0, "B": 82.0, "C": 80.0, "D": 55.0, "E": 75.0, "H": 120.0, "K": 55.0, "L": 90.0,
    "M": 86.0, "O": 135.0, "P": 108.0, "S": 90.0, "T": 60.0, "V": 35.0, "W": 80.0,
}  # fmt: skip
"""Angle between the edges of an insert by its first letter (ISO 1832). R is round: it has none."""
_STYLES_DEG = {
    "A": 90.0, "B": 75.0, "D": 45.0, "E": 60.0, "G": 90.0, "H": 107.5, "J": 93.0, "L": 95.0,
    "M": 50.0, "N": 63.0, "R": 75.0, "S": 45.0, "T": 60.0, "V": 72.5, "Y": 85.0,
}  # fmt: skip
"""Entering angle of a holder that feeds along the axis, by its style (ISO 5608). Styles C, F, K, U
and W cut with the end, so that their angle is that of facing: they tell none here."""
_BARS_DEG = {"F": 90.0, "K": 75.0, "Q": 107.5, "U": 93.0, "W": 60.0}
"""The same of the styles that cut with the end, on a bar or a round head: it feeds along its own
axis (ISO 6261)."""
_ROUND_MM = {"06": 6.35, "09": 9.525, "12": 12.7, "15": 15.875, "19": 19.05, "25": 25.4}
"""Diameter of a round insert by its size, where the code ends in 00; in M0 it is the size itself
(ISO 1832). Those of the type X (RCMX) have diameters in mm in either."""
_SHAPES = "".join(_SHAPES_DEG)
_LETTERS = rf"(?<![A-Z])([{_SHAPES}R])[A-GNOP][A-HJ-NU]([A-HJMNPQRTUWXZ])"
_INSERT = re.compile(_LETTERS + r"[\s_-]*(\d{2})[\s_-]*(?:\d{2}|T\d)[\s_-]*(\d{2}|M0)(?!\d)")
_INCHES = re.compile(
    rf"(?<![A-Z])([{_SHAPES}R])[A-GNOP][A-HJ-NU][A-HJMNPQRTUWXZ]?[\s_-]*"
    r"\d\(?[1-9](?:\.5)?\)?(\d(?:\.5)?)(?![\d.])"
)
"""Insert of ANSI B212.4: eighths of an inch across, sixteenths thick, sixty-fourths of nose."""
_HOLDER = re.compile(
    rf"(C(?:3|4|5|6|8|10)|[A-HJSX]\d{{2}}[A-Z]?)?([CDMPSW])([{_SHAPES}R])([A-Y])([A-GNOP])([RLN])"
    r"(?:\d{4,6}[A-Z]?)?(\d{2})?"
)
_INCH_MM = 25.4


def geometry_of_code(text: str) -> dict[str, float]:
    """Return what the codes in a tool's name tell, by names of a tool's geometry; often nothing.

    >>> geometry_of_code("CNMG 120408 in PCLNR 2525M12")
    {'included_deg': 80.0, 'nose_radius_mm': 0.8, 'kappa_deg': 95.0}
    """
    found: dict[str, float] = {}
    said, shape = text.upper(), ""
    insert = _INSERT.search(said) or _INCHES.search(said)
    if insert is not None:
        shape, found["nose_radius_mm"] = insert[1], _nose_mm(insert)
        said = said.replace(insert[0], " ")
    holder = _HOLDER.search(re.sub(r"[\s\-_./]", "", said))
    if holder is not None:
        shape = shape or holder[3]
        kappa = _STYLES_DEG.get(holder[4], _BARS_DEG.get(holder[4]) if holder[1] else None)
        found |= {} if kappa is None or holder[3] == "R" else {"kappa_deg": kappa}
    if shape in _SHAPES_DEG:
        found = {"included_deg": _SHAPES_DEG[shape], **found}
    return found


def _nose_mm(insert: re.Match[str]) -> float:
    """Return the nose radius that an insert's code says: of a round one half its diameter."""
    if insert.re is _INCHES:
        return float(insert[2]) * _INCH_MM / 64.0
    size, nose = insert[3], insert[4]
    if insert[1] != "R":
        return int(nose.replace("M", "")) / 10.0  # M0: sharp, as 00
    inches = nose != "M0" and insert[2] != "X"
    return 0.5 * (_ROUND_MM.get(size, float(size)) if inches else float(size))
