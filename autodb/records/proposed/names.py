"""What names of columns say, in the words of five languages: a quantity, an axis, a unit."""

import re
from dataclasses import dataclass

from autodb.files.channels import is_channel
from autodb.readers.text.cells import unit_within

_TOKENS = re.compile(r"[A-ZÄÖÜ]?[a-zäöüßáéíóúàèìòùâêçñ]+|[A-ZÄÖÜ]+(?![a-zäöü])|\d+")
AXES = ("x", "y", "z", "a", "b", "c", "u", "v", "w")
SPINDLE = ("spindle", "spindel", "spdl", "sp", "broche", "mandrino", "husillo", "cabezal")
COMMANDED = ("command", "cmd", "soll", "set", "setpoint", "target", "reference", "ref", "nominal")
QUANTITIES: dict[str, tuple[str, ...]] = {
    "position": ("position", "positions", "pos", "lage", "weg", "posizione", "posición", "encoder"),
    "velocity": (
        *("velocity", "vel", "geschwindigkeit", "vitesse", "velocità", "velocidad", "speed"),
        *("drehzahl", "rpm", "tacho", "taco"),
    ),
    "acceleration": ("acceleration", "acc", "accel", "beschleunigung", "accélération"),
    "current": ("current", "strom", "courant", "corrente", "corriente", "iq", "amps"),
    "torque": ("torque", "moment", "drehmoment", "couple", "coppia", "par"),
    "force": ("force", "kraft", "forza", "fuerza"),
    "power": ("power", "leistung", "puissance", "potenza", "potencia"),
    "temperature": ("temperature", "temp", "temperatur", "température", "temperatura"),
    "angle": ("angle", "winkel", "angolo", "ángulo"),
}
_TIME = ("t", "time", "zeit", "temps", "tempo", "tiempo", "timestamp", "zeitstempel", "when", "ts")
_CUTS: dict[str, tuple[str, ...]] = {
    "cut": ("cut", "nr", "no", "run", "schnitt", "versuch", "coupe", "essai", "prova", "ensayo"),
    "operation": ("operation", "bearbeitung", "opération", "lavorazione", "operación", "cycle"),
    "work.material": ("material", "werkstoff", "matériau", "matière", "materiale", "stoff"),
    "tool": ("tool", "werkzeug", "outil", "utensile", "herramienta"),
    "work.diameter": ("diameter", "durchmesser", "diamètre", "diametro", "diámetro", "od"),
    "spindle.speed": ("drehzahl", "rpm", "n", "spindlespeed", "giri", "revoluciones"),
    "cutting.speed": ("vc", "schnittgeschwindigkeit", "cuttingspeed", "vcm"),
    "cutting.feed": ("feed", "vorschub", "avance", "avanzamento", "fpr", "f", "fz", "feedrate"),
    "cutting.depth": ("depth", "tiefe", "schnitttiefe", "ap", "doc", "profondeur", "profondità"),
    "cutting.width": ("width", "ae", "breite", "eingriffsbreite", "largeur", "larghezza"),
    "tool.flank_wear": ("vb", "wear", "verschleiß", "usure", "usura", "desgaste"),
}
_FORCES = {"fx": "force.x", "fy": "force.y", "fz": "force.z"}
_COMPONENTS = {"fc": "force.y", "ff": "force.z", "fp": "force.x"}
"""Cutting, feed and passive force of turning (ISO 3002-4) in machine axes."""
_SYMBOLS = ("v", "a", "u", "w", "b", "c")
"""Names that are an axis as well as a quantity: a velocity, an acceleration, a voltage."""
COMPOUND = 5
"""Letters of a word from which on it is known in a compound. Chosen."""
_BRACKETS = re.compile(r"[\[(][^\[\]()]+[\])]\s*$")
_WITHOUT = re.compile(r"[\[(].*?[\])]|\b(mm|m|s|min|rev|n|k?hz|ms)\b(?=$)")


@dataclass(frozen=True)
class NameSays:
    """What a column's name says; an empty text or None where it does not.

    ``commanded``: it is wanted, not measured. ``foreign``: its unit is none that we know.
    """

    quantity: str = ""
    axis: str = ""
    unit: str = ""
    commanded: bool = False
    foreign: bool = False


def name_words(name: str) -> list[str]:
    """Return the words of a name in small letters.

    >>> name_words("X1_ActualPosition"), name_words("I_Z_Luft")
    (['x', '1', 'actual', 'position'], ['i', 'z', 'luft'])
    """
    return [token.casefold() for token in _TOKENS.findall(_WITHOUT.sub(" ", name))]


def said_by(name: str) -> NameSays:
    """Return what the name of a column of moves says.

    >>> said_by("X1_ActualVelocity").quantity, said_by("Strom Z [mA]").axis
    ('velocity', 'z')
    """
    words = name_words(name)
    joined = "".join(words)
    if joined in _SYMBOLS:
        return NameSays(unit=unit_within(name))
    quantity = next((q for q, known in QUANTITIES.items() if _any_of(words, known)), "")
    if not quantity and words[:1] == ["i"]:
        quantity = "current"
    numbered = words[:1] == ["s"] and words[1:2] and words[1].isdigit()
    axis = "spindle" if _any_of(words, SPINDLE) or numbered else ""
    axis = axis or next((word for word in words if word in AXES), "")
    if joined in _FORCES or joined in _COMPONENTS:
        quantity, axis = "force", (_FORCES | _COMPONENTS)[joined][-1]
    if not axis and len(joined) == 2 and joined[0] in "iv" and joined[1] in AXES:
        quantity, axis = {"i": "current", "v": "velocity"}[joined[0]], joined[1]
    commanded = bool(set(COMMANDED) & set(words)) or any(w.startswith("soll") for w in words)
    unit = unit_within(name)
    foreign = not unit and _BRACKETS.search(name) is not None
    return NameSays(quantity, axis, unit, commanded, foreign)


def _any_of(words: list[str], known: tuple[str, ...]) -> bool:
    """Say whether a word is among known ones, or a compound of a long one: `Istposition`."""
    long = [one for one in known if len(one) >= COMPOUND]
    return any(word in known or word.startswith((*long,)) or word.endswith((*long,))
               for word in words)  # fmt: skip


def is_time(name: str) -> bool:
    """Say whether a name is one of time.

    >>> is_time("Time (s)"), is_time("Zeit"), is_time("timeout")
    (True, True, False)
    """
    words = name_words(name) or [name.casefold()]
    return words in (["t"], ["ts"]) or words[0] in _TIME[1:-1] or words[-1] in _TIME[1:7]


def of_a_cut(name: str) -> str:
    """Return the column of a cut table that a name stands for; empty where it is none.

    >>> of_a_cut("Vorschub"), of_a_cut("a_p"), of_a_cut("Fc [kN]"), of_a_cut("remarks")
    ('cutting.feed', 'cutting.depth', 'force.y', '')
    >>> of_a_cut("Fz"), of_a_cut("fz")
    ('force.z', 'cutting.feed')
    """
    if is_channel(name):
        return name
    words = name_words(name)
    joined = "".join(words)
    if joined in _COMPONENTS or (joined in _FORCES and name.lstrip()[0] == "F"):
        return (_COMPONENTS | _FORCES)[joined]
    found = (c for c, known in _CUTS.items() if joined in known or words[:1] == [known[0]])
    return next(found, "")
