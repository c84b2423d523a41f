"""A calibration that drifts is told from a pair's own change, from all work, and from wear."""

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.pairs.changes.drifting_gain import GainDrift, drifted_gain
from autodb.pairs.changes.shared_shifts import SensedShares
from tests.helpers.campaigns import first

Array = NDArray[np.float64]
RECORDINGS, CUTS, SHARE = 10, 8, 0.06


def _shop(
    seed: int, *, axis: float = 0.0, pair: float = 0.0, work: float = 0.0, worn: float = 0.0
) -> SensedShares:
    """Return three pairs' cuts of ten files: from the sixth on something is off by a share.

    Files' levels scatter by 1 %, a pair's in a file by 2 %, readings by 3 %; edges wear on over
    two files, in a root of time, and the second component twice as much.
    """
    rng = np.random.default_rng(seed)
    pairs, recordings, components = np.meshgrid(
        range(3), range(RECORDINGS), range(2), indexing="ij"
    )
    where = [np.repeat(one.ravel(), CUTS) for one in (pairs, recordings, components)]
    k, d, c = where
    clock = np.tile(np.arange(CUTS) * 100.0, len(k) // CUTS)
    used = clock + 800.0 * ((d + k) % 2)
    day, own = rng.normal(0.0, 0.01, (RECORDINGS, 2)), rng.normal(0.0, 0.02, (3, RECORDINGS, 1))
    off = day[d, c] + own[k, d, 0] + rng.normal(0.0, 0.03, len(k))
    off += worn * (1.0 + c) * np.sqrt(used / 1600.0)
    later = d >= 5
    off += later * (axis * (c == 1) + pair * (k == 0) + work)
    of_pair, recording, component = (one.astype(np.intp) for one in where)
    return SensedShares(of_pair, recording, component, off, used, clock)


@pytest.mark.parametrize("sign", first(1, [-1.0, 1.0]))
def test_one_axis_of_all_pairs_is_named(sign: float) -> None:
    found = [drifted_gain(_shop(seed, axis=sign * SHARE)) for seed in range(4)]
    named = [one for one in found if one is not None]
    assert len(named) >= 3
    for one in named:
        assert one.component == 1
        assert len(one.pairs) >= 2
        assert 3 <= one.since <= 6
        assert abs(one.share - sign * SHARE) < 3.0 * one.sd
        assert one.probability > 0.8


def test_it_is_named_on_wearing_edges_too() -> None:
    found = [drifted_gain(_shop(seed, axis=SHARE, worn=0.15)) for seed in range(4)]
    assert sum(isinstance(one, GainDrift) and one.component == 1 for one in found) >= 3


@pytest.mark.parametrize("seed", first(1, range(4)))
@pytest.mark.parametrize("what", [{}, {"pair": 0.15}, {"work": SHARE}, {"worn": 0.2}])
def test_nothing_else_is_taken_for_it(what: dict[str, float], seed: int) -> None:
    assert drifted_gain(_shop(seed, **what)) is None


def test_too_little_tells_nothing() -> None:
    shop = _shop(1, axis=SHARE)
    for some in (shop.pair == 0, shop.recording < 4):
        few = SensedShares(**{name: values[some] for name, values in vars(shop).items()})
        assert drifted_gain(few) is None
