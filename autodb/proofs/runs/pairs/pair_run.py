"""One work-tool pair of another law: learnt from cuts of one operation, predicted in all."""

import numpy as np

from autodb.pairs.updating import posterior_of_readings
from autodb.proofs.machines.lathe.power_pairs import PowerPair, scattered
from autodb.proofs.runs.pairs import pair_oracle, pair_ours
from autodb.proofs.runs.pairs.pair_cuts import (
    COMPONENTS,
    FAMILIES,
    KNOWN,
    UNITS,
    OperationFamily,
    draw_pair,
    draw_read_cuts,
    true_forces,
)
from autodb.proofs.runs.score import Judged, Z


def run_pair(seed: int) -> list[Judged]:
    """Learn the pair of a seed in turning and in slots; judge one next cut of every operation."""
    rng, pair = draw_pair(seed)
    return [one for family in FAMILIES for one in _family(rng, pair, family)]


def _family(rng: np.random.Generator, pair: PowerPair, family: OperationFamily) -> list[Judged]:
    sensed = draw_read_cuts(rng, pair, family.known, KNOWN)
    posterior = posterior_of_readings(
        pair_ours.prior(pair.material), pair_ours.observed(pair, sensed)
    )
    best = pair_oracle.oracle_fit(pair, sensed)
    judged = []
    for operation in family.predicted:
        cut = operation.draw(rng, pair)
        truth = true_forces(pair, cut, scattered(rng))
        mean, sd = pair_ours.predicted_next(posterior, pair, operation.name, (cut,))
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
