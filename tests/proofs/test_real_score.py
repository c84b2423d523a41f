"""How answers to real axes are scored, on answers made by hand; limits can be missed."""

import json
from collections.abc import Callable
from dataclasses import replace

import pytest

from autodb.proofs.cases.real.injected import fitted_axis
from autodb.proofs.cases.real.real_cases import real_specs
from autodb.proofs.cases.real.real_sources import real_axis
from autodb.proofs.catalogue import proof
from autodb.proofs.runs.found import markdown
from autodb.proofs.runs.real import real_run
from autodb.proofs.runs.real.idle_names import idle_names
from autodb.proofs.runs.real.real_answers import (
    RealAnswer,
    SaidEntry,
    explained_real,
    read_answer,
)
from autodb.proofs.runs.real.real_peers import PEERS, greedy
from autodb.proofs.runs.real.real_run import judged_real, planned, run_real
from autodb.proofs.runs.real.real_score import JudgedReal, peer_score, unjudged
from autodb.proofs.runs.real.real_summary import RealSummary, real_summary_of
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.stamps.stamp_answers import SaidLines
from tests.helpers.laid_axis import hand_case

CASE = hand_case()
NULL = hand_case(None, kind="null", variant="exact")
SIZE = CASE.true_size or 0.0
NONE = RealAnswer((), 1.0, 0.1)


def _answer(*entries: tuple[str, float, float], after: float = 0.05) -> RealAnswer:
    """Return an answer of (term, confidence, size in true sizes); `*` before one mistuned."""
    said = tuple(
        SaidEntry(term.lstrip("*"), "mistuned" if term[0] == "*" else "missing", sure, SIZE * size)
        for term, sure, size in entries
    )
    return RealAnswer(said, 1.0, after)


@pytest.mark.parametrize(
    ("entries", "named", "hit", "wrong"),
    [
        ((("coulomb", 0.99, 1.0),), True, True, False),
        ((("coulomb", 0.99, 1.9),), True, False, False),
        ((("coulomb", 0.99, 2.1),), False, False, False),
        ((("coulomb", 0.49, 1.0),), False, False, False),
        ((("coulomb", 0.6, 1.0), ("lag", 0.99, 3.0)), True, True, False),  # more than one is said
        ((("lag", 0.99, 0.6),), False, False, True),
        ((("lag", 0.99, 0.4),), False, False, False),
        ((("lag", 0.8, 1.0),), False, False, False),
        ((("unknown", 0.99, 1.0),), False, False, False),
        ((("*viscous", 0.99, 1.0),), False, False, False),
        ((), False, False, False),
    ],
)
def test_names_and_sizes(
    entries: tuple[tuple[str, float, float], ...], named: bool, hit: bool, wrong: bool
) -> None:
    judged = judged_real(CASE, _answer(*entries), NONE)
    assert (judged.named, judged.hit, judged.wrong) == (named, hit, wrong)


def test_another_fair_name_is_as_good() -> None:
    both = hand_case(fair=("stribeck",))
    judged = judged_real(both, _answer(("stribeck", 0.7, 1.1)), NONE)
    assert judged.named
    assert judged.size_ratio is None
    assert both.decidable
    assert not hand_case(fair=("stribeck",), kind="injected").decidable


def test_fit_and_harm_are_of_held_out_errors() -> None:
    good = judged_real(CASE, _answer(after=2.0 * CASE.rms_full), NONE)
    assert good.fit == pytest.approx(2.0)
    assert not good.harm
    assert not judged_real(CASE, _answer(after=1.019), NONE).harm
    assert judged_real(CASE, _answer(after=1.021), NONE).harm


def test_what_the_recording_holds_anyway_is_not_held_against_an_answer() -> None:
    said = _answer(("coulomb", 0.95, 1.0), ("lag", 0.95, 0.1), ("gain", 0.8, 0.1))
    assert judged_real(CASE, said, NONE).sure == ((0.95, True), (0.95, False))
    also = _answer(("lag", 0.3, 0.1))
    assert judged_real(CASE, said, also).sure == ((0.95, True),)
    named = _answer(("coulomb", 0.6, 1.0))
    assert judged_real(CASE, said, named).false_name
    assert not judged_real(CASE, said, also).false_name


