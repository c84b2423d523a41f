"""Files become channels in our units, or one line says which file, column and row."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.readers import MOST_COLUMNS
from autodb.records import source as records
from autodb.records.tables import CutTable, Recording
from tests.conftest import Cli
from tests.helpers.files import write

T = np.arange(20) * 0.01
X = np.linspace(0.0, 3.0, 20)


@pytest.mark.parametrize(
    "suffix", [".csv", ".gz", ".zip", ".xlsx", ".parquet", ".mat", ".h5", ".tdms", ".mf4"]
)
def test_one_table_reads_alike_in_every_format(tmp_path: Path, suffix: str) -> None:
    path = write(tmp_path / f"a{suffix}", {"t": T, "x.position": X, "note": X})
    table = records.read(path)
    assert isinstance(table, Recording)
    assert set(table.channels) == {"t", "x.position"}
    assert_allclose(table["x.position"], X, rtol=1e-12)
    assert table.rate_hz == pytest.approx(100.0)


def test_mat_vectors_are_channels_and_scalars_are_ignored(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mat", {"t": T, "qm": X})
    side = tmp_path / "c.toml"
    side.write_text('[channels]\n"x.position" = {column = "qm", unit = "m"}\n')
    table = records.read(path, columns=side)
    assert_allclose(table["x.position"], 1000.0 * X, rtol=1e-12)
    assert "gain" not in table.channels


def test_units_scales_signs_and_kinds(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"t": T, "p": X, "i": X, "f": X, "r": X})
    (tmp_path / "a.toml").write_text(
        "[channels]\n"
        '"x.position" = {column = "p", unit = "m", diameter = true}\n'
        '"x.current" = {column = "i", unit = "mA", kind = "rms"}\n'
        '"z.current" = {column = "i", kind = "percent", rated_A = 8.0}\n'
        '"force.x" = {column = "f", scale = 2.0, unit = "kN", sign = -1}\n'
        '"y.current" = {column = "r", unit = "raw"}\n'
    )
    table = records.read(path)
    assert_allclose(table["x.position"], 500.0 * X, rtol=1e-12)
    assert_allclose(table["x.current"], 1e-3 * np.sqrt(2.0) * X, rtol=1e-12)
    assert_allclose(table["z.current"], 0.08 * X, rtol=1e-12)
    assert_allclose(table["force.x"], -2000.0 * X, rtol=1e-12)
    assert table.unit("y.current") == "raw"
    assert table.unit("x.current") == "A"


@pytest.mark.parametrize(
    ("channel", "unit", "expected"),
    [
        ("x.temperature", "K", 19.85), ("x.temperature", "degF", 145.0),
        ("spindle.speed", "Hz", 17580.0),
        ("spindle.speed", "1/min", 293.0), ("spindle.speed", "rev/s", 17580.0), ("t", "ms", 0.293),
        ("cutting.feed", "mm/rev", 293.0), ("spindle.angle", "rev", 105480.0),
        ("torque.spindle", "Nm", 293.0), ("x.velocity", "m/min", 293000.0 / 60.0),
    ],
)  # fmt: skip
def test_units_of_the_shop(tmp_path: Path, channel: str, unit: str, expected: float) -> None:
    path = write(tmp_path / "a.csv", {"k": [1.0, 2.0, 3.0], "v": [293.0, 294.0, 295.0]})
    key = "t" if channel != "t" else "x.current"
    (tmp_path / "a.toml").write_text(
        f'[channels]\n"{key}" = "k"\n"{channel}" = {{column = "v", unit = "{unit}"}}\n'
    )
    assert records.read(path)[channel][0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("unit", ["m11", "A1", "Hz"])
def test_units_that_are_none_of_a_current(tmp_path: Path, unit: str) -> None:
    path = write(tmp_path / "a.csv", {"t": T, "x.current": X})
    side = f'[channels]\n"x.current" = {{column = "x.current", unit = "{unit}"}}\n'
    (tmp_path / "a.toml").write_text(side)
    with pytest.raises(UnusableInput, match=r"use A"):
        records.read(path)


def test_times_of_day_become_seconds(tmp_path: Path) -> None:
    stamps = np.datetime64("2026-01-01", "us") + np.arange(20) * np.timedelta64(500, "us")
    path = write(tmp_path / "a.parquet", {"t": stamps, "x.current": X})
    assert_allclose(np.diff(records.read(path)["t"]), 0.0005, rtol=1e-3)
    path = write(
        tmp_path / "b.parquet", {"t": stamps.astype("M8[ns]").astype(np.int64), "x.current": X}
    )
    (tmp_path / "b.toml").write_text('[channels]\n"t" = {column = "t", unit = "ns"}\n')
    assert_allclose(np.diff(records.read(path)["t"]), 0.0005, rtol=1e-3)


def test_spaces_after_the_commas_of_a_header_do_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t, x.position , ,\n0, 1,,\n1, 2,,\n2, 3,,\n")
    assert_allclose(records.read(path)["x.position"], [1, 2, 3])


def test_a_quote_that_does_not_close_swallows_no_rows(tmp_path: Path) -> None:
    rows = [f'{i},{i},"a, b"' for i in range(50)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["t,x.position,note", *rows]))
    assert len(records.read(path)) == 50
    rows = [f"{i},{i},a" for i in range(50)]
    rows[20] = '20,20,"5 pipe'
    path.write_text("\n".join(["t,x.position,note", *rows]))
    with pytest.raises(UnusableInput, match="row 21: a quote opens"):
        records.read(path)


def test_a_lathe_x_logged_as_diameter_is_halved(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"t": T, "x.position": X, "z.position": X})
    (tmp_path / "a.toml").write_text("[recording]\ndiameter = true\n")
    table = records.read(path)
    assert_allclose(table["x.position"], 0.5 * X, rtol=1e-12)
    assert_allclose(table["z.position"], X, rtol=1e-12)


def test_rows_are_counted_within_a_column(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"tool": [3, 3, 5, 5, 5], "F": [1.0, 2, 3, 4, 5]})
    side = tmp_path / "c.toml"
    side.write_text(
        '[channels]\n"cut" = {row_in = "*"}\n"t" = {row_in = "*", step_s = 2.0}\n'
        '"tool.edge" = "tool"\n"tool.cutting_time" = {row_in = "tool", step_s = 1.5}\n'
        '"force.z" = "F"\n'
    )
    table = records.read(path, columns=side)
    assert isinstance(table, CutTable)
    assert_allclose(table.cut, [0, 1, 2, 3, 4])
    assert_allclose(table["t"], [0, 2, 4, 6, 8])
    assert_allclose(table["tool.cutting_time"], [0, 1.5, 0, 1.5, 3.0])


def test_edges_may_be_named_by_text(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"cut": [1, 2, 3], "tool.edge": ["B", "A", "B"]})
    table = records.read(path)
    assert_allclose(table["tool.edge"], [0, 1, 0])
    assert table.texts["tool.edge"] == ["B", "A", "B"]


def test_a_text_that_was_made_neutral_is_read_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("cut,force.x,tool\n1,-1,'=1+1\n2,2,'own'\n3,3,-5\n")
    table = records.read(path)
    assert table.texts["tool"] == ["=1+1", "'own'", "-5"]
    assert table["force.x"].tolist() == [-1.0, 2.0, 3.0]


def test_nan_in_an_unused_column_is_none_of_our_business(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"t": T, "x.position": X, "other": [float("nan")] * 20})
    assert len(records.read(path)) == 20


def test_a_gap_matters_where_the_channel_is_used(tmp_path: Path) -> None:
    gap = [*X[:-1], float("nan")]
    table = records.read(write(tmp_path / "a.csv", {"t": T, "x.position": X, "y.current": gap}))
    assert_allclose(table["x.position"], X)
    for use in (table.__getitem__, table.get):
        with pytest.raises(UnusableInput, match=r"y\.current, row 20: no finite number"):
            use("y.current")


def test_what_one_cut_lacks_is_not_known_of_it(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("cut,tool.flank_wear,force.x\n1,0.1,5\n2,,6\n")
    table = records.read(path)
    assert_allclose(table["tool.flank_wear"], [0.1, np.nan])


def test_a_table_goes_to_pandas(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"cut": [1, 2], "force.x": [3.0, 4.0], "tool": ["a", "b"]})
    frame = records.read(path).to_pandas()
    assert list(frame.columns) == ["cut", "force.x", "tool"]
    assert frame["tool"].tolist() == ["a", "b"]


def _text(name: str, text: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        path = folder / name
        path.write_text(text)
        return path

    return write


BAD_FILES = [
    (_text("a.csv", ""), "the file is empty"),
    (_text("a.csv", "t,x.position\n"), "no rows of data"),
    (
        _text("a.csv", "t,x.position\n0,1\n0,2\n1,3\n"),
        "column 't', row 2: 0 s after the row before; record",
    ),
    (_text("a.csv", "t,x.position\n0,1\n,2\n2,3\n"), "t, row 2: no finite number"),
    (_text("a.csv", "cut,force.x\n1,1\n,2\n"), "cut, row 2: no finite number"),
    (_text("a.csv", "t,x.position\n0,1\n1,1e300\n2,3\n"), "row 2: 1e+300 is no measurement"),
    (_text("a.csv", "t;x.position\n0.5;1\n1,5;2\n2.5;3\n"), "row 2: '1,5' is not a number"),
    (_text("a.csv", "t,x.position\n0,1\n1,two\n2,3\n"), "row 2: 'two' is not a number"),
    (_text("a.csv", "time,x.position\n0,1\n1,2\n2,3\n"), "neither a column 't'"),
    (_text("a.csv", "t,t\n0,1\n1,2\n"), "stands in the header twice"),
    (_text("a.csv", "cut,force.x\n1,1\n2,2\n2,3\n"), "row 3: cut 2 stands twice"),
    (_text("a.csv", "t,x.position\n0,1\n1,2\n"), "2 rows are too few"),
    (_text("a.doc", "t"), "unknown kind of file; use .csv"),
    (_text("a.parquet", "PAR1 not really"), "not a whole Parquet file"),
    (_text("a.mat", "MATLAB not really"), "not a whole MAT file"),
    (lambda folder: folder, "is a folder"),
    (lambda folder: folder / "absent.csv", "no such file"),
]


@pytest.mark.parametrize(("make", "says"), BAD_FILES)
def test_bad_files_say_what_is_wrong(
    tmp_path: Path, make: Callable[[Path], Path], says: str
) -> None:
    with pytest.raises(UnusableInput) as caught:
        records.read(make(tmp_path))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


BAD_SIDE_FILES = [
    ("[channels]\n'x.curent' = 'a'\n", "did you mean x.current"),
    ("[channels]\n'x.current' = {colum = 'a'}\n", "did you mean column"),
    ("[chanels]\n", "did you mean channels"),
    ("[channels]\n'x.current' = {column = 'II'}\n", "no column 'II'"),
    ("[channels]\n'x.current' = {column = 'a', unit = 'furlong'}\n", "cannot become A"),
    ("[channels]\n'x.current' = {column = 'a', unit = 'ampèèère'}\n", "unknown unit"),
    ("[channels]\n'x.current' = {}\n", "needs either column or row_in"),
    ("[cut]\noperation = 'knit'\n", "cut.operation"),
    ("[channels\n", "not a readable TOML file"),
    ("[channels]\n'x.current' = {column = 'a', scale = 0}\n", "scale 0"),
    ("[channels]\n'x.current' = {column = 'a', scale = nan}\n", "channels.x.current.scale"),
    ("[tool]\nteeth = -4\n", "tool.teeth"),
    ("[channels]\n'x.current' = {column = 'a', rated_A = '12'}\n", "rated_A"),
]


@pytest.mark.parametrize(("toml", "says"), BAD_SIDE_FILES)
def test_bad_side_files_name_what_would_work(tmp_path: Path, toml: str, says: str) -> None:
    path = write(tmp_path / "a.csv", {"t": T, "a": X})
    side = tmp_path / "side.toml"
    side.write_text(toml)
    with pytest.raises(UnusableInput) as caught:
        records.read(path, columns=side)
    assert says in str(caught.value)


def test_a_missing_channel_names_near_ones(tmp_path: Path) -> None:
    table = records.read(write(tmp_path / "a.csv", {"t": T, "x.position": X}))
    with pytest.raises(UnusableInput, match=r"did you mean x\.position"):
        table["x.positon"]


def _wide(folder: Path, columns: int) -> Path:
    """Write a table of two cuts and as many columns."""
    names = ["cut", "force.x", *(f"c{k}" for k in range(2, columns))]
    rows = [",".join([str(row), *["7"] * (columns - 1)]) for row in (1, 2)]
    path = folder / "wide.csv"
    path.write_text("\n".join([",".join(names), *rows, ""]))
    return path


def test_as_many_columns_as_are_taken_are_read(tmp_path: Path) -> None:
    table = records.read(_wide(tmp_path, MOST_COLUMNS))
    assert isinstance(table, CutTable)
    assert table["force.x"].tolist() == [7.0, 7.0]
    assert len(table.ignored) == MOST_COLUMNS - 2


@pytest.mark.parametrize("columns", [MOST_COLUMNS + 1, 100_000])
def test_more_columns_are_refused_in_one_line(tmp_path: Path, columns: int) -> None:
    """Each name is looked at once: squared, a tenth of a million would take minutes."""
    with pytest.raises(UnusableInput, match=rf"wide\.csv: {columns} columns; send at most 10000"):
        records.read(_wide(tmp_path, columns))


@pytest.mark.parametrize("suffix", [".parquet", ".h5"])
def test_columns_of_any_format_are_bounded(
    tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path / f"a{suffix}", {"t": T, "x.position": X, "note": X})
    monkeypatch.setattr("autodb.readers.MOST_COLUMNS", 2)
    with pytest.raises(UnusableInput, match="3 columns; send at most 2"):
        records.read(path)


def test_a_table_too_wide_is_exit_2(cli: Cli, tmp_path: Path) -> None:
    cli("init")
    cli("machine", "add", "lathe-1")
    done = cli("import", _wide(tmp_path, MOST_COLUMNS + 1), "--machine", "lathe-1")
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert "10001 columns" in done.err


def test_a_column_named_almost_like_a_channel_is_shown_with_the_channel(tmp_path: Path) -> None:
    path = tmp_path / "m.csv"
    path.write_text("t,x.curren\n0,1\n1,2\n2,3\n")
    with pytest.raises(UnusableInput, match=r'such as "x\.current" = "x\.curren"'):
        records.read(path)
