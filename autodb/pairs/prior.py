"""Where a pair starts from: what any metal may have, narrowed by a card of its material.

A card says specific forces per width over chip thickness, as Kienzle's numbers, a handbook's table
or a linear edge do, and how far the material at hand may be off it, at every thickness alike and
from one to another. It enters as readings of an orthogonal edge.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.elements import Elements
from autodb.cutting.shear import NAMES, PARAMETERS, Edge
from autodb.fitting.gaussian import Gaussian
from autodb.pairs.observed import Observed, PairCuts, X, Y
from autodb.pairs.posterior import (
    CALIBRATION,
    GAIN,
    OF_CARD,
    OWN,
    REFERENCES,
    USUAL_SCATTER,
    PairPosterior,
    Shared,
)

Array = NDArray[np.float64]

ANY_METAL = {
    "shear_stress": (500.0, 1.0),
    "friction_angle": (28.0, 0.5),
    "chip_ratio": (0.4, 0.4),
    "K_te": (25.0, 0.7),
    "K_re": (35.0, 0.7),
    "K_ae": (0.0, 0.0),
    "chip_ratio_thickness": (0.15, 0.12),
    "shear_stress_speed": (0.0, 0.1),
    "friction_speed": (0.0, 0.1),
    "chip_ratio_speed": (0.0, 0.1),
    "friction_rake": (0.5, 0.7),
    "chip_ratio_rake": (0.3, 0.7),
    "chip_flow": (0.8, 0.3),
    "shear_stress_thickness": (0.0, 0.05),
    "friction_thickness": (0.0, 0.15),
    "flow_angle": (1.0, 0.4),
    "edge_mm": (0.008, 1.0),
}
"""Middle and standard deviation, of the logarithm for those that are positive (of the angle: of
its tangent), of the number itself for the others. Speed, and no force of the edge along itself:
chosen; rake and thickness: around what Budak, Altintas and Armarego 1996
give for a titanium alloy; a chip that flows mostly as one: Young, Mathew and Oxley 1987; the others
chosen, wide enough for aluminium to nickel alloys, around an edge of some micrometres and Stabler's
rule."""

OPPOSED = (
    ("friction_angle", "chip_ratio"), ("friction_speed", "chip_ratio_speed"),
    ("friction_thickness", "chip_ratio_thickness"),
)  # fmt: skip
OPPOSED_BY = -0.5
"""Where a chip rubs more, the shear plane is flatter: the resultant force keeps its angle to the
plane. Lee and Shaffer 1951 have 45°, Merchant 1945 between 45 and 60°, the titanium alloy of Budak,
Altintas and Armarego 1996 52°. Chosen: with it the 14° that sds of friction angle and chip ratio
leave are 10°."""

OF_EDGE = ("K_te", "K_re", "K_ae", "edge_mm", "chip_flow")
RELATIVE = 0.2
"""Chosen: grade, coating and chip breaker move a material's numbers by a fifth of what metals
differ by."""


@dataclass(frozen=True)
class CardForces:
    """Forces per width, N/mm, of an orthogonal edge at chips (k,): tangential, and thrust or None.

    ``level``: how far the material at hand may be off all of them alike, a share, and
    ``thrust_level`` off the thrust where that differs; ``shape``: off each of them beyond that.
    ``rake_rad`` and ``speed_m_min`` that it holds for.
    """

    thickness_mm: Array
    tangential: Array
    thrust: Array | None
    level: float
    shape: float
    rake_rad: float = 0.0
    speed_m_min: float = 100.0
    thrust_level: float | None = None


def any_metal() -> PairPosterior:
    """Return the posterior about a pair of which nothing is known."""
    pairs = [ANY_METAL[parameter.name] for parameter in PARAMETERS]
    mean = np.array(
        [float(p.inside(middle)) for p, (middle, _) in zip(PARAMETERS, pairs, strict=True)]
    )
    together = np.eye(OWN)
    for one, other in OPPOSED:
        i, j = NAMES.index(one), NAMES.index(other)
        together[i, j] = together[j, i] = OPPOSED_BY
    sd = np.array([sd for _, sd in pairs])
    return PairPosterior(Gaussian(mean, np.outer(sd, sd) * together), (), USUAL_SCATTER, 0)


def of_card(card: CardForces, *, start: PairPosterior | None = None) -> PairPosterior:
    """Return the posterior that a card leaves; it counts as no cut."""
    from autodb.pairs.updating import posterior_of_readings

    known = posterior_of_readings(start or any_metal(), _as_readings(card))
    return PairPosterior(known.law, (), USUAL_SCATTER, 0)


def of_relative(posterior: PairPosterior) -> PairPosterior:
    """Return what the posterior about a pair says of one of the same material and another tool.

    What belongs to the material is known by RELATIVE more standard deviations of what any metal
    leaves open, what belongs to the tool's edge as of any metal. Errors of the machine's
    calibrations and sensors stay tied to it: they are the same ones, whatever the tool.
    """
    sensing = (CALIBRATION, REFERENCES, GAIN)
    kept = tuple(one for one in posterior.shared if one.key.startswith(sensing))
    rows = np.concatenate([np.arange(OWN), *(np.r_[posterior.columns(one.key)] for one in kept)])
    mean, wider = posterior.state.mean[rows], posterior.state.covariance[np.ix_(rows, rows)]
    any_ = any_metal().law
    wider[:OWN, :OWN] += RELATIVE**2 * any_.covariance
    for name in OF_EDGE:
        k = NAMES.index(name)
        mean[k] = any_.mean[k]
        wider[k], wider[:, k] = 0.0, 0.0
        wider[k, k] = any_.covariance[k, k]
    return PairPosterior(Gaussian(mean, wider), kept, posterior.scatter, 0, posterior.off_law)


def of_state(posterior: PairPosterior) -> PairPosterior:
    """Return what the posterior about a pair says of it in another process state.

    As of a relative, but for the edge, which is the same tool's: all numbers are known by
    RELATIVE more standard deviations of what any metal leaves open.
    """
    wider = posterior.state.covariance.copy()
    wider[:OWN, :OWN] += RELATIVE**2 * any_metal().law.covariance
    return replace(posterior, state=Gaussian(posterior.state.mean, wider), cuts=0, passive={})


def _as_readings(card: CardForces) -> Observed:
    count = len(card.thickness_mm)
    forces = [card.tangential] if card.thrust is None else [card.tangential, card.thrust]
    common = np.zeros((count * len(forces), len(forces)))
    for k in range(len(forces)):
        common[k * count : (k + 1) * count, k] = 1.0
    across = card.level if card.thrust_level is None else card.thrust_level
    levels = np.array([card.level, across])[: len(forces)]
    return Observed(
        cuts=(PairCuts(OF_CARD, _orthogonal(card)),),
        cut=np.tile(np.arange(count), len(forces)),
        quantity=np.repeat([Y, X][: len(forces)], count),
        value=np.concatenate(forces),
        sd=card.shape * np.concatenate(forces),
        common=common,
        shared=(Shared("card", np.diag(levels**2)),),
    )


def _orthogonal(card: CardForces) -> Elements:
    """Return an edge 1 mm wide that feeds along -x, one cut a thickness."""
    one = np.ones((1, 1))
    return Elements(
        count=len(card.thickness_mm),
        of=None,
        edge=Edge(
            card.thickness_mm[:, None], card.speed_m_min * one, card.rake_rad * one, 0.0 * one
        ),
        width_mm=one,
        kappa=(one, 0.0 * one),
        phi=(one, 0.0 * one),
        radius_mm=0.0 * one,
        speed_rpm=np.zeros(1),
        frames=np.array([[[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]]),
    )