def test_a_retuning_is_right_of_what_was_made_wrong() -> None:
    tuned = replace(CASE, retuned=("viscous",))
    said = _answer(("*viscous", 0.95, 0.1), ("*inertia", 0.95, 0.1))
    assert judged_real(tuned, said, NONE).sure == ((0.95, True), (0.95, False))
    refitted = replace(CASE, retuned=("viscous", "inertia"))
    assert judged_real(refitted, said, NONE).sure == ()


def test_a_null_may_be_retuned_by_less_than_a_third() -> None:
    peak = NULL.own_peaks["viscous"]
    for share, right in ((0.29, True), (0.31, False)):
        said = RealAnswer((SaidEntry("viscous", "mistuned", 0.9, share * peak),), 1.0, 1.0)
        judged = judged_real(NULL, said, NONE)
        assert (judged.own_ok, judged.null_ok) == (right, right)
    assert not judged_real(NULL, _answer(after=1.1), NONE).null_ok


def test_names_that_do_no_work_in_a_null_are_idle() -> None:
    said = RealAnswer((SaidEntry("gravity", "missing", 0.95, 1.0),), 1.0, 1.0)
    assert judged_real(NULL, said, NONE).idle == ("gravity",)
    working = replace(NULL, axis=NULL.axis.with_effort(NULL.axis.effort + 0.5))
    assert idle_names(working, ("gravity", "spring")) == ("spring",)


