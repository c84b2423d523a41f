"""What stands beside the numbers of a table: labels, a period, remarks below, quotes over lines."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.readers import ColumnSet, open_bases
from tests.helpers.files import write_workbook


def _only(path: Path, text: str) -> ColumnSet:
    path.write_text(text, "utf-8")
    (base,) = open_bases(path)
    return base


def _numbers(base: ColumnSet, name: str) -> NDArray[np.float64]:
    return np.asarray(base.read([name])[name], dtype=np.float64)


def test_names_stand_before_the_numbers_of_each_row(tmp_path: Path) -> None:
    """As halscope of LinuxCNC writes: its period above, decimal commas, a pin twice."""
    rows = [f"pid.z.out +{k},250 axis.z.pos -0,{k}5 pid.z.out +{k},250 " for k in range(40)]
    base = _only(tmp_path / "a.log", "\n".join(["Sampling period is 500000 nSec ", "", *rows, ""]))
    assert base.columns == (
        *("t", "column 1", "pid.z.out", "column 3", "axis.z.pos", "column 5", "pid.z.out (2)"),
    )
    assert_allclose(_numbers(base, "t"), 0.0005 * np.arange(40), rtol=1e-12)
    assert_allclose(_numbers(base, "pid.z.out"), np.arange(40) + 0.25)
    assert_allclose(_numbers(base, "axis.z.pos"), [-float(f"0.{k}5") for k in range(40)])
    assert set(base.read([], ["column 1"])["column 1"].tolist()) == {"pid.z.out"}
    assert "called by what stands before them, rows are 0.0005 s apart" in base.layout


@pytest.mark.parametrize(
    ("line", "step_s"),
    [
        ("Sample rate: 2 kHz", 0.0005),
        ("Sampling interval = 0,5 ms", 0.0005),
        ("sample_time 2 s", 2.0),
        ("Sampling frequency (Hz) 400", None),
        ("Sample rate: 0 Hz", None),
        ("Sample rate: 3 furlongs", None),
    ],
)
def test_a_rate_above_a_table_without_a_time(
    tmp_path: Path, line: str, step_s: float | None
) -> None:
    rows = [f"{(-1) ** k};{k % 3},5" for k in range(30)]
    base = _only(tmp_path / "a.txt", "\n".join([line, "", "Kraft;Strom", *rows]))
    if step_s is None:
        assert base.columns == ("Kraft", "Strom")
    else:
        assert base.columns == ("t", "Kraft", "Strom")
        assert_allclose(_numbers(base, "t"), step_s * np.arange(30), rtol=1e-12)


def test_a_rate_beside_a_time_is_left(tmp_path: Path) -> None:
    rows = [f"{k / 4};{k % 3},5".replace(".", ",") for k in range(30)]
    base = _only(tmp_path / "a.txt", "\n".join(["Sample rate: 4 Hz", "", "Zeit;Strom", *rows]))
    assert base.columns == ("Zeit", "Strom")


TABLE = ["Nr;Kraft", "1;2,5", "2;2,75", "3;3,0", "4;3,25"]


def test_remarks_below_a_table_are_left_out_and_said(tmp_path: Path) -> None:
    base = _only(tmp_path / "a.csv", "\n".join([*TABLE, "", "gemessen nachts", "von Hand;", ""]))
    assert_allclose(_numbers(base, "Kraft"), [2.5, 2.75, 3.0, 3.25])
    assert base.layout.endswith("remarks from line 6 on left out")


@pytest.mark.parametrize("last", ["5", "5;x", "Mittel;2,9"])
def test_a_row_that_is_cut_off_or_wrong_is_no_remark(tmp_path: Path, last: str) -> None:
    base = _only(tmp_path / "a.csv", "\n".join([*TABLE, last]))
    with pytest.raises(UnusableInput, match=r"row 5|row 6"):
        base.read(["Nr", "Kraft"])


def test_remarks_below_the_table_of_a_sheet(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Versuch mit C45"], [], ["Fc [N]", "Nr", "Fc [N]"]]
    rows += [[900 + k, k, 700 + k] for k in range(8)]
    rows += [[], ["Werkzeug neu"], ["Kühlung aus"]]
    path = write_workbook(tmp_path / "a.xlsx", {"Kräfte": rows})
    (base,) = open_bases(path)
    assert base.columns == ("Fc [N]", "Nr", "Fc [N] (2)")
    assert_allclose(_numbers(base, "Fc [N] (2)"), 700.0 + np.arange(8))
    assert "remarks from row 12 on left out" in base.layout


def test_cells_between_quotes_may_go_over_lines(tmp_path: Path) -> None:
    rows = "".join(f'{k},"+{k}.5E+00\n","a ""b""\r\nc",{2 * k}\n' for k in range(50))
    base = _only(tmp_path / "a.csv", f"k,volts,said,twice\n{rows}")
    assert_allclose(_numbers(base, "volts"), np.arange(50) + 0.5)
    assert_allclose(_numbers(base, "twice"), 2.0 * np.arange(50))
    assert set(base.read([], ["said"])["said"].tolist()) == {'a "b" c'}


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ('{"calibration": [\n 1.5,\n 2.5,\n 3.5\n]}', "JSON"),
        ('[{"t": 0.5},\n{"t": 1.0}]', "JSON"),
        ('<?xml version="1.0"?>\n<trace>1,2</trace>', "XML"),
    ],
)
def test_json_and_xml_are_said_to_be_no_table(
    refused: Callable[..., str], text: str, kind: str
) -> None:
    Path("a.log").write_text(text)
    assert f"a.log: {kind}, not a table; export it as CSV" in refused("look", "a.log")


def test_lines_of_words_are_no_table(refused: Callable[..., str]) -> None:
    Path("a.txt").write_text("==7== tool, at work\n==7== one\n==7== two, three, four\n==7== five")
    assert "no table in it" in refused("look", "a.txt")


def test_a_column_without_a_name_keeps_its_first_number(tmp_path: Path) -> None:
    base = _only(tmp_path / "a.csv", "".join(f"{k}.25\n" for k in range(9)))
    assert base.columns == ("column 1",)
    assert_allclose(_numbers(base, "column 1"), np.arange(9) + 0.25)


def test_a_log_in_which_some_lines_look_like_rows_is_no_table(refused: Callable[..., str]) -> None:
    said = [
        f"2026-11-26T10:00:{k % 60:02}Z|mode|auto {k}|load|{'x' * (k % 9)}" for k in range(3000)
    ]
    Path("a.txt").write_text("\n".join([*said[:2900], *(f"{k}  {k + 1}  2" for k in range(9))] * 2))
    assert "no table in it" in refused("look", "a.txt")


def test_a_scope_that_numbers_its_channels_names_them_so(tmp_path: Path) -> None:
    rows = "".join(f"{k}E-06,{2.5 + k / 4},{k / 8}\n" for k in range(40))
    base = _only(tmp_path / "a.csv", f"x-axis,1,2\nsecond,Volt,Volt\n{rows}")
    assert base.columns == ("x-axis", "1", "2")
    assert_allclose(_numbers(base, "1"), 2.5 + np.arange(40) / 4)


def test_settings_above_the_rows_are_no_names(tmp_path: Path) -> None:
    rows = "".join(f"{k}E-07,{3340 + k}.000\n" for k in range(40))
    above = "#timebase=80000000(ps)\n,#voltbase=500000(uV)\n#size=40\n"
    base = _only(tmp_path / "a.csv", above + rows)
    assert base.columns == ("column 1", "column 2")
    assert_allclose(_numbers(base, "column 2"), 3340.0 + np.arange(40))


def test_a_waveform_export_of_yokogawa_is_read_by_its_header(tmp_path: Path) -> None:
    head = (
        '"Model","Xviewer"\n"BlockNumber","1"\n"TraceName","CH1","CH2",\nBlockSize,9,9,\n'
        "VUnit,V,A,\nHResolution,1.000000e-03,1.000000e-03,\nHOffset,-9,-9,\nHUnit,s,s,\n"
    )
    base = _only(tmp_path / "a.csv", head + "".join(f",{k}.,-{k}.5e-002\n" for k in range(9)))
    assert (base.columns, base.units) == (("t", "CH1", "CH2"), {"CH2": "A"})
    assert_allclose(_numbers(base, "t"), np.arange(9) * 1e-3)
    assert_allclose(_numbers(base, "CH2"), -(np.arange(9) + 0.5) / 100)
