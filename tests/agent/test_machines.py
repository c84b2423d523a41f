"""Machines and tools as data: files, what is stored of them, and how they change."""

from collections.abc import Callable
from pathlib import Path

import pytest
from numpy.testing import assert_allclose
from sqlalchemy import select
from sqlalchemy.orm.exc import StaleDataError

from autodb.agent.rows.machines import as_file
from autodb.errors import UnusableInput
from autodb.files.machine import LATHE, MachineFile, flat, read_machine_file
from autodb.files.tool import ISO_13399, geometry_of, read_tool
from autodb.store import models, open_store
from tests.conftest import Cli
from tests.helpers.remedies import has_remedy

URL = "sqlite:///autodb.sqlite3"
MILL = """\
dialect = "heidenhain"
units = "inch"
rotary_order = ["a", "c"]
[axes.x]
carries = "work"
carried_by = "y"
[axes.y]
carries = "work"
[axes.z]
vertical = "up"
brake = true
counterweight = "gas"
counterweight_force_N = 1800
limits = {force_N = 5000, travel_low_mm = 0, travel_high_mm = 400.5}
[axes.z.torque_constant_N_m_A]
value = 1.1
lower = 1.0
upper = 1.25
source = "data sheet"
[axes.a]
carries = "work"
carried_by = "x"
[axes.c]
carries = "work"
carried_by = "a"
[axes.spindle]
"""


def _stored(name: str) -> MachineFile:
    store = open_store(URL)
    with store.reading() as session:
        row = session.scalar(select(models.Machine).where(models.Machine.name == name))
        assert row is not None
        file = as_file(row)
    store.close()
    return file


@pytest.mark.parametrize("text", [MILL, "[axes.z]\n"])
def test_a_machine_comes_back_as_its_file_said(cli: Cli, text: str) -> None:
    Path("m.toml").write_text(text)
    cli("init")
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    assert _stored("m") == read_machine_file(Path("m.toml"))
    assert "already there" in cli("machine", "add", "m", "--file", "m.toml").out


def test_the_sample_machine_file_is_stored_whole(cli: Cli, sample_jobs: Path) -> None:
    path = sample_jobs / "stepped_shaft" / "machine.toml"
    cli("init")
    assert cli("machine", "add", "lathe-1", "--file", path).code == 0
    file = read_machine_file(path)
    assert _stored("lathe-1") == file
    shown = cli("machine", "show", "lathe-1").out
    for key, value in flat(file).items():
        assert key.endswith((".carries", ".current_sign")) or f"{key} = {value}" in shown


def test_an_update_says_what_changed_and_counts_the_version(cli: Cli) -> None:
    Path("m.toml").write_text(MILL)
    cli("init")
    cli("machine", "add", "m", "--file", "m.toml")
    changed = MILL.replace("value = 1.1", "value = 1.1000001").replace("400.5", "410")
    Path("m.toml").write_text(changed.replace("[axes.spindle]\n", ""))
    lines = cli("machine", "update", "m", "--file", "m.toml").out.splitlines()
    assert lines == [
        "machine 'm': 4 changes",
        "axes.z.limits.travel_high_mm: 400.5 → 410",
        "axes.z.torque_constant_N_m_A.value: 1.1 → 1.1000001",
        "axes.spindle.carries: tool → not stated",
        "axes.spindle.current_sign: 1 → not stated",
    ]
    assert _stored("m") == read_machine_file(Path("m.toml"))
    store = open_store(URL)
    with store.reading() as session:
        assert session.scalars(select(models.Machine.version)).all() == [2]
    store.close()
    assert "already there" in cli("machine", "update", "m", "--file", "m.toml").out


def test_a_writer_that_saw_an_older_machine_is_refused(cli: Cli) -> None:
    cli("init")
    cli("machine", "add", "m")
    store = open_store(URL)
    with store.reading() as session:
        seen = session.scalars(select(models.Machine)).one()
        session.expunge(seen)
    with store.writing() as session:
        session.scalars(select(models.Machine)).one().units = "mm"
    with pytest.raises(StaleDataError), store.writing() as session:
        seen.units = "inch"
        session.add(seen)
    store.close()


