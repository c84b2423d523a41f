"""Several sensors of one force: what is known comes back, none harms, and gaps are filled."""

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.sensing.fusion import (
    Fusion,
    SensedTogether,
    disagreeing,
    fuse,
    independent,
    learn_fusion,
    trusting_less,
    with_sensor,
)

Array = NDArray[np.float64]

NAMES = ("drive", "table")


def _recordings(
    seed: int, sds: Sequence[float], *, bias: float = 0.0, shared: float = 0.0, count: int = 16
) -> tuple[list[SensedTogether], list[Array]]:
    """Draw forces as two sensors tell them; ``shared``: sd of an error that both have."""
    rng = np.random.default_rng([seed, 30])
    heard, known = [], []
    for _ in range(count):
        force = 100.0 * rng.standard_normal(500)
        both = shared * rng.standard_normal(500)
        stated = [force + both + sd * rng.standard_normal(500) for sd in sds]
        stated[0] = stated[0] + bias
        said = np.column_stack([np.full(500, np.hypot(sd, shared)) for sd in sds])
        heard.append(SensedTogether(np.column_stack(stated), said))
        known.append(force)
    return heard, known


def _rms(fusion: Fusion, heard: Sequence[SensedTogether], known: Sequence[Array]) -> float:
    off = [fuse(fusion, one).value_N - true for one, true in zip(heard, known, strict=True)]
    return float(np.sqrt(np.mean(np.concatenate(off) ** 2)))


def test_two_of_one_kind_are_the_inverse_variance_mean() -> None:
    """sds 10 and 20: weights 0.8 and 0.2, error √(1/(1/100 + 1/400)) = 8.94 N, bias taken off."""
    fusion = learn_fusion(NAMES, *_recordings(1, (10.0, 20.0), bias=30.0))
    heard, known = _recordings(2, (10.0, 20.0), bias=30.0)
    made = fuse(fusion, heard[0])
    assert_allclose(np.median(made.weight, axis=0), [0.8, 0.2], atol=0.06)
    assert_allclose(fusion.bias_N, [30.0, 0.0], atol=1.0)
    assert_allclose(_rms(fusion, heard, known), 8.944, rtol=0.05)
    held = [np.abs(fuse(fusion, h).value_N - k) <= 1.96 * fuse(fusion, h).sd_N
            for h, k in zip(heard, known, strict=True)]  # fmt: skip
    assert 0.93 < np.mean(held) < 0.97  # of 8000 rows that are alike


def test_a_sensor_that_says_what_another_says_adds_nothing() -> None:
    """The second has all of the first's error and more: the first alone is the answer."""
    rng = np.random.default_rng(7)
    heard, known = _recordings(3, (10.0, 0.0))
    heard = [
        SensedTogether(
            np.column_stack(
                [one.value_N[:, 0], one.value_N[:, 0] + 15.0 * rng.standard_normal(500)]
            ),
            np.column_stack([np.full(500, 10.0), np.full(500, 18.0)]),
        )
        for one in heard
    ]
    fusion = learn_fusion(NAMES, heard, known)
    assert fusion.counts == (True, False)
    alone = np.concatenate([h.value_N[:, 0] - k for h, k in zip(heard, known, strict=True)])
    assert_allclose(_rms(fusion, heard, known), np.sqrt(np.mean(alone**2)), rtol=1e-9)


def test_where_one_does_not_sense_the_other_answers_and_where_none_does_nothing() -> None:
    fusion = learn_fusion(NAMES, *_recordings(4, (10.0, 20.0)))
    heard, _ = _recordings(5, (10.0, 20.0), count=1)
    value = heard[0].value_N.copy()
    value[:100, 0], value[50:150, 1] = np.nan, np.nan
    made = fuse(fusion, SensedTogether(value, heard[0].sd_N))
    assert_allclose(made.value_N[:50], value[:50, 1] - fusion.bias_N[1])
    assert np.isnan(made.value_N[50:100]).all()
    assert np.isnan(made.sd_N[50:100]).all()
    assert_allclose(made.value_N[100:150], value[100:150, 0] - fusion.bias_N[0])
    assert_allclose(made.weight[100:150], [[1.0, 0.0]] * 50)
    assert (made.sd_N[:50] > made.sd_N[200:].max() * 0.99).all()


