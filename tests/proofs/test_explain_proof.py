"""The proof of explanations: its oracle and score on cases made by hand, its runs, its tables."""

import ast
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.explain.answer.answer import (
    Cause,
    ChannelAnswer,
    ChannelTrace,
    Explained,
    Explanation,
    FitQuality,
)
from autodb.explain.answer.answer import Where as Place
from autodb.proofs import catalogue
from autodb.proofs.cases.base.case import Case, Hidden, Rival
from autodb.proofs.cases.plan import PlannedCase, draw_concealed
from autodb.proofs.catalogue import (
    CONCEALED,
    CONCEALED_MILLS,
    PROOFS,
    Proof,
    begin_runs,
    carry_out,
    proof,
)
from autodb.proofs.runs.explain import left_out
from autodb.proofs.runs.explain.explain_oracle import SURE, oracle_recovery, oracle_verdict
from autodb.proofs.runs.explain.explain_score import (
    NamedEntry,
    ScoredCase,
    answer_entries,
    answer_recovery,
    brier,
    confidences,
    overlap,
    reliability,
    stretches,
)
from autodb.proofs.runs.explain.explain_summary import (
    NOTHING,
    ExplainSummary,
    confusion,
    effects,
    limited_shares,
)
from autodb.proofs.runs.found import markdown
from autodb.proofs.runs.score import exact_interval
from tests.conftest import ROOT, Cli

EXPLAIN = proof("explain")
T = np.linspace(0.0, 10.0, 500)


def _case(part: list[float] | np.ndarray, rivals: list[Rival], *, noise: float = 1.0) -> Case:
    """A constant is the simulation's own term; noise is white with sd 1 unless scaled."""
    hidden = np.asarray(part, dtype=np.float64)
    truth = 2.0 + hidden
    measured = truth + noise * np.random.default_rng(7).standard_normal(T.size)
    return Case(
        seed=1, kind="slope", wanted=20.0, reached=True, tuning="true",
        channels={"t": T, "x.current": measured}, simulation={"t": T, "x.current": 2.0 + 0.0 * T},
        includes=("gravity",), explained=("x.current",),
        hidden=(Hidden("slope", 1.0, 20.0, hidden),), interval=(2.0, 4.0),
        measured=measured, simulated=np.full_like(T, 2.0), truth=truth,
        own=np.ones((1, T.size)), whitened=lambda values: values, rivals=lambda: iter(rivals),
    )  # fmt: skip


def test_the_oracle_finds_evidence_of_what_no_rival_can_do() -> None:
    """Against rivals at right angles the margin is d^2 and noise; against its double nothing."""
    slope = T - np.mean(T)
    slope *= 20.0 / np.linalg.norm(slope)
    across = np.cos(2.0 * np.pi * np.arange(T.size) * 40 / T.size)
    far = oracle_verdict(_case(slope, [Rival("ripple", across[None])]))
    assert far.margin is not None
    assert_allclose(far.margin, 400.0, atol=4.0 * 20.0 + 20.0)
    assert far.decidable
    double = oracle_verdict(_case(slope, [Rival("double", -3.0 * slope[None] + 5.0)]))
    assert double.margin is not None
    assert abs(double.margin) < 0.01
    assert not double.decidable


def test_the_oracle_weighs_likeness_by_its_angle() -> None:
    """A rival that shares a part c of the effect's direction leaves (1 - c^2) d^2 of evidence."""
    slope = T - np.mean(T)
    slope /= np.linalg.norm(slope)
    across = np.cos(2.0 * np.pi * np.arange(T.size) * 40 / T.size)
    across -= np.mean(across) + slope * (slope @ across)
    across /= np.linalg.norm(across)
    alike = 0.8 * slope + 0.6 * across
    judged = oracle_verdict(_case(60.0 * slope, [Rival("alike", alike[None])], noise=0.01))
    assert judged.margin is not None
    assert_allclose(judged.margin, 0.36 * 3600.0, rtol=1e-3)


