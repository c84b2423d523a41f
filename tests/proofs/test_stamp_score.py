"""The score of stamped recordings can fail: right, wrong, refused and broken answers."""

from dataclasses import replace

import pytest
from numpy.testing import assert_allclose

from autodb.proofs.cases.stamps.stamp_cases import (
    STAMP_KINDS,
    stamped_of,
)
from autodb.proofs.runs.found import markdown
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.stamps.stamp_answers import (
    SaidLines,
    StampAnswers,
    answers_to,
    printed_coefficients,
    read_causes,
)
from autodb.proofs.runs.stamps.stamps_run import JudgedStamps, explained_as, judged_stamps
from autodb.proofs.runs.stamps.stamps_summary import (
    ALL,
    TWINS,
    StampsSummary,
    stamps_summary_of,
)

SEED = 1214
"""Of recordings that no run of the proof draws; short ones."""
KINDS = {kind.name: kind for kind in STAMP_KINDS}


TABLE = """\
x.current of axis x

  term      parameter         value        sd   unit      plain least squares       sd
 ─────────────────────────────────────────────────────────────────────────────────────
  inertia   coefficient     {inertia}   1.1e-05   A·s²/mm            0.00301908  5.9e-06
  viscous   coefficient   0.0100021   6.7e-05   A·s/mm              0.0100537   2.1e-05
  coulomb   level           1.19984    0.0091   A                     1.19466    0.0016

stamps are evenly spaced
"""
REFUSAL = SaidLines(2, "", "autodb: recording.csv: column 't', row 2: time stands still\n")
GIVEN = {"inertia": 0.00201, "viscous": 0.01, "coulomb": 1.2}
TOLD = SaidLines(0, "x.current: no mismatch beyond noise\n", "")


def _answers(
    coefficients: dict[str, float] | None = None, causes: tuple[str, ...] = ("viscous",)
) -> StampAnswers:
    given = GIVEN if coefficients is None else coefficients
    said = SaidLines(0, TABLE.format(inertia="0.00201"), "")
    return StampAnswers(said, TOLD, given, frozenset(causes), "0" * 16)


def _judge(answers: StampAnswers, twin: StampAnswers | None = None) -> JudgedStamps:
    drawn = stamped_of(KINDS["1 ms, rounded"], SEED)
    known = replace(drawn, axis=replace(drawn.axis, left_out="viscous"))
    return judged_stamps(known, answers, twin or _answers(), 0.1)


def test_a_right_answer_is_not_wrong() -> None:
    judged = _judge(_answers())
    assert (judged.stamped.identified, judged.stamped.explained) == ("answered", "same")
    assert_allclose([e for e in judged.stamped.errors if e is not None], [0.5, 0, 0], atol=1e-9)
    assert not judged.stamped.silently_wrong
    assert judged.stamped.said == "stamps are evenly spaced"


@pytest.mark.parametrize(
    "answers",
    [
        _answers({**GIVEN, "inertia": 0.00207}),
        _answers({**GIVEN, "coulomb": 1.16}),
        _answers({"inertia": 0.002, "viscous": 0.01}),  # not given, and nothing refused
        _answers({}),
        _answers(causes=("viscous", "lag")),
        _answers(causes=("viscous", "inertia (mistuned)")),
        _answers(causes=()),
    ],
)
def test_a_wrong_answer_is_silently_wrong(answers: StampAnswers) -> None:
    assert _judge(answers).stamped.silently_wrong


def test_a_refusal_is_refused_and_a_traceback_or_two_lines_are_broken() -> None:
    refused = StampAnswers(REFUSAL, REFUSAL, {}, frozenset(), "")
    judged = _judge(refused).stamped
    assert (judged.identified, judged.explained) == ("refused", "refused")
    assert not judged.silently_wrong
    assert not judged.broken
    assert judged.said.startswith("autodb: recording.csv: column 't'")
    for bad in (
        SaidLines(1, "", "ValueError: x"), SaidLines(2, "", "a\nb\n"), SaidLines(2, "a", "b"),
        SaidLines(130, "", "interrupted"),
    ):  # fmt: skip
        assert _judge(replace(refused, identified=bad)).stamped.broken


