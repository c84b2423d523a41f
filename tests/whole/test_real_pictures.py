"""The pictures of real axes: they are on their page, name what was left out, and still hold."""

import re
from pathlib import Path

import pytest

from autodb.reports.explanation import headline, term_words
from docs.make import real_axes, style
from docs.make.__main__ import REAL_CASES
from tests.conftest import ROOT

PAGE = ROOT / "docs" / "proofs" / "real.md"
LARGEST_BYTES = 60_000
SIZE = re.compile(r"(\w+): ([\d.]+)\xa0A \(([\d.]+) to ([\d.]+)\xa0A\), (\d+) % sure")


def _drawn(name: str) -> list[str]:
    """Return the lines of text of a committed figure."""
    text = (style.FIGURES / f"{name}.svg").read_text("utf-8")
    return re.findall(r">([^<\n]+)</text>", text)


@pytest.mark.parametrize("picture", real_axes.PICTURES, ids=lambda picture: picture.name)
def test_a_picture_is_small_shown_and_names_what_was_left_out(
    picture: real_axes.RealPicture,
) -> None:
    assert (style.FIGURES / f"{picture.name}.svg").stat().st_size < LARGEST_BYTES
    assert f"(../figures/{picture.name}.svg)" in PAGE.read_text("utf-8")
    assert f"-no_{picture.term}-" in picture.folder
    lines = _drawn(picture.name)
    assert picture.what in lines
    assert any(line.endswith("A);") and term_words(picture.term) in line for line in lines)
    (size,) = [found for line in lines if (found := SIZE.fullmatch(line))]
    assert size[1] == picture.term
    assert float(size[3]) < float(size[2]) < float(size[4])
    assert {"recording", "simulation", "corrected", "time, s"} <= set(lines)
    (errors,) = [re.findall(r"([\d.]+)\xa0A", line) for line in lines if "left out" in line]
    before, after = map(float, errors)
    assert after < 0.6 * before


@pytest.mark.pages
@pytest.mark.parametrize("picture", real_axes.PICTURES, ids=lambda picture: picture.name)
def test_explain_still_says_what_a_picture_says(picture: real_axes.RealPicture) -> None:
    case = REAL_CASES / picture.folder
    if not case.exists():
        pytest.skip(f"no {case}")
    answer, trace = real_axes.explained(case)
    assert answer.missing[0].term == picture.term
    lines = _drawn(picture.name)
    assert real_axes.found_words(picture, answer) in lines
    assert real_axes.held_out_words(answer) in lines
    assert headline(answer, trace) in " ".join(lines)


def test_without_recordings_the_pictures_stay_and_a_line_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from docs.make import __main__ as make

    monkeypatch.setattr(make, "REAL_CASES", tmp_path / "real")
    monkeypatch.setattr(make, "REAL", (tmp_path / "emps.mat",))
    monkeypatch.setattr(style, "FIGURES", tmp_path)
    make.draw_recordings()
    assert capsys.readouterr().out.splitlines() == [
        f"figures of proofs/real.md are left as they are: no {tmp_path / 'real'}",
        f"tutorial.md and its figures are left as they are: no {tmp_path / 'emps.mat'}",
    ]
    assert not list(tmp_path.iterdir())
