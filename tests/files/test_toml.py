"""What is wrong with a file is said at once."""

from pathlib import Path

import pytest

from autodb.errors import UnusableInput
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
