"""Fixed cases with concealed effects: what is named, and nothing where nothing is hidden.

`autodb prove explain` counts over many cases how often names are right; here a few say whether a
change has lost what was had: one of the sixty, and all sixty in `make campaigns`.
"""

from dataclasses import replace

import pytest
from numpy.testing import assert_array_equal

from autodb.proofs.cases.base.case import Case
from autodb.proofs.cases.plan import FIXED, draw_concealed, fixed_cases, planned_case
from autodb.proofs.runs.explain.explain_score import ScoredCase
from autodb.proofs.runs.explain.left_out import scored_case

TEN = 10
MISSED = 2
"""Of some five decidable cases in ten, those that may come out otherwise than exactly."""
ONE = 7
"""One that hides an effect, and is named exactly."""


def _scores_hold(scored: list[ScoredCase], *, missed: int) -> None:
    """Nothing where nothing is hidden, and of decidable cases all but so many named exactly."""
    assert {one.seed: one.found for one in scored if not one.terms and one.found} == {}
    decidable = [one for one in scored if one.terms and one.decidable]
    wanting = [(one.seed, one.kind, sorted(one.found)) for one in decidable if not one.exact]
    assert len(wanting) <= missed, wanting
    assert sum(bool(one.wrong) for one in decidable) <= 1, wanting


def _drawn(seed: int) -> Case:
    plan = replace(planned_case(seed), wanted=20.0 if seed % 2 else 8.0)
    return draw_concealed(seed, family=FIXED, asked=plan)


def _answered(seed: int) -> ScoredCase:
    return scored_case(_drawn(seed))


def test_one_case() -> None:
    """It is explained, scored, and the measured channel corrected."""
    one = _answered(ONE)
    _scores_hold([one], missed=0)
    assert (one.refused, one.exact) == ("", True)
    assert one.recovery is not None
    assert one.recovery < 0.5


@pytest.mark.campaign
@pytest.mark.parametrize("first", range(0, 60, TEN))
def test_ten_fixed_cases(first: int) -> None:
    scored = [_answered(seed) for seed in range(first + 1, first + TEN + 1)]
    _scores_hold(scored, missed=MISSED)


def test_the_fixed_cases_are_those_of_the_plan() -> None:
    first, again = next(fixed_cases(1)), _drawn(1)
    assert first.seed == again.seed == 1
    assert first.terms == again.terms
    assert_array_equal(first.measured, again.measured)
