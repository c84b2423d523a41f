"""What commands print, and the pages that they write, in German and in a shop's units.

Sentences are put between marks where they are looked up, as for the pages of the service. What
programs read is the same bytes in every language.
"""

import json
import re
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from autodb.files.units import INCH
from autodb.wording import catalogues
from tests.conftest import Cli
from tests.helpers.files import write
from tests.helpers.marked_words import OPEN, Marked, left, left_of_page

N_PER_LBF = 4.4482216152605
PAIR = ("--material", "steel bar", "--tool", "carbide insert")
CUT = ("--diameter", "50", "--depth", "1.5", "--feed", "0.2", "--speed", "220")
LARGEST = ("lookup", *PAIR, *CUT[:4], *CUT[6:], "--largest", "feed")
MODE = """
[[mode]]
axis = "x"
frequency_Hz = 603
damping_ratio = 0.039
stiffness_N_m = 5590e3
"""
LIMITS = """
[axes.x]
force_N = 800
[axes.z]
force_N = 3000
[spindle]
torque_N_m = 40
power_W = 7500
"""
TYPED = re.compile(
    r"stepped shaft|\b(?:rough|finish) Ø\d+|[\w-]+\.(?:html|csv)|\bF[pcf]\b|\bforce\.|"
    r"\bspindle\b|\bRMSE\b|\bin³|\bout/"
)
"""Names in the files of these tests, channels and signs of equations."""


@pytest.fixture
def german(standard_learnt: Cli, monkeypatch: pytest.MonkeyPatch) -> Cli:
    """Return the command line for a German shop that measures in inches, on a lathe that learnt."""
    monkeypatch.setenv("AUTODB_LANGUAGE", "de")
    monkeypatch.setenv("AUTODB_UNITS", INCH)
    return standard_learnt


