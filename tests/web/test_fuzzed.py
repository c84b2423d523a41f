"""Bytes from outside are read, or refused in one line: what fuzzing kept, and mutations of it.

A few seconds; `AUTODB_MUTATIONS=100` makes a hundred times as many, other ones each time.
"""

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.helpers.fuzzed import CORPUS, TARGETS
from tests.helpers.mutations import MUTATIONS, Edit, mutated

TIMES = int(os.environ.get("AUTODB_MUTATIONS", "1"))
EXAMPLES = {"nc": 120, "toml": 80, "upload": 80}


def _kept(name: str) -> list[Path]:
    found = sorted((CORPUS / name).iterdir())
    assert len(found) >= 50, "made by python -m tests.by_hand.fuzz"
    return found


@pytest.mark.parametrize("name", TARGETS)
def test_what_fuzzing_kept(name: str, tmp_path: Path) -> None:
    for path in _kept(name):
        folder = tmp_path / path.name
        folder.mkdir()
        TARGETS[name](path.read_bytes(), folder)


@pytest.mark.parametrize("name", TARGETS)
def test_mutations_of_what_fuzzing_kept(name: str, tmp_path: Path) -> None:
    wholes = [path.read_bytes() for path in _kept(name)]
    tried: list[int] = []

    @settings(
        max_examples=EXAMPLES[name] * TIMES,
        deadline=None,
        database=None,
        derandomize=TIMES == 1,
        suppress_health_check=list(HealthCheck),
    )
    @given(st.sampled_from(wholes), MUTATIONS)
    def check(whole: bytes, edits: list[Edit]) -> None:
        folder = tmp_path / str(len(tried))
        folder.mkdir()
        tried.append(1)
        TARGETS[name](mutated(whole, edits), folder)

    check()
    assert len(tried) >= EXAMPLES[name]
