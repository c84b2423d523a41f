"""Friction that differs from run to run: a random part of each run, beside the laws.

Friction of a real axis is never twice the same: three runs of the same passes differ by ± 10 %
(P2, section III). What one run has of its own is no parameter of the axis, but hides the mean that
the laws are about: their intervals hold only if it counts. A run is a stroke there with the one
back, because what strokes there have of their own beside strokes back is weight or asymmetry. Its
parts are normal, with sizes that the rows show (restricted maximum likelihood,
``fitting.deviation``): none where runs agree. In a sweep over speeds a run is a speed: what is its
own is not told from what friction deviates by there.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.fit.deviation import SPEED, follows
from autodb.sensing.drives.fit.linearised import Linearised
from autodb.sensing.drives.moves.motion import motion_blocks
from autodb.sensing.drives.moves.prepared import Prepared

Array = NDArray[np.float64]

MOST_RUNS = 40
"""Runs told apart; of more, neighbours count as one: the mean of all is as unsure. Chosen."""
FEWEST_RUNS = 6
"""Runs that tell how far they differ at least. Chosen."""
SLOW_SHARE = 0.3
"""Correlation time of what wanders slowly, as a share of the recorded time. Chosen of 0.1 and 0.3
on the axes of ``tests/helpers/wandering_axis.py``: what wanders faster runs hold as well, what
wanders slower cannot be told from the mean.
"""


WANDER_SHARE = 0.1
"""Share by which friction likely differs from run to run: runs of P2 differ by ± 10 %. It matters
where few runs show a speed: one with rapids took their friction for its own, and viscous friction
was told by what happens near standstill, ten times too high (the x axis of a mill, SMART lab)."""


@dataclass(frozen=True)
class Wander:
    """Groups of columns (m, runs) by which friction of each run may differ.

    ``likely``: how large each group's size is taken to be beforehand. ``blocks`` (m,): rows that
    are left out together to see how sure the laws are.
    """

    groups: list[Array]
    likely: list[float]
    blocks: NDArray[np.intp]


def friction_wander(rows: Prepared, problem: Linearised, *, tells: bool) -> Wander:
    """Return how friction of each run may differ: a share of all of it, and what grows with the
    speed, each run by itself; and a share that wanders slowly in time, so that neighbouring runs
    are alike.

    ``tells``: whether the rows can tell it. Where not, or with too few runs, there are no groups,
    and blocks of motion.
    """
    sense, t = rows.sampled("direction"), rows.sampled("t")
    run = runs(sense)
    count = int(run[-1]) + 1
    if not tells or count < FEWEST_RUNS:
        return Wander([], [], motion_blocks(t, sense))
    friction = friction_of(problem)
    fast = rows.reduced(rows.inputs["velocity"])
    member = np.eye(count)[run]
    middle = np.bincount(run, t) / np.bincount(run)
    apart = np.abs(np.subtract.outer(middle, middle)) / (SLOW_SHARE * (t[-1] - t[0]))
    alike = np.linalg.cholesky(np.exp(-apart) + 1e-9 * np.eye(count))
    groups = [friction[:, None] * m for m in (member, member @ alike)]
    # What grows with the speed is a share of friction at the run's own highest: a slow run tells
    # nothing of how far fast ones differ
    highest, rubs = (_largest(np.abs(one), run) for one in (fast, friction))
    groups.append((fast * rubs / np.maximum(highest, np.finfo(float).tiny))[:, None] * member)
    return Wander(groups, [WANDER_SHARE] * 3, run)


def _largest(values: Array, run: NDArray[np.intp]) -> Array:
    """Return the largest of the values (m,) of each row's run, (m,)."""
    found = np.zeros(int(run[-1]) + 1)
    np.maximum.at(found, run, values)
    return found[run]


def friction_of(problem: Linearised) -> Array:
    """Return friction over speed (m,) by plain least squares of the laws."""
    told = np.linalg.lstsq(problem.columns, problem.target, rcond=1e-10)[0]
    rubs = [follows(part.term, SPEED) and p not in part.term.shape for part, p in problem.names]
    return np.asarray(problem.columns[:, rubs] @ told[rubs])


def runs(sense: Array) -> NDArray[np.intp]:
    """Return the run (m,) of each row: 0, 1, … in time, MOST_RUNS at most.

    A stroke begins where the axis starts or turns, from its rest before; a run with a stroke in the
    direction in which the last run began.
    """
    moving = np.where(np.abs(sense) >= 1.0, np.sign(sense), 0.0)
    starts = np.flatnonzero((moving != 0.0) & (np.diff(moving, prepend=0.0) != 0.0))
    begins: list[int] = []
    first = 0.0
    for row in starts.tolist():
        if moving[row] == first or not begins:
            begins.append(row)
            first = moving[row]
    run = np.searchsorted(begins[1:], np.arange(len(sense)), side="right")
    together = -(-len(begins) // MOST_RUNS) or 1
    return np.asarray(run // together, dtype=np.intp)
