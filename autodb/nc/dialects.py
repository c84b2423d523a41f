"""Words of the controls that programs are written for: one table a control and machine.

Fanuc's lathes are in G-code system A, the one that most are delivered with: there G99 is feed per
revolution, G98 per minute, ``G50 S`` the highest speed, X and Z are absolute, and G90 is a turning
cycle. In systems B and C these are G95, G94, ``G92 S`` and G90: such a lathe must not run this
program. Mills have one set of codes; G53 counts with G90 only, so that increments (G91) come after
it.

Siemens' are Sinumerik's own language, not ISO mode. G710 takes lengths and feeds in mm. G95, G96
and G97 are one group: G97 ends a constant cutting speed and keeps the feed per revolution; LIMS
limits the speed in G96 and G97. SUPA leaves out all frames for one block and D0 the tool's offset.
X is retracted as a radius (DIAMOF); DIAMON then makes it a diameter.

No program made with these words has run on a control.
"""

from autodb.nc.words import Words

_FANUC_OPENING = ("%", "O0101 ({name})")
_FANUC_CLOSING = ("M5", "M9", "M30", "%")

_FANUC_LATHE = Words(
    opening=_FANUC_OPENING,
    comment="({})",
    notes=(
        "G-code system A: G99 is mm/rev and G50 S the speed limit; in B and C do not run it",
        "X in diameters needs parameter 1006 bit 3 = 1, in radii 0",
    ),
    modes=("G21 G18 G40 G80 G99", "G50 S{limit_rpm}", "M9"),
    home="G0 G53 {axis}{value}",
    home_in_radii=False,
    x_in_diameters=(),
    x_in_radii=(),
    begin=("G54", "T{tool:02d}{tool:02d}"),
    spindle="G97 S{rpm} {turn}",
    closing=_FANUC_CLOSING,
    sweep_modes=("G21 G18 G40 G80 G98", "M5", "M9"),
    increments=(),
    step={"x": "U", "y": "V", "z": "W"},
    dwell="G4 P{milliseconds}",
)

_FANUC_MILL = Words(
    opening=_FANUC_OPENING,
    comment="({})",
    notes=("The speed limit was checked when this was made; no word of it sets one",),
    modes=("G21 G90 G17 G40 G49 G80 G94", "M9"),
    home="G0 G53 {axis}{value}",
    home_in_radii=False,
    x_in_diameters=(),
    x_in_radii=(),
    begin=("T{tool} M6", "G54", "G0 G43 H{tool} Z{retract_z}"),
    spindle="S{rpm} {turn}",
    closing=_FANUC_CLOSING,
    sweep_modes=("G21 G90 G17 G40 G49 G80 G94", "M5", "M9"),
    increments=("G91",),
    step={"x": "X", "y": "Y", "z": "Z"},
    dwell="G4 P{milliseconds}",
)

_SIEMENS_OPENING = ("; {name}",)
_SIEMENS_CLOSING = ("M5", "M9", "M30")

_SIEMENS_LATHE = Words(
    opening=_SIEMENS_OPENING,
    comment="; {}",
    notes=("Sinumerik language, not ISO mode; G97 keeps the feed per revolution of G95",),
    modes=("G710 G18 G40 G90", "G95", "G97 LIMS={limit_rpm}", "M9", "DIAMOF"),
    home="SUPA G0 {axis}{value} D0",
    home_in_radii=True,
    x_in_diameters=("DIAMON",),
    x_in_radii=("DIAMOF",),
    begin=("G54", "T{tool} D1"),
    spindle="G97 S{rpm} {turn}",
    closing=_SIEMENS_CLOSING,
    sweep_modes=("G710 G18 G40 G90 G94", "M5", "M9", "DIAMOF"),
    increments=("G91",),
    step={"x": "X", "y": "Y", "z": "Z"},
    dwell="G4 F{seconds}",
)

_SIEMENS_MILL = Words(
    opening=_SIEMENS_OPENING,
    comment="; {}",
    notes=(
        "Sinumerik language, not ISO mode",
        "The speed limit was checked when this was made; no word of it sets one",
    ),
    modes=("G710 G17 G40 G90", "G94", "M9"),
    home="SUPA G0 {axis}{value} D0",
    home_in_radii=False,
    x_in_diameters=(),
    x_in_radii=(),
    begin=("T{tool}", "M6", "G54 D1"),
    spindle="S{rpm} {turn}",
    closing=_SIEMENS_CLOSING,
    sweep_modes=("G710 G17 G40 G90 G94", "M5", "M9"),
    increments=("G91",),
    step={"x": "X", "y": "Y", "z": "Z"},
    dwell="G4 F{seconds}",
)

DIALECTS: dict[str, tuple[Words, Words]] = {
    "fanuc": (_FANUC_LATHE, _FANUC_MILL),
    "siemens": (_SIEMENS_LATHE, _SIEMENS_MILL),
}
"""The words of each control, on a lathe and on a mill."""