@pytest.mark.parametrize(("constant_A", "idle"), [(0.5, False), (0.0, True)])
def test_a_name_of_the_recording_itself_does_work_there_or_none(
    constant_A: float, idle: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = replace(CASE, concealed="gravity", sizes={"gravity": SIZE})
    twin = replace(NULL, axis=NULL.axis.with_effort(NULL.axis.effort + constant_A))
    monkeypatch.setattr(real_run, "made_case", lambda _: case)
    monkeypatch.setattr(real_run, "twin_of", lambda _: twin)
    monkeypatch.setattr(real_run, "TWINS", {})
    monkeypatch.setattr(real_run, "explained_real", lambda _: _answer(("gravity", 0.95, 1.0)))
    (judged,) = run_real(1)
    assert (judged.false_name, judged.false_idle) == (True, idle)
    assert _summary(judged).real.false_idle == idle


def test_an_error_names_nothing_and_is_counted() -> None:
    lines = SaidLines(2, "", "autodb: recording.csv: too short\n")
    refused = read_answer({}, CASE.channel, lines)
    judged = judged_real(CASE, refused, NONE)
    assert judged.error == "autodb: recording.csv: too short"
    assert not judged.named
    assert not judged_real(NULL, refused, NONE).null_ok
    found = _summary(judged)
    assert found.both.errors == 1
    assert found.errors == (("autodb: recording.csv: too short", 1),)
    assert read_answer({"channels": {}}, CASE.channel, SaidLines(0, "", "")).error == (
        "exit 0, no answer"
    )


def test_an_answer_is_read_from_what_the_command_writes() -> None:
    entry = {"term": "coulomb", "kind": "missing", "confidence": 0.7,
             "parameters": {"size": {"value": -1.5}}}  # fmt: skip
    channel = {"missing": [entry], "fit": {"heldout_before": 2.0, "heldout_after": 1.0}}
    held = json.loads(json.dumps({"channels": {"x.current": channel}}))
    answer = read_answer(held, "x.current", SaidLines(0, "", ""))
    assert answer.entries == (SaidEntry("coulomb", "missing", 0.7, 1.5),)
    assert (answer.before, answer.after, answer.error) == (2.0, 1.0, "")


def test_the_command_is_asked_as_a_user_asks() -> None:
    answer = explained_real(CASE)
    assert answer.error == ""
    assert answer.after is not None
    assert answer.before is not None
    assert answer.after < answer.before
    short = replace(CASE, axis=CASE.axis.rows(slice(0, 5)), simulated=CASE.simulated[:5])
    assert explained_real(short).error.startswith("autodb: ")


def test_greedy_names_what_shows_at_a_glance_and_not_what_is_not_there() -> None:
    for names in PEERS.values():
        scored = peer_score(CASE, greedy(CASE, names))
        assert scored.named
        assert not scored.wrong
        assert scored.fit is not None
        assert scored.fit < 1.05
    assert peer_score(NULL, greedy(NULL, PEERS["greedy, plain columns"])).silent
    lag_alone = peer_score(CASE, greedy(CASE, ("position_friction",)))
    assert not lag_alone.named


def test_what_does_not_show_is_not_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(real_run, "made_case", lambda _: hand_case(seen=False))
    monkeypatch.setattr(real_run, "explained_real", lambda _: pytest.fail("asked"))
    (judged,) = run_real(1)
    assert judged == unjudged(hand_case(seen=False), "emps")
    found = _summary(judged, _judged())
    assert found.both.cases == 1
    (count,) = (one for one in found.counts if one.name == "left out")
    assert (count.cases, count.asked, count.decidable) == (2, 1, 1)


def _judged(
    kind: str = "left out", *, strength: str = "", fair: tuple[str, ...] = ()
) -> JudgedReal:  # fmt: skip
    case = hand_case(kind=kind, strength=strength, fair=fair)
    judged = judged_real(case, _answer(("coulomb", 0.95, 1.0), after=case.rms_full), NONE)
    peers = {name: peer_score(case, greedy(case, ("viscous",))) for name in PEERS}
    return replace(judged, peers=peers)


def _null() -> JudgedReal:
    judged = judged_real(NULL, RealAnswer((), 1.0, 1.0), NONE)
    return replace(judged, peers={name: peer_score(NULL, greedy(NULL, ())) for name in PEERS})


def _summary(*judged: JudgedReal) -> RealSummary:
    full = [one if one.peers or not one.seen else replace(one, peers=_null().peers)
            for one in judged]  # fmt: skip
    runs = [Finished(seed, (one,)) for seed, one in enumerate(full, start=1)]
    return real_summary_of(runs, Origin("real", "0", "0" * 16, "0" * 16))


def test_a_summary_passes_where_everything_is_right() -> None:
    shown, strong = _judged("shown"), _judged("injected", strength="strong")
    found = _summary(shown, *[strong] * 80, _null())
    assert [check for check in found.checks() if not check[-1]] == []
    assert found.passed
    assert not _summary(shown, *[strong] * 20, _null()).passed  # 20 are too few for the limits
    assert RealSummary.from_json(found.to_json()) == found
    assert "real and injected: named" in markdown(found)


@pytest.mark.parametrize(
    ("wrong", "missed"),
    [
        (lambda one: replace(one, kind="shown", wrong=True), "shown: wrong"),
        (lambda one: replace(one, kind="shown", named=False), "shown: named"),
        (lambda one: replace(one, harm=True), "harmed"),
        (lambda one: replace(one, sure=((0.95, False),) * 20), "entries at 0.9 or more: right"),
    ],
)
def test_a_summary_says_which_limit_is_missed(
    wrong: Callable[[JudgedReal], JudgedReal], missed: str
) -> None:
    shown, strong = _judged("shown"), _judged("injected", strength="strong")
    found = _summary(shown, *[strong] * 120, _null(), wrong(_judged()))
    assert [name for name, *_, passed in found.checks() if not passed] == [missed]


def test_a_null_is_silent_where_nothing_is_named() -> None:
    nulls = [
        judged_real(NULL, RealAnswer(entries, 1.0, 1.0), NONE)
        for entries in (
            (),
            (SaidEntry("lag", "missing", 0.4, 1.0), SaidEntry("unknown", "missing", 0.9, 1.0)),
            (SaidEntry("viscous", "mistuned", 0.9, 0.1),),
            (SaidEntry("lag", "missing", 0.5, 1.0),),
        )
    ]
    ours = _summary(_judged(), *nulls).peers[0]
    assert (ours.nulls, ours.silent) == (4, 3)


def test_cases_that_cannot_be_decided_are_counted_apart() -> None:
    found = _summary(_judged("injected", fair=("stribeck",), strength="weak"), _judged())
    assert (found.both.cases, found.others.cases) == (1, 1)


def test_the_plan_ends(refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch) -> None:
    assert proof("real").runs == len(real_specs())
    assert planned(1) == real_specs()[0]
    monkeypatch.delenv("AUTODB_SHARED", raising=False)
    for kept in (real_axis, fitted_axis):
        kept.cache_clear()
    assert "AUTODB_SHARED is not set" in refused("prove", "real", "--runs", 1)
    monkeypatch.setenv("AUTODB_SHARED", "/nowhere")
    assert "/nowhere/data/" in refused("prove", "real", "--runs", 1)
    monkeypatch.setattr(real_run, "real_specs", list)
    assert "the plan has 0 cases" in refused("prove", "real", "--runs", 1)
