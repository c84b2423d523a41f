"""How a control writes what a program says: its words as data, one table a control and machine.

Templates are filled with ``{name}``, ``{limit_rpm}``, ``{tool}``, ``{retract_z}``, and the ones of
their own fields. Numbers have a decimal point: without one some controls count in thousandths.
"""

import unicodedata
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from autodb.nc.steps import StraightMove

Lines = tuple[str, ...]


@dataclass(frozen=True)
class Words:
    """The words of one control on a lathe or a mill.

    ``modes`` come before the first motion, ``home`` retracts an axis in machine coordinates and
    ``begin`` calls tool and offset after it. ``x_in_diameters`` and ``x_in_radii`` say how X counts
    from then on; ``home_in_radii``: X counts as a radius in ``home`` whatever they say.
    ``sweep_modes``: modes of a program at a feed per minute; ``increments``: what then makes moves
    increments, after the last place in machine coordinates, which is absolute; ``step``: the letter
    of an axis' increment; ``dwell``: a rest of ``{seconds}`` or ``{milliseconds}``.
    """

    opening: Lines
    comment: str
    notes: Lines
    modes: Lines
    home: str
    home_in_radii: bool
    x_in_diameters: Lines
    x_in_radii: Lines
    begin: Lines
    spindle: str
    closing: Lines
    sweep_modes: Lines
    increments: Lines
    step: Mapping[str, str]
    dwell: str

    def said(self, text: str) -> str:
        """Return a comment: capital letters of ASCII, without brackets of its own."""
        plain = unicodedata.normalize("NFKD", text.replace("Ø", "dia ").replace("'", ""))
        ascii_only = plain.encode("ascii", "ignore").decode()
        return self.comment.format(" ".join(ascii_only.translate(_BRACKETS).upper().split()))

    def moved(self, move: StraightMove, *, x_factor: float) -> str:
        """Return the block of a move; ``x_factor`` is 2 where X counts in diameters."""
        kind = "G0" if move.feed is None else "G1"
        words = [kind, *coordinate_words(move, x_factor=x_factor)]
        return " ".join(words if move.feed is None else [*words, f"F{move.feed:.3f}"])


_BRACKETS = str.maketrans("();", "[],")


def coordinate_words(move: StraightMove, *, x_factor: float) -> Iterator[str]:
    """Yield the words of a move's coordinates, X first."""
    for axis in sorted(move.to):
        factor = x_factor if axis == "x" else 1.0
        yield f"{axis.upper()}{factor * move.to[axis]:.3f}"
