"""What is wrong with a file is said at once."""

import re
from pathlib import Path

import pytest

from autodb.errors import UnusableInput
from autodb.files.job import read_job
from autodb.files.machine import read_machine_file
from autodb.files.toml import MOST_MISTAKES


def _refused(path: Path, text: str) -> str:
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UnusableInput) as caught:
        read_machine_file(path)
    return str(caught.value)


def test_every_mistake_of_a_file_is_said_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    said = _refused(
        path,
        'dialekt = "heidenhain"\n[axes.z]\nvertical = "sideways"\nlimits = {force = 9}\n',
    )
    assert said.startswith(f"{path}: ")
    assert "\n" not in said
    for key in ("dialekt: unknown key", "axes.z.vertical: ", "axes.z.limits.force: unknown key"):
        assert key in said


def test_more_mistakes_than_a_line_holds_are_counted(tmp_path: Path) -> None:
    keys = "".join(f"wrong_{number} = 1\n" for number in range(MOST_MISTAKES + 3))
    said = _refused(tmp_path / "m.toml", keys + "[axes.z]\n")
    assert said.count("unknown key") == MOST_MISTAKES
    assert said.endswith("; 3 more mistakes")


def test_near_keys_are_those_of_the_section(tmp_path: Path) -> None:
    said = _refused(tmp_path / "m.toml", "force_N = 1\n[axes.z]\n[spindle]\ngear = 1\n")
    assert "force_N: unknown key (there are: axes, " in said
    assert "spindle.gear: must be a list, not 1" in said


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("diameter = 50", "cut.1.diameter: unknown key (did you mean diameter_mm, "),
        ("diameter_mm = 50,5  # Ø", "line 5: 50,5 has a decimal comma; write a decimal point"),
        ("diameter_mm = '50,5'", "cut.1.diameter_mm: must be a number, not '50,5'"),
    ],
)
def test_what_is_mistyped_in_a_job(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "job.toml"
    path.write_text(f"name = 'a'\nmaterial = 'b'\ntool = 'c'\n[[cut]]\n{text}\n", "utf-8")
    with pytest.raises(UnusableInput, match=re.escape(said)):
        read_job(path)


def test_one_section_where_several_may_be_is_said(tmp_path: Path) -> None:
    path = tmp_path / "job.toml"
    path.write_text("name = 'a'\nmaterial = 'b'\ntool = 'c'\n[cut]\ndepth_mm = 1\n", "utf-8")
    with pytest.raises(UnusableInput, match=re.escape("cut: begin each with [[cut]], in place of")):
        read_job(path)
