"""Words with a name, of Sinumerik: those that move nothing, and those that are read elsewhere."""

from collections.abc import Mapping

HARMLESS_NAMES = frozenset(
    {"MSG", "STOPRE", "SOFT", "BRISK", "DRIVE", "FFWON", "FFWOF", "COMPOF", "COMPON", "COMPCAD"}
    | {"COMPCURV", "CYCLE832", "ORIWKS", "ORIMKS", "ORIAXES", "ORIVECT", "TRAFOOF", "CFC", "CFTCP"}
    | {"CFIN", "UPATH", "SPATH", "FIFOCTRL", "SETMS", "WORKPIECE", "G60", "KONT", "NORM", "KONTT"}
    | {"KONTC", "WALIMON", "WALIMOF", "SUPA", "FGROUP", "DIAMCYCOF", "ROTS0", "CUTCONON"}
    | {"CUTCONOF", "TOFFON", "TOFFOF", "ADISPOS", "TRAORI_OF", "SAVE", "DISPLOF", "GROUP_BEGIN"}
    | {"GROUP_END", "F_HEAD", "E_HEAD", "STOPFIFO", "STARTFIFO", "PRESETON0", "TOWSTD", "SPCON"}
    | {"SPCOF", "FNORM", "FLIN", "ACC", "VELOLIM", "ACCLIMA", "JERKLIM"}
    | {"EXTERN", "ASPLINE_OF", "SBLON", "SBLOF", "FENDNORM", "IPOBRKA", "LFOF", "LFON"}
    | {"DYNNORM", "DYNPOS", "DYNROUGH", "DYNSEMIFIN", "DYNFINISH", "DYNPREC", "RTLION", "RTLIOF"}
    | {"CUT2D", "CUT2DF", "COMPSURF", "CPRECON", "CPRECOF", "CDON", "CDOF", "WALCS0", "WAITS"}
    | {"CUTMOF", "WAITM", "WAITE", "OSOF", "SOFTA", "BRISKA"}
)
"""They change what the machine does on its way, not where the tool goes."""
CALLS = frozenset(
    {"CYCLE62", "CYCLE81", "CYCLE82", "CYCLE83", "CYCLE84", "CYCLE85", "CYCLE86", "CYCLE87"}
    | {"CYCLE88", "CYCLE89", "CYCLE93", "CYCLE95", "CYCLE97", "CYCLE99", "CYCLE952", "MCALL"}
    | {"CYCLE840", "CYCLE800", "CYCLE801", "HOLES1", "HOLES2", "POCKET3", "POCKET4"}
    | {"SLOT1", "SLOT2", "LONGHOLE"}
)
"""Calls of cycles of the control."""
MODES_BY_NAME = frozenset(
    {"DIAMON", "DIAMOF", "DIAM90", "TRANS", "ATRANS", "ROT", "AROT", "MIRROR", "AMIRROR", "SCALE"}
    | {"ASCALE", "LIMS", "CR", "RND", "RNDM", "CHF", "CHR", "ANG", "SPOS", "SF", "FRC", "FRCM"}
    | {"TURN", "AC", "IC"}
)
NAMES = HARMLESS_NAMES | CALLS | MODES_BY_NAME
"""Names that are no subprograms of the program's own."""
REFUSED_NAMES: Mapping[str, str] = {
    **dict.fromkeys(
        ("TRAORI", "TRANSMIT", "TRACYL", "TRAANG", "TOFRAME", "TOROT", "PAROT"),
        (
            "this moves axes together with a table or a head; only X, Y and Z of one position are "
            "read: give what is cut in each as a program of its own"
        ),
    ),
    **dict.fromkeys(
        ("CT", "CIP", "INVCW", "INVCCW"),
        ("this is an arc by a tangent or by a place on it; program it by G2 or G3"),
    ),
    **dict.fromkeys(
        ("ASPLINE", "BSPLINE", "CSPLINE", "POLY"), "this is a spline; program lines and arcs"
    ),
}
"""Words with a name that change where the tool goes, and are not read."""
REFUSED_SETTINGS: Mapping[str, str] = {
    **dict.fromkeys(("FB", "FZ"), "this feed is of one block or of a tooth; state F"),
    **dict.fromkeys(("OVR", "OVRA"), "this changes the feed; state it by F"),
    **dict.fromkeys(("POS", "POSA", "POSP"), "this moves an axis by itself; use G0 or G1"),
    **dict.fromkeys(("MEAS", "MEAW"), "this probes until the work is touched; leave out probing"),
    **dict.fromkeys(
        ("TCARR", "TOFFL", "TOFFR", "TOFF"), "this moves the tool's tip; state it with the tool"
    ),
}
"""Names of Sinumerik with = that are no variables of a program."""
