"""The page of the field: rivals' figures beside autodb's, as commands printed them."""

import dataclasses
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.proofs.runs.found import TextTable
from benchmarks.axis_peers.answer import Array, stribeck
from benchmarks.axis_peers.run import ORACLE, OURS, AxisErrors
from docs.make import field, sugeno
from docs.make.cells import Cell
from docs.make.field_rows import Contest, Rival
from docs.make.kept import COMPARISONS, Kept, NothingKept, axis_table, kept
from tests.conftest import ROOT

TABLE = TextTable(
    "Errors",
    ("way", ">force", ">exact set", ">score", ">other", ">error", ">other", ">size"),
    (
        ("autodb", "2.0 N", "13 of 18", "0.21", "0.15", "88.0 %", "90.5 %", "71.5 N"),
        ("rival", "6.2 N", "4 of 18", "0.21", "0.30", "90.5 %", "88.0 %", "71.6 N"),
    ),
)


@pytest.fixture
def rival(monkeypatch: pytest.MonkeyPatch) -> Rival:
    """Return a rival of a table made here; its force is 3.1 times as far off."""
    known = {"it": Kept((TABLE,), "do", "abc", 1)}
    monkeypatch.setattr("docs.make.cells.kept", known.__getitem__)
    monkeypatch.setattr("docs.make.field.kept", known.__getitem__)
    ours = Cell("it", "Errors", ("autodb",), "force")
    return Rival("rival", "1.0", "as it comes", "force", _theirs(ours), ours)


def _theirs(ours: Cell) -> Cell:
    return dataclasses.replace(ours, row=("rival",))


def _judged(rival: Rival, column: str, *, more: bool) -> tuple[str, str]:
    ours = rival.ours.beside(column)
    return field.won(dataclasses.replace(rival, ours=ours, theirs=_theirs(ours), more=more))


def test_the_page_is_what_commands_printed() -> None:
    text = field.PAGE.read_text("utf-8")
    assert field.filled(text) == text


def test_the_page_of_sugeno_systems_has_what_was_printed() -> None:
    text = sugeno.PAGE.read_text("utf-8")
    assert sugeno.filled(text) == text


def test_every_comparison_that_is_kept_is_on_the_page() -> None:
    named = {rival.theirs.of for contest in field.contests() for rival in contest.rivals}
    assert set(COMPARISONS) <= named


def test_where_a_rival_wins_stands_above_and_is_bold() -> None:
    above, below = field.PAGE.read_text("utf-8").split("<!-- field -->")
    behind = [
        (rival, by)
        for contest in field.contests()
        for rival in contest.rivals
        for winner, by in [field.won(rival)]
        if winner not in (field.OURS, field.EVEN)
    ]
    assert len(behind) >= 1
    for rival, by in behind:
        line = f"- {rival.name}, {rival.figure}: {rival.theirs.text} for {rival.ours.text}, {by}."
        assert line in above
        assert f"| **{rival.name}**, {by}" in below


def test_modules_that_repeat_it_are_there_and_their_packages_pinned() -> None:
    for contest in field.contests():
        for rival in contest.rivals:
            module = re.search(r"-m (benchmarks[\w.]*)", kept(rival.theirs.of).command)
            assert module is None or (ROOT / f"{module[1].replace('.', '/')}.py").exists()
    pinned = (ROOT / "benchmarks/axis_peers/requirements.txt").read_text("utf-8").split()
    rows = kept("axis-peers").tables[0].rows
    for _, version, *_ in rows[1:-1]:
        assert version.replace(" ", "==") in pinned


def test_who_wins_is_who_is_nearer_or_has_more(rival: Rival) -> None:
    assert field.won(rival) == ("autodb", "by a factor of 3.10")
    assert _judged(rival, "exact set", more=True) == ("autodb", "by 9 of 18")
    assert _judged(rival, "error", more=True) == ("rival", "by 2.5 points")
    assert _judged(rival, "error", more=False) == ("autodb", "by a factor of 1.03")
    assert _judged(rival, "score", more=False) == ("even", "")
    assert _judged(rival, "size", more=False) == ("even", "")


def test_a_head_that_stands_twice_is_the_one_after_another(rival: Rival) -> None:
    other = dataclasses.replace(rival.ours, column="other", after="error")
    assert (rival.ours.beside("other").text, other.text) == ("0.15", "90.5 %")


@pytest.mark.usefixtures("rival")
def test_a_section_has_its_data_rows_and_commands(rival: Rival) -> None:
    text = field.tables([Contest("Forces", "Ten cuts.", (rival, rival))])
    won = "autodb, by a factor of 3.10"
    found = "6.2\N{NO-BREAK SPACE}N | 2.0\N{NO-BREAK SPACE}N"
    row = f"| rival | 1.0 | as it comes | force | {found} | {won} |\n"
    assert text.startswith("## Forces\n\nTen cuts.\n\n| rival | version |")
    assert text.endswith(f"{row}{row}\n    do    # product abc\n")


def test_what_nothing_is_kept_of_is_named() -> None:
    with pytest.raises(NothingKept, match="nothing is kept of 'planets'"):
        kept("planets")


def test_autodb_on_axes_must_be_as_near_as_the_nearest_other() -> None:
    def row(method: str, median: float) -> AxisErrors:
        return AxisErrors(method, "a 1", 2, 8, median, 2.0 * median, 1.0, "abc")

    rows = [row(OURS, 0.01), row("one", 0.03), row("two", 0.02), row(ORACLE, 0.004)]
    assert axis_table(rows).rows[0][2:] == ("1.00 %", "2.00 %", "1.0", "2.00 %", "passed")
    worse = axis_table([row(OURS, 0.021), *rows[1:]])
    assert worse.rows[0][-1] == "FAILED"
    assert [one[-1] for one in worse.rows[1:]] == ["", "", ""]


def test_an_axis_by_a_known_law_is_found_by_those_who_fit_it() -> None:
    rng = np.random.default_rng(5)
    x, a = rng.uniform(0.0, 400.0, 800), rng.uniform(-500.0, 500.0, 800)
    v = rng.uniform(2.0, 150.0, 800) * rng.choice([-1.0, 1.0], 800)

    def current(v: Array, a: Array) -> Array:
        dip = 0.4 * np.exp(-((v / 8.0) ** 2))
        return np.asarray(np.sign(v) * (1.0 + dip) + 0.004 * v + 0.002 * a + 0.3)

    asked = np.array([3.0, -20.0, 100.0])
    told = stribeck(x, v, a, current(v, a))(np.zeros(3), asked, np.zeros(3))
    assert_allclose(told, current(asked, np.zeros(3)), atol=1e-4)
