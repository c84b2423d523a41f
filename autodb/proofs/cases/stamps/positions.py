"""Even stamps, and a position that wraps or overflows: what looks like a fault of time."""

from dataclasses import replace

import numpy as np

from autodb.proofs.cases.stamps.axis_rows import AxisDraw
from autodb.proofs.cases.stamps.programme import Array
from autodb.proofs.cases.stamps.stamped import (
    Rng,
    StampedRows,
    StampKind,
    Write,
    even_rows,
    seconds_texts,
)

TURN_DEG = 360.0
COUNTS = 2**16
MODULI = (0.15, 0.6)
"""Of the travel: how far a counter of 16 bits reaches. Chosen: it wraps at least once."""
LAST = 0.93
"""Of the travel: where a counter overflows that only the last move reaches (0.85 are passed)."""


def _with_position(draw: AxisDraw, position: Array, drawn: dict[str, float]) -> StampedRows:
    rows = replace(even_rows(draw), position=position)
    return StampedRows(rows, seconds_texts(draw.grid_s), "", drawn)


def _counter(rng: Rng, draw: AxisDraw) -> StampedRows:
    """Counts of 16 bits, turned into mm; the resolution is that of the counter."""
    reach = float(rng.uniform(*MODULI) * draw.programme.motion(draw.grid_s).x.max())
    step = reach / COUNTS
    counts = np.round(draw.programme.motion(draw.grid_s).x / step)
    return _with_position(draw, (counts % COUNTS) * step, {"wraps at": reach})


def _angle(low_deg: float) -> Write:
    """Return what writes an angle that wraps at a turn, from ``low_deg`` on."""

    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        del rng
        angle = even_rows(draw).position
        return _with_position(draw, (angle - low_deg) % TURN_DEG + low_deg, {"wraps at": TURN_DEG})

    return write


def _overflow(rng: Rng, draw: AxisDraw) -> StampedRows:
    """The counter's sign turns over once, in the last move: it falls by its whole range."""
    position = even_rows(draw).position
    limit = LAST * float(position.max())
    fall = float(rng.choice([2.0 * limit, limit]))
    wrapped = np.where(position >= limit, position - fall, position)
    return _with_position(draw, wrapped, {"falls by": fall})


def _unwrapped(rng: Rng, draw: AxisDraw) -> StampedRows:
    del rng
    return _with_position(draw, even_rows(draw).position, {})


POSITIONS = (
    StampKind("rotary, even", "A rotary axis with even stamps, whose angle does not wrap.",
              "What the next two kinds are compared with.", _unwrapped, plain=True, rotary=True),
    StampKind("16 bit position", "The position is a counter of 16 bits in mm, and wraps.",
              "Encoder inputs of 16 bits.", _counter),
    StampKind("angle of 0 to 360", "The angle of a rotary axis wraps at a turn.",
              "Modulo axes of SINUMERIK and TwinCAT.", _angle(0.0), rotary=True),
    StampKind("angle of ±180", "The angle of a rotary axis wraps at half a turn.",
              "Resolvers, atan2.", _angle(-180.0), rotary=True),
    StampKind("position overflows", "A position overflows once, in the last move.",
              "Signed counters.", _overflow),
)  # fmt: skip
