"""Words with a name, of Sinumerik: those that move nothing, and those that are read elsewhere."""

HARMLESS_NAMES = frozenset(
    {"MSG", "STOPRE", "SOFT", "BRISK", "DRIVE", "FFWON", "FFWOF", "COMPOF", "COMPON", "COMPCAD"}
    | {"COMPCURV", "CYCLE832", "ORIWKS", "ORIMKS", "ORIAXES", "ORIVECT", "TRAFOOF", "CFC", "CFTCP"}
    | {"CFIN", "UPATH", "SPATH", "FIFOCTRL", "SETMS", "WORKPIECE", "G60", "KONT", "NORM", "KONTT"}
    | {"KONTC", "WALIMON", "WALIMOF", "SUPA", "FGROUP", "DIAMCYCOF", "ROTS0", "CUTCONON"}
    | {"CUTCONOF", "TOFFON", "TOFFOF", "ADISPOS", "TRAORI_OF", "SAVE", "DISPLOF", "GROUP_BEGIN"}
    | {"GROUP_END", "F_HEAD", "E_HEAD", "STOPFIFO", "STARTFIFO", "PRESETON0", "TOWSTD", "SPCON"}
    | {"SPCOF", "FNORM", "FLIN", "ACC", "OVR", "VELOLIM", "ACCLIMA", "JERKLIM", "CYCLE800"}
    | {"EXTERN", "ASPLINE_OF", "SBLON", "SBLOF", "FENDNORM", "IPOBRKA", "LFOF", "LFON"}
)
"""They change what the machine does on its way, not where the tool goes."""
CALLS = frozenset(
    {"CYCLE62", "CYCLE81", "CYCLE82", "CYCLE83", "CYCLE84", "CYCLE85", "CYCLE86", "CYCLE87"}
    | {"CYCLE88", "CYCLE89", "CYCLE93", "CYCLE95", "CYCLE97", "CYCLE99", "CYCLE952", "MCALL"}
    | {"CYCLE840", "HOLES1", "HOLES2"}
)
"""Calls of cycles of the control."""
MODES_BY_NAME = frozenset(
    {"DIAMON", "DIAMOF", "DIAM90", "TRANS", "ATRANS", "ROT", "AROT", "MIRROR", "AMIRROR", "SCALE"}
    | {"ASCALE", "LIMS", "CR", "RND", "RNDM", "CHF", "CHR", "ANG", "SPOS", "SF", "FRC", "FRCM"}
    | {"CIP", "CT", "POLY", "TURN", "AC", "IC"}
)
NAMES = HARMLESS_NAMES | CALLS | MODES_BY_NAME
"""Names that are no subprograms of the program's own."""
