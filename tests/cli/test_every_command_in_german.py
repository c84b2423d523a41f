"""Commands of a shop's day answer in German, with right and with wrong input, and store English.

As in ``test_languages_of_answers`` sentences are put between marks where they are looked up: what a
command prints outside of marks, and is no name or number, nobody has translated.
"""

import re
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autodb.cli import commands
from autodb.cli._listed import READERS
from autodb.wording import catalogues
from tests.conftest import Cli
from tests.helpers.files import write
from tests.helpers.marked_words import CLOSE, OPEN, Marked, left, left_of_page, unmarked

IN_ENGLISH = frozenset({"agent", "serve", "prove"})
"""Commands whose answers are logs of a service, or tables of a proof: they answer in English."""
TYPED = re.compile(
    r"steel bar|carbide insert|\b(?:air|worn|load|part|axis|standard-cuts)\b[\w.-]*|"
    r"\bforce[._]\w+|\bspindle\b|"
    r"\bsha256\b|\b[0-9a-f]{12}\b|\bRMSE\b|\bout/|sqlite:///\S+|--[\w-]+|\b[a-z]+\.\w+\b|\bMaria\b|\bmill-\d|"
    r"\b(?:coefficient|level|amplitude|period|phase|factor)\b|\bMPa\b|"
    r"[\w-]*\.(?:txt|foo|tsv|lvm|dat|asc|log|gz|zip|xlsx|xlsm|xls|xlsb|ods|mat|h5|hdf5|tdms|mf4|mdf|xml|html)\b|"
    r"\.range\b|\bforce(?= \d)|\baxes\b|\bbar\b"
)
"""Names in the files of these tests, channels, options, and parameters by their names."""
NAMED = re.compile(rf" \((?:there are: |did you mean ){CLOSE}[^{OPEN}]*")
"""Names that are proposed, which are those of files, columns and keys."""
TOOL = "carbide insert"
PART = """
machine_compliance_mm_N = 3e-5
[bar]
diameter_mm = 30
length_mm = 200
modulus_MPa = 210000
held = "chuck"
[measured]
place_mm = [20, 60, 100, 140, 180]
diameter_error_mm = [0.010, 0.013, 0.024, 0.045, 0.082]
noise_mm = 0.001
largest_N = 2000
"""
FILE = """
[axes.x.limits]
force_N = 800
[axes.z]
[axes.spindle]
carries = "work"
"""


def _unsaid(text: str) -> list[str]:
    """Return what of an answer was looked up nowhere, without what is written in files."""
    lines = NAMED.sub(" ", text).splitlines()
    return left(TYPED.sub(" ", unmarked(line)) for line in lines)


def _axis(folder: Path) -> None:
    """Write moves in air of an axis, and moves with a ripple that the first do not have."""
    time_s = 0.004 * np.arange(2000)
    velocity = 40.0 * np.sin(2.5 * time_s) + 15.0 * np.sin(0.9 * time_s)
    acceleration = np.gradient(velocity, 0.004)
    place = 100.0 + np.cumsum(velocity) * 0.004
    effort = 1.2 * np.sign(velocity) + 0.004 * velocity + 0.002 * acceleration
    noise = 0.03 * np.random.default_rng(41).normal(size=time_s.size)
    for name, more in (("air", 0.0), ("worn", 0.4 * np.sin(0.8 * place))):
        channels = {"t": time_s, "z.position": place, "z.velocity": velocity}
        channels |= {"z.acceleration": acceleration, "z.current": effort + noise + more}
        write(folder / f"{name}.csv", channels)


@pytest.fixture
def marked(standard_learnt: Cli, monkeypatch: pytest.MonkeyPatch) -> Cli:
    """Return the command line for a German shop, on a lathe that learnt, its sentences marked."""
    _axis(Path.cwd())
    Path("part.toml").write_text(PART)
    Path("file.toml").write_text(FILE)
    monkeypatch.setenv("AUTODB_LANGUAGE", "de")
    monkeypatch.setenv("COLUMNS", "2000")  # a mark is in one line
    monkeypatch.setattr(catalogues, "catalogue", lambda _language: Marked())
    return standard_learnt


