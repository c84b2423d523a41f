"""What the ISO designation of an indexable insert says of it: CNMG 120408 has 80° and 0.8 mm.

Source: ISO 1832, symbols 1 (shape and included angle) and 7 (corner radius in tenths of a mm).
"""

import re

INCLUDED_DEG = {
    "C": 80.0, "D": 55.0, "E": 75.0, "M": 86.0, "V": 35.0, "W": 80.0, "H": 120.0, "O": 135.0,
    "P": 108.0, "S": 90.0, "T": 60.0, "A": 85.0, "B": 82.0, "K": 55.0, "L": 90.0,
}  # fmt: skip
"""Included angle of a shape."""
_DESIGNATION = re.compile(
    rf"\b([{''.join(INCLUDED_DEG)}])[A-GNPO][ACE-HJ-NU][AFGMNQRTUWXBCHJ][ -]?"
    r"\d{2}(?:\d{2}|T\d)(\d{2})(?!\d)"
)


def geometry_of_designation(name: str) -> dict[str, float]:
    """Return the nose radius and the included angle that a tool's name states; {}: none.

    >>> geometry_of_designation("PCLNL 2525 / CNMG 120408-PM")
    {'included_deg': 80.0, 'nose_radius_mm': 0.8}
    >>> geometry_of_designation("DCMT 11T304")
    {'included_deg': 55.0, 'nose_radius_mm': 0.4}
    >>> geometry_of_designation("end mill 1204")
    {}
    """
    found = _DESIGNATION.search(name)
    if found is None:
        return {}
    tenths = int(found.group(2))
    radius = {"nose_radius_mm": tenths / 10.0} if tenths else {}
    return {"included_deg": INCLUDED_DEG[found.group(1)], **radius}
