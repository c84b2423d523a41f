"""An edge change that nobody recorded is found where wear falls back to its beginning."""

import numpy as np
import pytest

from autodb.pairs.changes.edge_changes import EdgeCuts, edge_changes, wears


def _cuts(
    seed: int, *, unseen: int | None, grows: float = 0.25, step: float = 0.0, both: bool = True
) -> EdgeCuts:
    """Return 60 cuts of 60 s: edges of 20 cuts, by their counters; the second component grows more.

    ``unseen``: the cut before which an edge was changed as well. Growth is a root of time with an
    edge's own share. ``step``: by what all later forces are lower instead.
    """
    rng = np.random.default_rng(seed)
    number = np.arange(60)
    edge, written = number // 20, 60.0 * (number % 20)
    true = written.copy()
    if unseen is not None and step == 0.0:
        later = (edge == edge[unseen]) & (number >= unseen)
        true[later] -= true[unseen]
    growth = grows * rng.uniform(0.8, 1.2, 4)[edge] * np.sqrt(true / 1200.0)
    q = np.column_stack([growth, 1.6 * growth]) + rng.normal(0.0, 0.03, (60, 2))
    if unseen is not None:
        q[number >= unseen] -= step
    if not both:
        q[:, 0] = np.nan
    return EdgeCuts(q, edge.astype(np.intp), np.asarray(written, dtype=np.float64), 1.0)


@pytest.mark.parametrize("both", [True, False])
def test_a_change_within_an_edge_is_found(both: bool) -> None:
    for seed in range(8):
        (one,) = edge_changes(_cuts(seed, unseen=32, both=both))
        assert abs(one.cut - 32) <= 2
        assert 0.1 < one.fell[1] < 0.6
        assert np.isnan(one.fell[0]) == (not both)


@pytest.mark.parametrize("what", [{"unseen": None}, {"unseen": 32, "step": 0.2}])
def test_no_change_and_a_step_that_stays_are_none(what: dict[str, float]) -> None:
    found = [edge_changes(_cuts(seed, **what)) for seed in range(12)]  # type: ignore[arg-type]
    assert found.count([]) >= 11


def test_little_wear_tells_nothing() -> None:
    assert edge_changes(_cuts(3, unseen=32, grows=0.05)) == []


def test_an_edge_that_wears_late_was_not_changed() -> None:
    """Its growth begins where that of the others would begin anew, and no force falls there."""
    for seed in range(8):
        rng = np.random.default_rng(seed)
        number = np.arange(60)
        written = np.asarray(60.0 * (number % 20), dtype=np.float64)
        true = np.where(number < 40, written, np.maximum(written - 300.0, 0.0))
        growth = 0.35 * np.sqrt(true / 1200.0)
        q = np.column_stack([growth, 1.6 * growth]) + rng.normal(0.0, 0.03, (60, 2))
        assert edge_changes(EdgeCuts(q, (number // 20).astype(np.intp), written, 0.5)) == []


def test_growth_is_seen_and_seldom_where_there_is_none() -> None:
    """Of 200 draws 0.6 are expected to be wrong (0.3 %): more than 5 are once in 20 000 times."""
    assert all(wears(_cuts(seed, unseen=None, grows=0.1)) for seed in range(20))
    assert sum(wears(_cuts(seed, unseen=None, grows=0.0)) for seed in range(200)) <= 5


def test_forces_that_fall_with_use_do_not_wear() -> None:
    assert not wears(_cuts(4, unseen=None, grows=-0.2))


def _broke_down(seed: int, after: int, softer: int = 0) -> EdgeCuts:
    """Return the cuts of an edge that wears late, changed before the last ``after`` of them.

    ``softer``: so many cuts before the last are of softer work instead.
    """
    rng = np.random.default_rng(seed)
    number = np.arange(40)
    edge = np.where(number < 16, 0, 1)
    written = np.asarray(60.0 * np.where(edge == 0, number, number - 16), dtype=np.float64)
    begun_s = written[40 - after] if after else 0.0
    true = np.where(number >= 40 - after, written - begun_s, written)
    share = true / 1440.0
    growth = 0.08 * share + 0.3 * share**6
    growth[39 - softer : 39] -= 0.25
    q = np.column_stack([growth, 1.3 * growth]) + rng.normal(0.0, 0.03, (40, 2))
    return EdgeCuts(q, edge.astype(np.intp), written, 1.0)


@pytest.mark.parametrize("after", [2, 3, 5])
def test_an_edge_that_breaks_down_is_seen_to_be_changed_soon(after: int) -> None:
    found = [[one.cut for one in edge_changes(_broke_down(seed, after))] for seed in range(8)]
    assert found.count([40 - after]) >= 6


def test_softer_cuts_before_a_worn_one_are_no_new_edge() -> None:
    for seed in range(8):
        assert edge_changes(_broke_down(seed, 0, softer=2)) == []