def test_causes_are_compared_with_the_twins_and_the_truth() -> None:
    truth = frozenset({"coulomb"})
    both = frozenset({"coulomb", "stribeck"})
    assert explained_as(_answers(causes=("coulomb",)), both, truth) == "fewer"
    assert explained_as(_answers(causes=("stribeck",)), both, truth) == "wrong"
    assert explained_as(_answers(causes=()), frozenset(), truth) == "same"  # neither can tell
    assert explained_as(replace(_answers(), explained=None), both, truth) == "not asked"


def test_answers_are_read_from_what_commands_print_and_write() -> None:
    found = printed_coefficients(TABLE.format(inertia="0.00201468"))
    assert found == {"inertia": 0.00201468, "viscous": 0.0100021, "coulomb": 1.19984}
    assert printed_coefficients("not excited, not estimated: inertia coefficient: moves") == {}
    causes = [
        {"term": "viscous", "kind": "missing", "confidence": 0.99},
        {"term": "lag", "kind": "missing", "confidence": 0.49},
        {"term": "inertia", "kind": "mistuned", "confidence": 0.5},
        {"term": "unknown", "kind": "missing", "confidence": 0.9},
    ]
    assert read_causes({"x.current": {"missing": causes}}) == {"viscous", "inertia (mistuned)"}


def _summary(*judged: JudgedStamps) -> StampsSummary:
    origin = Origin("stamps", "0", "0" * 16, "0" * 16)
    runs = [Finished(seed, (one,)) for seed, one in enumerate(judged, start=1)]
    return stamps_summary_of(runs, origin)


def test_a_summary_passes_only_without_anything_wrong() -> None:
    refused = StampAnswers(REFUSAL, REFUSAL, {}, frozenset(), "")
    right, wrong = _judge(_answers()), _judge(_answers({**GIVEN, "viscous": 0.0104}))
    assert _summary(right, _judge(refused)).passed
    assert not _summary(right, wrong).passed
    assert not _summary(replace(right, plain=True, stamped=_judge(refused).stamped)).passed
    assert not _summary(_judge(_answers(), twin=refused)).passed
    assert not _summary(_judge(replace(refused, explained=SaidLines(1, "", "boom")))).passed


def test_a_summary_shows_shares_and_comes_back_from_json() -> None:
    refused = StampAnswers(REFUSAL, REFUSAL, {}, frozenset(), "")
    found = _summary(_judge(_answers()), _judge(refused), _judge(_answers({})))
    assert StampsSummary.from_json(found.to_json()) == found
    row = next(one for one in found.rows if one.name == "1 ms, rounded")
    assert row.cells() == (
        "1 ms, rounded", "3", "1", "66.7 %", "0.50 %, none in 1", "2", "0", "1", "0", "1", "0"
    )  # fmt: skip
    assert [one.name for one in found.rows] == ["1 ms, rounded", ALL, TWINS]
    (wrong, *_) = found.limits
    assert (wrong.count, wrong.cases) == (1, 3)
    assert_allclose(wrong.high, 0.9057, atol=1e-4)  # Clopper-Pearson, 1 of 3
    assert "numbers of the even twins" in markdown(found)


def test_commands_are_asked_as_a_user_asks() -> None:
    """One that is answered, with its side file, and one that is refused in one line."""
    stated = stamped_of(KINDS["ms, stated"], SEED)
    found = judged_stamps(stated, answers_to(stated, stated.stamped), _answers(), 0.0).stamped
    assert found.identified == "answered"
    assert not found.off
    constant = stamped_of(KINDS["constant"], SEED)
    refused = answers_to(constant, constant.stamped)
    assert refused.identified.outcome == "refused"
    assert "recording.csv" in refused.identified.of_time
    assert "/" not in refused.identified.of_time
