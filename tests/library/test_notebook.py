"""The notebook of the docs runs from an empty folder, and shows what it says."""

import re
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from autodb.library.answers import CalibrateResult
from autodb.library.found import ExplainResult
from tests.conftest import ROOT

pytestmark = pytest.mark.usefixtures("one_law")

NOTEBOOK = ROOT / "docs" / "notebook.py"
CELL = re.compile(r"^# %%(.*)\n", re.MULTILINE)
MOST_CELLS = 15


def _cells() -> list[tuple[str, str]]:
    """Return kind and text of each cell of a notebook in jupytext's percent format."""
    parts = CELL.split(NOTEBOOK.read_text("utf-8"))[1:]
    return [(kind.strip(), text) for kind, text in zip(parts[::2], parts[1::2], strict=True)]


def test_the_notebook_goes_from_an_empty_folder_to_an_explanation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("AUTODB_DB", raising=False)
    cells = _cells()
    assert len(cells) <= MOST_CELLS
    there: dict[str, Any] = {"__name__": "__notebook__"}
    for kind, text in cells:
        if kind == "[markdown]":
            assert all(line.startswith("#") for line in text.splitlines() if line)
            continue
        exec(compile(text, NOTEBOOK.name, "exec"), there)
    calibrated, explained = there["calibrated"], there["explained"]
    assert isinstance(calibrated, CalibrateResult)
    assert calibrated.to_pandas()["usable"].any()
    assert (there["predicted"].to_pandas()["force.y"] > 0).all()
    assert isinstance(explained, ExplainResult)
    assert "tool_wear" in set(explained.to_pandas()["term"])
    assert (tmp_path / "week-2.html").stat().st_size > 10_000
    assert isinstance(there["db"].machine().pairs().to_pandas(), pd.DataFrame)
