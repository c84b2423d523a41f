"""No answer hangs on a rounding; a thousandth of the noise moves none by a tenth of its interval.

A sample job and a case, each perturbed once; all of them by `make campaigns`, and as often as one
likes by `python -m tests.by_hand.perturbed`.
"""

from collections.abc import Callable
from functools import partial

import pytest

from tests.by_hand.perturbed import Perturb, Said, as_it_is, case, inputs, job, moved, rounded

STILL = 1e-5
"""Share of an interval: no printed digit tells it."""
EVERY = dict(inputs())


@pytest.mark.parametrize("asked", [partial(job, "facing"), partial(case, 1)], ids=["job", "case"])
def test_a_rounding_moves_nothing(asked: Callable[[Perturb], Said]) -> None:
    whole, off = asked(as_it_is), asked(rounded(1))
    assert off.names == whole.names
    assert whole.moved(off) < STILL


@pytest.mark.campaign
@pytest.mark.parametrize("name", EVERY)
def test_answers_stay(name: str) -> None:
    found = moved(name, EVERY[name], times=1)
    assert found.renamed == 0, found
    assert found.by_rounding < STILL, found
    assert found.by_noise < 0.1, found