def test_a_sensor_alone_waits_until_the_better_one_does_not_sense() -> None:
    heard, known = _recordings(6, (5.0, 200.0))
    fusion = learn_fusion(NAMES, heard, known)
    value = heard[0].value_N.copy()
    value[:10, 0] = np.nan
    made = fuse(fusion, SensedTogether(value, heard[0].sd_N))
    assert made.weight[:10, 1] == pytest.approx(1.0)
    assert (made.weight[10:, 0] > 0.9).all()


def test_unsure_rows_count_less() -> None:
    """A sensor that says of half its rows that it is unsure, and is, is heard in the others."""
    rng = np.random.default_rng(8)
    heard, known = [], []
    for _ in range(16):
        force = 100.0 * rng.standard_normal(600)
        sd = np.column_stack([np.where(np.arange(600) < 300, 5.0, 50.0), np.full(600, 15.0)])
        heard.append(SensedTogether(force[:, None] + sd * rng.standard_normal((600, 2)), sd))
        known.append(force)
    fusion = learn_fusion(NAMES, heard, known)
    assert fusion.by_row
    weight = fuse(fusion, heard[0]).weight
    assert weight[:300, 0].min() > 0.8
    assert weight[300:, 0].max() < 0.2


def test_a_sensor_that_starts_to_disagree_is_found_and_counts_less() -> None:
    """Three sensors of 10 N each; one is off by 40 N from then on: it alone is named."""
    names = ("drive", "network", "table")
    fusion = learn_fusion(names, *_recordings(9, (10.0, 10.0, 10.0)))
    heard, known = _recordings(10, (10.0, 10.0, 10.0))
    assert [disagreeing(fusion, one) for one in heard] == [None] * 16
    off = SensedTogether(heard[0].value_N + np.array([0.0, 40.0, 0.0]), heard[0].sd_N)
    apart = disagreeing(fusion, off)
    assert apart is not None
    assert apart.names == ("network",)
    before, after = fuse(fusion, off), fuse(trusting_less(fusion, apart), off)
    assert np.median(after.weight[:, 1]) < 0.4 * np.median(before.weight[:, 1])
    errors = [float(np.sqrt(np.mean((m.value_N - known[0]) ** 2))) for m in (before, after)]
    assert errors[1] < 0.7 * errors[0]


def test_of_two_that_disagree_nobody_can_say_which() -> None:
    fusion = learn_fusion(NAMES, *_recordings(11, (10.0, 10.0)))
    heard, _ = _recordings(12, (10.0, 10.0))
    off = SensedTogether(heard[0].value_N + np.array([60.0, 0.0]), heard[0].sd_N)
    apart = disagreeing(fusion, off)
    assert apart is not None
    assert apart.names == NAMES
    before, after = fuse(fusion, off), fuse(trusting_less(fusion, apart), off)
    assert np.median(after.sd_N) > 2.0 * np.median(before.sd_N)


def test_one_more_sensor_is_believed_as_it_says() -> None:
    """sds 10, 20 and 5: the third has 1/25 of 1/25 + 1/100 + 1/400, three quarters and more."""
    fusion = with_sensor(learn_fusion(NAMES, *_recordings(13, (10.0, 20.0))), "third")
    heard, known = _recordings(14, (10.0, 20.0, 5.0))
    made = fuse(fusion, heard[0])
    assert_allclose(np.median(made.weight, axis=0)[2], 0.04 / (0.04 + 0.01 + 0.0025), atol=0.05)
    assert disagreeing(fusion, heard[0]) is None
    assert _rms(fusion, heard, known) < 5.0
    same = independent(("a", "b", "c"))
    assert_allclose(np.median(fuse(same, heard[0]).weight, axis=0), np.array([4, 1, 16]) / 21)
    assert Fusion.of_json(same.to_json()).to_json() == same.to_json()
