"""What the code of an insert or a holder tells of a turning tool's geometry.

Read are inserts (ISO 1832, and the inch sizes of ANSI B212.4), external holders (ISO 5608), boring
bars (ISO 6261) and holders with a polygonal shank (prefix C3 to C10, ISO 26623). Neither rake nor
edge preparation is in a code: they stay assumed. Angles as these standards define the letters.
"""

import re

SHAPES_DEG = {
    "A": 85.0, "B": 82.0, "C": 80.0, "D": 55.0, "E": 75.0, "H": 120.0, "K": 55.0, "L": 90.0,
    "M": 86.0, "O": 135.0, "P": 108.0, "S": 90.0, "T": 60.0, "V": 35.0, "W": 80.0,
}  # fmt: skip
"""Angle between the edges of an insert by its first letter (ISO 1832). R is round: it has none."""
STYLES_DEG = {
    "A": 90.0, "B": 75.0, "D": 45.0, "E": 60.0, "G": 90.0, "H": 107.5, "J": 93.0, "L": 95.0,
    "M": 50.0, "N": 63.0, "R": 75.0, "S": 45.0, "T": 60.0, "V": 72.5, "Y": 85.0,
}  # fmt: skip
"""Entering angle of a holder that feeds along the axis, by its style (ISO 5608). Styles C, F, K, U
and W cut with the end, so that their angle is that of facing: they tell none here."""
_SHAPES = "".join(SHAPES_DEG)
_INSERT = re.compile(
    rf"([{_SHAPES}R])[A-GNOP][A-HJ-NU][A-HJMNQRTUWX](\d{{2}})(\d{{2}}|T\d)(\d{{2}})"
)
_INCHES = re.compile(rf"([{_SHAPES}R])[A-GNOP][A-HJ-NU][A-HJMNQRTUWX](\d)(\d)(\d)(?!\d)")
_HOLDER = re.compile(
    rf"(?:C(?:3|4|5|6|8|10)|[ACESF]\d{{2}}[A-Z]?)?([CDMPSW])([{_SHAPES}R])([A-Y])([A-GNOP])([RLN])"
    r"(?:\d{4,6}[A-Z]?)?(\d{2})?"
)
_INCH_MM = 25.4


def geometry_of_code(text: str) -> dict[str, float]:
    """Return what the codes in a tool's name tell, by names of a tool's geometry; often nothing.

    >>> geometry_of_code("CNMG 120408 in PCLNR 2525M12")
    {'included_deg': 80.0, 'nose_radius_mm': 0.8, 'kappa_deg': 95.0}
    """
    found: dict[str, float] = {}
    plain = re.sub(r"[\s\-_./]", "", text.upper())
    shape = ""
    insert, inches = _INSERT.search(plain), _INCHES.search(plain)
    if insert is not None:
        shape, found["nose_radius_mm"] = insert[1], int(insert[4]) / 10.0
    elif inches is not None:
        shape, found["nose_radius_mm"] = inches[1], int(inches[4]) * _INCH_MM / 64.0
    rest = plain.replace(insert[0], " ") if insert is not None else plain
    holder = _HOLDER.search(rest)
    if holder is not None and holder[3] in STYLES_DEG:
        found["kappa_deg"] = STYLES_DEG[holder[3]]
    shape = shape or (holder[2] if holder is not None else "")
    if shape in SHAPES_DEG:
        found = {"included_deg": SHAPES_DEG[shape], **found}
    return found
