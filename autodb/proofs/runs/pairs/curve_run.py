"""How fast a pair is learnt: errors of the next turned cuts after so many cuts felt."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.pairs.learning import learn
from autodb.pairs.posterior import Belief
from autodb.proofs.runs.pairs import pair_ours
from autodb.proofs.runs.pairs.curve_case import JUDGED, Case, draw_case, off, settings, some
from autodb.proofs.runs.pairs.curve_peers import PEERS, Peer
from autodb.proofs.runs.pairs.curve_plans import Planned, planned
from autodb.proofs.runs.pairs.pair_cuts import COMPONENTS, TURN

Array = NDArray[np.float64]

LEARNT = (0, 1, 2, 3, 5, 8, 12, 20, 40)
"""Cuts felt before the next are predicted."""
OURS = "autodb"
ADDED = "autodb, bit by bit"
"""The cuts between two of LEARNT are learnt from what was believed before them, not all anew."""


@dataclass(frozen=True)
class Learnt:
    """A way to predict and a component: median relative error of the next cuts of one pair after
    each number of LEARNT; None where it needs more cuts.
    """

    method: str
    component: str
    errors: tuple[float | None, ...]


def run(seed: int) -> list[Learnt | Planned]:
    """Learn a seed's pair from more and more cuts, by autodb and by other ways; then plan cuts."""
    case = draw_case(seed)
    others = [one for peer in PEERS for one in learnt(peer, case)]
    ours = [*listed(OURS, _errors(case, _anew(case))), *listed(ADDED, _errors(case, _added(case)))]
    return [*ours, *others, *planned(case)]


def learnt(peer: Peer, case: Case) -> list[Learnt]:
    """Return another way's errors on the same readings."""
    known, read, asked = settings(case.felt.cuts), case.read_N, settings(case.asked)
    errors = np.full((len(LEARNT), len(JUDGED)), np.nan)
    for row, n in enumerate(LEARNT):
        if n >= peer.needs:
            expected = [peer.predict(known[:n], one[:n], asked) for one in read.T]
            errors[row] = off(np.column_stack(expected), case)
    return listed(peer.name, errors)


def listed(method: str, errors: Array) -> list[Learnt]:
    """Return errors (numbers of cuts, components) as they are kept."""
    given = [[None if np.isnan(e) else float(e) for e in column] for column in errors.T]
    return [
        Learnt(method, COMPONENTS[c], tuple(column))
        for c, column in zip(JUDGED, given, strict=True)
    ]


def _anew(case: Case) -> Iterator[Belief]:
    """Return the beliefs after each number of cuts, learnt together."""
    start = pair_ours.prior(case.pair.material)
    yield start
    for count in LEARNT[1:]:
        yield learn(start, pair_ours.observed(case.pair, some(case.felt, 0, count)))


def _added(case: Case) -> Iterator[Belief]:
    """Return the beliefs after each number of cuts, each learnt from the one before."""
    belief = pair_ours.prior(case.pair.material)
    yield belief
    for begin, end in pairwise(LEARNT):
        belief = learn(belief, pair_ours.observed(case.pair, some(case.felt, begin, end)))
        yield belief


def _errors(case: Case, beliefs: Iterator[Belief]) -> Array:
    """Return the errors of beliefs (numbers of cuts, components)."""
    means = (pair_ours.predicted(b, case.pair, TURN.name, case.asked)[0] for b in beliefs)
    return np.array([off(mean[:, list(JUDGED)], case) for mean in means])