@pytest.mark.usefixtures("one_law")
def test_every_sentence_of_a_command_is_looked_up(marked: Cli, sample_jobs: Path) -> None:
    cuts = sample_jobs / "stepped_shaft" / "recordings" / "standard-cuts.csv"
    job = sample_jobs / "stepped_shaft" / "job.toml"
    of_cut = ("--machine", "lathe-1", "--recording", cuts, "--cut", "3")
    asked = (
        ("init",), ("look", "air.csv"), ("look", "air.csv", "--write"),
        ("import", "air.csv"), ("import", "air.csv"), ("import", cuts, "--machine", "lathe-1"),
        ("identify", "air.csv", "--also", "worn.csv"),
        ("identify", "air.csv", "--machine", "lathe-1", "--page", "axis.html"),
        ("identify", "air.csv", "--machine", "lathe-1", "--update"),
        ("reconstruct", "worn.csv", "--page", "load.html", "--out", "load.csv"),
        ("reconstruct", "worn.csv", "--moves", "air.csv", "--out", "load.csv"),
        ("inspect", "part.toml"), ("inspect", "part.toml", *of_cut), ("refresh",),
        ("explain", "worn.csv", "--machine", "lathe-1", "--out", "out"),
        ("mismatch", "confirm", "1", "--by", "Maria"), ("mismatch", "confirm", "1"),
        ("trace", "mismatch", "1"), ("trace", "model", "2"), ("mismatch", "reopen", "1"),
        ("mismatch", "reject", "1"), ("mismatch", "reject", "1"), ("mismatch", "reopen", "1"),
        ("trace", "prediction", "1"), ("trace", "parameters", "1"),
        ("trace", "force", "1"), ("trace", "calibration", "1"), ("trace", "recording", "1"),
        ("edge", "list"), ("edge", "changed", "--tool", TOOL, "--at", "2026-03-01T07:30"),
        ("edge", "changed", "--tool", TOOL, "--at", "2026-03-01T07:30"),
        ("edge", "changed", "--tool", TOOL, "--by", "Maria"), ("edge", "list", "--all"),
        ("edge", "undo", "1"), ("edge", "undo", "1"), ("edge", "list", "--all"),
        ("doctor",), ("machine", "list"), ("machine", "show", "lathe-1"),
        ("machine", "update", "lathe-1", "--file", "file.toml"),
        ("machine", "update", "lathe-1", "--file", "file.toml"), ("machine", "add", "mill-2"),
        ("machine", "add", "mill-2"), ("machine", "retire", "mill-2"),
        ("machine", "retire", "mill-2"), ("machine", "retire", "mill-2", "--undo"),
        ("machine", "rename", "mill-2", "mill-3"),
        ("fleet", "learn"), ("fleet", "show"), ("fleet", "refresh"),
    )  # fmt: skip
    marked("predict", job)
    said = [(one, marked(*one)) for one in asked]
    assert [one for one, did in said if did.code not in (0, None)] == []
    left_out = [(one, _unsaid(did.out + did.err)) for one, did in said]
    assert [(one, some) for one, some in left_out if some] == []
    pages = ("axis.html", "load.html")
    left_in = {one: [TYPED.sub("", text) for text in left_of_page(Path(one).read_text("utf-8"))]
               for one in pages}  # fmt: skip
    assert {one: left(some) for one, some in left_in.items() if left(some)} == {}
    with closing(sqlite3.connect("autodb.sqlite3")) as database:
        assert OPEN not in "\n".join(database.iterdump())
    assert OPEN not in Path("air.toml").read_text("utf-8") + Path("load.csv").read_text("utf-8")


WRONG = (
    ("look", "nothing.csv"), ("look", "text.foo"), ("look", "empty.csv"),
    ("import", "nothing.csv"), ("import", "uncounted.csv"), ("import", "words.csv"),
    ("import", "newtons.csv"), ("import", "air.csv", "--machine", "lathe-9"),
    ("identify", "few.csv"), ("identify", "standard-cuts.csv"), ("identify", "air.csv", "--update"),
    ("identify", "air.csv", "--axis", "x"), ("identify", "air.csv", "--terms", "inertia,colomb"),
    ("identify", "turned.csv"), ("identify", "air.csv", "--page", "axis.txt"),
    ("identify", "unevenly.csv"), ("identify", "air.csv", "--pitch", "5"),
    ("reconstruct", "air.csv", "--machine", "lathe-1"),
    ("reconstruct", "air.csv", "--out", "a.txt"),
    ("reconstruct", "air.csv", "--moves", "air.csv", "--machine", "lathe-1"),
    ("reconstruct", "air.csv", "--moves", "air.csv", "--bandwidth", "900"),
    ("mismatch", "confirm", "9"), ("mismatch", "reject", "9"), ("mismatch", "reopen", "9"),
    ("trace", "force", "99999"), ("trace", "pair", "1"), ("inspect", "nothing.toml"),
    ("inspect", "wrong.toml"), ("inspect", "part.toml", "--cut", "3"),
    ("scale", "air.csv"), ("scale", "air.csv", "--standard-cut", "published"),
    ("scale", "air.csv", "--standard-cut", "turning-aluminium:none"),
    ("machine", "show", "lathe-9"), ("machine", "add", " "), ("machine", "rename", "lathe-9", "a"),
    ("machine", "update", "lathe-1", "--file", "wrong.toml"), ("fleet", "show"),
    ("edge", "changed", "--tool", "insert", "--machine", "lathe-1"), ("edge", "undo", "9"),
    ("edge", "changed", "--tool", TOOL, "--at", "soon"),
    ("edge", "changed", "--tool", TOOL, "--at", "2999-01-01"),
    ("doctor", "--db", "sqlite:///nothing.sqlite3"), ("demo", "--out", "part.toml"),
)  # fmt: skip


