"""Data of tool catalogues are tools: ISO 13399 (.p21), its packages (.zip) and DIN 4000."""

import json
import math
import zipfile
from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.files.tool import geometry_of, read_tool
from tests.conftest import Cli

Values = tuple[tuple[str, str, str], ...]


def _p21(*values: tuple[str, str, str], name: str = "M 10", order: str = "4711") -> str:
    """Return an attribute file as catalogues write it, with values of symbol, unit, number."""
    units = {unit: 100 + k for k, unit in enumerate(sorted({unit for _, unit, _ in values}))}
    lines = [
        "ISO-10303-21;\nHEADER;\nFILE_SCHEMA (('CUTTING_TOOL_SCHEMA_ARM'));\nENDSEC;\nDATA;",
        "#1 = LANGUAGE ($, 'eng');",
        f"#2 = STRING_WITH_LANGUAGE ('{name}', #1);\n#3 = MULTI_LANGUAGE_STRING ((), #2);",
        f"#4 = ITEM ($, '{order}', #3);\n#5 = PLIB_PROPERTY_REFERENCE ('71CF29872F0AB', #9);",
        *(f"#{number} = UNIT ('{unit}');" for unit, number in units.items()),
        *(
            f"#{200 + k} = NUMERICAL_VALUE ('{symbol}', $, #{units[unit]}, '{number}');"
            for k, (symbol, unit, number) in enumerate(values)
        ),
        "#999 = STRING_VALUE ('GRADE', 'a;b, (c)''d');\nENDSEC;\nEND-ISO-10303-21;\n",
    ]
    return "\n".join(lines)


MILL = (("DC", "mm", "10"), ("APMX", "mm", "22"), ("ZEFF", "", "4"), ("FHA", "°", "36"))
DRILL = (("DC", "inch", "0.25"), ("NOF", "", "2"), ("SIG", "deg", "140"), ("FHA", "rad", "0.5"))
INSERT = (("RE", "mm", "0.794"), ("EPSR", "deg", "80"), ("S", "mm", "4.76"))
HOLDER = (("KAPR", "deg", "95"), ("LAMS", "deg", "-6"), ("GAMO", "deg", "-6"))
ROUTER = (("NSM", "DIN4000-82"), ("A1", "1,588"), ("F21", "4"), ("F4", "36"), ("J22", "H1"))
TWIST = (("NSM", "DIN4000-81"), ("A11", "10.5"), ("D1", "2"), ("D3", "30"), ("E1", "140"))


