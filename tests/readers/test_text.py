"""Text tables as loggers write them: what is detected is what was written, and is said."""

import codecs
import gzip
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.readers import ColumnSet, open_bases
from autodb.records import source as records
from autodb.records.tables import CutTable
from tests.conftest import SHARED

LOGS = SHARED / "failures" / "logs"
T = np.round(np.arange(30) * 0.5, 3)
F = np.round(1234.5 * np.cos(T), 2)
NAMES = ("t", "force.x", "x.position")


def _rows(separator: str, decimal: str = ".", end: str = "\n") -> str:
    lines = [
        separator.join(f"{v}" for v in row).replace(".", decimal)
        for row in zip(T, F, np.arange(30), strict=True)
    ]
    return end.join(lines) + end


def _read(path: Path) -> ColumnSet:
    (base,) = open_bases(path)
    return base


def _check(path: Path, said: str, force: np.ndarray = F) -> None:
    """Check what was read against what was written, and what is said of the layout."""
    base = _read(path)
    assert base.layout == said
    assert base.columns == NAMES
    found = base.read(list(NAMES))
    assert_allclose(np.asarray(found["t"], dtype=float), T, rtol=1e-12)
    assert_allclose(np.asarray(found["force.x"], dtype=float), force, rtol=1e-12)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize(
    ("separator", "decimal", "said"),
    [
        (",", ".", ""),
        (";", ".", "semicolons between columns"),
        (";", ",", "semicolons between columns, decimal commas"),
        ("\t", ",", "tabs between columns, decimal commas"),
        ("|", ".", "bars between columns"),
        ("   ", ".", "spaces between columns"),
    ],
)
def test_separators_and_decimal_marks(
    tmp_path: Path, separator: str, decimal: str, said: str, end: str
) -> None:
    path = tmp_path / "a.txt"
    text = separator.join(NAMES) + end + _rows(separator, decimal, end)
    path.write_bytes(text.encode())
    _check(path, said)


