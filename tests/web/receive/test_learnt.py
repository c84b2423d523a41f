"""What a page's learning does in its own process: calibrate if so asked, then refresh."""

import os
from pathlib import Path

import pytest

from autodb.errors import UnusableInput
from autodb.store import open_store
from autodb.web.http.responses import adapter
from autodb.web.receive.apart import MachineToLearn
from autodb.web.receive.learnt import MachineLearnt
from tests.conftest import Cli


def _learnt(*, calibrate: bool) -> MachineLearnt:
    store = open_store("sqlite:///autodb.sqlite3")
    try:
        said = MachineToLearn("lathe-1", calibrate).do(store, lambda _: None)
    finally:
        store.close()
    found = adapter(MachineLearnt).validate_json(said)
    assert isinstance(found, MachineLearnt)
    return found


def test_a_machine_is_calibrated_before_it_learns_where_that_is_asked(
    cli: Cli, sample_jobs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "nice", lambda _: 0)
    cli("init")
    cli("machine", "add", "lathe-1")
    with pytest.raises(UnusableInput, match="no imported cuts with force"):
        _learnt(calibrate=True)
    cli("import", sample_jobs / "stepped_shaft/recordings/standard-cuts.csv")
    first = _learnt(calibrate=True)
    assert first.new_calibrations == 3
    assert first.report.versions
    assert _learnt(calibrate=True).new_calibrations == 0
    assert _learnt(calibrate=False).new_calibrations is None
