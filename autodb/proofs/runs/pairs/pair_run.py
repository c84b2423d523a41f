"""One work-tool pair of another law: learnt from cuts of one operation, predicted in all."""

import numpy as np

from autodb.pairs.learning import learn
from autodb.proofs.machines.lathe.power_pairs import PowerPair, scattered
from autodb.proofs.runs.pairs import pair_oracle, pair_ours
from autodb.proofs.runs.pairs.pair_cuts import (
    COMPONENTS,
    FAMILIES,
    KNOWN,
    UNITS,
    Family,
    drawn,
    feel,
    forces,
)
from autodb.proofs.runs.score import Judged, Z


def run(seed: int) -> list[Judged]:
    """Learn the pair of a seed in turning and in slots; judge one next cut of every operation."""
    rng, pair = drawn(seed)
    return [one for family in FAMILIES for one in _family(rng, pair, family)]


def _family(rng: np.random.Generator, pair: PowerPair, family: Family) -> list[Judged]:
    felt = feel(rng, pair, family.known, KNOWN)
    belief = learn(pair_ours.prior(pair.material), pair_ours.observed(pair, felt))
    best = pair_oracle.fitted(pair, felt)
    judged = []
    for operation in family.predicted:
        cut = operation.draw(rng, pair)
        truth = forces(pair, cut, scattered(rng))
        mean, sd = pair_ours.predicted(belief, pair, operation.name, (cut,))
        for c in operation.judged:
            value, half = float(mean[0, c]), Z * float(sd[0, c])
            middle, spread = best.interval(cut, c)
            judged.append(
                Judged(
                    f"{operation.name}, {COMPONENTS[c]}", UNITS[c], float(truth[c]),
                    value, value - half, value + half, middle - Z * spread, middle + Z * spread,
                )
            )  # fmt: skip
    return judged
