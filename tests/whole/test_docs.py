"""The documentation says what the program does: its outputs, commands, figures and links."""

import json
import pkgutil
import re
import tomllib
from functools import cache
from pathlib import Path

import pytest
import yaml
from numpy.testing import assert_allclose

import autodb
from autodb.proofs.catalogue import PROOFS
from autodb.proofs.machines.axis.quantities import NAMES
from autodb.proofs.runs.found import origin_line
from autodb.proofs.runs.proof_summary import IntervalsSummary
from autodb.proofs.runs.score import POOLED, coverage_limits, exact_interval
from autodb.store import head
from autodb.terms.vocabulary import TERMS, vocabulary
from docs.make import __main__ as make
from docs.make import (
    api,
    blocks,
    commands,
    explained,
    frames,
    homes,
    pair_peers,
    proofs,
    style,
    terms,
)
from tests.conftest import ROOT

DOCS = ROOT / "docs"
FIGURES = sorted((DOCS / "figures").glob("*.svg"))
NUMBER = re.compile(r"\d+(?:\.\d+)?")
COUNTS = 33
"""Whole numbers below are of cuts, versions, rows."""
FETCHED = re.compile(
    r"<(?:script|img|iframe|source|video|audio)[^>]+src=[\"']?(?:https?:)?//"
    r"|<link[^>]+href=[\"']?(?:https?:)?//|url\([\"']?(?:https?:)?//|@import[^;]+//"
)


OF_THE_PACKAGE = re.compile(
    r"^(?! *(?:from|import) ).*?(?<![\w./@-])(autodb(?:\.[A-Za-z_]\w*)+)", re.M
)
NO_MODULES = {"autodb.sqlite3", "autodb.service", "autodb.example"}
"""Files and a host of this name."""


def test_names_of_the_package_are_those_of_something() -> None:
    """In pages, and in what modules say of themselves or to whoever misuses them."""
    pages = [ROOT / "README.md", *DOCS.rglob("*.md")]
    modules = [m for m in (ROOT / "autodb").rglob("*.py") if "proofs" not in m.parts]
    unknown = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in (*pages, *modules)
        for name in OF_THE_PACKAGE.findall(path.read_text("utf-8"))
        if name not in NO_MODULES and not _is_something(name)
    }
    assert not unknown


@cache
def _is_something(name: str) -> bool:
    try:
        return pkgutil.resolve_name(name) is not None
    except (ImportError, AttributeError):
        return False


@pytest.mark.pages
@pytest.mark.parametrize("page", make.SAMPLE_PAGES, ids=lambda page: page.stem)
def test_how_to_pages_print_what_the_commands_print(page: Path) -> None:
    _agree(make.made(page, make.SAMPLE), page.read_text("utf-8"))


@pytest.mark.pages
def test_the_tutorial_prints_what_the_commands_print(emps: Path, vicomtech: Path) -> None:
    _agree(make.made(make.REAL_PAGE, (emps, vicomtech)), make.REAL_PAGE.read_text("utf-8"))


def _agree(made: str, page: str) -> None:
    """Hold two texts to the same words and numbers, but for one in a last digit.

    Whole numbers below COUNTS are the same.
    """
    assert NUMBER.sub("#", made).split() == NUMBER.sub("#", page).split()
    for ours, theirs in zip(NUMBER.findall(made), NUMBER.findall(page), strict=True):
        assert float(ours) == pytest.approx(float(theirs), rel=0.0, abs=_last_digit(theirs))


def _last_digit(number: str) -> float:
    """Return what one in the last digit of a printed number is; three digits at most count."""
    _, point, decimals = number.partition(".")
    if point:
        return 1.001 * 10.0 ** -len(decimals)
    return 0.0 if float(number) < COUNTS else 1.001 * 10.0 ** max(0, len(number) - 3)


def test_numbers_may_differ_by_rounding_alone() -> None:
    _agree("z  73.0 N  v2", "z 73.1 N v2")
    _agree("z  1051 N", "z 1059 N")
    for other in ("z 73.2 N v2", "y 73.0 N v2", "z 73.0 N v7", "z 73.0 N"):
        with pytest.raises(AssertionError):
            _agree("z 73.0 N v2", other)


def test_the_command_reference_is_the_command_line() -> None:
    page = make.COMMANDS_PAGE.read_text("utf-8")
    assert commands.filled(page) == page
    assert "| `--machine NAME` | the only one | Name of the machine. |" in page


def test_the_reference_of_the_library_is_its_docstrings() -> None:
    page = make.LIBRARY_PAGE.read_text("utf-8")
    assert api.filled(page) == page
    for name in ("autodb.explain(recording", ".import_(recording", ".to_pandas()", ".plot()"):
        assert f"`{name}" in page


