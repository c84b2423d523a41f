"""A fast and a slow group in one text table, each with a column of time of its own."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.files.side import SideFile, stated_side
from autodb.readers import open_bases
from autodb.records import source as records
from autodb.records.tables import Recording

PAIRS = [
    ("t", "t2"), ("t_fast", "t_slow"), ("Zeit schnell [s]", "Zeit langsam [s]"), ("Time1", "Time2"),
    ("Temps (s)", "Temps (s) 2"), ("timestamp", "timestamp.1"),
]  # fmt: skip


def _table(
    names: tuple[str, str], fast: np.ndarray, slow: np.ndarray, mark: str = ",", decimal: str = "."
) -> str:
    """Return a position by the fast clock and a temperature by the slow one, which ends early."""
    lines = [mark.join((names[0], "x.position", names[1], "x.temperature"))]
    for k in range(max(len(fast), len(slow))):
        cells = [f"{fast[k]:.6f}", f"{10 * k}"] if k < len(fast) else ["", ""]
        cells += [f"{slow[k]:.6f}", f"{20 + k}"] if k < len(slow) else ["", ""]
        lines.append(mark.join(cell.replace(".", decimal) for cell in cells))
    return "\n".join(lines) + "\n"


def _read(path: Path, time: str) -> dict[str, Recording]:
    side = SideFile() if time == "t" else stated_side({"t": time}, where="side")
    source = records.open_source(path, columns=side)
    read = [base.read() for base in source.usable()]
    return {
        next(c for c in one.channels if c != "t"): one for one in read if isinstance(one, Recording)
    }


@pytest.mark.parametrize(("mark", "decimal"), [(",", "."), (";", ","), ("\t", ".")])
@pytest.mark.parametrize("names", PAIRS)
def test_each_group_is_read_by_its_own_clock(
    tmp_path: Path, names: tuple[str, str], mark: str, decimal: str
) -> None:
    path = tmp_path / "a.csv"
    path.write_text(_table(names, np.arange(500) * 0.001, np.arange(50) * 0.01, mark, decimal))
    found = _read(path, names[0])
    assert {name: len(one.channels["t"]) for name, one in found.items()} == {
        "x.position": 500, "x.temperature": 50,
    }  # fmt: skip
    assert_allclose(found["x.temperature"].channels["t"], np.arange(50) * 0.01)
    assert_allclose(found["x.position"].channels["x.position"], 10.0 * np.arange(500))


@settings(max_examples=40, deadline=None)
@given(
    rate=st.floats(50.0, 5000.0), times=st.integers(2, 40), rows=st.integers(200, 900),
    whole=st.booleans(),
)  # fmt: skip
def test_a_slow_group_of_any_rate_is_read_whether_it_ends_early_or_not(
    tmp_path_factory: pytest.TempPathFactory, rate: float, times: int, rows: int, whole: bool
) -> None:
    path = tmp_path_factory.mktemp("two") / "a.csv"
    fast = np.arange(rows) / rate
    slow = np.arange(rows if whole else max(rows // times, 12)) * times / rate
    path.write_text(_table(("t_fast", "t_slow"), fast, slow))
    if times != 1 and not (whole and times == 60):
        found = _read(path, "t_fast")
        assert len(found["x.temperature"].channels["t"]) == len(slow)
        assert_allclose(found["x.temperature"].channels["t"][-1], slow[-1], rtol=1e-3)


@pytest.mark.parametrize(
    "second",
    [np.arange(200) * 0.001, np.arange(200) * 1.0, np.arange(200) * 0.001 + 0.5,
     np.cumsum(np.arange(1, 201)) * 0.001],
    ids=["the same", "in milliseconds", "counted from elsewhere", "what passes unevenly"],
)  # fmt: skip
def test_one_clock_in_two_columns_stays_one_time_base(tmp_path: Path, second: np.ndarray) -> None:
    path = tmp_path / "a.csv"
    path.write_text(_table(("t", "t2"), np.arange(200) * 0.001, second))
    (base,) = open_bases(path)
    assert base.columns == ("t", "x.position", "t2", "x.temperature")


def test_times_of_cuts_are_no_clocks(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = "".join(f"{k},{10 * k},{0.1 + 0.01 * k},{10 * k + 4},2\n" for k in range(1, 30))
    path.write_text(f"cut,Start time,cutting.feed,End time,cutting.depth\n{rows}")
    (base,) = open_bases(path)
    assert len(base.columns) == 5


def test_what_is_told_wrongly_is_stated(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(_table(("t", "t2"), np.arange(200) * 0.001, np.arange(20) * 0.01))
    one = stated_side({"csv": {"times": []}}, where="side")
    assert len(open_bases(path, one.csv)) == 1
    path.write_text(_table(("clock", "watch"), np.arange(200) * 0.001, np.arange(20) * 0.01))
    assert len(open_bases(path)) == 1
    two = {"csv": {"times": ["clock", "watch"]}, "channels": {"t": "clock"}}
    source = records.open_source(path, columns=stated_side(two, where="side"))
    assert [sorted(base.conversion.specs) for base in source.usable()] == [
        ["t", "x.position"], ["t", "x.temperature"],
    ]  # fmt: skip
    assert "'clock', 'watch' are times, each of the columns behind it" in source.remarks[0]
    with pytest.raises(UnusableInput, match=r"times: no column 'wach' \(did you mean watch"):
        open_bases(path, stated_side({"csv": {"times": ["clock", "wach"]}}, where="side").csv)