def test_the_oracle_combines_rivals_for_two_hidden_effects() -> None:
    """Two of three directions are hidden: the best wrong pair has the larger, not the smaller."""
    waves = np.array([np.cos(2.0 * np.pi * np.arange(T.size) * k / T.size) for k in (3, 5, 9)])
    waves /= np.linalg.norm(waves, axis=1)[:, None]
    one = _case(30.0 * waves[0], [], noise=1e-3)
    hidden = (
        Hidden("a", 1.0, 30.0, 30.0 * waves[0]),
        Hidden("b", 1.0, 10.0, 10.0 * waves[1]),
    )
    whole = np.sum([h.part for h in hidden], axis=0)
    case = replace(
        one,
        hidden=hidden,
        truth=2.0 + whole,
        measured=one.measured - one.truth + 2.0 + whole,
        rivals=lambda: iter([Rival("c", waves[2:]), Rival("a", waves[:1])]),
    )
    judged = oracle_verdict(case)
    assert judged.margin is not None
    assert_allclose(judged.margin, 100.0, rtol=1e-2)


def test_the_oracle_recovers_to_its_degrees_of_freedom() -> None:
    """Two free sizes leave an error of sd sqrt(2/n) on average, beside an effect of known rms."""
    case = _case(np.sin(2.0 * np.pi * T), [])
    left = oracle_recovery(case)
    assert left is not None
    assert 0.0 < left < 4.0 * np.sqrt(2.0 / T.size) / np.sqrt(0.5)


def test_nothing_hidden_has_no_margin_and_no_error() -> None:
    case = draw_concealed(3, asked=PlannedCase((), 8.0))
    judged = oracle_verdict(replace(case, simulated=case.truth))
    assert judged.margin is None
    assert judged.decidable
    assert judged.recovery is None


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


def _scored(hidden: tuple[str, ...], *named: NamedEntry, wanted: float = 20.0) -> ScoredCase:
    return ScoredCase(
        seed=1, kind="+".join(hidden), place="axis", wanted=wanted, reached=True, tuning="true",
        terms=hidden, clarities=(wanted,) * len(hidden), margin=100.0, decidable=True,
        best_recovery=0.2, named=named, recovery=0.25,
    )  # fmt: skip


def _name(term: str, confidence: float = 0.9, *alternatives: str) -> NamedEntry:
    return NamedEntry("x.current", term, confidence, alternatives)


@pytest.mark.parametrize(
    ("named", "exact", "covered", "wrong", "abstained"),
    [
        ((), False, False, False, True),
        ((_name("unknown"),), False, False, False, True),
        ((_name("unknown", 0.9, "spring", "cogging"),), False, True, False, True),
        ((_name("spring"), _name("cogging")), True, True, False, False),
        ((_name("spring"), _name("spring"), _name("cogging")), True, True, False, False),
        ((_name("spring", 0.9, "cogging"),), False, True, False, False),
        ((_name("spring"), _name("cogging"), _name("lag")), False, True, True, False),
        ((_name("lag"),), False, False, True, False),
        ((_name("lag"), _name("unknown")), False, False, True, False),
    ],
)
def test_answers_are_right_wrong_or_abstain(
    named: tuple[NamedEntry, ...], exact: bool, covered: bool, wrong: bool, abstained: bool
) -> None:
    one = _scored(("spring", "cogging"), *named)
    assert (one.exact, one.covered, one.wrong, one.abstained) == (exact, covered, wrong, abstained)


def test_unknown_is_right_where_no_identifier_stands() -> None:
    assert _scored(("unknown",), _name("unknown")).exact
    assert not _scored(("unknown",), _name("unknown")).wrong
    assert _scored(("unknown",), _name("gravity")).wrong


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
    case = _case(np.sin(T), [])
    half = case.simulated + 0.5 * (case.truth - case.simulated)
    trace = ChannelTrace("t", T, case.measured, case.simulated, half)
    explained = Explained(Explanation(recording="", channels={}), {"x.current": trace})
    assert_allclose(answer_recovery(case, explained) or 0.0, 0.5)
    assert answer_recovery(replace(case, simulated=case.truth), explained) is None


