"""autodb's posterior of a power-law pair before and after its cuts, and what it predicts."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import endmill, insert
from autodb.cutting.elements import Elements
from autodb.pairs.forecast import forecast
from autodb.pairs.observed import TORQUE, Observed, PairCuts, X, Y, Z
from autodb.pairs.posterior import PairPosterior, Shared
from autodb.pairs.prior import CardForces, of_card
from autodb.proofs.machines.lathe.power_pairs import GAIN, SPREAD, PowerMilledCut, PowerPair
from autodb.proofs.runs.pairs.pair_cuts import Cut as DrawnCut
from autodb.proofs.runs.pairs.pair_cuts import ReadCuts, as_expected, number_of_cuts, sensing

Array = NDArray[np.float64]

QUANTITY = (X, Y, Z, TORQUE)
CARD_MM = np.array([0.03, 0.06, 0.12, 0.25, 0.4])
CARD_SHAPE = 0.1
"""How far a material may be off its card from one thickness to another: chosen."""


@lru_cache
def prior(material: str) -> PairPosterior:
    """Return the posterior that a card of what a shop expects of the material leaves."""
    chip_t, chip_r, rub_t, rub_r = as_expected(material).per_width(CARD_MM, np.full(5, 100.0))
    return of_card(
        CardForces(CARD_MM, chip_t + rub_t, chip_r + rub_r, level=SPREAD, shape=CARD_SHAPE)
    )


def observed(pair: PowerPair, measured: ReadCuts) -> Observed:
    """Return readings as the semi-inverse takes them: a gain common to each component's."""
    count, sensed = measured.read.shape
    value = measured.read.T.ravel()
    common = np.zeros((count * sensed, sensed))
    for k in range(sensed):
        common[k * count : (k + 1) * count, k] = 1.0
    return Observed(
        cuts=(PairCuts(measured.operation.name, elements(pair, measured.cuts)),),
        cut=np.tile(np.arange(count), sensed),
        quantity=np.repeat([QUANTITY[c] for c in measured.operation.sensed], count),
        value=value,
        sd=np.repeat(sensing(pair)[list(measured.operation.sensed)], count),
        common=common,
        shared=known_gains(measured.operation.sensed),
    )


def known_gains(components: tuple[int, ...]) -> tuple[Shared, ...]:
    """Return what the errors of the machine's gains are known to be, of components."""
    return tuple(Shared(f"gain {c}", np.array([[GAIN**2]])) for c in components)


def predicted_next(
    posterior: PairPosterior, pair: PowerPair, operation: str, cuts: tuple[DrawnCut, ...]
) -> tuple[Array, Array]:
    """Return force x, y, z and torque of the next cuts (n, 4), and their sd."""
    known = forecast(posterior, PairCuts(operation, elements(pair, cuts)))
    return known.mean[:, :4], known.sd[:, :4]


def elements(pair: PowerPair, cuts: tuple[DrawnCut, ...]) -> Elements:
    """Return the elements of cuts of one kind; a shop knows the tool's geometry."""
    if isinstance(cuts[0], PowerMilledCut):
        return _milled(pair, cuts)
    tool = insert.Insert(pair.nose_mm, pair.kappa_deg)
    count = len(cuts)
    return insert.insert_elements(
        tool,
        insert.TurnedCuts(
            feed_mm=number_of_cuts(cuts, "feed_mm"),
            depth_mm=number_of_cuts(cuts, "depth_mm"),
            speed_m_min=number_of_cuts(cuts, "speed_m_min"),
            radius_mm=np.full(count, 30.0),
            inward_rad=np.radians(number_of_cuts(cuts, "inward_deg")),
        ),
    )


def _milled(pair: PowerPair, cuts: tuple[DrawnCut, ...]) -> Elements:
    radius = 0.5 * pair.diameter_mm
    none = np.zeros(len(cuts))
    mill = endmill.EndMill(pair.diameter_mm, pair.teeth, pair.helix_deg)
    return endmill.averaged(
        mill,
        endmill.Milled(
            feed_mm=number_of_cuts(cuts, "feed_mm"),
            depth_mm=number_of_cuts(cuts, "depth_mm"),
            speed_rpm=number_of_cuts(cuts, "speed_rpm"),
            low_mm=radius * np.cos(np.radians(number_of_cuts(cuts, "ends_deg"))),
            high_mm=radius * np.cos(np.radians(number_of_cuts(cuts, "begins_deg"))),
            direction_rad=none,
            ramp_rad=none,
        ),
    )
