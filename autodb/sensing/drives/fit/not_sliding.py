"""Effort while the axis does not slide as its laws of friction say: at rest, and after it turned.

At rest the drive holds what the last move left, anything up to breakaway; after a reversal the
contacts of guide, nut and seals bend before they slide, and friction rises to its law over a way
(Dahl 1968; P2 names both gaps). Laws over speed claim 0 at rest and the whole level from the first
micrometre on. Coloured noise is nearly constant over a move, so that its whitening leaves the steps
at the ends of moves as nearly all that tells Coulomb friction from a load: just these rows. The
level then reads low and viscous friction high: on two thirds of EMPS, a published ball-screw, 18.0
and 18.8 N, where 20.4 N is published and plain least squares finds it.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.fit.drive_errors import TURN_MM
from autodb.sensing.drives.moves.prepared import Prepared
from autodb.terms.friction import since_reversal

Array = NDArray[np.float64]

WAYS_MM = TURN_MM * np.array([0.03, 0.1, 0.3, 1.0])
"""Ways over which friction comes to its law, in mm (degrees of a rotary axis), up to where an axis
counts as having just turned: pre-sliding of published axes ends within 0.1 mm, play is as large.
"""
MOST_RESTS = 40
"""Rests that hold a load of their own; of more, neighbours count as one. Chosen."""


def friction_after_turns(rows: Prepared) -> Array:
    """Return columns (m, 4): the direction, fading over each way gone since the axis turned."""
    sense, way_mm = since_reversal(rows.inputs["direction"], rows.inputs["position"])
    fades = np.exp(-way_mm[:, None] / WAYS_MM)
    return rows.reduced(sense[:, None] * fades)


def held_at_rest(rows: Prepared) -> Array:
    """Return columns (m, rests): 1 while the axis stands, fading to 0 as it starts or stops."""
    moves = np.minimum(np.abs(rows.inputs["direction"]), 1.0)
    still = moves < 1.0
    begins = still & ~np.concatenate([[False], still[:-1]])
    rest = np.maximum(np.cumsum(begins) - 1, 0)
    together = -(-(int(rest[-1]) + 1) // MOST_RESTS)
    held = np.zeros((len(moves), int(rest[-1]) // together + 1))
    held[np.arange(len(moves)), rest // together] = 1.0 - moves
    columns = rows.reduced(held)
    return columns[:, columns.any(axis=0)]
