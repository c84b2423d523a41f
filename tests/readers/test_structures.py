"""Cells of several numbers, structs, sheets and files that were cut off: fields, or one line."""

from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pytest
from nptdms import ChannelObject, TdmsWriter
from numpy.testing import assert_allclose
from pyarrow import parquet
from scipy.io import savemat

from autodb.errors import UnusableInput
from autodb.readers import ColumnSet, open_bases
from autodb.records import source as records
from tests.conftest import SHARED
from tests.helpers.files import write_workbook

LOGS = SHARED / "failures" / "logs"
T = np.arange(40) * 0.01
X = np.sin(T)
PICKLED = b"(lp1\nVt\np2\naVx.position\np3\naVx.current\np4\na."
"""A list of three names as pandas writes one, in the plainest pickle."""


def _base(path: Path, name: str = "") -> ColumnSet:
    return next(base for base in open_bases(path) if base.name == name)


def _number(base: ColumnSet, name: str) -> np.ndarray:
    return np.asarray(base.read([name])[name], dtype=np.float64)


@pytest.mark.parametrize("named", [True, False])
def test_a_block_of_numbers_in_records_is_columns(tmp_path: Path, named: bool) -> None:
    """As pandas writes a table; its pickle of names is read, not run."""
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        rows = np.zeros(len(T), dtype=[("index", "i8"), ("values_block_0", "f8", (3,))])
        rows["values_block_0"] = np.column_stack([T, X, 2.0 * X])
        table = file.create_dataset("df/table", data=rows)
        if named:
            table.attrs["values_block_0_kind"] = np.bytes_(PICKLED)
    base = _base(path)
    names = (
        ["t", "x.position", "x.current"] if named else [f"values_block_0 {k}" for k in (1, 2, 3)]
    )
    assert base.columns == ("index", *names)
    for name, expected in zip(names, (T, X, 2.0 * X), strict=True):
        assert_allclose(_number(base, name), expected)


def test_a_pandas_frame_of_the_fixed_kind(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["df/block0_items"] = np.array([b"t", b"x.position"])
        file["df/block0_values"] = np.column_stack([T, X])
        file["picture"] = np.ones((480, 640))
    table = records.read(path, group="df")
    assert_allclose(table["x.position"], X)


@pytest.mark.parametrize("across", [True, False])
def test_matrices_of_hdf5_are_columns(tmp_path: Path, across: bool) -> None:
    """MATLAB writes them the other way round."""
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        matrix = np.column_stack([T, X, 3.0 * X])
        file["data"] = matrix.T if across else matrix
    assert_allclose(_number(_base(path), "data 3"), 3.0 * X)


def test_structs_of_matlab(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    cuts = [{"t": T, "F": X, "number": 1.0}, {"t": T[:25], "F": X[:25], "number": 2.0}]
    log = {"t": T, "axis": {"x": X, "all": np.column_stack([T, X])}, "name": "lathe"}
    savemat(path, {"log": log, "cuts": np.array(cuts, dtype=object)})
    bases = {base.name: base for base in open_bases(path)}
    assert set(bases) == {"40 rows", "cuts(1)", "cuts(2)"}
    assert set(bases["40 rows"].columns) == {
        "log.t",
        "log.axis.x",
        "log.axis.all 1",
        "log.axis.all 2",
    }
    assert_allclose(_number(bases["40 rows"], "log.axis.all 2"), X)
    assert_allclose(_number(bases["cuts(2)"], "F"), X[:25])


def test_cells_of_matlab_that_hold_arrays(tmp_path: Path) -> None:
    """One of other lengths is a time base of its own; cells of texts are none."""
    cells = np.empty(3, dtype=object)
    for k in range(3):
        cells[k] = np.column_stack([np.arange(20 + k), np.arange(20 + k) / 4.0])
    path = tmp_path / "a.mat"
    savemat(path, {"runs": cells, "names": np.array(["a", "bc"], dtype=object)})
    bases = {base.name: base for base in open_bases(path)}
    assert list(bases) == ["runs{1}", "runs{2}", "runs{3}"]
    assert bases["runs{2}"].columns == ("runs 1", "runs 2")
    np.testing.assert_array_equal(bases["runs{3}"].read(["runs 2"])["runs 2"], np.arange(22) / 4.0)


def test_structs_and_lists_of_parquet(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    pairs = pa.array([[a, b] for a, b in zip(T, X, strict=True)], pa.list_(pa.float64(), 2))
    loose = pa.array([[a] for a in T])
    struct = pa.array([{"x": float(x), "deep": {"y": 1.0}} for x in X])
    parquet.write_table(pa.table({"pairs": pairs, "log": struct, "loose": loose}), path)
    base = _base(path)
    assert base.columns == ("pairs 1", "pairs 2", "log.x", "log.deep.y", "loose")
    assert_allclose(_number(base, "pairs 2"), X)
    assert_allclose(_number(base, "log.x"), X)
    with pytest.raises(UnusableInput, match=r"column 'loose', row 1: several values in a cell"):
        base.read(["loose"])


def test_sheets_of_a_workbook(tmp_path: Path) -> None:
    """Lines above, a row of units, decimal commas as texts, unknown cells, a sheet of words."""
    rows: list[list[object]] = [
        ["Prüfstand 4"],
        [],
        ["Nr", "Bearbeitung", "Kraft", "Tiefe"],
        [None, None, "kN", "mm"],
        [1, "turn", "1,25", 0.5],
        [2, "turn", "NA", 0.6],
        [3, "face", "2,5", None],
    ]
    path = write_workbook(
        tmp_path / "a.xlsx", {"Schnitte": rows, "Notes": [["made by hand"], ["twice"]]}
    )
    base = _base(path)
    assert base.layout == "sheet 'Schnitte', row 3 names the columns, row 4 has units"
    assert_allclose(_number(base, "Kraft"), [1.25, np.nan, 2.5])
    (tmp_path / "a.toml").write_text(
        '[channels]\n"cut" = "Nr"\n"force.y" = "Kraft"\n"operation" = "Bearbeitung"\n'
    )
    table = records.read(path)
    assert_allclose(table["force.y"], [1250.0, np.nan, 2500.0])
    assert table.texts["operation"] == ["turn", "turn", "face"]
    (tmp_path / "a.toml").write_text('[csv]\nsheet = "Schnite"\n')
    with pytest.raises(UnusableInput, match="did you mean Schnitte"):
        records.read(path)


def test_tdms_that_was_cut_off_keeps_its_whole_rows(tmp_path: Path) -> None:
    path = tmp_path / "a.tdms"
    with TdmsWriter(path) as file:
        for part in range(4):
            t = T + part * 0.4
            file.write_segment(
                [ChannelObject("g", "t", t), ChannelObject("g", "x.position", np.sin(t))]
            )
    whole = path.read_bytes()
    path.write_bytes(whole[: -10 * 8])
    assert "cut off" in _base(path).layout
    table = records.read(path)
    assert len(table) == 4 * len(T) - 10
    assert_allclose(table["x.position"], np.sin(table["t"]), atol=1e-12)


@pytest.mark.skipif(not LOGS.is_dir(), reason="the shared failures are not there")
def test_mdf_3_and_a_table_without_names() -> None:
    table = records.read(LOGS / "v3.mf4")
    assert {"t", "x.position", "x.current"} <= set(table.channels)
    assert len(table) == 4000
    (base,) = open_bases(LOGS / "pd_table.h5")
    steps = np.diff(_number(base, "values_block_0 1"))
    assert_allclose(steps, 0.002, atol=1e-9)
