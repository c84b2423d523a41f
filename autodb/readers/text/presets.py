"""Text files of known programs, as data: each has read files that its program wrote.

`docs/layouts.md` says which files these were.
"""

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Preset:
    """What one program writes beyond a plain table.

    ``begins``: what the first lines match, with the separator. ``names``, ``units``, ``steps``: the
    first cell of the line that names the columns, states their units, or the step of time of each.
    ``time``: how columns of time are called; each is followed by those that belong to it.
    ``time_unit``: theirs. ``unit_cell``: where a cell of the line of units has the unit.
    ``remarks``: a last column of text that rows may leave out.
    """

    title: str
    begins: re.Pattern[str]
    names: str
    units: str
    time: str
    time_unit: str
    steps: str = ""
    unit_cell: re.Pattern[str] = re.compile(r"(?P<unit>.+)")
    remarks: str = ""


PRESETS = (
    Preset(
        "LabVIEW measurement (LVM)",
        re.compile(r"LabVIEW Measurement\b.*\n(?:.*\n){0,9}?\w+_Version(?P<separator>[\t,;])"),
        names="X_Value",
        units="Y_Unit_Label",
        time="X_Value",
        time_unit="s",
        steps="Delta_X",
        remarks="Comment",
    ),
    Preset(
        "TwinCAT Scope export",
        re.compile(r"\"?Name\"?(?P<separator>[^\w\"]).*\n\"?File\"?(?P=separator)"),
        names="Name",
        units="Unit",
        time="Name",
        time_unit="ms",
        unit_cell=re.compile(r"(?P<unit>\S+) \(.*"),
    ),
    Preset(
        "Yokogawa waveform export",
        re.compile(r"\"?Model\"?(?P<separator>[,;\t]).*\n\"?BlockNumber\"?"),
        names="TraceName",
        units="VUnit",
        time="TraceName",
        time_unit="s",
        steps="HResolution",
    ),
)

NO_ROWS = ("overrun", "EOF")
"""Lines that begin so are no rows, in any file: halsampler of LinuxCNC writes the first where it
lost samples, TwinCAT Scope the second at the end if it is told to."""
