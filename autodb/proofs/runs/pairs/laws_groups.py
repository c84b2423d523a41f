"""What the forces of pairs of other laws are split by, and the figures of one group of them.

The cuts of a pair share its errors, so that a pair is what is counted: each has its own share that
was held, median error, median width and mean score, and a row is their mean or median over pairs.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.runs.pairs.laws_case import ASKED_FOR, THIN_FEED_MM, WITHIN
from autodb.proofs.runs.pairs.laws_run import WAYS, DrawnLaw, ForeseenForce
from autodb.proofs.runs.run_file import Finished
from autodb.proofs.runs.score import interval_score

Array = NDArray[np.float64]
Belongs = Callable[[DrawnLaw, ForeseenForce], bool]

EVERYWHERE, INSIDE, OUTSIDE = "everywhere", "inside", "outside"
EVERY = "all"
REGIONS: dict[str, Belongs] = {
    EVERYWHERE: lambda _, __: True,
    INSIDE: lambda _, force: force.kind == WITHIN,
    OUTSIDE: lambda _, force: force.kind != WITHIN,
}
GROUPS: dict[str, Belongs] = {
    EVERY: lambda _, __: True,
    "force.x": lambda _, force: force.component == 0,
    "force.y": lambda _, force: force.component == 1,
    "force.z": lambda _, force: force.component == 2,
    "f < 0.1 mm": lambda _, force: force.feed_mm < THIN_FEED_MM,
    "f < 0.1 mm, force.z": lambda _, f: f.feed_mm < THIN_FEED_MM and f.component == 2,
    "with a nose": lambda pair, _: pair.nose_mm > 0.0,
    "straight edge": lambda pair, _: pair.nose_mm == 0.0,
    "m_c 0.35": lambda pair, _: pair.m_c == 0.35,
    "m_c 0.25": lambda pair, _: pair.m_c == 0.25,
    "m_c 0.1": lambda pair, _: pair.m_c == 0.1,
    "with an edge force": lambda pair, _: pair.edge,
    "without an edge force": lambda pair, _: not pair.edge,
    "law: Kienzle": lambda pair, _: pair.law == "Kienzle",
    "law: linear edge": lambda pair, _: pair.law == "linear edge",
    "law: shear": lambda pair, _: pair.law == "shear",
    "κ 90°": lambda pair, _: pair.kappa_deg == 90.0,
    "κ 75°": lambda pair, _: pair.kappa_deg == 75.0,
    "κ 45°": lambda pair, _: pair.kappa_deg == 45.0,
    "forces measured": lambda pair, _: pair.measured,
    "forces sensed": lambda pair, _: not pair.measured,
    "tool stated": lambda pair, _: pair.stated,
    "tool not stated": lambda pair, _: not pair.stated,
}
KINDS = tuple(dict.fromkeys(one.kind for one in ASKED_FOR if one.kind != WITHIN))


def _of_kind(kind: str) -> Belongs:
    return lambda _, force: force.kind == kind


ROWS: tuple[tuple[str, str, Belongs], ...] = (
    *((INSIDE, group, belongs) for group, belongs in GROUPS.items()),
    *((OUTSIDE, group, belongs) for group, belongs in GROUPS.items()),
    *((OUTSIDE, kind, _of_kind(kind)) for kind in KINDS),
)
"""Region, group, and which forces of the region are in it."""


@dataclass(frozen=True)
class PairFigures:
    """Of one pair and forces (n,): errors and half-widths as shares of their size (n, ways), the
    nominal half-width (n,), which intervals held the next cut's force, and scores (n, ways).

    Where a way tells nothing the error is NaN; an interval without an end is infinitely wide.
    """

    error: Array
    half: Array
    nominal: Array
    held: NDArray[np.bool_]
    score: Array


def figures_of_pairs(
    runs: Sequence[Finished[DrawnLaw | ForeseenForce]], region: str, belongs: Belongs
) -> list[PairFigures]:
    """Return the figures of each pair that has forces in a region and a group."""
    found = []
    for run in runs:
        (pair,) = [one for one in run.judged if isinstance(one, DrawnLaw)]
        forces = [
            one
            for one in run.judged
            if isinstance(one, ForeseenForce) and REGIONS[region](pair, one) and belongs(pair, one)
        ]
        if forces:
            found.append(_figures(forces))
    return found


def _figures(forces: Sequence[ForeseenForce]) -> PairFigures:
    def column(name: str) -> Array:
        return np.array([getattr(one, name) for one in forces], dtype=np.float64)

    size, truth = column("size"), column("next")
    value, low, high = (column(name).reshape(-1, len(WAYS)) for name in ("value", "low", "high"))
    given = np.isfinite(low) & np.isfinite(high)
    score = interval_score(low, high, truth[:, None]) / size[:, None]
    return PairFigures(
        error=np.abs(value - column("mean")[:, None]) / size[:, None],
        half=np.where(given, 0.5 * (high - low) / size[:, None], np.inf),
        nominal=column("nominal") / size,
        held=(low <= truth[:, None]) & (truth[:, None] <= high),
        score=np.where(given, score, np.inf),
    )
