"""A stamped recording: rows, the text of each row's stamp, a side file where one is given."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from autodb.proofs.cases.stamps.axis_rows import RATES_HZ, AxisDraw, SampledRows
from autodb.proofs.cases.stamps.programme import Array

Rng = np.random.Generator
Texts = list[str]
UNEVEN_HZ = (300.0, 400.0, 800.0, 1600.0)
"""Rates whose step is no whole number of milliseconds."""


@dataclass(frozen=True)
class StampedRows:
    """What a logger wrote: rows in the order of the file, their stamps, the side file's text.

    ``drawn`` holds what was drawn of the kind, for whoever looks at a recording.
    """

    rows: SampledRows
    stamps: Texts
    side: str = ""
    drawn: dict[str, float] = field(default_factory=dict)


Write = Callable[[Rng, AxisDraw], StampedRows]


@dataclass(frozen=True)
class StampKind:
    """One kind of stamps: name, what is the case, why there are such files, and how to write one.

    A recording of any kind may be refused in one line, but of a ``plain`` one; whatever is answered
    must be right. ``rates_hz`` are those at which the kind does what it says.
    """

    name: str
    sentence: str
    reason: str
    write: Write
    plain: bool = False
    rates_hz: tuple[float, ...] = RATES_HZ
    rotary: bool = False


def seconds_texts(t_s: Array, digits: int = 6) -> Texts:
    """Return times as a logger prints them, with ``digits`` behind the point."""
    return [f"{value:.{digits}f}" for value in t_s.tolist()]


def whole_texts(counts: Array) -> Texts:
    """Return whole numbers as a logger prints them."""
    return [str(round(value)) for value in counts.tolist()]


def unit_side(unit: str) -> str:
    """Return the side file that states the unit of ``t``."""
    return f'[channels]\n"t" = {{column = "t", unit = "{unit}"}}\n'


def even_rows(draw: AxisDraw) -> SampledRows:
    """Return what is sampled evenly."""
    return draw.rows(draw.grid_s)