def test_where_causes_are_kept_is_what_their_terms_say() -> None:
    page = make.HOMES_PAGE.read_text("utf-8")
    assert homes.filled(page) == page
    for name in vocabulary():
        assert page.count(f"| `{name}` |") == 1


def test_the_tables_of_terms_are_the_terms() -> None:
    page = make.TERMS_PAGE.read_text("utf-8")
    assert terms.filled(page) == page
    assert page.count("\n| `coulomb` | ") == 1
    assert [terms.standstill(t) for t in TERMS[:7]] == [*"000", "acts", "acts", *"00"]


def test_what_explain_can_name_is_read_off_its_candidates() -> None:
    assert {"cogging", "cross_coupling", "external_load", "backlash"} <= explained.axis_names()
    assert explained.names() <= vocabulary()
    page = make.TERMS_PAGE.read_text("utf-8")
    rows = {line.split("`")[1]: line for line in page.splitlines() if line.startswith("| `")}
    assert {name for name, row in rows.items() if row.endswith("| yes |")} == explained.names()
    assert rows["shear"].endswith("| only as mistuned |")
    assert rows["windage"].endswith("|  |")


def test_formats_has_the_parameters_of_everything_that_explain_can_name() -> None:
    page = (DOCS / "formats.md").read_text("utf-8").split("## explanation.json")[1]
    rows = re.findall(r"^    \| (`[^|]+`) \|", page.split("\n## ")[0], re.MULTILINE)
    assert {name for row in rows for name in re.findall(r"`(\w+)`", row)} == explained.names()


@pytest.mark.parametrize("page", ["kills.md", "promises.md", "threat-model.md"])
def test_tests_that_pages_name_are_there(page: str) -> None:
    text = (ROOT / "docs" / page).read_text("utf-8")
    tests = {path: path.read_text("utf-8") for path in (ROOT / "tests").rglob("test_*.py")}
    there = {name for one in tests.values() for name in re.findall(r"^def (test_\w+)", one, re.M)}
    files = {path.name for path in tests}
    named = set(re.findall(r"`(test_\w+)`", text))
    assert len(named) >= 10
    assert named <= there
    assert set(re.findall(r"`(?:tests/[\w/]*)?(test_\w+\.py)`", text)) <= files


def test_files_of_tests_that_pages_name_are_there() -> None:
    pages = [page.read_text("utf-8") for page in DOCS.rglob("*.md")]
    named = {name for text in pages for name in re.findall(r"`(tests/[\w/]+(?:\.py)?)`", text)}
    assert len(named) >= 10
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_a_page_whose_command_ends_otherwise_is_not_made(tmp_path: Path) -> None:
    page = "<!-- run: autodb trace prediction 7 -->\n```text\n```\n"
    with pytest.raises(blocks.WrongExit, match="exit 2, the page says 0"):
        blocks.played(page, tmp_path)


def test_blocks_are_run_in_their_folder_in_order(tmp_path: Path) -> None:
    page = (
        "<!-- write: a.txt -->\n```text\none\ntwo\n```\n"
        "<!-- python -->\n```python\nfrom pathlib import Path\n"
        "Path('b.txt').write_text(2 * Path('a.txt').read_text())\n```\n"
        "<!-- show: b.txt 3 -->\n```text\nold\n```\n"
        "<!-- run: autodb init -->\n```text\nold\n```\n"
    )
    played = blocks.played(page, tmp_path)
    assert "<!-- show: b.txt 3 -->\n```text\none\ntwo\none\n```\n" in played
    assert (
        f"```text\n$ autodb init\nsqlite:///autodb.sqlite3: ready, schema {head()}\n```\n" in played
    )
    assert (tmp_path / "autodb.sqlite3").exists()


def test_force_on_a_milling_tooth_has_the_signs_of_the_frame() -> None:
    # D 10, slot, h = 0.05 sin φ, K_tc 2000, K_rc 600 N/mm², a_p 1 mm, one tooth at φ = 90°
    assert_allclose(frames.force_on_tool(100.0, 30.0, 90.0), (-30.0, 100.0), atol=1e-9)
    assert_allclose(frames.tooth_at(90.0, 5.0), (5.0, 0.0), atol=1e-9)


