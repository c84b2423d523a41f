"""autodb's posterior of a pair of another law in a shop without a card, and forces foreseen."""

import numpy as np
from numpy.typing import NDArray

from autodb.forward.prediction import intervals, passive_known
from autodb.pairs.averaging import learn_averaging
from autodb.pairs.engaged import BY_NAME, DEPTH, DIRECTION, FEED, SPEED, Conditions
from autodb.pairs.forecast import forecast
from autodb.pairs.observed import Observed, PairCuts
from autodb.pairs.posterior import GAIN as GAIN_KEY
from autodb.pairs.posterior import PairPosterior, Shared
from autodb.pairs.prior import any_metal
from autodb.proofs.machines.lathe.law_pairs import LawPair
from autodb.proofs.machines.lathe.power_pairs import TurnedCut
from autodb.proofs.runs.pairs.laws_case import LawsCase

Array = NDArray[np.float64]


def learnt_law(case: LawsCase) -> PairPosterior:
    """Return the posterior after a case's cuts, from what any metal may have."""
    count, width = case.read_N.shape
    gain = np.array([[case.pair.gain_share**2]])
    observed = Observed(
        cuts=(stated_cuts(case.pair, "turn", case.cuts),),
        cut=np.repeat(np.arange(count), width),
        quantity=np.tile(case.read, count),
        value=case.read_N.ravel(),
        sd=np.tile(case.pair.noise_N[list(case.read)], count),
        common=np.tile(np.eye(width), (count, 1)),
        shared=tuple(Shared(f"{GAIN_KEY} of {component}", gain) for component in case.read),
    )
    return learn_averaging(any_metal(), observed).past()


def forces_foreseen(posterior: PairPosterior, case: LawsCase) -> Array:
    """Return force x, y, z of the cuts asked for, as a prediction of a job has them (m, 3, 3).

    The last axis: mean, and low and high of the next cut's force.
    """
    found = np.empty((len(case.asked), 3, 3))
    operations = np.array([_operation(cut) for cut in case.asked])
    for name in dict.fromkeys(operations.tolist()):
        rows = np.flatnonzero(operations == name)
        cuts = stated_cuts(case.pair, name, tuple(case.asked[k] for k in rows))
        known = passive_known(posterior, name)
        told = intervals(forecast(posterior, cuts), operation=name, known=known)
        found[rows] = [[(f.value, f.low, f.high) for f in each[:3]] for each in told]
    return found


def stated_cuts(pair: LawPair, operation: str, cuts: tuple[TurnedCut, ...]) -> PairCuts:
    """Return cuts as the shop states them, with its tool or with one that it says nothing of."""
    tool = pair.tool
    stated = {
        "nose_radius_mm": tool.nose_mm,
        "kappa_deg": tool.kappa_deg,
        "rake_deg": tool.rake_deg,
        "inclination_deg": tool.inclination_deg,
        "included_deg": tool.included_deg,
    }
    rows = [_conditions(cut) for cut in cuts]
    return BY_NAME[operation].cuts(stated if pair.stated else {}, rows, called="tool")


def _operation(cut: TurnedCut) -> str:
    return {0.0: "turn", 90.0: "face"}.get(cut.inward_deg, "taper")


def _conditions(cut: TurnedCut) -> Conditions:
    return {
        FEED: cut.feed_mm,
        DEPTH: cut.depth_mm,
        SPEED: cut.speed_m_min,
        DIRECTION: cut.inward_deg,
    }