def test_confidence_is_scored_as_in_closed_form() -> None:
    one = _scored(("spring",), _name("spring", 0.8), _name("lag", 0.3))
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
        _scored(("spring",), _name("spring")),
        _scored(("lag",), _name("spring")),
        replace(_scored(("lag",), _name("spring", 0.6, "lag")), decidable=False),
        _scored(("lag",), wanted=4.0),
        _scored((), _name("gravity")),
        _scored(()),
        replace(_scored(("external_load",), _name("external_load")), overlap=0.4),
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
        cases = [_scored((), *([_name("lag")] if i < false else [])) for i in range(1000)]
        return limited_shares(cases)[4].passed

    assert judged(10)
    assert not judged(11)


def test_confusion_has_what_was_named_instead() -> None:
    cases = [
        _scored(("spring", "lag"), _name("spring"), _name("gravity")),
        _scored(("lag",)),
        _scored(("lag",), _name("lag")),
        _scored((), _name("lag")),
        _scored(("lag",), _name("cogging"), wanted=4.0),
    ]
    assert confusion(cases) == {
        "spring": {"spring": 1},
        "lag": {"gravity": 1, "lag": 1, NOTHING: 1},
        NOTHING: {"lag": 1},
    }


def test_a_row_for_each_effect_and_clarity_leaves_dropped_cases_out() -> None:
    one = _scored(("spring",), _name("spring"))
    dropped = replace(_scored(("spring",)), reached=False)
    together, alone = effects([one, dropped, _scored(("spring", "lag"), _name("lag"))])
    assert (together.name, together.cases, together.exact) == ("axis: 2 effects", 1, 0.0)
    assert (alone.name, alone.cases, alone.dropped) == ("axis: spring", 1, 1)
    assert (alone.exact, alone.recovery) == (1.0, 0.25)


def _by_seed(seed: int) -> list[ScoredCase]:
    """A right answer, but for every fifth; every third hides nothing."""
    if seed % 3 == 0:
        return [replace(_scored(()), seed=seed)]
    named = (_name("lag" if seed % 5 == 0 else "spring", 0.5 + 0.01 * seed),)
    return [replace(_scored(("spring",), *named), seed=seed)]


def _made(run: Callable[[int], list[ScoredCase]]) -> Proof[ScoredCase]:
    return replace(EXPLAIN, run=run)


def _files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("after", [0, 1, 7])
def test_an_interrupted_proof_goes_on_and_ends_the_same(tmp_path: Path, after: int) -> None:
    called: list[int] = []

    def interrupted(seed: int) -> list[ScoredCase]:
        if len(called) == after:
            raise KeyboardInterrupt
        called.append(seed)
        return _by_seed(seed)

    carry_out(begin_runs(_made(_by_seed), tmp_path / "one"), 12, progress=lambda _: None)
    with pytest.raises(KeyboardInterrupt):
        carry_out(begin_runs(_made(interrupted), tmp_path / "two"), 12, progress=lambda _: None)
    assert sorted(begin_runs(_made(_by_seed), tmp_path / "two").finished) == called
    carry_out(begin_runs(_made(_by_seed), tmp_path / "two"), 12, progress=lambda _: None)
    assert _files(tmp_path / "one") == _files(tmp_path / "two")


def test_two_workers_find_what_one_finds(tmp_path: Path) -> None:
    told: list[int] = []
    two = carry_out(begin_runs(EXPLAIN, tmp_path / "two"), 2, progress=told.append, workers=2)
    one = carry_out(begin_runs(EXPLAIN, tmp_path / "one"), 2, progress=lambda _: None)
    assert one == two
    assert told == [0, 1, 2]
    lines = [
        (tmp_path / name / "explain.jsonl").read_bytes().splitlines() for name in ("one", "two")
    ]
    assert sorted(lines[0]) == sorted(lines[1])


