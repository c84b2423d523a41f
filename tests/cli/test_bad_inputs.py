"""Every unusable input on the docs page gets the line that stands there, exit 2, nothing stored."""

import re
from pathlib import Path

import pytest

from tests.by_hand.bad_inputs import answer, entry, folder_of
from tests.conftest import ROOT
from tests.helpers.bad_inputs import PARTS, Case

CASES = [case for _, cases in PARTS for case in cases]
PAGE = (ROOT / "docs" / "bad-inputs.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.what)
def test_the_page_says_what_the_command_says(case: Case) -> None:
    code, said = answer(case)
    assert code == 2
    lines = said.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("autodb: ")
    assert entry(case, said) in PAGE


def test_the_page_has_no_other_cases() -> None:
    assert re.findall(r"^\*\*(.+)\*\* ·", PAGE, re.MULTILINE) == [case.what for case in CASES]


def test_a_refused_file_leaves_the_folder_as_it_was() -> None:
    for case in CASES:
        with folder_of(case) as folder:
            before = sorted(folder.iterdir())
            answer(case)
            assert sorted(folder.iterdir()) == before, case.what


def test_the_working_folder_is_given_back() -> None:
    here = Path.cwd()
    answer(CASES[0])
    assert Path.cwd() == here
