"""No answer hangs on a rounding; a thousandth of the noise moves none by a tenth of its interval.

By `make campaigns`, and as often as one likes by `python -m tests.by_hand.perturbed`.
"""

import pytest

from tests.by_hand.perturbed import as_it_is, case, inputs, moved, rounded

STILL = 1e-5
"""Share of an interval: no printed digit tells it."""
EVERY = dict(inputs())


@pytest.mark.campaign
def test_a_rounding_moves_nothing() -> None:
    whole, off = (case(1, perturb) for perturb in (as_it_is, rounded(1)))
    assert off.names == whole.names
    assert whole.moved(off) < STILL


@pytest.mark.campaign
@pytest.mark.parametrize("name", EVERY)
def test_answers_stay(name: str) -> None:
    found = moved(name, EVERY[name], times=1)
    assert found.renamed == 0, found
    assert found.by_rounding < STILL, found
    assert found.by_noise < 0.1, found