@pytest.mark.usefixtures("marked")
def test_every_refusal_of_a_command_is_looked_up(
    refused: Callable[..., str], sample_jobs: Path
) -> None:
    cuts = (sample_jobs / "stepped_shaft" / "recordings" / "standard-cuts.csv").read_text()
    head, *rows = (line.split(",") for line in cuts.splitlines())
    moves = [line.split(",") for line in Path("air.csv").read_text().splitlines()]
    force, feed = head.index("force.y"), head.index("cutting.feed")
    files = {
        "standard-cuts.csv": [head, *rows],
        "uncounted.csv": [row[2:] for row in [head, *rows]],
        "words.csv": [head, *([*row[:feed], "much", *row[feed + 1 :]] for row in rows)],
        "newtons.csv": [
            head, *([*r[:force], f"{1000.0 * float(r[force])}", *r[force + 1 :]] for r in rows)
        ],
        "few.csv": moves[:40],
        "turned.csv": [moves[0], *([*r[:4], f"{-float(r[4])}"] for r in moves[1:])],
        "unevenly.csv": [moves[0], *(moves[1 + k] for k in range(0, 1500, 2) if k % 300 > 50)],
        "empty.csv": [], "text.foo": [["a"]],
    }  # fmt: skip
    for name, lines in files.items():
        Path(name).write_text("\n".join(",".join(row) for row in lines))
    Path("wrong.toml").write_text("[bar]\ndiameter_mm = -3\nlenght_mm = 3\n")
    said = {one: refused(*one).removeprefix("autodb: ") for one in WRONG}
    assert {one: _unsaid(line) for one, line in said.items() if _unsaid(line)} == {}
    with closing(sqlite3.connect("autodb.sqlite3")) as database:
        assert OPEN not in "\n".join(database.iterdump())


def test_what_is_not_looked_up_would_show(standard_learnt: Cli) -> None:
    """The marks are what the other tests go by: without them everything is left."""
    assert _unsaid(standard_learnt("machine", "show", "lathe-1").out)
    assert _unsaid(standard_learnt("machine", "show", "lathe-9").err)


def test_each_command_is_known_to_answer_in_german_or_in_english() -> None:
    every: set[str] = set()

    def add(path: str, one: Any) -> None:
        if not hasattr(one, "commands"):
            every.add(path)
            return
        for name in one.commands:
            add(f"{path} {name}".strip(), one.commands[name])

    add("", commands())
    assert every == READERS | IN_ENGLISH
    assert not READERS & IN_ENGLISH


def test_programs_read_the_same_bytes(
    standard_learnt: Cli, sample_jobs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _axis(Path.cwd())
    Path("part.toml").write_text(PART)
    cuts = sample_jobs / "stepped_shaft" / "recordings" / "standard-cuts.csv"
    standard_learnt("identify", "air.csv", "--machine", "lathe-1")
    asked = (
        ("look", cuts), ("import", cuts, "--machine", "lathe-1"), ("identify", "air.csv"),
        ("reconstruct", "worn.csv"), ("inspect", "part.toml"), ("doctor",), ("machine", "list"),
        ("machine", "show", "lathe-1"), ("trace", "parameters", "1"), ("trace", "model", "1"),
    )  # fmt: skip

    def answers() -> list[str]:
        return [standard_learnt(*one, "--json").out for one in asked]

    ours = answers()
    monkeypatch.setenv("AUTODB_LANGUAGE", "de")
    monkeypatch.setenv("AUTODB_UNITS", "inch")
    assert answers() == ours
