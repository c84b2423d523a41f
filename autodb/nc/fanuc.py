"""Words of Fanuc controls.

Lathes in G-code system A, the one that most are delivered with: there G99 is feed per revolution,
G98 per minute, ``G50 S`` the highest speed, X and Z are absolute, and G90 is a turning cycle. In
systems B and C these are G95, G94, ``G92 S`` and G90: such a lathe must not run this program.
Mills have one set of codes; G53 counts with G90 only, so that increments (G91) come after it. No
program made with these words has run on a control.
"""

from autodb.nc.words import Words

_OPENING = ("%", "O0101 ({name})")
_CLOSING = ("M5", "M9", "M30", "%")

LATHE = Words(
    opening=_OPENING,
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
    closing=_CLOSING,
    sweep_modes=("G21 G18 G40 G80 G98", "M5", "M9"),
    increments=(),
    step={"x": "U", "y": "V", "z": "W"},
    dwell="G4 P{milliseconds}",
)

MILL = Words(
    opening=_OPENING,
    comment="({})",
    notes=("The speed limit was checked when this was made; no word of it sets one",),
    modes=("G21 G90 G17 G40 G49 G80 G94", "M9"),
    home="G0 G53 {axis}{value}",
    home_in_radii=False,
    x_in_diameters=(),
    x_in_radii=(),
    begin=("T{tool} M6", "G54", "G0 G43 H{tool} Z{retract_z}"),
    spindle="S{rpm} {turn}",
    closing=_CLOSING,
    sweep_modes=("G21 G90 G17 G40 G49 G80 G94", "M5", "M9"),
    increments=("G91",),
    step={"x": "X", "y": "Y", "z": "Z"},
    dwell="G4 P{milliseconds}",
)
