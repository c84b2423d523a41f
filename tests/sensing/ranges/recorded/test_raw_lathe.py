"""A lathe that shares no code with the package: its recordings, from phases to forces."""

import numpy as np
import pytest

from tests.by_hand.raw_lathes import rms, run
from tests.helpers.campaigns import first

OPERATIONS = {("turn", "spindle"), ("turn", "z"), ("face", "spindle"), ("face", "x")}


@pytest.mark.parametrize(("seed", "cuts"), first(1, [(3, 52), (3, 64), (2, 64)]))
def test_forces_of_every_operation_are_as_near_as_the_lathe_allows(seed: int, cuts: int) -> None:
    """One lathe with magnetising currents, one that folds and logs no positions.

    Errors are at most 1.6 times those of the lathe's own law fitted to ranges without noise: the
    95 % upper limit of 1.2 for ratios of 5 to 12 cuts whose own errors both share.
    """
    scores = run(seed, cuts=cuts)
    assert set(scores) >= OPERATIONS
    for key in OPERATIONS:
        one = scores[key]
        assert len(one.ours) >= 0.8 * one.cuts
        assert rms(one.ours) <= 1.6 * rms(one.oracle)
        assert rms(one.ours) <= 1.2 * rms(one.plain)
        assert np.mean(one.held) >= 0.75
