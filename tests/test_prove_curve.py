"""How fast a pair is learnt: the readings, the ways to predict, and the plans that are compared."""

import numpy as np
from numpy.testing import assert_allclose

from autodb.pairs.learning import learn
from autodb.prove import pair_ours
from autodb.prove.pair_cuts import TURN, Felt, drawn
from autodb.virtual.power_pairs import TurnedCut


def test_many_noisy_readings_under_one_gain_do_not_pull_the_force_down() -> None:
    # One cut read 100 times, 6 % scatter: the mean has a standard error of 0.6 %, tolerance 4 of it
    _, pair = drawn(6001)
    start = pair_ours.prior(pair.material)
    cut = TurnedCut(feed_mm=0.25, depth_mm=2.0, speed_m_min=150.0)
    expected, _ = pair_ours.predicted(start, pair, TURN.name, (cut,))
    rng = np.random.default_rng(1)
    read = expected[:, [1, 2]] * (1.0 + 0.06 * rng.standard_normal((100, 2)))
    belief = learn(start, pair_ours.observed(pair, Felt(TURN, (cut,) * 100, read)))
    after, _ = pair_ours.predicted(belief, pair, TURN.name, (cut,))
    assert_allclose(after[0, [1, 2]], expected[0, [1, 2]], rtol=4 * 0.06 / np.sqrt(100))
