"""Effects that are one column but for a little are none where they are larger than what is missing.

Moves one way but for two short turns, so that dry friction, friction by direction and viscous
friction at a steady speed are nearly one constant.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.cancelling import most_cancelled

Array = NDArray[np.float64]

ROWS = 2000
SPEED = np.where(np.arange(ROWS) % 1000 < 20, -1.0, 1.0)
RIPPLE = np.sin(2.0 * np.pi * np.arange(ROWS) / 50.0)
LEVEL = np.ones((ROWS, 1))


def test_two_that_make_each_other_up_are_not_both_effects() -> None:
    """Friction, and friction by direction the other way: beside each other they say what is missing
    at the turns, where a law that is wrong by a tenth says as much. A curve is not judged."""
    none, other_way = np.empty((ROWS, 0)), np.where(SPEED < 0.0, 1.4, -2.0)
    effects = [2.0 * SPEED, other_way, 0.2 * RIPPLE]
    missing = sum(effects)
    assert np.std(missing) < 0.2
    assert most_cancelled(effects, none, missing, named=[True] * 3) in {0, 1}
    assert most_cancelled(effects, none, missing, named=[False, False, True]) is None
    alone = [effects[0], effects[2]]
    assert most_cancelled(alone, none, sum(alone), named=[True] * 2) is None


def test_an_effect_that_own_terms_cancel_is_none() -> None:
    """As large as is missing it may be that; five times as large the own term is changed as much
    the other way for it."""
    nearly = 1.0 + 0.05 * RIPPLE
    for size, cancelled in ((0.6, None), (5.0, 0)):
        assert most_cancelled([size * nearly], LEVEL, RIPPLE, named=[True]) == cancelled


def test_what_a_fit_has_taken_up_is_given_back() -> None:
    """A fit has taken up four fifths of friction with a load: it is larger than what is left, and
    an own term changes the other way, but more of it is left than laws are wrong by."""
    turning = np.where(np.arange(ROWS) % 1000 < 100, -1.0, 1.0)
    left = turning - turning.mean()
    assert np.std(left) < 0.7
    assert most_cancelled([turning], LEVEL, left, named=[True]) is None
