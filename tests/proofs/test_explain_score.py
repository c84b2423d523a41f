"""How answers are scored in the proof of explanations, on cases made by hand."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.explain.answer import (
    Cause,
    ChannelAnswer,
    ChannelTrace,
    Explained,
    Explanation,
    FitQuality,
)
from autodb.explain.answer import Where as Place
from autodb.proofs.runs.explain.explain_score import (
    NamedEntry,
    answer_entries,
    answer_recovery,
    brier,
    confidences,
    overlap,
    reliability,
    stretches,
)
from autodb.proofs.runs.explain.explain_summary import NOTHING, confusion, effects, limited_shares
from autodb.proofs.runs.score import exact_interval
from tests.helpers.explained_cases import T, entry, hand_made, scored


def _answer(*causes: tuple[str, str, float, tuple[str, ...]]) -> ChannelAnswer:
    listed = [
        Cause(term=term, kind="mistuned" if kind == "mistuned" else "missing",
              confidence=confidence, statement=".", parameters={}, alternatives=alternatives)
        for term, kind, confidence, alternatives in causes
    ]  # fmt: skip
    fit = FitQuality(
        rms_before=1.0, rms_after=1.0, heldout_before=1.0, heldout_after=1.0, noise_floor=1.0
    )
    where = Place(intervals=((1.0, 3.0),))
    return ChannelAnswer(
        unit="A", mismatch=bool(listed), where=where, missing=tuple(listed), fit=fit
    )


@pytest.mark.parametrize(
    ("named", "exact", "covered", "wrong", "abstained"),
    [
        ((), False, False, False, True),
        ((entry("unknown"),), False, False, False, True),
        ((entry("unknown", 0.9, "spring", "cogging"),), False, True, False, True),
        ((entry("spring"), entry("cogging")), True, True, False, False),
        ((entry("spring"), entry("spring"), entry("cogging")), True, True, False, False),
        ((entry("spring", 0.9, "cogging"),), False, True, False, False),
        ((entry("spring"), entry("cogging"), entry("lag")), False, True, True, False),
        ((entry("lag"),), False, False, True, False),
        ((entry("lag"), entry("unknown")), False, False, True, False),
    ],
)
def test_answers_are_right_wrong_or_abstain(
    named: tuple[NamedEntry, ...], exact: bool, covered: bool, wrong: bool, abstained: bool
) -> None:
    one = scored(("spring", "cogging"), *named)
    assert (one.exact, one.covered, one.wrong, one.abstained) == (exact, covered, wrong, abstained)


def test_unknown_is_right_where_no_identifier_stands() -> None:
    assert scored(("unknown",), entry("unknown")).exact
    assert not scored(("unknown",), entry("unknown")).wrong
    assert scored(("unknown",), entry("gravity")).wrong


def test_what_is_missing_is_read_off_every_channel() -> None:
    answers = {
        "force.x": _answer(("gain", "missing", 0.7, ("sensor_drift",))),
        "force.y": _answer(("shear", "mistuned", 0.9, ()), ("tool_wear", "missing", 0.8, ())),
    }
    assert answer_entries(answers) == (
        NamedEntry("force.x", "gain", 0.7, ("sensor_drift",)),
        NamedEntry("force.y", "tool_wear", 0.8, ()),
    )
    assert stretches(answers) == [(1.0, 3.0), (1.0, 3.0)]


@pytest.mark.parametrize(
    ("given", "step", "expected"),
    [
        ([(2.0, 4.0)], 0.0, 1.0),
        ([(3.0, 5.0)], 0.0, 1.0 / 3.0),
        ([(1.0, 3.0), (3.0, 4.0)], 0.0, 2.0 / 3.0),
        ([(2.0, 3.0), (2.5, 4.0)], 0.0, 1.0),
        ([(5.0, 6.0)], 0.0, 0.0),
        ([], 0.0, 0.0),
        ([(3.0, 4.0)], 1.0, 2.0 / 3.0),
    ],
)
def test_stretches_share_what_both_hold(
    given: list[tuple[float, float]], step: float, expected: float
) -> None:
    assert_allclose(overlap(given, (2.0, 4.0), step=step), expected)


def test_recovery_is_the_error_left_as_a_share() -> None:
    case = hand_made(np.sin(T), [])
    half = case.simulated + 0.5 * (case.truth - case.simulated)
    trace = ChannelTrace("t", T, case.measured, case.simulated, half)
    explained = Explained(Explanation(recording="", channels={}), {"x.current": trace})
    assert_allclose(answer_recovery(case, explained) or 0.0, 0.5)
    assert answer_recovery(replace(case, simulated=case.truth), explained) is None


def test_confidence_is_scored_as_in_closed_form() -> None:
    one = scored(("spring",), entry("spring", 0.8), entry("lag", 0.3))
    assert confidences([one]) == [(0.8, True), (0.3, False)]
    assert_allclose(brier(confidences([one])), (0.2**2 + 0.3**2) / 2.0)
    # a forecast p that is right with probability p has the score p (1 - p) on average
    pairs = [(0.7, i < 700) for i in range(1000)]
    assert_allclose(brier(pairs), 0.7 * 0.3)
    bins = reliability([(i / 1000.0, i % 2 == 0) for i in range(250)])
    assert [answers for answers, _, _ in bins] == [125, 125]
    assert_allclose([share for _, _, share in bins], 0.5, atol=0.01)
    assert reliability([]) == []


def test_limits_count_the_cases_they_are_of() -> None:
    cases = [
        scored(("spring",), entry("spring")),
        scored(("lag",), entry("spring")),
        replace(scored(("lag",), entry("spring", 0.6, "lag")), decidable=False),
        scored(("lag",), wanted=4.0),
        scored((), entry("gravity")),
        scored(()),
        replace(scored(("external_load",), entry("external_load")), overlap=0.4),
    ]
    found = limited_shares(cases)
    assert [(one.count, one.cases) for one in found] == [
        (2, 3), (1, 1), (0, 1), (1, 1), (1, 2), (0, 1), (3, 3)
    ]  # fmt: skip
    assert [one.passed for one in found] == [False, True, True, False, False, False, True]
    assert (found[4].low, found[4].high) == exact_interval(1, 2)
    assert not any(one.passed for one in limited_shares([]))


def test_a_thousand_nulls_pass_with_ten_false_alarms_and_fail_with_eleven() -> None:
    def judged(false: int) -> bool:
        cases = [scored((), *([entry("lag")] if i < false else [])) for i in range(1000)]
        return limited_shares(cases)[4].passed

    assert judged(10)
    assert not judged(11)


def test_confusion_has_what_was_named_instead() -> None:
    cases = [
        scored(("spring", "lag"), entry("spring"), entry("gravity")),
        scored(("lag",)),
        scored(("lag",), entry("lag")),
        scored((), entry("lag")),
        scored(("lag",), entry("cogging"), wanted=4.0),
    ]
    assert confusion(cases) == {
        "spring": {"spring": 1},
        "lag": {"gravity": 1, "lag": 1, NOTHING: 1},
        NOTHING: {"lag": 1},
    }


def test_a_row_for_each_effect_and_clarity_leaves_dropped_cases_out() -> None:
    one = scored(("spring",), entry("spring"))
    dropped = replace(scored(("spring",)), reached=False)
    together, alone = effects([one, dropped, scored(("spring", "lag"), entry("lag"))])
    assert (together.name, together.cases, together.exact) == ("axis: 2 effects", 1, 0.0)
    assert (alone.name, alone.cases, alone.dropped) == ("axis: spring", 1, 1)
    assert (alone.exact, alone.recovery) == (1.0, 0.25)
