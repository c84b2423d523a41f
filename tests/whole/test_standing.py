"""The page *Where it stands*: a figure is a cell that a command printed, a miss is in sight."""

import pytest

from autodb.proofs.catalogue import PROOFS
from autodb.proofs.runs.found import TextTable
from docs.make import cells, proofs, standing
from docs.make.cells import Cell, NoSuchCell
from docs.make.kept import Kept
from docs.make.standing_rows import Figure

GATES = {"published-axis", "published-mill"}
"""Proofs of how hard generated machines are: they judge nothing of autodb's."""
TABLE = TextTable(
    "Errors, median",
    ("axis", ">autodb", ">× oracle's (≤ 1.2)", "", ">held (≥ 93 %)", ""),
    (
        ("x", "25.5 N", "1.14", "FAILED", "96.0 %", "passed"),
        ("z", "17.2 N", "1.00", "passed", "90.0 %", "FAILED"),
    ),
)
LIMITS = TextTable(
    "Limits", ("", ">found", ">must be ≤", ""), (("harmed", "0 of 9", "3", "passed"),)
)


@pytest.fixture
def one_proof(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep one proof of two tables, made here."""
    known = Kept((TABLE, LIMITS), "autodb prove it --out runs", "abc", 7)
    monkeypatch.setattr(cells, "kept", lambda name: {"it": known}[name])
    monkeypatch.setattr("docs.make.standing.kept", lambda name: {"it": known}[name])
    monkeypatch.setattr("docs.make.standing_rows.kept", lambda name: {"it": known}[name])


def test_the_page_is_what_the_summaries_say() -> None:
    text = standing.PAGE.read_text("utf-8")
    assert standing.filled(text) == text
    assert len(standing.figures()) >= 30


def test_every_proof_that_judges_autodb_has_a_figure() -> None:
    named = {one.value.of for one in standing.figures()}
    assert {proof.name for proof in PROOFS} - GATES <= named


def test_each_row_has_the_product_of_its_summary() -> None:
    text = standing.PAGE.read_text("utf-8")
    for name in {one.value.of for one in standing.figures()} & {proof.name for proof in PROOFS}:
        assert f"`autodb prove {name}`<br>{proofs.kept(name).origin.product} |" in text


def test_what_is_missed_stands_above_and_in_its_row() -> None:
    above, below = standing.PAGE.read_text("utf-8").split("<!-- figures -->")
    missed = [one for one in standing.figures() if one.missed]
    assert below.count("**missed**") == len(missed)
    for one in missed:
        assert f"- {one.what}: {one.said}; asked: {one.must_be}." in above


@pytest.mark.usefixtures("one_proof")
def test_a_limit_is_that_of_its_column_and_a_verdict_the_next_one() -> None:
    x, z = (Cell("it", "Errors", (axis,), "autodb") for axis in "xz")
    assert (x.text, x.verdict) == ("25.5 N", "**missed**")
    assert (x.beside("× oracle's").limit, x.beside("held").limit) == ("≤ 1.2", "≥ 93 %")
    assert (z.verdict, z.beside("held").verdict) == ("met", "**missed**")
    harmed = Cell("it", "Limits", ("harmed",), "found")
    assert (harmed.text, harmed.limit, harmed.verdict) == ("0 of 9", "≤ 3", "met")


@pytest.mark.usefixtures("one_proof")
def test_a_figure_of_two_limits_is_missed_where_either_is() -> None:
    both = {
        (value.text, judged.text): Figure("Job", "it", value, judged=judged).missed
        for axis in "xz"
        for value, judged in [
            (Cell("it", "Errors", (axis,), "autodb"), Cell("it", "Errors", (axis,), "held")),
            (Cell("it", "Errors", (axis,), "held"), Cell("it", "Limits", ("harmed",), "found")),
        ]
    }
    assert both == {
        ("25.5 N", "96.0 %"): True,
        ("96.0 %", "0 of 9"): False,
        ("17.2 N", "90.0 %"): True,
        ("90.0 %", "0 of 9"): True,
    }


@pytest.mark.usefixtures("one_proof")
def test_a_row_says_its_figure_limit_rival_oracle_and_command() -> None:
    x = Cell("it", "Errors", ("x",), "autodb")
    figure = Figure(
        "Job: it", "Force", x, judged=x.beside("× oracle's"), text="{0}, {1} × the oracle's",
        rival=("published", Cell("it", "Errors", ("z",), "autodb")), oracle=x.beside("held"),
    )  # fmt: skip
    assert standing.cells(figure) == (
        "Force", "25.5\N{NO-BREAK SPACE}N, 1.14 × the oracle's<br>n = 7", "≤ 1.2", "**missed**",
        "published: 17.2\N{NO-BREAK SPACE}N", "96.0\N{NO-BREAK SPACE}%", "`autodb prove it`<br>abc",
    )  # fmt: skip
    alone = Figure("Job: it", "Force", Cell("it", "Errors", ("z",), "autodb"), limit="all")
    assert standing.cells(alone)[3:6] == ("met", "none run", "none")
    answer = standing.answer([figure, alone])
    assert "1 of 2 limits are met. Job: 1 of 2." in answer
    assert "- Force: 25.5 N, 1.14 × the oracle's; asked: ≤ 1.2." in answer


@pytest.mark.usefixtures("one_proof")
@pytest.mark.parametrize(
    ("cell", "lacks"),
    [
        (Cell("it", "Means", ("x",), "autodb"), "no such table"),
        (Cell("it", "Errors", ("y",), "autodb"), "no such row"),
        (Cell("it", "Errors", ("x",), "rival"), "no such column"),
    ],
)
def test_a_cell_that_is_not_there_is_named(cell: Cell, lacks: str) -> None:
    with pytest.raises(NoSuchCell, match=lacks):
        _ = cell.text
    with pytest.raises(NoSuchCell, match="no limit"):
        _ = Cell("it", "Errors", ("x",), "autodb").limit
