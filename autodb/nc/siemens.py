"""Words of Siemens Sinumerik controls, their own language (not ISO mode).

G710 takes lengths and feeds in mm. G95, G96 and G97 are one group: G97 ends a constant cutting
speed and keeps the feed per revolution; LIMS limits the speed in G96 and G97. SUPA leaves out all
frames for one block and D0 the tool's offset. X is retracted as a radius (DIAMOF); DIAMON then
makes it a diameter. No program made with these words has run on a control.
"""

from autodb.nc.words import Words

_OPENING = ("; {name}",)
_CLOSING = ("M5", "M9", "M30")

LATHE = Words(
    opening=_OPENING,
    comment="; {}",
    notes=("Sinumerik language, not ISO mode; G97 keeps the feed per revolution of G95",),
    modes=("G710 G18 G40 G90", "G95", "G97 LIMS={limit_rpm}", "M9", "DIAMOF"),
    home="SUPA G0 {axis}{value} D0",
    home_in_radii=True,
    x_in_diameters=("DIAMON",),
    x_in_radii=("DIAMOF",),
    begin=("G54", "T{tool} D1"),
    spindle="G97 S{rpm} {turn}",
    closing=_CLOSING,
    sweep_modes=("G710 G18 G40 G90 G94", "M5", "M9", "DIAMOF"),
    increments=("G91",),
    step={"x": "X", "y": "Y", "z": "Z"},
    dwell="G4 F{seconds}",
)

MILL = Words(
    opening=_OPENING,
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
    closing=_CLOSING,
    sweep_modes=("G710 G17 G40 G90 G94", "M5", "M9"),
    increments=("G91",),
    step={"x": "X", "y": "Y", "z": "Z"},
    dwell="G4 F{seconds}",
)