def _file(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def _package(path: Path, *members: tuple[str, str | bytes]) -> Path:
    with zipfile.ZipFile(path, "w") as package:
        for name, content in members:
            package.writestr(name, content)
    return path


def _refusal(path: Path) -> str:
    with pytest.raises(UnusableInput) as error:
        read_tool(path)
    assert str(error.value).startswith(f"{path}: ")
    return str(error.value)


def _assert_says(path: Path, name: str, kind: str, expected: dict[str, float]) -> None:
    tool = read_tool(path)
    assert (tool.name, tool.kind) == (name, kind)
    geometry = geometry_of(tool).model_dump(exclude_none=True)
    assert set(geometry) == set(expected)
    assert_allclose([geometry[key] for key in expected], list(expected.values()))


@pytest.mark.parametrize(
    ("values", "kind", "expected"),
    [
        (MILL, "end_mill", {"diameter_mm": 10.0, "teeth": 4, "helix_deg": 36.0}),
        (
            (*MILL, ("ZEFP", "", "3"), ("RE", "mm", "0,5")),
            "end_mill",
            {"diameter_mm": 10.0, "teeth": 3, "helix_deg": 36.0, "corner_radius_mm": 0.5},
        ),
        (
            DRILL,
            "drill",
            {
                "diameter_mm": 6.35,
                "teeth": 2,
                "point_angle_deg": 140.0,
                "helix_deg": math.degrees(0.5),
            },
        ),
    ],
)
def test_an_attribute_file_says_what_a_tool_file_would(
    tmp_path: Path, values: Values, kind: str, expected: dict[str, float]
) -> None:
    path = _file(tmp_path / "a.p21", _p21(*values))
    _assert_says(path, "M 10", kind, expected)
    assert read_tool(path, "T12").name == "T12"  # what the shop calls it


def test_an_insert_and_its_holder_in_a_package_are_one_tool(tmp_path: Path) -> None:
    holder = _package(tmp_path / "holder.zip", ("holder.p21", _p21(*HOLDER, name="PCLNR")))
    package = _package(
        tmp_path / "assembly.zip",
        ("product_data_files/insert.p21", _p21(*INSERT, name="CNMG")),
        ("holder.zip", holder.read_bytes()),
        ("product_3d_models_basic/insert.stp", "not read"),
    )
    # the normal rake of an orthogonal one: tan gamma_n = tan gamma_o cos lambda_s
    rake = math.degrees(math.atan(math.tan(math.radians(-6.0)) * math.cos(math.radians(6.0))))
    stated = {"nose_radius_mm": 0.794, "included_deg": 80.0, "kappa_deg": 95.0}
    expected = {**stated, "inclination_deg": -6.0, "rake_deg": rake}
    _assert_says(package, "CNMG / PCLNR", "turning_insert", expected)


def test_a_name_beyond_ascii_is_read(tmp_path: Path) -> None:
    path = _file(tmp_path / "a.p21", _p21(*MILL, name=r"Schaftfr\X2\00E4\X0\ser 10''"))
    assert read_tool(path).name == "Schaftfräser 10'"


def _xml(*properties: tuple[str, str]) -> str:
    said = "".join(
        f"<Property-Data><PropertyName source='din_mk'>{code}</PropertyName>"
        f"<Value>{value}</Value></Property-Data>"
        for code, value in properties
    )
    return f"<Tool><Properties>{said}</Properties></Tool>"


@pytest.mark.parametrize(
    ("properties", "kind", "expected"),
    [
        ((*ROUTER, ("BLD", "2")), "end_mill", {"diameter_mm": 1.588, "teeth": 4, "helix_deg": 36}),
        (
            (*ROUTER, ("BLD", "6")),
            "end_mill",
            {"diameter_mm": 1.588, "teeth": 4, "helix_deg": 36, "corner_radius_mm": 0.794},
        ),
        (
            (*TWIST, ("BLD", "1"), ("J22", "H1")),
            "drill",
            {"diameter_mm": 10.5, "teeth": 2, "helix_deg": 30, "point_angle_deg": 140},
        ),
    ],
)
def test_a_table_says_the_same_as_xml_and_as_csv(
    tmp_path: Path, properties: tuple[tuple[str, str], ...], kind: str, expected: dict[str, float]
) -> None:
    xml = f'<?xml version="1.0"?><Tool-Data>{_xml(*properties)}</Tool-Data>'
    lines = (";".join(code for code, _ in properties), ";".join(value for _, value in properties))
    _assert_says(_file(tmp_path / "a.xml", xml), "H1", kind, expected)
    _assert_says(_file(tmp_path / "a.csv", "\n".join(lines) + ";\n"), "H1", kind, expected)


def test_of_several_tools_one_is_named(tmp_path: Path) -> None:
    both = _xml(*ROUTER, ("BLD", "1")) + _xml(*TWIST, ("BLD", "1"), ("J22", "D1"))
    path = _file(tmp_path / "a.xml", f"<Tool-Data>{both}</Tool-Data>")
    assert read_tool(path, "D1").kind == "drill"
    assert "has 2 tools; name one of them: H1, D1" in _refusal(path)


BAD = [
    ("a.p21", "solid cube", "is no attribute file of ISO 13399"),
    ("a.p21", _p21(*MILL)[:300], "ends before its end"),
    ("a.p21", _p21(("OAL", "mm", "63")), "what is needed of an end mill (DC, ZEFP)"),
    ("a.p21", _p21(*MILL, ("DC", "mm", "12")), "says DC twice, 10 and 12; use data of one tool"),
    ("a.p21", _p21(("DC", "ell", "1"), ("ZEFP", "", "2")), "DC = '1' ell is no quantity"),
    ("a.p21", _p21(("DC", "mm", "wide"), ("ZEFP", "", "2")), "DC = 'wide' mm is no quantity"),
    ("a.p21", _p21(("DC", "mm", "10"), ("ZEFP", "", "2.5")), "geometry.teeth"),
    ("a.zip", b"PK\x03\x04 cut short", "is no whole package"),
    ("a.xml", "<Tool-Data>", "is no XML"),
    ("a.xml", "<Tool-Data/>", "has no properties of DIN 4000"),
    ("a.csv", "t,x.position\n0,1\n", "has no properties of DIN 4000"),
    ("a.csv", "NSM;BLD;A1\nDIN4000-76;1;12\n", "NSM DIN4000-76, BLD 1: no end mill or drill"),
    ("a.csv", "NSM;BLD;A1\nDIN4000-82;1;M10\n", "A1 = 'M10' is no number"),
]


@pytest.mark.parametrize(("name", "content", "says"), BAD)
def test_data_of_no_tool_are_refused(
    tmp_path: Path, name: str, content: str | bytes, says: str
) -> None:
    assert says in _refusal(_file(tmp_path / name, content))


def test_a_package_is_whole_and_has_attribute_files(tmp_path: Path) -> None:
    models = _package(tmp_path / "models.zip", ("model.stp", "ISO-10303-21;"))
    assert "has no attribute file (.p21)" in _refusal(models)
    whole = _package(tmp_path / "whole.zip", ("a.p21", _p21(*MILL))).read_bytes()
    for end in range(0, len(whole), 97):
        _refusal(_file(tmp_path / "a.zip", whole[:end]))
    for at in range(0, len(whole), 7):
        broken = whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :]
        path = _file(tmp_path / "a.zip", broken)
        try:
            assert geometry_of(read_tool(path)).model_dump(exclude_none=True)
        except UnusableInput as error:
            assert str(error).startswith(f"{path}: ")


def test_a_folder_is_no_tool_file(tmp_path: Path) -> None:
    assert "is a folder; give a file in it" in _refusal(tmp_path)


def test_a_package_larger_than_memory_is_refused(tmp_path: Path) -> None:
    with (
        zipfile.ZipFile(tmp_path / "a.zip", "w", zipfile.ZIP_DEFLATED) as package,
        package.open("a.p21", "w") as member,
    ):
        for _ in range(33):
            member.write(bytes(1 << 20))
    assert "have more than 32 MB" in _refusal(tmp_path / "a.zip")


def test_look_ups_take_a_catalogues_data(tmp_path: Path, cli: Cli) -> None:
    path = _file(tmp_path / "mill.p21", _p21(*MILL))
    for asked in (("init",), ("machine", "add", "m")):
        assert cli(*asked).code == 0
    slot = ("--operation", "slot", "--depth", 2, "--feed", 0.05, "--rpm", 3000)
    named = ("lookup", "--material", "C45", *slot, "--tool-file", path, "--json")
    assert json.loads(cli(*named).out)["tool"] == "M 10"
    assert json.loads(cli(*named, "--tool", "T12").out)["tool"] == "T12"
