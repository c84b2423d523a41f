"""Examples in docstrings print what they say; those of the library are whole programs."""

import doctest
from importlib import import_module
from pathlib import Path

import pytest

import autodb
from tests.conftest import ROOT

WITH = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for path in (ROOT / "autodb").rglob("*.py")
    if ">>> " in path.read_text("utf-8") and "proofs/cases" not in path.as_posix()
)
"""All but generators of proofs, whose text is part of what was proved."""
OF_THE_LIBRARY = {"explain", "identify", "open"}
"""Functions of `import autodb`."""


@pytest.mark.parametrize("name", WITH)
def test_examples_print_what_they_say(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("AUTODB_DB", raising=False)
    done = doctest.testmod(import_module(name), optionflags=doctest.ELLIPSIS)
    assert done.attempted > 0
    assert done.failed == 0


def test_each_function_of_the_library_has_an_example() -> None:
    functions = {name for name in autodb.__all__ if name[0].islower()}
    assert functions == OF_THE_LIBRARY
    for name in functions:
        assert ">>> " in str(getattr(autodb, name).__doc__), name