def test_a_summary_comes_back_from_json_and_prints_every_table(tmp_path: Path) -> None:
    found = carry_out(begin_runs(_made(_by_seed), tmp_path), 12, progress=lambda _: None)
    assert isinstance(found, ExplainSummary)
    assert ExplainSummary.from_json(found.to_json()) == found
    page = markdown(found)
    assert page.startswith("explain: 12 runs, seeds 1 to 12, autodb ")
    for table in found.tables():
        assert f"**{table.title}**" in page
        assert all(len(row) == len(table.heads) for row in table.rows)


def test_a_case_is_explained_and_scored() -> None:
    """A coulomb friction left out, clear as a machine's: named, and the current is corrected."""
    one = left_out.scored_case(draw_concealed(11, asked=PlannedCase(("coulomb",), 200.0)))
    assert one.refused == ""
    assert one.terms == ("coulomb",)
    assert "coulomb" in one.found
    assert one.recovery is not None
    assert one.recovery < 0.5


def test_a_case_that_cannot_be_as_clear_is_kept_without_an_answer() -> None:
    one = left_out.scored_case(draw_concealed(11, asked=PlannedCase(("gain",), 1e6, table=True)))
    assert not one.reached
    assert one.named == ()
    assert one.clarities[0] < 1e6


def test_a_refused_case_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    from autodb.errors import UnusableInput

    def refuse(*_: object, **__: object) -> None:
        raise UnusableInput("too short")

    monkeypatch.setattr(left_out, "explain", refuse)
    one = left_out.scored_case(draw_concealed(1))
    assert (one.refused, one.named, one.recovery) == ("too short", (), None)


@pytest.mark.parametrize(
    ("drawn_by", "digested"), [("plan", CONCEALED), ("mill.mill_plan", CONCEALED_MILLS)]
)
def test_the_generator_is_all_that_draws_a_case(
    drawn_by: str, digested: tuple[ModuleType, ...]
) -> None:
    """What a drawn case is made of, module by module, is what a table's digest is taken of."""
    package = "autodb.proofs.cases"
    used, ahead = {package}, [f"{package}.{drawn_by}"]
    while ahead:
        name = ahead.pop()
        used.add(name)
        tree = ast.parse((ROOT / f"{name.replace('.', '/')}.py").read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith(package):
                ahead += {_module(str(node.module), alias.name) for alias in node.names} - used
    assert {module.__name__ for module in digested} == used


def _module(package: str, name: str) -> str:
    """Return the module that an import of a name is from."""
    inside = ROOT / f"{package.replace('.', '/')}/{name}.py"
    return f"{package}.{name}" if inside.exists() else package


def test_the_command_proves_explanations(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "explain" in cli("prove").out
    monkeypatch.setattr(catalogue, "PROOFS", (PROOFS[0], _made(_by_seed)))
    done = cli("prove", "explain", "--runs", 12, "--out", "here")
    assert done.code == 1
    assert "FAILED" in done.out
    assert (
        "12 of 12 runs are already there"
        in cli("prove", "explain", "--runs", 12, "--out", "here").out
    )
    written = json.loads(Path("here/explain.json").read_text("utf-8"))
    assert written["seeds"] == [1, 12]
    assert written["confusion"]["spring"] == {"lag": 2, "spring": 6}


def test_the_command_refuses_what_changes_nothing(refused: Callable[..., str]) -> None:
    assert "go with the name of a proof" in refused("prove", "--workers", 2)
    assert "did you mean explain" in refused("prove", "explian")
    assert "is a file" in refused("prove", "explain", "--runs", 1, "--out", __file__)


def test_one_worker_is_no_choice(cli: Cli) -> None:
    done = cli("prove", "explain", "--workers", 1)
    assert done.code == 2
    assert "'--workers'" in done.err


def test_margins_are_what_decides() -> None:
    assert not replace(_scored(("lag",)), decidable=False).decidable
    for margin, sure in ((SURE + 1.0, True), (SURE - 1.0, False)):
        slope = T - np.mean(T)
        slope *= np.sqrt(margin) / np.linalg.norm(slope)
        assert (
            oracle_verdict(_case(slope, [Rival("none", np.ones((1, T.size)))], noise=0.0)).decidable
            is sure
        )