def test_what_was_learnt_from_keeps_its_axis_and_sign(
    cli: Cli, refused: Callable[..., str], sample_jobs: Path
) -> None:
    recordings = sample_jobs / "stepped_shaft" / "recordings"
    cli("init")
    cli("machine", "add", "m")
    cli("import", recordings / "standard-cuts.csv", "--machine", "m")
    cli("calibrate", "--machine", "m")
    Path("m.toml").write_text('[axes.x]\n[axes.spindle]\ncarries = "work"\n')
    line = refused("machine", "update", "m", "--file", "m.toml")
    assert "axis 'z' has calibrations (1) and cannot be removed" in line
    Path("m.toml").write_text("[axes.x]\n[axes.z]\ncurrent_sign = -1\n[axes.spindle]\n")
    line = refused("machine", "update", "m", "--file", "m.toml")
    assert "axes.z.current_sign cannot change after an import" in line
    assert _stored("m") == LATHE


BAD_MACHINES = [
    ('dialect = "fanuk"\n[axes.z]\n', "dialect"),
    ("[axes.zz]\n", "axes.zz: no axis has this name"),
    ('[axes.x]\ncarried_by = "q"\n', "axes.x.carried_by: no axis 'q'"),
    ('[axes.x]\ncarried_by = "z"\n[axes.z]\ncarried_by = "x"\n', "carry each other in a ring"),
    ('rotary_order = ["z"]\n[axes.z]\n', "'z' is no rotary axis"),
    ("[axes.z]\nlimits = {travel_low_mm = 9, travel_high_mm = 1}\n", "is not below"),
    ("[axes.z]\nlimits = {force = 9}\n", "axes.z.limits.force: unknown key (did you mean force_N"),
    ("[axes.z]\ntorque_constant_N_m_A = {value = 2, lower = 3}\n", "between lower and upper"),
    (
        "[axes.z]\n[[spindle.gear]]\nname = 'a'\nlow_rpm = 5\nhigh_rpm = 2\n",
        "is not below high_rpm",
    ),
    ("[axes.z]\nmoved_mass_kg = -3\n", "axes.z.moved_mass_kg"),
    ("[axes.z]\ncounterweight_force_N = 3\n", "needs a counterweight"),
    ("axes = 3\n", "axes"),
]


