"""A file that is not there: the refusal says what would work."""

from collections.abc import Callable
from pathlib import Path

import pytest

from autodb.errors import near, near_words, no_such_file
from autodb.wording import Presentation, language_of, presented

HERE: list[tuple[str, tuple[str, ...], str, str]] = [
    ("jbo.toml", ("job.toml", "other.toml"), "", " (did you mean job.toml?)"),
    ("job.tml", ("job.toml",), "", " (did you mean job.toml?)"),
    ("nix.toml", ("m.toml", ".nix.toml"), "'autodb demo'", "; 'autodb demo'"),
    ("nix.toml", ("m.toml", "a.csv"), "", " (there are: m.toml)"),
    ("nix.toml", ("a.csv",), "", "; its folder has no .toml file"),
    ("gone/nix.toml", ("nix.toml",), "", "; there is no folder {folder}/gone"),
    ("gone/nix.json", (), "start it", "; there is no folder {folder}/gone; start it"),
]


@pytest.mark.parametrize(("name", "there", "remedy", "says"), HERE)
def test_what_would_work_is_said(
    tmp_path: Path, name: str, there: tuple[str, ...], remedy: str, says: str
) -> None:
    for one in there:
        (tmp_path / one).touch()
    path = tmp_path / name
    assert str(no_such_file(path, remedy)) == (
        f"{path}: no such file{says.format(folder=tmp_path)}"
    )


def test_each_command_that_takes_a_file_says_how_one_is_made(
    refused: Callable[..., str],
) -> None:
    Path("job.toml").touch()
    assert "(did you mean job.toml?)" in refused("predict", "jb.toml")
    assert "'autodb demo' writes one, demo-out/job.toml" in refused("predict", "nix.toml")
    assert "[axes.spindle]" in refused("machine", "add", "lathe-1", "--file", "nix.toml")
    assert "its folder has no .csv file" in refused("look", "nix.csv")


def test_a_hint_is_in_the_language_of_its_sentence() -> None:
    with presented(Presentation("de")):
        assert near("jb", ["job"]) == " (did you mean job?)"
        assert near_words("jb", ["job"]) == " (gemeint: job?)"
        assert language_of(near_words("jb", ["job"])) == "de"
