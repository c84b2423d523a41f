"""What shops call operations, in German, English, French, Italian and Spanish: suggestions alone.

A table that uses such a word is not taken to mean it: the side file says so.
"""

import unicodedata
from difflib import get_close_matches

WORDS: dict[str, tuple[str, ...]] = {
    "turn": (
        *("drehen", "längsdrehen", "langdrehen", "außenlängsdrehen", "überdrehen", "schruppdrehen"),
        *("schlichtdrehen", "außendrehen", "turning", "longitudinal turning", "straight turning"),
        *("cylindrical turning", "external turning", "od turning", "rough turning"),
        *("finish turning", "tournage", "chariotage", "tornitura", "tornitura cilindrica"),
        *("cilindratura", "torneado", "cilindrado"),
    ),
    "face": (
        *("plandrehen", "querplandrehen", "stirndrehen", "facing", "face turning", "dressage"),
        *("surfaçage en tournage", "sfacciatura", "intestatura", "refrentado"),
    ),
    "taper": (
        *("kegeldrehen", "konischdrehen", "taper turning", "tournage conique"),
        *("tornitura conica", "torneado cónico"),
    ),
    "contour": (
        *("konturdrehen", "formdrehen", "profildrehen", "contour turning", "profile turning"),
        *("copy turning", "contournage", "contornatura", "torneado de perfiles", "contorneado"),
    ),
    "slot": (
        *("nutenfräsen", "nutfräsen", "vollnutfräsen", "slotting", "slot milling", "rainurage"),
        *("fresatura di cave", "fresatura dal pieno", "ranurado"),
    ),
    "side-down": (
        *("gleichlauf", "gleichlauffräsen", "climb milling", "down milling", "down-milling"),
        *("fraisage en avalant", "fresatura concorde", "fresado en concordancia"),
    ),
    "side-up": (
        *("gegenlauf", "gegenlauffräsen", "conventional milling", "up milling", "up-milling"),
        *("fraisage en opposition", "fresatura discorde", "fresado en oposición"),
    ),
    "ramp": (
        *("rampenfräsen", "schräges eintauchen", "ramping", "ramp milling", "fraisage en rampe"),
        *("fresatura in rampa", "fresado en rampa"),
    ),
    "pocket": (
        *("taschenfräsen", "pocketing", "pocket milling", "fraisage de poche"),
        *("fresatura di tasche", "svuotamento", "cajeado", "fresado de cajeras"),
    ),
    "drill": ("bohren", "vollbohren", "drilling", "perçage", "foratura", "taladrado"),
}
OTHERS = (
    *("einstechen", "abstechen", "ausdrehen", "innendrehen", "gewindedrehen", "gewindeschneiden"),
    *("planfräsen", "stirnfräsen", "reiben", "senken", "grooving", "parting", "parting off"),
    *("boring", "threading", "tapping", "reaming", "face milling", "surfaçage", "alésage"),
    *("filetage", "tronçonnage", "alesatura", "filettatura", "troncatura", "spianatura"),
    *("mandrinado", "roscado", "tronzado", "planeado", "escariado"),
)
"""Operations that are none of ours, so that no like word is suggested for them."""
LIKE = 0.85
"""How like a word must be to one above, of `difflib`. Chosen: a letter in seven."""


def _bare(word: str) -> str:
    """Return a word without accents, case, hyphens and doubled spaces."""
    letters = unicodedata.normalize("NFKD", word.casefold().replace("-", " ").replace("_", " "))
    return " ".join("".join(c for c in letters if not unicodedata.combining(c)).split())


def suggested_operation(word: str) -> str | None:
    """Return the operation that a shop's word most likely means, or None.

    >>> suggested_operation("Längsdrehen"), suggested_operation("CHARIOTAGE")
    ('turn', 'turn')
    >>> suggested_operation("Gewindedrehen") is None
    True
    """
    known = {_bare(one): name for name, words in WORDS.items() for one in (name, *words)}
    every = [*known, *map(_bare, OTHERS)]
    close = get_close_matches(_bare(word), every, n=1, cutoff=LIKE)
    return known.get(close[0]) if close else None