@pytest.fixture
def marked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have every sentence marked that is looked up for who reads German."""
    monkeypatch.setattr(catalogues, "catalogue", lambda _language: Marked())


def _axis(folder: Path) -> tuple[str, str]:
    """Write a recording of an axis with a ripple that its simulation lacks; return both files."""
    time_s = 0.004 * np.arange(1500)
    velocity = 40.0 * np.sin(2.5 * time_s)
    place = np.cumsum(velocity) * 0.004
    simulated = 1.2 * np.tanh(velocity) + 0.004 * velocity
    noise = 0.03 * np.random.default_rng(41).normal(size=time_s.size)
    both = {"measured": simulated + 0.3 * np.sin(0.8 * place) + noise, "simulated": simulated}
    for name, current in both.items():
        axis = {"t": time_s, "x.position": place, "x.velocity": velocity, "x.current": current}
        write(folder / f"{name}.csv", axis)
    return "measured.csv", "simulated.csv"


def _page(name: str) -> str:
    """Return a page without the papers that advice is from."""
    return re.sub(r"<small>\(.*?\)</small>", "", Path(name).read_text("utf-8"))


def _unsaid(texts: list[str]) -> list[str]:
    """Return what of texts was looked up nowhere, without what is written in files."""
    return left(TYPED.sub(" ", text) for text in left(texts))


@pytest.mark.usefixtures("one_law", "marked")
def test_every_sentence_that_a_command_prints_is_looked_up(german: Cli, sample_jobs: Path) -> None:
    job, here = sample_jobs / "stepped_shaft" / "job.toml", Path.cwd()
    (here / "limits.toml").write_text(LIMITS)
    (here / "mode.toml").write_text(MODE)
    measured, simulated = _axis(here)
    asked = [
        ("sensors",), ("mismatch", "list"), ("lookup",), ("lookup", *PAIR, *CUT),
        LARGEST, ("lookup", "--machine", "lath-1"),
        ("life", job), ("refresh",), ("refresh", "--report"),
        ("calibrate", "--card", "card.html"),
        ("stability", job, "--dynamics", "mode.toml", "--plot", "lobes.html"),
        ("explain", measured, "--simulation", simulated, "--out", "out"),
    ]  # fmt: skip
    said = {one: german(*one) for one in asked}
    german("machine", "update", "lathe-1", "--file", "limits.toml")
    asked = [
        LARGEST, ("predict", job, "--beside", job, "--plot", "picture.html"), ("plan", job),
        ("predictions", "score"),
    ]  # fmt: skip
    said |= {(*one, "within limits"): german(*one) for one in asked}
    left_out = {one: _unsaid((did.out + did.err).splitlines()) for one, did in said.items()}
    assert {one: some for one, some in left_out.items() if some} == {}
    pages = ("card.html", "picture.html", "lobes.html", "out/report.html")
    left_in = {one: _unsaid(left_of_page(_page(one))) for one in pages}
    assert {one: some for one, some in left_in.items() if some} == {}
    with closing(sqlite3.connect("autodb.sqlite3")) as database:
        assert OPEN not in "\n".join(database.iterdump())
    assert OPEN not in Path("out/explanation.json").read_text("utf-8")


@pytest.mark.usefixtures("one_law")
def test_programs_read_the_same_bytes_in_every_language(
    german: Cli, sample_jobs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    job = sample_jobs / "stepped_shaft" / "job.toml"
    asked = (
        ("lookup", *PAIR, *CUT, "--json"), ("lookup", "--json"), ("refresh", "--report", "--json"),
        ("predictions", "score", "--json"), ("plan", job, "--json"), ("calibrate", "--json"),
        ("predict", job, "--json", "--csv", "answer.csv", "--plot", "answer.html"),
    )  # fmt: skip

    def answers() -> list[str]:
        said = [german(*one).out for one in asked]
        said[-1] = re.sub(r'(?<="prediction_id": )\d+', "1", said[-1])
        return [*said, Path("answer.csv").read_text("utf-8")]

    theirs, page = answers(), Path("answer.html").read_text("utf-8")
    for name in ("AUTODB_LANGUAGE", "AUTODB_UNITS"):
        monkeypatch.delenv(name)
    assert theirs == answers()
    assert all(json.loads(one) for one in theirs[:-1])
    assert '<html lang="de">' in page
    assert "Kraft Y (Schnittkraft Fc) [lbf]" in page
    assert "angenommen" in page  # also notes, which the JSON beside it has in English
    assert '<span lang="en">' not in page


def _numbers(line: str) -> list[float]:
    return [float(one.replace(",", ".")) for one in re.findall(r"-?\d+(?:[.,]\d+)?", line)]


@pytest.mark.usefixtures("one_law")
def test_numbers_have_the_marks_and_the_units_of_the_reader(standard_learnt: Cli) -> None:
    def row(*options: str) -> str:
        said = standard_learnt("lookup", *PAIR, *CUT, *options).out
        return next(line for line in said.splitlines() if re.match(r"  (turn|Längsdrehen) ", line))

    ours, german, inch = row(), row("--language", "de"), row("--language", "de", "--units", "inch")
    assert " to " in ours
    assert "." in ours
    assert " bis " in german
    assert "." not in german + inch
    assert _numbers(german) == _numbers(ours)
    shop = np.array(_numbers(inch))
    factors = [1.0, 0.3048, *[N_PER_LBF] * 9, *[1.355817948] * 3, *[745.6998716] * 3]
    np.testing.assert_allclose(shop * factors, _numbers(ours), rtol=0.02, atol=0.06)


def test_a_language_and_units_that_there_are_not_are_refused(
    refused: Callable[..., str], cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    cli("init")
    assert "--language 'fr': there is none (there are: en, de)" in refused(
        "lookup", "--language", "fr"
    )
    monkeypatch.setenv("AUTODB_UNITS", "ells")
    assert "--units 'ells': there is none (there are: si, inch)" in refused("refresh")
    monkeypatch.setenv("AUTODB_UNITS", INCH)
    monkeypatch.setenv("AUTODB_LANGUAGE", "de")
    assert "keine Maschine 'lathe-9'" in refused("lookup", "--machine", "lathe-9")
    assert "no machine 'lathe-9'" in refused("lookup", "--machine", "lathe-9", "--language", "en")
    assert "keine Maschine 'lathe-9'" in refused("export", "tables", "--machine", "lathe-9")