@pytest.mark.parametrize(
    ("encoding", "mark", "said"),
    [
        ("utf-8", codecs.BOM_UTF8, ""),
        ("utf-16-le", codecs.BOM_UTF16_LE, "utf-16-le"),
        ("utf-16-be", codecs.BOM_UTF16_BE, "utf-16-be"),
        ("utf-16-le", b"", "utf-16-le"),
    ],
)
def test_encodings(tmp_path: Path, encoding: str, mark: bytes, said: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(mark + (",".join(NAMES) + "\n" + _rows(",")).encode(encoding))
    _check(path, said)


def test_names_of_western_europe_are_read_in_its_encoding(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes("t;Länge [mm];Maß\n0;1;2\n1;2;3\n2;3;4\n".encode("cp1252"))
    base = _read(path)
    assert base.columns == ("t", "Länge [mm]", "Maß")
    assert base.units == {"Länge [mm]": "mm"}
    assert base.layout == "semicolons between columns, cp1252"


ABOVE = [
    ("sep=;\nt;force.x;x.position\n", "line 2 names the columns"),
    ("Lathe 4\n\nt;force.x;x.position\n", "line 3 names the columns"),
    ("Machine;lathe 4\nOperator;\nt;force.x;x.position\n", "line 3 names the columns"),
    ("t;force.x;x.position;\n", ""),
    ("t;force.x;x.position\ns;kN;mm\n", "line 2 has units"),
    ("t;force.x;x.position\n[s];[kN];[mm]\n\n", "line 2 has units"),
    ("# t;force.x;x.position\n", ""),
    ("# lathe 4\n# t;force.x;x.position\n", "line 2 names the columns"),
]


@pytest.mark.parametrize(("above", "said"), ABOVE)
def test_lines_above_the_rows(tmp_path: Path, above: str, said: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(above + _rows(";", ","))
    expected = ["semicolons between columns", "decimal commas", *([said] if said else [])]
    _check(path, ", ".join(expected))
    if "units" in said:
        assert _read(path).units == {"t": "s", "force.x": "kN", "x.position": "mm"}
        assert_allclose(records.read(path)["force.x"], 1000.0 * F, rtol=1e-12)


def test_a_scale_without_a_unit_goes_from_the_number_to_our_unit(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,F [kN]\n0,1\n1,2\n2,3\n")
    side = tmp_path / "a.toml"
    for spec, factor in (("scale = 10", 10.0), ("sign = -1", -1000.0), ('unit = "N"', 1.0)):
        side.write_text(f'[channels]\n"force.x" = {{column = "F [kN]", {spec}}}\n')
        assert_allclose(records.read(path)["force.x"], factor * np.array([1.0, 2.0, 3.0]))


@pytest.mark.parametrize(
    ("separator", "decimal", "thousands"), [(";", ",", "."), (";", ".", "'"), ("\t", ".", ",")]
)
def test_thousands(tmp_path: Path, separator: str, decimal: str, thousands: str) -> None:
    def written(value: float) -> str:
        return f"{value:,.2f}".replace(",", "_").replace(".", decimal).replace("_", thousands)

    force = 1000.0 * F
    lines = [
        separator.join([written(t), written(f), "26.11.2026"])
        for t, f in zip(T, force, strict=True)
    ]
    path = tmp_path / "a.csv"
    path.write_text(separator.join(("t", "force.x", "day")) + "\n" + "\n".join(lines))
    base = _read(path)
    assert f"'{thousands}' between thousands" in base.layout
    assert_allclose(np.asarray(base.read(["force.x"])["force.x"], dtype=float), force, rtol=1e-12)
    assert base.read([], ["day"])["day"][0] == "26.11.2026"


def test_lines_that_are_no_rows_are_left_out_of_every_column(tmp_path: Path) -> None:
    """As halsampler writes them, beyond the lines that the layout is detected from too."""
    rows = [f"{i},{i}" for i in range(20_000)]
    rows[12_000] = "overrun,"
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["tag,x.position", *rows]))
    base = _read(path)
    for name in ("tag", "x.position"):
        assert len(base.read([name])[name]) == 19_999


def test_a_first_line_of_numbers_is_a_row(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(_rows(","))
    base = _read(path)
    assert base.columns == ("column 1", "column 2", "column 3")
    assert base.layout == "line 1 is the first row, columns are called by their place"
    assert_allclose(np.asarray(base.read(["column 2"])["column 2"], dtype=float), F)
    (tmp_path / "a.toml").write_text('[csv]\nnames = ["t", "force.x", "x.position"]\n')
    assert_allclose(records.read(path)["force.x"], F)


def test_what_is_stated_holds(tmp_path: Path) -> None:
    """A line of numbers above the rows, and commas that are not decimal ones."""
    path = tmp_path / "a.csv"
    path.write_text("1;2;3\nt;force.x;x.position\n" + _rows(";"))
    (tmp_path / "a.toml").write_text("[csv]\nheader_line = 2\n")
    assert_allclose(records.read(path)["force.x"], F)
    path.write_text("t;x.position\n0;1,234\n1;2,345\n2;3,456\n")
    (tmp_path / "a.toml").write_text('[csv]\nthousands = ","\n')
    assert records.read(path)["x.position"].tolist() == [1234.0, 2345.0, 3456.0]


def test_bases_with_stamps_of_their_own(tmp_path: Path) -> None:
    """Pairs of columns, the shorter ones empty at the end; those with the same stamps are one."""
    lines = ["t,x.position,t,x.current,t,z.current"]
    for row in range(30):
        slow = f"{2 * T[row]},{row}" if row < 15 else ","
        lines.append(f"{T[row]},{row},{T[row]},{-row},{slow}")
    path = tmp_path / "a.csv"
    path.write_text("\n".join(lines))
    fast, slow_base = open_bases(path)
    assert (fast.name, fast.columns) == ("x.position", ("t", "x.position", "x.current"))
    assert (slow_base.name, slow_base.columns) == ("z.current", ("t", "z.current"))
    assert [len(base.read(["t"])["t"]) for base in (fast, slow_base)] == [30, 15]


def test_an_archive_of_several_files_is_refused(tmp_path: Path) -> None:
    import zipfile

    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.csv", "t,x.position\n")
        archive.writestr("b.csv", "t,x.position\n")
    with pytest.raises(UnusableInput, match="2 files in it; unpack it"):
        open_bases(path)


LVM = """\
LabVIEW Measurement\t
Writer_Version\t2
Separator\tTab
Decimal_Separator\t,
***End_of_Header***\t

Channels\t2\t\t
Y_Unit_Label\tNewtons\tm/s^2\t
X_Dimension\tTime\tTime\t
X0\t0,0E+0\t0,0E+0\t
Delta_X\t1,000000E-3\t1,000000E-3\t
***End_of_Header***\t\t\t
X_Value\tForce\tShake\tComment
\t0,25\t1,5
\t0,5\t2,5
\t0,75\t3,5\tlast
"""


def test_labview_measurements(tmp_path: Path) -> None:
    path = tmp_path / "a.lvm"
    path.write_text(LVM)
    (tmp_path / "a.toml").write_text('[channels]\n"force.x" = "Force"\n')
    table = records.read(path)
    assert_allclose(table["t"], [0.0, 0.001, 0.002], rtol=1e-12)
    assert table["force.x"].tolist() == [0.25, 0.5, 0.75]


SCOPE = """\
Name;drives
File;drives.csv
Starttime of export;132959733843760000

Name;I_X;Name;T_oil
SymbolComment;;SymbolComment;
Unit;mA (Current);Unit;(None)

0;100;0;20
0.5;110;;
1;120;1;21
EOF
"""


def test_twincat_scope(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(SCOPE)
    (tmp_path / "a.toml").write_text('[channels]\n"x.current" = "I_X"\n')
    table = records.read(path)
    assert_allclose(table["t"], [0.0, 0.0005, 0.001], rtol=1e-12)
    assert_allclose(table["x.current"], [0.1, 0.11, 0.12], rtol=1e-12)


@pytest.mark.skipif(not LOGS.is_dir(), reason="the shared failures are not there")
def test_a_german_table_of_cuts(tmp_path: Path) -> None:
    path = tmp_path / "german.csv"
    path.write_bytes((LOGS / "german.csv").read_bytes())
    (tmp_path / "german.toml").write_bytes((LOGS / "t3.toml").read_bytes())
    table = records.read(path)
    assert isinstance(table, CutTable)
    assert_allclose(table["cutting.feed"][:3], [0.32, 0.18, 0.25])
    assert_allclose(table["force.y"][:3], [1427.5, 986.7, 784.9])


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (gzip.compress(b"t,x.current\n0,1\n" * 100, mtime=0), "packed by gzip, not text; rename"),
        (b"\x89HDF\r\n\x1a\n\x81" + bytes(99), r"HDF5, not text; rename it to end in \.h5"),
        (np.linspace(-9.0, 9.0, 500).astype("<f4").tobytes(), "not text in any encoding; export"),
        (b"t;Gr\xf6\xdfe\n0;\x81\n", 'not text in cp1252.*state encoding = "…"'),
    ],
)
def test_bytes_of_another_format_are_called_so(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(content)
    with pytest.raises(UnusableInput, match=rf"a\.csv: {said}"):
        records.open_source(path)
