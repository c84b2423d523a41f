"""How many cuts a pair needs: proposed one by one, at random, or the corners of the range.

All plans take their cuts from one grid, and cuts that are proposed are learnt before the next is.
Two widths of the 95 % interval are followed, over the force, mean of the next cuts and components:
that of the next cut's force, and that of its mean given the machine's gain. The first has a floor,
which no cuts lower: what cuts scatter by, and the error of the gain that all were sensed with. The
second is what lies above the floor.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from autodb.pairs.forecast import forecast
from autodb.pairs.next_cut import SensedComponent, gain_error, propose
from autodb.pairs.observed import PairCuts
from autodb.pairs.posterior import PairPosterior
from autodb.pairs.updating import posterior_of_readings
from autodb.proofs.machines.lathe.power_pairs import TurnedCut
from autodb.proofs.runs.pairs import pair_ours
from autodb.proofs.runs.pairs.curve_case import JUDGED, CurveCase, median_errors
from autodb.proofs.runs.pairs.pair_cuts import (
    TURN,
    TURNED_DEPTH_MM,
    TURNED_FEED_MM,
    TURNED_SPEED_M_MIN,
    ReadCuts,
    made,
    sensing,
)
from autodb.proofs.runs.score import Z

Array = NDArray[np.float64]
Plan = Callable[[PairPosterior, CurveCase, int], TurnedCut]
"""Chooses a cut from the posterior, what is asked, and how many were made."""

PROPOSED, RANDOM, FACTORIAL = "proposed", "random", "factorial"
AT = {PROPOSED: tuple(range(11)), RANDOM: (0, 1, 2, 4, 6, 8, 10, 12), FACTORIAL: (8,)}
"""Numbers of cuts after which a plan is judged: what random ones reach with the last of theirs is
the level to be reached with fewer."""


def cut_grid(feeds: int, depths: int, speeds: int) -> tuple[TurnedCut, ...]:
    """Return cuts at equal steps over the ranges, ends included; the speed changes fastest."""
    levels = (
        np.linspace(*TURNED_FEED_MM, feeds).tolist(),
        np.linspace(*TURNED_DEPTH_MM, depths).tolist(),
        np.linspace(*TURNED_SPEED_M_MIN, speeds).tolist(),
    )
    return tuple(TurnedCut(*one) for one in product(*levels))


CANDIDATES = cut_grid(4, 3, 3)
CORNERS = cut_grid(2, 2, 2)
QUANTITIES = tuple(pair_ours.QUANTITY[c] for c in JUDGED)
GAINS = pair_ours.known_gains(JUDGED)


@dataclass(frozen=True)
class PlannedPair:
    """A plan in one pair, after the cuts AT: the two widths, and the median relative error of the
    next cuts, mean of the components.
    """

    plan: str
    whole: tuple[float, ...]
    given_gain: tuple[float, ...]
    errors: tuple[float, ...]


def learn_by_plans(case: CurveCase) -> list[PlannedPair]:
    """Learn a pair by each of the plans; each has readings of its own."""
    plans: dict[str, Plan] = {
        PROPOSED: proposed,
        RANDOM: _at_random(np.random.default_rng([case.seed, 0])),
        FACTORIAL: lambda _, __, done: CORNERS[done],
    }
    return [
        _followed(case, name, plan, np.random.default_rng([case.seed, k]))
        for k, (name, plan) in enumerate(plans.items(), start=1)
    ]


def proposed(posterior: PairPosterior, case: CurveCase, _: int) -> TurnedCut:
    """Return the cut that `propose` takes."""
    noise = sensing(case.pair)
    sensed = tuple(
        SensedComponent(pair_ours.QUANTITY[c], float(noise[c]), (gain_error(error),))
        for c, error in zip(JUDGED, GAINS, strict=True)
    )
    may_be = PairCuts(TURN.name, pair_ours.elements(case.pair, CANDIDATES))
    found = propose(posterior, may_be, _asked(case), sensed=sensed, quantities=QUANTITIES)
    if found is None:
        raise ValueError("without limits no cut exceeds one")
    return CANDIDATES[found.candidate]


def _at_random(rng: np.random.Generator) -> Plan:
    return lambda _, __, ___: CANDIDATES[rng.integers(len(CANDIDATES))]


def _followed(case: CurveCase, name: str, plan: Plan, rng: np.random.Generator) -> PlannedPair:
    """Make the cuts of a plan, and learn all that were made where it is judged."""
    start = pair_ours.prior(case.pair.material)
    posterior, sensed, seen = start, _sensed_nothing(), []
    for done in range(AT[name][-1] + 1):
        if done in AT[name]:
            posterior = (
                posterior_of_readings(start, pair_ours.observed(case.pair, sensed))
                if done
                else start
            )
            seen.append(judged_plan(posterior, case))
        if done < AT[name][-1]:
            sensed = _and(sensed, made(rng, case.pair, TURN, (plan(posterior, case, done),)))
    whole, given_gain, errors = zip(*seen, strict=True)
    return PlannedPair(name, whole, given_gain, errors)


def _sensed_nothing() -> ReadCuts:
    return ReadCuts(TURN, (), np.zeros((0, len(JUDGED))))


def _and(sensed: ReadCuts, more: ReadCuts) -> ReadCuts:
    return replace(
        sensed, cuts=(*sensed.cuts, *more.cuts), read=np.vstack([sensed.read, more.read])
    )


def judged_plan(posterior: PairPosterior, case: CurveCase) -> tuple[float, float, float]:
    """Return both widths (half, over the force) and the error of the next cuts."""
    known = posterior.also((*GAINS, *posterior.law_errors(TURN.name)))
    expected = forecast(known, _asked(case))
    open_ = _given_gains(known)
    sd = np.sqrt(np.einsum("nqi,ij,nqj->nq", expected.slopes, open_, expected.slopes))

    def half(sd: Array) -> float:
        return float(np.mean((Z * sd / np.abs(expected.mean))[:, QUANTITIES]))

    error = float(np.mean(median_errors(expected.mean[:, QUANTITIES], case)))
    return half(expected.sd), half(sd), error


def _given_gains(posterior: PairPosterior) -> Array:
    """Return the covariance of a posterior's state were the gains known."""
    whole = posterior.state.covariance
    gains = np.r_[tuple(posterior.columns(one.key) for one in GAINS)]
    taught = np.linalg.solve(whole[np.ix_(gains, gains)], whole[gains])
    return np.asarray(whole - whole[:, gains] @ taught)


def _asked(case: CurveCase) -> PairCuts:
    return PairCuts(TURN.name, pair_ours.elements(case.pair, case.asked))
