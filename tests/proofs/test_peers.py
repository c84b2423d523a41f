"""The comparison with known methods: split, dictionaries, reading, score and table."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from autodb.proofs.cases.base.case import Case
from autodb.proofs.cases.plan import PlannedCase, draw_concealed
from benchmarks.peers import score
from benchmarks.peers.axis_dictionary import axis_columns, since_reversal
from benchmarks.peers.cases import problem_of
from benchmarks.peers.choosing import best
from benchmarks.peers.cut_dictionary import cut_columns
from benchmarks.peers.ours import answer as explained
from benchmarks.peers.problem import Answer, Array, Part, load, read_answer, split, thinned
from benchmarks.peers.reading import Summand, axis_term, cut_term
from benchmarks.peers.run import METHODS, OURS, kept
from benchmarks.peers.score import Score, names, scored, structure, unscored
from benchmarks.peers.table import markdown, tables
from docs.make import peers as page

SHORT = 15
"""A seed whose recording of an axis is short."""


@pytest.fixture(scope="module")
def spring() -> Case:
    """Return a short recording of an axis on which a spring is hidden."""
    return draw_concealed(SHORT, asked=PlannedCase(("spring",), 20.0))


@pytest.fixture(scope="module")
def nothing() -> Case:
    """Return a short recording with nothing hidden."""
    return draw_concealed(SHORT, asked=PlannedCase((), 20.0))


@pytest.fixture(scope="module")
def wear() -> Case:
    """Return a table of cuts whose edges wear."""
    return draw_concealed(1, asked=PlannedCase(("tool_wear",), 20.0, table=True))


def test_every_fifth_block_is_held_out_and_its_surroundings_fit_nothing() -> None:
    parts = split(1000, gap=20)
    assert_array_equal(np.flatnonzero(parts.held_out), [*range(400, 500), *range(900, 1000)])
    neither = ~parts.fitted & ~parts.held_out
    assert_array_equal(
        np.flatnonzero(neither), [*range(380, 400), *range(500, 520), *range(880, 900)]
    )
    assert not np.any(parts.fitted & parts.held_out)
    few = split(11, gap=0)
    assert np.count_nonzero(few.held_out) == 2
    assert_array_equal(few.fitted, ~few.held_out)


def test_a_choice_must_be_better_than_no_correction_where_it_was_not_fitted() -> None:
    parts = split(100, gap=0)
    target = np.where(parts.held_out, -1.0, 1.0)
    assert best([("all", target), ("fitted", np.ones(100))], target, parts) == "all"
    assert best([("fitted", np.ones(100))], target, parts) is None
    assert best([("less", target), ("more", target)], target, parts) == "less"


def test_rows_over_time_are_averaged_and_cuts_are_taken(spring: Case, wear: Case) -> None:
    moves, cuts = problem_of(spring), problem_of(wear)
    n = moves.measured.shape[1]
    thin = thinned(moves, n // 3)
    means = [np.mean(moves.measured[0, i : i + 3]) for i in (0, 3)]
    assert_allclose(thin.of(moves.measured)[0, :2], means)
    assert thin.of(moves.difference[0]).shape == thin.split.fitted.shape
    whole = cuts.measured.shape[1]
    taken = thinned(cuts, -(-whole // 2))
    assert_array_equal(taken.of(cuts.measured), cuts.measured[:, ::2])
    assert taken.of(cuts.measured).shape[1] == len(taken.split.fitted)


def test_a_case_goes_to_a_file_without_its_truth(spring: Case, wear: Case, tmp_path: Path) -> None:
    for case in (spring, wear):
        problem_of(case).save(tmp_path / "case.npz")
        read = load(tmp_path / "case.npz")
        assert_array_equal(read.measured.reshape(case.measured.shape), case.measured)
        assert_array_equal(read.difference, read.measured - read.simulated)
        assert read.table == case.table
        with np.load(tmp_path / "case.npz") as held:
            known = {name.split("/")[0] for name in held.files}
            assert known == {
                "names", "measured", "simulated", "rate_hz", "input", "recording", "simulation",
            }  # fmt: skip
            for name in held.files:
                values = held[name]
                if values.dtype.kind == "f" and values.size == case.truth.size:
                    assert not np.array_equal(values.ravel(), case.truth.ravel())


def test_an_answer_comes_back_as_it_was_given(tmp_path: Path) -> None:
    given = Answer(np.arange(6.0).reshape(2, 3), (Part("force.x", "gain", "F t", 0.5),))
    given.save(tmp_path / "answer.npz", seconds=1.5, version="a 1")
    read, seconds, version = read_answer(tmp_path / "answer.npz")
    assert_array_equal(read.correction, given.correction)
    assert (read.parts, seconds, version) == (given.parts, 1.5, "a 1")


@pytest.mark.parametrize("kind", ["spring", "viscous", "asymmetry", "lag", "external_load"])
def test_the_dictionary_of_an_axis_holds_what_is_hidden(kind: str) -> None:
    case = draw_concealed(SHORT, asked=PlannedCase((kind,), 20.0))
    assert case.reached
    columns = axis_columns(problem_of(case))
    mine = [column for term, _, column in columns if term == kind]
    assert _left(mine, case.hidden[0].part) < 0.5
    assert {term for term, _, _ in columns} >= {kind, "gravity", "cogging", "unknown"}


@pytest.mark.parametrize("kind", ["tool_wear", "speed_softening", "hard_spot", "depth_error"])
def test_the_dictionary_of_cuts_holds_what_is_hidden(kind: str) -> None:
    case = draw_concealed(1, asked=PlannedCase((kind,), 20.0, table=True))
    problem = problem_of(case)
    for i, part in enumerate(case.hidden[0].part):
        mine = [column for term, _, column in cut_columns(problem, i) if term == kind]
        assert _left(mine, part) < 0.5


def _left(columns: list[Array], part: Array) -> float:
    """Share of a part that no combination of columns follows."""
    matrix = np.array(columns).T
    matrix = matrix / np.linalg.norm(matrix, axis=0)
    follows = matrix @ np.linalg.lstsq(matrix, part, rcond=None)[0]
    return float(np.linalg.norm(part - follows) / np.linalg.norm(part))


def test_the_way_since_a_reversal_begins_anew_where_the_direction_turns() -> None:
    direction = np.array([0.0, 1.0, 1.0, 0.0, 1.0, -1.0, -1.0])
    position = np.array([0.0, 1.0, 2.0, 2.0, 3.0, 2.5, 1.0])
    last, way = since_reversal(direction, position)
    assert_array_equal(last, [0, 1, 1, 1, 1, -1, -1])
    assert_allclose(way, [0.0, 0.0, 1.0, 1.0, 2.0, 0.0, 1.5])


@pytest.mark.parametrize(
    ("read", "summand", "term"),
    [
        (axis_term, Summand(frozenset()), "gravity"),
        (axis_term, Summand(frozenset({"x"}), wave=True), "cogging"),
        (axis_term, Summand(frozenset({"x"})), "spring"),
        (axis_term, Summand(frozenset({"s", "v"})), "stribeck"),
        (axis_term, Summand(frozenset({"s", "v"}), even=True), "asymmetry"),
        (axis_term, Summand(frozenset({"sim"}), straight=True), "gain"),
        (axis_term, Summand(frozenset({"sim"}), even=True), "lost_sign"),
        (axis_term, Summand(frozenset({"t"}), wave=True), "unknown"),
        (axis_term, Summand(frozenset({"x", "ya"})), "unknown"),
        (cut_term, Summand(frozenset({"sim"}), straight=True), "shear"),
        (cut_term, Summand(frozenset({"sim"})), "deflection"),
        (cut_term, Summand(frozenset({"depth"})), "edge_force"),
        (cut_term, Summand(frozenset({"depth", "used"})), "tool_wear"),
        (cut_term, Summand(frozenset({"sim", "t"})), "gain"),
        (cut_term, Summand(frozenset({"t"})), "sensor_drift"),
        (cut_term, Summand(frozenset({"z"})), "unknown"),
    ],
)
def test_a_summand_is_read_by_its_variables(
    read: Callable[[Summand], str], summand: Summand, term: str
) -> None:
    assert read(summand) == term


def test_names_are_what_is_large_and_not_in_the_simulation() -> None:
    parts = tuple(
        Part("x.current", term, "", share)
        for term, share in (("spring", 0.9), ("cogging", 0.04), ("viscous", 0.5), ("", 1.0))
    )
    assert names(Answer(np.zeros((1, 3)), parts), ("viscous", "inertia")) == ("spring",)
    assert names(Answer(np.zeros((1, 3)), parts), ()) == ("spring", "viscous")


def test_the_truth_scores_best_and_no_answer_scores_nothing(spring: Case) -> None:
    part = (Part("x.current", "spring", "x", 1.0),)
    whole = (spring.truth - spring.simulated)[None]
    right = scored(spring, OURS, Answer(whole, part), seconds=1.0, version="a 1")
    assert right.exact
    assert right.left == 0.0
    assert right.recovered
    assert not right.wrong
    half = scored(spring, OURS, Answer(0.4 * whole, ()), seconds=1.0, version="a 1")
    assert half.left is not None
    assert_allclose(half.left, 0.6)
    assert not half.recovered
    assert not half.exact
    none = unscored(spring, "gaussian", seconds=120.0, why="time")
    assert none.left == 1.0
    assert not none.exact
    assert (none.named, none.failed) == ((), "time")


def test_an_alarm_is_a_name_or_a_correction_that_own_terms_cannot_follow(nothing: Case) -> None:
    def alarm(correction: Array, *parts: Part) -> bool:
        answer = Answer(correction[None], parts)
        return scored(nothing, OURS, answer, seconds=0.0, version="").alarm

    noise = nothing.measured - nothing.truth
    own = np.asarray(0.3 * nothing.own[0])
    assert_allclose(structure(nothing, own), 0.0, atol=1e-9)
    assert not alarm(own)
    assert not alarm(0.09 * noise)
    assert alarm(0.2 * noise)
    assert alarm(np.zeros_like(own), Part("x.current", "spring", "x", 1.0))
    assert not alarm(np.zeros_like(own), Part("x.current", nothing.includes[0], "", 1.0))


def test_explain_answers_from_the_same_file(wear: Case, tmp_path: Path) -> None:
    problem_of(wear).save(tmp_path / "case.npz")
    answer = explained(load(tmp_path / "case.npz"))
    given = scored(wear, OURS, answer, seconds=0.0, version="autodb")
    assert given.exact
    assert given.recovered


def test_the_table_counts_and_says_what_is_missing() -> None:
    def one(seed: int, method: str, **other: object) -> Score:
        usual = {
            "kind": "spring", "table": False, "decidable": True, "hidden": ("spring",),
            "named": ("spring",), "written": 1, "left": 0.1, "alarm": False, "seconds": 2.0,
            "origin": score.origin(), "version": "a 1",
        }  # fmt: skip
        return Score(**{"seed": seed, "method": method, **usual, **other})  # type: ignore[arg-type]

    scores = [
        one(1, OURS),
        one(2, OURS, named=("cogging",), left=0.7),
        one(3, OURS, hidden=(), named=(), left=None, alarm=True),
        one(1, "gaussian", named=(), failed="time", left=1.0, version=""),
        one(2, "boosting", named=(), left=0.6),
    ]
    whole, cases = tables(scores)
    assert whole.rows[0][1:7] == ("3", "1 of 2", "1 of 2", "1 of 2", "1 of 2", "0.40")
    assert whole.rows[0][7:9] == ("1 of 2", "1 of 1")
    row = next(row for row in whole.rows if row[0] == "Gaussian process")
    assert row[1:3] == ("1", "names nothing")
    assert row[-2:] == ("1", "0")
    assert cases.rows[0][3:5] == ("**0.10** ✓", "not run")
    assert "time" in cases.rows[0]
    assert len(cases.rows) == 2
    assert f"3 of the first 30 fixed cases, 8 methods, {3 * len(METHODS) - 5} answers not" in (
        markdown(scores)
    )


def test_the_page_of_proofs_has_the_tables_of_the_lines_kept() -> None:
    text = page.PAGE.read_text("utf-8")
    assert page.filled(text) == text
    assert {one.method for one in kept(page.KEPT)} <= set(METHODS)