@pytest.mark.parametrize(("text", "says"), BAD_MACHINES)
def test_bad_machine_files_name_the_key(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "m.toml"
    path.write_text(text)
    with pytest.raises(UnusableInput, match=r"m\.toml: ") as error:
        read_machine_file(path)
    assert says in str(error.value)


def test_a_tool_reads_the_same_under_both_names(tmp_path: Path) -> None:
    own, iso = tmp_path / "own.toml", tmp_path / "iso.toml"
    head = 'name = "T1"\nkind = "end_mill"\n'
    own.write_text(
        f"{head}[geometry]\ndiameter_mm = 10\nteeth = 4\nhelix_deg = 30\ncorner_radius_mm = 0.5\n"
    )
    iso.write_text(f"{head}[iso13399]\nDC = 10\nZEFP = 4\nFHA = 30\nRE = 0.5\n")
    assert geometry_of(read_tool(own)) == geometry_of(read_tool(iso))
    insert = tmp_path / "insert.toml"
    insert.write_text('name = "T2"\nkind = "turning_insert"\n[iso13399]\nRE = 0.8\nKAPR = 93\n')
    found = geometry_of(read_tool(insert))
    assert_allclose([found.nose_radius_mm or 0, found.kappa_deg or 0], [0.8, 93.0])


BAD_TOOLS = [
    ('kind = "end_mill"\n', "name: is missing"),
    ('name = "a"\nkind = "saw"\n', "kind"),
    ('name = "a"\nkind = "drill"\n[iso13399]\nKAPR = 3\n', "iso13399.KAPR: no code of ours for"),
    (
        'name = "a"\nkind = "end_mill"\n[geometry]\ndiameter_mm = 8\n[iso13399]\nDC = 10\n',
        "iso13399.DC = 10 but geometry.diameter_mm = 8",
    ),
    ('name = "a"\nkind = "drill"\n[geometry]\nteeth = 0\n', "geometry.teeth"),
]


@pytest.mark.parametrize(("text", "says"), BAD_TOOLS)
def test_bad_tool_files_name_the_key(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "t.toml"
    path.write_text(text)
    with pytest.raises(UnusableInput, match=r"t\.toml: ") as error:
        read_tool(path)
    assert says in str(error.value)


def test_iso_codes_lead_to_fields_that_are_there() -> None:
    from autodb.files.tool import Geometry

    assert len({code.symbol for code in ISO_13399}) == len(ISO_13399)
    for code in ISO_13399:
        assert set(code.ours.values()) <= set(Geometry.model_fields)


def test_a_side_file_takes_its_tool_from_a_tool_file(
    cli: Cli, refused: Callable[..., str], sample_jobs: Path
) -> None:
    tool = sample_jobs / "stepped_shaft" / "tool.toml"
    Path("tool.toml").write_text(tool.read_text())
    Path("cuts.csv").write_text("cut,t,z.current,work.material,tool\n1,0,2,steel,carbide insert\n")
    cli("init")
    cli("machine", "add", "m")
    cli("import", "cuts.csv", "--machine", "m")
    assert _tool().nose_radius_mm is None
    Path("more.csv").write_text("cut,t,z.current\n2,0,2\n")
    Path("more.toml").write_text('[recording]\nwork = "steel"\n[tool]\nfile = "tool.toml"\n')
    assert cli("import", "more.csv", "--machine", "m").code == 0
    row = _tool()
    assert (row.kind, row.nose_radius_mm, row.kappa_deg, row.rake_deg) == (
        "turning_insert", 0.8, 93.0, -6.0,
    )  # fmt: skip
    Path("bad.csv").write_text("cut,t,z.current\n3,0,2\n")
    Path("bad.toml").write_text('[tool]\nfile = "tool.toml"\nkappa_deg = 75\n')
    line = refused("import", "bad.csv", "--machine", "m")
    assert "bad.toml: [tool] kappa_deg = 75.0, but tool.toml says 93.0" in line
    Path("bad.toml").write_text('[tool]\nfile = "none.toml"\n')
    assert "none.toml: no such file" in refused("import", "bad.csv", "--machine", "m")


def _tool() -> models.Tool:
    store = open_store(URL)
    with store.reading() as session:
        row = session.scalars(select(models.Tool)).one()
        session.expunge(row)
    store.close()
    return row


@pytest.mark.parametrize("name", ["two\nlines", "lathe ", "\x1b[2J"])
def test_names_that_cannot_be_read_back_are_refused(
    cli: Cli, refused: Callable[..., str], name: str
) -> None:
    cli("init")
    assert has_remedy(refused("machine", "add", name))


def test_a_machine_file_in_the_place_of_a_name_is_refused(
    cli: Cli, refused: Callable[..., str]
) -> None:
    cli("init")
    line = refused("machine", "add", "mill-2.toml")
    assert "autodb machine add mill-2 --file mill-2.toml" in line
    assert "mill-2" not in cli("machine", "list").out


def test_marks_of_the_terminal_are_printed_as_they_are(cli: Cli) -> None:
    cli("init")
    cli("machine", "add", "[red]lathe[/x]")
    assert "[red]lathe[/x]" in cli("machine", "list").out
    assert "[red]lathe[/x]" in cli("machine", "show", "[red]lathe[/x]").out


def test_a_file_with_a_byte_order_mark_reads(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    path.write_text("[axes.z]\n", encoding="utf-8-sig")
    assert list(read_machine_file(path).axes) == ["z"]


def test_a_code_beyond_its_kind_of_tool_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "t.toml"
    path.write_text('name = "d"\nkind = "drill"\n[iso13399]\nDC = 0\n')
    with pytest.raises(UnusableInput, match="DC: must be greater than 0, not"):
        read_tool(path)
