"""Mutated files of every format: read, or refused in one line, never anything else.

Some seconds; `AUTODB_MUTATIONS=50` makes fifty times as many, other ones each time.
"""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings

from autodb.errors import UnusableInput
from autodb.readers import READERS
from autodb.records import source as records
from autodb.records.plausible import doubts
from autodb.records.summary import summarise
from autodb.records.tables import Recording
from tests.helpers.files import write, write_groups
from tests.helpers.mutations import MUTATIONS, Edit, mutated

TIMES = int(os.environ.get("AUTODB_MUTATIONS", "1"))
T = np.arange(60) * 0.01
COLUMNS = {"t": T, "x.position": np.sin(T), "x.current": np.cos(T)}
TEXTS = {suffix for suffix, module in READERS.items() if module == "text.reading"}
ALIKE = TEXTS | {".hdf5", ".mdf", ".xls", ".xlsm", ".xlsb", ".ods"}
"""Read by what reads another, which is mutated."""
EXAMPLES = {
    ".xlsx": 5,
    ".csv": 200,
    ".gz": 60,
    ".zip": 60,
    ".parquet": 200,
    ".tdms": 120,
    ".mat": 5,
    ".h5": 5,
    ".mf4": 4,
    ".xml": 120,
    ".json": 120,
}
SIDE = """\
[recording]
machine = "m"
diameter = true
[channels]
"x.position" = {column = "pos", unit = "mm", sign = -1}
"x.current" = {column = "cur", unit = "A", kind = "percent", rated_A = 8.0}
"cut" = {row_in = "*", step_s = 2}
[cut]
operation = "turn"
depth_mm = 1.5
"""


def _use(path: Path) -> None:
    """Do with a file all that a look and a read do; check what was read."""
    try:
        source = records.open_source(path)
        for base in summarise(source):
            list(doubts(base, source.side))
        for usable in source.usable():
            table = usable.read()
            assert {len(values) for values in table.channels.values()} == {len(table)}
            if isinstance(table, Recording):
                assert (np.diff(table.t_s) > 0).all()
                assert all(np.isfinite(values).all() for values in table.channels.values())
    except UnusableInput as refusal:
        assert str(refusal).isprintable()


def test_every_kind_of_file_is_mutated() -> None:
    assert {*READERS} == {*EXAMPLES} | ALIKE


@pytest.mark.parametrize("suffix", EXAMPLES)
@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_mutated_recordings(tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("autodb.readers._child.LONGEST_S", 2.0)
    path = write(tmp_path / f"a{suffix}", COLUMNS)
    _try_mutations(path, EXAMPLES[suffix])


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_mutated_files_with_several_time_bases(tmp_path: Path) -> None:
    groups = {"a": COLUMNS, "b": {"t": T[::5], "x.temperature": T[::5]}}
    _try_mutations(write_groups(tmp_path / "a.tdms", groups), 300)


def test_mutated_side_files(tmp_path: Path) -> None:
    data = write(tmp_path / "a.csv", {"pos": T, "cur": T})
    side = tmp_path / "a.toml"
    side.write_text(SIDE)
    assert len(records.read(data)) == len(T)
    _try_mutations(side, 300, used=data)


def _try_mutations(path: Path, examples: int, used: Path | None = None) -> None:
    whole = path.read_bytes()
    tried: list[int] = []

    @settings(
        max_examples=examples * TIMES,
        deadline=None,
        database=None,
        derandomize=TIMES == 1,
        suppress_health_check=list(HealthCheck),
    )
    @example([])
    @given(MUTATIONS)
    def check(edits: list[Edit]) -> None:
        path.write_bytes(mutated(whole, edits))
        _use(used or path)
        tried.append(1)

    check()
    assert len(tried) >= examples
