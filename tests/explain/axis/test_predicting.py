"""What a correction takes has to predict rows that its fit did not see."""

import pytest

from autodb.proofs.cases.real.real_case import RealSpec
from autodb.proofs.cases.real.real_cases import made_case
from autodb.proofs.runs.real.real_answers import explained_real
from tests.conftest import shared


def test_what_a_law_gets_wrong_in_shape_goes_where_it_predicts_worse(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A dip of 42 N in the friction of a real axis: white rows show a deviation of its shape whose
    error is 9.2 N on rows left out, without the deviation 3.3 N, and of the simulation 8.4 N."""
    shared("data", "emps", "DATA_EMPS.mat")
    monkeypatch.setenv("AUTODB_SHARED", str(shared("data").parent))
    case = made_case(RealSpec("injected", "emps", "stribeck", "strong", "mistuned"))
    answer = explained_real(case)
    assert answer.before is not None
    assert answer.after is not None
    assert answer.after < 0.5 * answer.before
    (dip,) = [one for one in answer.entries if one.term == "stribeck"]
    assert dip.confidence > 0.9
    assert dip.size == pytest.approx(case.true_size, rel=0.25)


def test_what_an_own_term_would_have_to_double_for_is_counted_to_the_effect(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Friction that differs by direction is a constant but for the turns: rows hardly tell it from
    the simulation's own constant load, which would have to grow to six times its size."""
    shared("data", "odrive_cogging")
    monkeypatch.setenv("AUTODB_SHARED", str(shared("data").parent))
    case = made_case(RealSpec("injected", "odrive-beside-fed", "asymmetry", "weak", "exact"))
    (uneven,) = [one for one in explained_real(case).entries if one.term == "asymmetry"]
    assert uneven.size == pytest.approx(case.true_size, rel=0.1)
