"""Wear of edges that is as large as its size, and a week of three edges that wear out."""

from dataclasses import replace

import numpy as np

from autodb.pairs.forecast import worn
from autodb.pairs.observed import Observed, PairCuts
from autodb.pairs.posterior import WEAR, PairPosterior, PairTerms, Wear
from tests.helpers.turned_pairs import cuts_of, prior, sensed, truth

WEARS = Wear(2.0, 1200.0, 0.2, (60.0, 90.0))


def worn_posterior(wear: Wear = WEARS) -> PairPosterior:
    """Return the prior's law with a wear that is as large as its size, 10 and 15 N/mm."""
    posterior = replace(prior(), terms=PairTerms(wear)).also(
        replace(prior(), terms=PairTerms(wear)).open_terms
    )
    place = posterior.columns(WEAR)
    mean, covariance = posterior.state.mean.copy(), posterior.state.covariance.copy()
    mean[place] = wear.size
    covariance[place, place] = np.diag([10.0**2, 15.0**2])
    return replace(posterior, state=replace(posterior.state, mean=mean, covariance=covariance))


def week(seed: int, *, wear: Wear | None, count: int = 12) -> tuple[PairCuts, Observed]:
    """Return cuts of three edges that wear out, and their readings of y and z."""
    rng = np.random.default_rng(seed)
    drawn = cuts_of(seed, 3 * count)
    cuts = replace(
        drawn,
        worn_s=np.tile(np.linspace(0.0, 1200.0, count), 3),
        edges=tuple(np.repeat(["A", "B", "C"], count).tolist()),
    )
    observed = sensed(truth(1), cuts, seed)
    if wear is not None:
        added = worn(worn_posterior(replace(wear, between=0.0)), cuts).mean
        own = 1.0 + wear.between * np.repeat(rng.standard_normal(3), count)
        more = (added * own[:, None])[observed.cut, observed.quantity]
        observed = replace(observed, value=observed.value + more)
    return cuts, observed
