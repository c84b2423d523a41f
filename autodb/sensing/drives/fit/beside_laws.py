"""All by which effort may differ from its terms: columns, and how large they likely are."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.fit.linearised import Linearised
from autodb.sensing.drives.fit.not_sliding import friction_after_turns, held_at_rest
from autodb.sensing.drives.fit.steady import Deviation, friction_deviation
from autodb.sensing.drives.fit.wander import friction_of, friction_wander
from autodb.sensing.drives.moves.prepared import Prepared

Array = NDArray[np.float64]

LIKELY_SHARE = 0.3
"""Share of friction by which it is likely off its laws at a speed or place: Stribeck dips of feed
axes are 0.1 to 0.5 of Coulomb friction. It matters only where no rows show the deviation: of few
rows at high speed friction was taken to deviate by 80 times itself. Chosen."""


@dataclass(frozen=True)
class BesideLaws:
    """Groups of columns (m, k), the first of them ``deviation``'s; how large the size of each is
    likely; and rows (m,) that are left out together to see how sure the laws are.
    """

    deviation: Deviation | None
    groups: list[Array]
    likely: list[float]
    blocks: NDArray[np.intp]


def beside_laws(rows: Prepared, problem: Linearised, *, sweep: bool, deviates: bool) -> BesideLaws:
    """Return what friction is off its laws, where it ``deviates``; of moves that are no sweep also
    what is there while the axis does not slide, and what runs have of their own.

    In a sweep what is a run's own is not told from what friction deviates by at its speed, and rows
    of turns and rests count little.
    """
    deviation = friction_deviation(rows, problem)
    own_runs = deviation is not None and not sweep
    wander = friction_wander(rows, problem, tells=own_runs)
    deviation = deviation if deviates else None
    groups = deviation.groups if deviation else []
    likely = _likely(rows, problem)
    sizes = [LIKELY_SHARE * likely] * len(groups)
    if own_runs:
        groups = [*groups, friction_after_turns(rows)]
        sizes.append(LIKELY_SHARE * likely)
        held = held_at_rest(rows)
        if held.size:
            groups.append(held)
            sizes.append(likely)
    return BesideLaws(deviation, [*groups, *wander.groups], [*sizes, *wander.likely], wander.blocks)


def _likely(rows: Prepared, problem: Linearised) -> float:
    """Return how large friction is, in the effort's unit, by least squares of its laws; at most the
    effort.
    """
    moving = np.abs(rows.sampled("direction")) >= 1.0
    friction = friction_of(problem)[moving]
    whole = float(np.sqrt(np.mean(rows.effort**2)))
    rms = float(np.sqrt(np.mean(friction**2))) if len(friction) else whole
    return min(rms, whole) if rms > 0.0 else np.inf
