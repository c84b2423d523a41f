"""What names of columns say, in the words of five languages: a quantity, an axis, a unit."""

import re
from collections.abc import Collection
from dataclasses import dataclass

from autodb.readers.text.cells import name_and_unit, unit_within

_TOKENS = re.compile(r"[A-ZÄÖÜ]?[a-zäöüßáéíóúàèìòùâêçñ]+|[A-ZÄÖÜ]+(?![a-zäöü])|\d+")
AXES = ("x", "y", "z", "a", "b", "c", "u", "v", "w")
SPINDLE = ("spindle", "spindel", "spdl", "sp", "broche", "mandrino", "husillo", "cabezal")
COMMANDED = (
    *("command", "commanded", "cmd", "soll", "set", "setpoint", "target", "reference", "ref"),
    *("nominal", "forward", "feedforward", "ffw"),
)
QUANTITIES: dict[str, tuple[str, ...]] = {
    "position": ("position", "positions", "pos", "lage", "weg", "posizione", "posición", "encoder"),
    "velocity": (
        *("velocity", "vel", "geschwindigkeit", "vitesse", "velocità", "velocidad", "speed"),
        *("drehzahl", "rpm", "tacho", "taco"),
    ),
    "acceleration": ("acceleration", "acc", "accel", "beschleunigung", "accélération"),
    "current": ("current", "strom", "courant", "corrente", "corriente", "iq", "amps"),
    "torque": ("torque", "moment", "drehmoment", "couple", "coppia", "par"),
    "force": ("force", "kraft", "forza", "fuerza", "thrust"),
    "power": ("power", "leistung", "puissance", "potenza", "potencia"),
    "temperature": ("temperature", "temp", "temperatur", "température", "temperatura"),
    "angle": ("angle", "winkel", "angolo", "ángulo"),
}
_UNIT_WORDS: dict[str, dict[str, str]] = {
    "position": {"mm": "mm", "um": "um", "m": "m", "deg": "deg", "rad": "rad"},
    "velocity": {"rpm": "rpm", "rps": "rps", "hz": "Hz", "rad": ""},
    "current": {"a": "A", "ma": "mA"},
    "torque": {"nm": "N*m", "mnm": "mN*m", "ncm": "cN*m"},
    "force": {"n": "N", "kn": "kN", "gf": "gram_force", "kgf": "kgf", "lbf": "lbf"},
    "power": {"w": "W", "kw": "kW", "mw": "mW"},
    "temperature": {"c": "degC", "degc": "degC", "k": "K"},
    "angle": {"deg": "deg", "rad": "rad"},
}
"""Last words of names that are units, by quantity; empty: a unit that is not all of it."""
COUNTS = frozenset(("raw", "counts", "adc", "lsb", "pct", "percent", "ratio", "prozent", "duty"))
"""Words of numbers that are in no unit of their quantity."""
_TIME = ("t", "time", "zeit", "temps", "tempo", "tiempo", "timestamp", "zeitstempel", "when", "ts")
FORCES_BY_AXIS = {"fx": "force.x", "fy": "force.y", "fz": "force.z"}
COMPONENTS = {"fc": "force.y", "ff": "force.z", "fp": "force.x"}
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

    >>> name_words("X1_ActualPosition"), name_words("Schnittkraft / N")
    (['x', '1', 'actual', 'position'], ['schnittkraft'])
    """
    plain = _WITHOUT.sub(" ", name_and_unit(name)[0])
    return [token.casefold() for token in _TOKENS.findall(plain)]


def said_by(name: str, beside: Collection[str] = ()) -> NameSays:
    """Return what the name of a column of moves says, ``beside`` those of other columns.

    A letter behind a low line is a unit, unless another column has the letter of another axis.

    >>> said_by("X1_ActualVelocity").quantity, said_by("Strom Z [mA]").axis
    ('velocity', 'z')
    >>> said_by("current_a"), said_by("A_current").axis
    (NameSays(quantity='current', axis='', unit='A', commanded=False, foreign=False), 'a')
    """
    words = name_words(name)
    joined = "".join(words)
    if joined in _SYMBOLS:
        return NameSays(unit=unit_within(name))
    quantity = next((q for q, known in QUANTITIES.items() if _any_of(words, known)), "")
    if not quantity and words[:1] == ["i"]:
        quantity = "current"
    numbered = words[:1] == ["s"] and words[1:2] and words[1].isdigit()
    unit = unit_within(name)
    known = _UNIT_WORDS.get(quantity, {})
    if "_" in name and words[-1] in known and words[0] != "i" and not _of_axes(name, beside):
        unit, words = unit or _UNIT_WORDS[quantity][words[-1]], words[:-1]
    axis = "spindle" if _any_of(words, SPINDLE) or numbered else ""
    axis = axis or next((word for word in words if word in AXES), "")
    if name_and_unit(name.strip())[0] == "F":
        quantity = "force"
    if joined in FORCES_BY_AXIS or joined in COMPONENTS:
        quantity, axis = "force", (FORCES_BY_AXIS | COMPONENTS)[joined][-1]
    if not axis and len(joined) == 2 and joined[0] in "iv" and joined[1] in AXES:
        quantity, axis = {"i": "current", "v": "velocity"}[joined[0]], joined[1]
    commanded = bool(set(COMMANDED) & set(words)) or any(w.startswith("soll") for w in words)
    foreign = not unit and (_BRACKETS.search(name) is not None or not COUNTS.isdisjoint(words))
    return NameSays(quantity, axis, unit, commanded, foreign)


def _of_axes(name: str, beside: Collection[str]) -> bool:
    """Say whether another name differs by the letter of an axis at its end alone."""
    stem, letter = name[:-1], name[-1]
    return any(stem + other in beside for axis in AXES for other in (axis, axis.upper())
               if other.casefold() != letter.casefold())  # fmt: skip


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
