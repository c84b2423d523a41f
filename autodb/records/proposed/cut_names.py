"""What names of columns say in a table of cuts, in the words of five languages."""

import re

from autodb.errors import UnusableInput
from autodb.files.channels import is_channel, unit_of
from autodb.files.units import conversion
from autodb.readers.text.cells import name_and_unit
from autodb.records.proposed.names import COMPONENTS, FORCES_BY_AXIS, name_words, said_by

_NUMBERING = ("no", "nr", "num", "number", "id", "nº", "index")
"""Words that may end the name of a cut, a tool or a material."""
_CUTS: dict[str, tuple[str, ...]] = {
    "cut": (
        *("cut", "run", "runorder", "schnitt", "versuch", "coupe", "essai", "prova", "ensayo"),
        *("exp", "experiment", "test", "trial", "sample", "s", "sl", "sr", "lfd", *_NUMBERING),
    ),
    "operation": (
        *("operation", "bearbeitung", "opération", "lavorazione", "operación", "cycle"),
        *("verfahren", "arbeitsgang", "bearbeitungsart", "fertigungsverfahren"),
    ),
    "work.material": (
        *("material", "werkstoff", "matériau", "matière", "materiale", "stoff"),
        *("workmaterial", "workpiecematerial"),
    ),
    "tool": (
        *("tool", "werkzeug", "outil", "utensile", "herramienta", "insert", "schneidplatte"),
        *("wendeschneidplatte", "wendeplatte", "cuttinginsert", "plaquette", "inserto", "plaquita"),
    ),
    "work.diameter": (
        *("diameter", "durchmesser", "diamètre", "diametro", "diámetro", "od", "ø", "⌀", "dia"),
        *("workdiameter", "workpiecediameter", "werkstückdurchmesser", "rohdurchmesser"),
    ),
    "spindle.speed": ("drehzahl", "rpm", "n", "spindlespeed", "giri", "revoluciones"),
    "cutting.speed": (
        *("vc", "schnittgeschwindigkeit", "cuttingspeed", "vcm", "vitessedecoupe"),
        *("velocidaddecorte", "velocitàditaglio"),
    ),
    "cutting.feed": (
        *("feed", "vorschub", "avance", "avanzamento", "fpr", "f", "fz", "fn", "feedrate"),
        *("feedperrev", "feedperrevolution", "feedpertooth"),
    ),
    "cutting.depth": (
        *("depth", "depthofcut", "tiefe", "schnitttiefe", "ap", "doc", "profondeur", "profondità"),
        *("profundidad", "cuttingdepth", "axialdepth", "axialdepthofcut", "profondeurdepasse"),
        *("profonditàdipassata", "profonditàditaglio", "profundidaddecorte", "profundidaddepasada"),
    ),
    "cutting.width": (
        *("width", "widthofcut", "ae", "breite", "eingriffsbreite", "largeur", "larghezza"),
        *("radialdepth", "radialdepthofcut", "ancho", "cuttingwidth", "stepover"),
    ),
    "cut.duration": (
        *("duration", "cutduration", "dauer", "schnittdauer", "durée", "durata", "duración"),
        *("machiningtime", "bearbeitungszeit"),
    ),
    "tool.flank_wear": (
        *("vb", "wear", "verschleiß", "usure", "usura", "desgaste", "flankwear"),
        *("freiflächenverschleiß", "verschleißmarkenbreite"),
    ),
    "force.y": (
        *(
            "schnittkraft",
            "hauptschnittkraft",
            "cuttingforce",
            "tangentialforce",
            "maincuttingforce",
        ),
        *("effortdecoupe", "forcedecoupe", "fuerzadecorte", "forzaditaglio", "tangentialkraft"),
    ),
    "force.z": (
        *(
            "vorschubkraft",
            "feedforce",
            "axialforce",
            "axialkraft",
            "effortdavance",
            "forcedavance",
        ),
        *("fuerzadeavance", "forzadiavanzamento", "forceaxiale", "fuerzaaxial", "forzaassiale"),
    ),
    "force.x": (
        *("passivkraft", "passiveforce", "radialforce", "radialkraft", "backforce", "forceradiale"),
        *("effortradial", "fuerzaradial", "forzaradiale"),
    ),
}
"""Names without spaces and signs, by what they name."""
_UNIT_ENDS = re.compile(r"(?<=\w)[_ ](mm|mm_?(per_)?(rev|tooth|r|z|u)|m_?(per_)?min|rpm|N)$")
"""Units of ours behind a low line."""


def of_a_cut(name: str) -> str:
    """Return the column of a cut table that a name stands for; empty where it is none.

    >>> of_a_cut("Vorschub"), of_a_cut("a_p"), of_a_cut("Fc [kN]"), of_a_cut("remarks")
    ('cutting.feed', 'cutting.depth', 'force.y', '')
    >>> of_a_cut("Fz"), of_a_cut("fz"), of_a_cut("Feed force (N)"), of_a_cut("tool life")
    ('force.z', 'cutting.feed', 'force.z', '')
    >>> of_a_cut("Ø [mm]"), of_a_cut("Verfahren"), of_a_cut("Schneidplatte")
    ('work.diameter', 'operation', 'tool')
    """
    if is_channel(name):
        return name
    plain, unit = name_and_unit(name.strip())
    bare = _UNIT_ENDS.sub("", plain)
    found = _of_words(bare, unit)
    head, _, symbol = bare.rpartition(" ")
    if found or not head:
        return found
    said = of_a_cut(head)
    return said if said == of_a_cut(symbol) else ""


def _of_words(name: str, unit: str) -> str:
    words = name_words(name) or [name.casefold()]
    joined = "".join(words)
    if joined in COMPONENTS or (joined in FORCES_BY_AXIS and name[0] == "F"):
        return (COMPONENTS | FORCES_BY_AXIS)[joined]
    if joined == "speed" and unit:
        able = ("spindle.speed", "cutting.speed")
        return next((channel for channel in able if has_unit_of(channel, unit)), "")
    said = said_by(name)
    if said.quantity == "force" and said.axis in ("x", "y", "z") and joined not in FORCES_BY_AXIS:
        return f"force.{said.axis}"
    while len(words) > 1 and words[-1] in _NUMBERING:
        words = words[:-1]
    found = (channel for channel, known in _CUTS.items() if "".join(words) in known)
    return next(found, "")


def has_unit_of(channel: str, unit: str) -> bool:
    """Say whether numbers in ``unit`` can become a channel's.

    >>> has_unit_of("cutting.feed", "mm/rev"), has_unit_of("cutting.feed", "mm/min")
    (True, False)
    """
    try:
        conversion(unit, to=unit_of(channel) or "1", where="")
    except UnusableInput:
        return False
    return True
