"""A pair of another law: learnt by autodb and by plain least squares, and asked for next cuts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.runs.pairs.laws_case import LawsCase, draw_laws_case
from autodb.proofs.runs.pairs.laws_nominal import nominal_sd_N
from autodb.proofs.runs.pairs.laws_ours import forces_foreseen, learnt_law
from autodb.proofs.runs.pairs.laws_peers import kienzle_squares
from autodb.proofs.runs.score import Z

Array = NDArray[np.float64]

AUTODB, KIENZLE_LINE, KIENZLE_SPEED = "autodb", "Kienzle", "Kienzle with speed"
WAYS = (AUTODB, KIENZLE_LINE, KIENZLE_SPEED)


@dataclass(frozen=True)
class DrawnLaw:
    """What a pair is: its law, tool, and what the shop knows of it."""

    law: str
    m_c: float
    edge: bool
    nose_mm: float
    kappa_deg: float
    measured: bool
    stated: bool


@dataclass(frozen=True)
class ForeseenForce:
    """A force of a cut that was asked for, N: ``component`` 0, 1, 2 for x, y, z.

    ``size``: what errors and widths are shares of; ``nominal``: half the nominal interval; of each
    way of WAYS the mean force expected, and the interval of the next cut's; None: not told.
    """

    kind: str
    component: int
    feed_mm: float
    mean: float
    next: float
    size: float
    nominal: float
    value: tuple[float | None, ...]
    low: tuple[float | None, ...]
    high: tuple[float | None, ...]


def run_laws(seed: int) -> list[DrawnLaw | ForeseenForce]:
    """Learn the pair of a seed in each way, and foresee its next cuts."""
    case = draw_laws_case(seed)
    ours = np.moveaxis(forces_foreseen(learnt_law(case), case), -1, 0)
    peers = [kienzle_squares(case, speed=speed) for speed in (False, True)]
    value = np.stack([ours[0], *(one.value for one in peers)], axis=-1)
    low = np.stack([ours[1], *(one.low for one in peers)], axis=-1)
    high = np.stack([ours[2], *(one.high for one in peers)], axis=-1)
    nominal = Z * nominal_sd_N(case)
    forces = [
        ForeseenForce(
            kind=case.kinds[k],
            component=c,
            feed_mm=case.asked[k].feed_mm,
            mean=float(case.mean_N[k, c]),
            next=float(case.next_N[k, c]),
            size=float(case.size_N[k, c]),
            nominal=float(nominal[k, c]),
            value=_told(value[k, c]),
            low=_told(low[k, c]),
            high=_told(high[k, c]),
        )
        for k in range(len(case.asked))
        for c in range(3)
    ]
    return [_drawn(case), *forces]


def _drawn(case: LawsCase) -> DrawnLaw:
    pair = case.pair
    return DrawnLaw(
        law=pair.law.name,
        m_c=pair.numbers["m_c"],
        edge=pair.edge,
        nose_mm=pair.tool.nose_mm,
        kappa_deg=pair.tool.kappa_deg,
        measured=pair.measured,
        stated=pair.stated,
    )


def _told(values: Array) -> tuple[float | None, ...]:
    return tuple(None if np.isnan(one) else one for one in values.tolist())
