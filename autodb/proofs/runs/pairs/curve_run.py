"""How fast a pair is learnt: errors of the next turned cuts after so many cuts sensed."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.pairs.posterior import PairPosterior
from autodb.pairs.updating import posterior_of_readings
from autodb.proofs.runs.pairs import pair_ours
from autodb.proofs.runs.pairs.curve_case import (
    JUDGED,
    CurveCase,
    draw_case,
    median_errors,
    settings,
    some,
)
from autodb.proofs.runs.pairs.curve_peers import PEERS, Peer
from autodb.proofs.runs.pairs.curve_plans import PlannedPair, learn_by_plans
from autodb.proofs.runs.pairs.pair_cuts import COMPONENTS, TURN

Array = NDArray[np.float64]

LEARNT = (0, 1, 2, 3, 5, 8, 12, 20, 40)
"""Cuts sensed before the next are predicted."""
OURS = "autodb"
ADDED = "autodb, bit by bit"
"""The cuts between two of LEARNT update the posterior before them; not all are learnt anew."""


@dataclass(frozen=True)
class LearningErrors:
    """A way to predict and a component: median relative error of the next cuts of one pair after
    each number of LEARNT; None where it needs more cuts.
    """

    method: str
    component: str
    errors: tuple[float | None, ...]


def run_curve(seed: int) -> list[LearningErrors | PlannedPair]:
    """Learn a seed's pair from more and more cuts, by autodb and by other ways; then plan cuts."""
    case = draw_case(seed)
    others = [one for peer in PEERS for one in learnt(peer, case)]
    ours = [
        *errors_listed(OURS, _errors(case, _anew(case))),
        *errors_listed(ADDED, _errors(case, _added(case))),
    ]
    return [*ours, *others, *learn_by_plans(case)]


def learnt(peer: Peer, case: CurveCase) -> list[LearningErrors]:
    """Return another way's errors on the same readings."""
    known, read, asked = settings(case.sensed.cuts), case.read_N, settings(case.asked)
    errors = np.full((len(LEARNT), len(JUDGED)), np.nan)
    for row, n in enumerate(LEARNT):
        if n >= peer.needs:
            expected = [peer.predict(known[:n], one[:n], asked) for one in read.T]
            errors[row] = median_errors(np.column_stack(expected), case)
    return errors_listed(peer.name, errors)


def errors_listed(method: str, errors: Array) -> list[LearningErrors]:
    """Return errors (numbers of cuts, components) as they are kept."""
    given = [[None if np.isnan(e) else float(e) for e in column] for column in errors.T]
    return [
        LearningErrors(method, COMPONENTS[c], tuple(column))
        for c, column in zip(JUDGED, given, strict=True)
    ]


def _anew(case: CurveCase) -> Iterator[PairPosterior]:
    """Return the posteriors after each number of cuts, learnt together."""
    start = pair_ours.prior(case.pair.material)
    yield start
    for count in LEARNT[1:]:
        yield posterior_of_readings(
            start, pair_ours.observed(case.pair, some(case.sensed, 0, count))
        )


def _added(case: CurveCase) -> Iterator[PairPosterior]:
    """Return the posteriors after each number of cuts, each learnt from the one before."""
    posterior = pair_ours.prior(case.pair.material)
    yield posterior
    for begin, end in pairwise(LEARNT):
        posterior = posterior_of_readings(
            posterior, pair_ours.observed(case.pair, some(case.sensed, begin, end))
        )
        yield posterior


def _errors(case: CurveCase, posteriors: Iterator[PairPosterior]) -> Array:
    """Return the errors of posteriors (numbers of cuts, components)."""
    means = (pair_ours.predicted_next(b, case.pair, TURN.name, case.asked)[0] for b in posteriors)
    return np.array([median_errors(mean[:, list(JUDGED)], case) for mean in means])
