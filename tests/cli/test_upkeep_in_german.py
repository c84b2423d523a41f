"""Commands that keep a database, and that make programs, answer in German, right or wrong input."""

import re
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from autodb.proofs.runs.keeping.writing_commands import A_LATHE
from autodb.wording import catalogues
from tests.conftest import Cli
from tests.helpers.marked_words import OPEN, Marked, left, unmarked

NAMED = re.compile(
    r"\b(?:copy|other|folder|tables|cards|ours|passes|inbox|autodb)\b[\w./-]*|sqlite:///\S+|"
    r"\b(?:turning-aluminium|milling-c45|drilling-c45|Maria|operate|read|lathe-1)\b|"
    r"\b(?:nowhere|year|hour, day, week|admin|boss|spindle|fanuc, siemens)\b|"
    r"\b(?:cp|systemctl|loginctl|journalctl)\b[^#]*|"
    r"\b(?:[xy]|diagonal) (?:plus|minus), [\d.]+ deep|"
    r"\baluminium alloy / .*|\b(?:aluminium alloy|steel C45|carbide drill|end mill)\b.*|"
    r"\b(?:turn|face|slot|drill|published|light|wide|heavy|fast|facing|k_c1\.1|m_c)\b|"
    r"\bsteel bar\b.*|--[\w-]+|\b[a-z]+\.\w+\b|"
    r"(?:The published interval|Speeds, feeds and depths) .*"
)
"""Names in the files of these tests and in what ships, options, and a protocol's own note."""


def _unsaid(text: str) -> list[str]:
    """Return what of an answer was looked up nowhere, without names."""
    return left(NAMED.sub(" ", unmarked(line)) for line in text.splitlines())


@pytest.fixture
def marked(standard_learnt: Cli, monkeypatch: pytest.MonkeyPatch) -> Cli:
    """Return the command line for a German shop, on a lathe that learnt, its sentences marked."""
    fast = re.sub(r"(travel_high_mm = \d+)", r"\1, speed_mm_min = 9000", A_LATHE)
    Path("machine.toml").write_text(fast)
    for folder in ("folder", "inbox"):
        Path(folder).mkdir()
    monkeypatch.setenv("AUTODB_LANGUAGE", "de")
    monkeypatch.setenv("COLUMNS", "2000")  # a mark is in one line
    monkeypatch.setattr(catalogues, "catalogue", lambda _language: Marked())
    return standard_learnt


def test_every_sentence_of_upkeep_is_looked_up(marked: Cli, sample_jobs: Path) -> None:
    cuts = sample_jobs / "stepped_shaft" / "recordings" / "standard-cuts.csv"
    other = ("--db", "sqlite:///other.sqlite3")
    sweep = ("sweep", "--axis", "z", "--dialect", "fanuc", "--machine-file", "machine.toml")
    asked = (
        ("backup", "copy.sqlite3"), ("backup", "folder", "--keep", "3"),
        ("backup", "folder", "--every", "day"), ("restore", "copy.sqlite3", *other),
        ("export", "tables"), ("export", "--cards", "cards.csv", "--machine", "lathe-1"),
        ("export", "--coefficients", "cards.json", "--machine", "lathe-1"),
        ("token", "list"), ("token", "revoke", "Maria"), ("token", "revoke", "Maria"),
        ("token", "list"), ("standard", "list"), ("standard", "show", "turning-aluminium"),
        ("standard", "show", "milling-c45"), ("standard", "new", "ours", cuts),
        ("standard", "new", "ours", cuts), (*sweep, "--out", "passes.nc"),
        (*sweep, "--out", "passes.nc"), ("schedule", "--inbox", "inbox", "--out", "folder"),
        ("predictions", "match"), ("withdraw", "1", "--why", "Maria"),
        ("withdraw", "1", "--why", "Maria"), ("withdraw", "1", "--undo"),
        ("withdraw", "1", "--undo"),
    )  # fmt: skip
    no_token = marked("token", "list")
    marked("token", "add", "Maria", "--role", "operate", "--days", "30")
    said = [(("token", "list"), no_token), *((one, marked(*one)) for one in asked)]
    assert [one for one, did in said if did.code not in (0, None)] == []
    left_out = [(one, _unsaid(did.out + did.err)) for one, did in said]
    assert [(one, some) for one, some in left_out if some] == []
    with closing(sqlite3.connect("autodb.sqlite3")) as database:
        assert OPEN not in "\n".join(database.iterdump())


WRONG = (
    ("backup", "nowhere/copy.sqlite3"), ("backup", "autodb.sqlite3"),
    ("backup", "folder", "--every", "year"), ("backup", "folder", "--keep", "3", "--replace"),
    ("restore", "copy.sqlite3"), ("restore", "folder"), ("export", "folder", "--cards", "a.csv"),
    ("export", "inbox", "--material", "steel"), ("export", "--cards", "cards.csv"),
    ("export", "--coefficients", "cards.json"), ("export", "tables", "--machine", "lathe-9"),
    ("token", "add", "Maria", "--role", "boss"), ("token", "add", " Maria"),
    ("token", "revoke", "Marie"), ("withdraw", "99", "--why", "Maria"), ("withdraw", "1"),
    ("predictions", "match", "--recording", "9", "--prediction", "9"),
    ("schedule", "--inbox", "nowhere"), ("schedule", "--inbox", "inbox", "--cron", "--every", "7"),
    ("standard", "show", "turning"), ("sweep", "--axis", "z", "--dialect", "fanuc"),
    ("sweep", "--axis", "q", "--dialect", "fanuc", "--machine-file", "machine.toml"),
    ("sweep", "--axis", "z", "--dialect", "okuma", "--machine-file", "machine.toml"),
    ("sweep", "--axis", "z", "--dialect", "fanuc", "--machine-file", "machine.toml",
     "--between", "900", "950"),
)  # fmt: skip


@pytest.mark.usefixtures("marked")
def test_every_refusal_of_upkeep_is_looked_up(refused: Callable[..., str]) -> None:
    said = {one: refused(*one).removeprefix("autodb: ") for one in WRONG}
    assert {one: _unsaid(line) for one, line in said.items() if _unsaid(line)} == {}


def test_a_shop_in_inches_reads_its_protocol(marked: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    shown = marked("standard", "show", "turning-aluminium", "--units", "inch").out
    assert "feed in" in shown
    assert "0.07874" in shown  # 2 mm
    assert "109.2" in shown  # 485.78 N in lbf
