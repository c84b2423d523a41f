"""Cases with hidden effects: the same bytes, effects as clear as wanted, a record that adds up."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.proofs.cases.axis.axis_cases import AXIS_KINDS, EFFORT, draw_axis_case
from autodb.proofs.cases.base.case import UNKNOWN, Case, Yardstick
from autodb.proofs.cases.base.disturbance import ChannelNoise
from autodb.proofs.cases.cuts.cut_cases import CUT_KINDS, FORCES, draw_table_case
from autodb.proofs.cases.plan import (
    CLARITIES,
    DEVELOPMENT,
    NOTHING_EVERY,
    PROOF,
    draw_concealed,
    fixed_cases,
    planned_case,
)
from autodb.proofs.runs.explain.explain_oracle import SURE, oracle_verdict
from autodb.terms.vocabulary import vocabulary
from tests.helpers.campaigns import first

RECORDED = {"saturation", "lost_sign"}
"""What acts on the noise too: the record less the truth is not the noise alone."""


def _axis(kind: str, wanted: float = 20.0, seed: int = 5) -> Case:
    return draw_axis_case(seed, (kind,), wanted, family=DEVELOPMENT)


def _table(kind: str, wanted: float = 20.0, seed: int = 5) -> Case:
    return draw_table_case(seed, (kind,), wanted, family=DEVELOPMENT)


BOTH = [(_axis, kind) for kind in AXIS_KINDS] + [(_table, kind) for kind in CUT_KINDS]


@pytest.fixture(scope="module", params=BOTH, ids=lambda one: f"{one[0].__name__[1:]}-{one[1]}")
def alone(request: pytest.FixtureRequest) -> Case:
    """Return a case with one hidden effect, of every kind, in a recording and in a table."""
    make, kind = request.param
    made: Case = make(kind)
    return made


def test_what_is_hidden_is_a_term_or_unknown_and_not_included(alone: Case) -> None:
    (hidden,) = alone.hidden
    expected = UNKNOWN if "outside" in alone.kind else alone.kind
    assert hidden.term == expected
    assert hidden.term in vocabulary() | {UNKNOWN}
    assert hidden.term not in alone.includes


def test_an_effect_shows_as_clearly_as_wanted(alone: Case) -> None:
    """By normal equations of whitened columns, where the generator uses an orthonormal basis."""
    (hidden,) = alone.hidden
    if alone.reached:
        assert_allclose(hidden.clarity, alone.wanted, rtol=1e-3)
    own = alone.whitened(alone.own).reshape(len(alone.own), -1)
    white = own / np.max(np.abs(own), axis=-1, keepdims=True)
    part = alone.whitened(hidden.part).ravel()
    left = part - white.T @ np.linalg.solve(white @ white.T, white @ part)
    assert_allclose(np.sqrt(np.sum(left**2)), hidden.clarity, rtol=0.02)


def test_simulation_and_effects_are_the_truth_and_noise_is_left(alone: Case) -> None:
    own = alone.own.reshape(len(alone.own), -1)
    rest = (alone.truth - alone.hidden[0].part).ravel()
    sizes = np.linalg.lstsq(own.T, rest, rcond=None)[0]
    assert_allclose(sizes @ own, rest, atol=1e-9 * np.max(np.abs(rest)))
    if alone.tuning == "true":
        assert_allclose(alone.simulated + alone.hidden[0].part, alone.truth, atol=1e-9)
    if alone.kind not in RECORDED:
        white = alone.whitened(alone.measured - alone.truth).ravel()
        few = 4.0 / np.sqrt(white.size)
        assert_allclose(np.std(white), 1.0, atol=0.03 + few)
        assert abs(np.mean(white[1:] * white[:-1])) < 0.03 + few


@pytest.mark.parametrize(
    "kind", first(2, ["stribeck", "outside_corner", "cogging", "warmup", "compliance"])
)
def test_the_oracle_finds_what_is_clear_in_an_axis(kind: str) -> None:
    judged = oracle_verdict(_axis(kind, 20.0, seed=8))
    assert judged.decidable
    assert judged.margin is not None
    assert judged.margin > SURE
    assert judged.recovery is not None
    assert judged.recovery < 1.0


def test_the_same_seed_has_the_same_bytes_and_another_family_others() -> None:
    one, same, other = draw_concealed(4), draw_concealed(4), draw_concealed(4, family=DEVELOPMENT)
    assert one.kind == other.kind
    for name, values in one.channels.items():
        assert values.tobytes() == same.channels[name].tobytes()
    assert one.simulation[EFFORT].tobytes() == same.simulation[EFFORT].tobytes()
    assert one.channels[EFFORT].tobytes() != other.channels[EFFORT].tobytes()
    assert draw_concealed(4, family=PROOF).measured.tobytes() == one.measured.tobytes()


def test_every_third_case_hides_nothing_and_the_rest_everything() -> None:
    plans = [planned_case(number) for number in range(1, 421)]  # each kind at each clarity
    assert all(not plan.kinds for plan in plans[NOTHING_EVERY - 1 :: NOTHING_EVERY])
    assert sum(not plan.kinds for plan in plans) == len(plans) // NOTHING_EVERY
    seen = {(kind, plan.table, plan.wanted) for plan in plans for kind in plan.kinds}
    assert seen == {
        (kind, table, wanted)
        for kinds, table in ((AXIS_KINDS, False), (CUT_KINDS, True))
        for kind in kinds
        for wanted in CLARITIES
    }


def test_fixed_cases_hide_something_in_two_of_three() -> None:
    fixed = list(fixed_cases(6))
    assert [case.seed for case in fixed] == [1, 2, 3, 4, 5, 6]
    assert [case.wanted for case in fixed] == [20.0, 8.0] * 3
    assert [bool(case.hidden) for case in fixed] == [True, True, False] * 2
    assert fixed[0].measured.tobytes() != draw_concealed(1).measured.tobytes()
    sixty = [planned_case(seed) for seed in range(1, 61)]
    assert sum(bool(plan.kinds) for plan in sixty) == 40
    assert {plan.table for plan in sixty} == {False, True}


def test_a_table_of_cuts_has_what_a_shop_knows() -> None:
    tables = [_table("tool_wear", seed=seed) for seed in range(1, 9)]
    case = next(one for one in tables if "tool.edge" in one.channels)
    assert {"cut", "t", "cutting.speed", "cutting.feed", "cutting.depth", *FORCES} <= set(
        case.channels
    )
    rpm = 1000.0 * case.channels["cutting.speed"] / (np.pi * case.channels["work.diameter"])
    assert_allclose(case.channels["spindle.speed"], rpm)
    edges, used = case.channels["tool.edge"], case.channels["tool.cutting_time"]
    starts = np.flatnonzero(np.diff(edges, prepend=-1.0))
    assert_allclose(used[starts], 0.0, atol=1e-6)
    inside = np.setdiff1d(np.arange(1, len(used)), starts)
    assert np.all(used[inside] > used[inside - 1])


@pytest.mark.parametrize("rho", [0.0, 0.6, 0.97])
@pytest.mark.parametrize("white", [0.0, 0.7])
def test_whitened_noise_is_white(rho: float, white: float) -> None:
    noise = ChannelNoise(slow=1.3, rho=rho, white=white)
    drawn = noise.draw(np.random.default_rng(3), 40_000)
    assert_allclose(np.std(drawn), np.hypot(1.3, white), rtol=0.1)
    flat = noise.whitened(drawn)
    assert_allclose(np.std(flat), 1.0, rtol=0.02)
    for lag in (1, 2, 7):
        assert abs(np.mean(flat[lag:] * flat[:-lag])) < 0.02


def test_a_yardstick_leaves_own_columns_out() -> None:
    case = _axis("cogging")
    beside = Yardstick.beside(case.own, case.whitened)
    assert beside.clarity(case.own[0]) < 1e-6 * np.linalg.norm(case.whitened(case.own[0]))
    both = beside.clarity(case.hidden[0].part + 3.0 * case.own[1])
    assert_allclose(both, beside.clarity(case.hidden[0].part), rtol=1e-9)


def test_every_case_of_a_plan_can_be_drawn() -> None:
    """What is hidden together can be: one case of each entry, seeds of DEVELOPMENT."""
    seeds = [seed for seed in range(1, 130) if planned_case(seed).kinds]
    cases = [draw_concealed(seed, family=DEVELOPMENT) for seed in seeds]
    assert {case.kind for case in cases} == {"+".join(planned_case(seed).kinds) for seed in seeds}
    assert sum(not case.reached for case in cases) < 0.15 * len(cases)
    for case in cases:
        assert np.isfinite(case.measured).all()
        if case.reached:
            assert_allclose([one.clarity for one in case.hidden], case.wanted, rtol=0.01)