def test_frames_are_drawn_with_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(style, "FIGURES", tmp_path)
    frames.draw()
    for made in tmp_path.iterdir():
        assert made.read_bytes() == (DOCS / "figures" / made.name).read_bytes()
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.stem)
def test_figures_are_small_shown_and_follow_the_colour_scheme(figure: Path) -> None:
    text = figure.read_text("utf-8")
    assert len(text) < 150_000
    assert "prefers-color-scheme:dark" in text
    assert not re.search(r"<image|href=\"http|<dc:date>", text)
    pages = "".join(page.read_text("utf-8") for page in DOCS.rglob("*.md"))
    pages = pages.replace("(../figures/", "(figures/")
    assert f"(figures/{figure.name})" in pages
    if figure.stem.startswith("turning-"):
        caption = pages.split(f"(figures/{figure.name})")[1].split("</figcaption>")[0]
        assert "Vicomtech" in caption
        assert "CC BY-SA 4.0" in " ".join(caption.split())


def test_the_site_fetches_nothing(site: Path) -> None:
    assert FETCHED.search('<script src="https://unpkg.com/x"></script>')
    pages = [p for p in site.rglob("*") if p.suffix in {".html", ".css", ".svg"}]
    assert len(pages) > 20
    for page in pages:
        assert not FETCHED.search(page.read_text("utf-8")), page


def test_the_site_holds_every_page_and_no_source(site: Path) -> None:
    for page in DOCS.rglob("*.md"):
        assert (site / page.relative_to(DOCS).with_suffix(".html")).exists(), page
    assert not list(site.rglob("*.py"))
    assert "var __index = " in (site / "search" / "search_index.js").read_text("utf-8")


@pytest.mark.parametrize(
    "asked", ["architecture", "contributing", "dynamometer", "uncertainty", "add an effect"]
)
def test_the_search_of_the_site_knows_what_developers_and_users_ask(site: Path, asked: str) -> None:
    text = (site / "search" / "search_index.js").read_text("utf-8")
    sections = json.loads(text.removeprefix("var __index = "))["docs"]
    titles = " ".join(one["title"].lower() for one in sections)
    assert asked in titles


def test_citation_agrees_with_the_package() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert citation["cff-version"] == "1.2.0"
    assert {"message", "title", "authors"} <= citation.keys()
    assert citation["version"] == project["version"] == autodb.__version__ == _versions()[0]
    assert citation["license"] == project["license"]
    assert citation["title"] == project["name"]


@pytest.mark.parametrize("page", proofs.PAGES, ids=lambda page: page.stem)
def test_a_page_of_proofs_has_their_tables(page: Path) -> None:
    text = page.read_text("utf-8")
    assert proofs.filled(text) == text


def _versions() -> list[str]:
    """Return the versions that the changes are of, the newest first."""
    return re.findall(r"^## (\d+\.\d+\.\d+)\b", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.M)


def test_every_proof_is_on_one_page_of_its_generator_and_of_this_version_or_the_last() -> None:
    text = "".join(page.read_text("utf-8") for page in proofs.PAGES)
    assert sorted(proofs.PROOF.findall(text)) == sorted(proof.name for proof in PROOFS)
    for proof in PROOFS:
        kept, origin = proofs.kept(proof.name), proof.origin()
        assert kept.origin.version in _versions()[:2]
        assert kept.origin.generator == origin.generator  # else run `make prove` again
        assert origin_line(kept) in text


def test_the_first_page_of_proofs_has_every_answer() -> None:
    text = proofs.INDEX.read_text("utf-8")
    assert proofs.index_filled(text) == text


@pytest.mark.parametrize("page", proofs.PAGES, ids=lambda page: page.stem)
def test_what_a_proof_answers_stands_in_its_tables(page: Path) -> None:
    for one in proofs.sections(page.read_text("utf-8")):
        said = {number for number in NUMBER.findall(one.answer) if "." in number}
        assert said <= set(NUMBER.findall(one.rest)), one.title


def test_the_page_of_pairs_has_the_table_of_boosted_trees() -> None:
    page = pair_peers.PAGE.read_text("utf-8")
    assert pair_peers.filled(page) == page


def test_the_page_of_axes_has_every_quantity_of_all_axes() -> None:
    (page, *_), kept = proofs.PAGES, proofs.kept("axis-intervals")
    text = page.read_text("utf-8")
    assert isinstance(kept, IntervalsSummary)
    assert kept.seeds == (1, PROOFS[0].runs)
    assert {row.name for row in kept.rows} == {*NAMES, POOLED}
    assert kept.rows[-1].runs == PROOFS[0].runs
    for row in kept.rows:
        assert f"| {row.name} | {row.runs} |" in text
        assert row.limits == coverage_limits(row.runs)
        assert (row.share_low, row.share_high) == exact_interval(row.share * row.runs, row.runs)
