"""Columns of unknown files are known by what they do; the side file that is proposed reads them."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.readers import open_bases
from autodb.records import source as records
from autodb.records.proposed.columns import propose_channels
from autodb.records.proposed.names import said_by
from autodb.records.proposed.written import side_file_of
from autodb.records.tables import Recording
from tests.conftest import SHARED, Cli
from tests.helpers.files import write

RATE_HZ = 500.0
T = np.arange(6000) / RATE_HZ
RNG = np.random.default_rng(39)


def _axis(frequencies_hz: tuple[float, ...], amplitude_mm: float) -> dict[str, np.ndarray]:
    """Return position, velocity and current of an axis with inertia and friction."""
    phases = [2.0 * np.pi * f * T for f in frequencies_hz]
    x = amplitude_mm * np.sum([np.sin(p + 0.4 * k) for k, p in enumerate(phases)], axis=0)
    v = np.gradient(x, T)
    i = 0.001 * np.gradient(v, T) + 0.01 * v + 1.2 * np.tanh(v / 0.5) + 0.3
    return {"place": x, "rate": v, "effort": i + 0.1 * RNG.normal(size=len(T))}


ONE, OTHER = _axis((0.31, 0.74), 40.0), _axis((0.23, 0.55), 25.0)


def _channels(path: Path) -> dict[str, tuple[str, str]]:
    (base,) = open_bases(path)
    return {one.channel: (one.column, one.unit) for one in propose_channels(base).proposals}


def test_names_say_quantity_and_axis() -> None:
    says = {
        "X1_ActualPosition": ("position", "x"),
        "Strom Z [mA]": ("current", "z"),
        "vitesse broche": ("velocity", "spindle"),
        "I_Y": ("current", "y"),
        "Fx (kN)": ("force", "x"),
        "S1_CurrentFeedback": ("current", "spindle"),
        "Drehmoment C": ("torque", "c"),
        "remarks": ("", ""),
    }
    found = {name: (said_by(name).quantity, said_by(name).axis) for name in says}
    assert found == says
    assert said_by("X1_CommandVelocity").commanded
    assert said_by("AccX (g)").foreign
    assert not said_by("AccX (m/s²)").foreign


def test_columns_without_names_are_known_by_their_physics(tmp_path: Path) -> None:
    """Two axes, velocities in mm/min, and a ripple of one frequency that follows no axis."""
    ripple = 200.0 * np.sin(2.0 * np.pi * 31.0 * T) + RNG.normal(size=len(T))
    columns = [T, OTHER["effort"], ONE["place"], 60.0 * OTHER["rate"], ripple]
    columns += [60.0 * ONE["rate"], OTHER["place"], ONE["effort"]]
    path = tmp_path / "a.txt"
    np.savetxt(path, np.column_stack(columns), fmt="%.6f", delimiter="\t")
    found = _channels(path)
    assert found["t"] == ("column 1", "")
    first, second = found["x.position"][0], found["y.position"][0]
    assert {first, second} == {"column 3", "column 7"}
    belongs = {"column 3": ("column 6", "column 8"), "column 7": ("column 4", "column 2")}
    for axis, place in (("x", first), ("y", second)):
        rate, effort = belongs[place]
        assert found[f"{axis}.velocity"] == (rate, "mm/min")
        assert found[f"{axis}.current"] == (effort, "")
    assert "column 5" not in [column for column, _ in found.values()]


def test_stamps_rounded_to_milliseconds_have_the_rate_of_all_of_them(tmp_path: Path) -> None:
    """At 400 Hz steps are 2 and 3 ms in turn."""
    t_s = np.round(np.arange(800) / 400.0, 3)
    (base,) = open_bases(write(tmp_path / "ms.csv", {"t": t_s, "x.position": np.sin(t_s)}))
    (time,) = [one for one in propose_channels(base).proposals if one.channel == "t"]
    assert time.because.endswith(": 400 Hz")


def test_two_ripples_of_one_frequency_are_no_axis(tmp_path: Path) -> None:
    """A force's derivative explains any other force of its frequency; no friction shows."""
    names = {
        name: np.sin(2.0 * np.pi * 2.0 * T + phase) + 0.01 * RNG.normal(size=len(T))
        for name, phase in (("a", 0.0), ("b", 0.7), ("c", 1.9))
    }
    assert _channels(write(tmp_path / "a.csv", {"time": T, **names})) == {"t": ("time", "")}


def test_names_decide_where_they_do(tmp_path: Path) -> None:
    path = write(
        tmp_path / "a.csv",
        {
            "Zeit_ms": 1000.0 * T,
            "Istposition Z": ONE["place"],
            "Sollposition Z": ONE["place"] + 0.01,
            "Strom Z": ONE["effort"],
            "Strom Spindel": 10.0 + OTHER["effort"],
        },
    )
    assert _channels(path) == {
        "t": ("Zeit_ms", "ms"),
        "z.position": ("Istposition Z", ""),
        "z.current": ("Strom Z", ""),
        "spindle.current": ("Strom Spindel", ""),
    }


def test_units_stand_behind_names_as_din_has_them(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = "".join(
        f"{k / 1000};{200 + k % 7};{k % 5};{80 + k % 3}\n".replace(".", ",") for k in range(99)
    )
    path.write_text(f"Zeit / ms;Schnittkraft / kN;Vorschubkraft in N;Passivkraft [daN]\n{rows}")
    assert _channels(path) == {
        "t": ("Zeit / ms", "ms"),
        "force.y": ("Schnittkraft / kN", "kN"),
        "force.z": ("Vorschubkraft in N", "N"),
        "force.x": ("Passivkraft [daN]", "daN"),
    }


def test_velocities_tell_the_time_of_a_row(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"PosX": ONE["place"], "VelX": ONE["rate"]})
    found = _channels(path)
    assert found["t"][0] == "*"
    assert float(found["t"][1]) == pytest.approx(1.0 / RATE_HZ, rel=0.01)


def test_the_proposed_side_file_reads_the_file(cli: Cli, tmp_path: Path) -> None:
    path = write(
        tmp_path / "a.csv",
        {"k": T, "p": ONE["place"], "q": 60.0 * ONE["rate"], "r": ONE["effort"]},
    )
    (answer,) = json.loads(cli("look", path, "--json").out)
    assert (answer["rows"], answer["columns"]) == (len(T), ["k", "p", "q", "r"])
    reasons = {one["channel"]: one["because"] for one in answer["channels"]}
    assert "correlation 1.000" in reasons["x.velocity"]
    done = cli("look", path, "--write")
    assert done.code == 0
    assert "correlation 1.000" in done.out
    assert "missing for calibrate" in done.out
    table = records.read(path)
    assert isinstance(table, Recording)
    assert_allclose(table["x.velocity"], ONE["rate"], atol=1e-6)
    assert_allclose(table["x.current"], ONE["effort"], atol=1e-6)
    again = cli("look", path, "--write")
    assert (again.code, again.err.count("\n")) == (2, 1)
    assert "is there already" in again.err


CUTS = "Nr;Bearbeitung;Werkstoff;Werkzeug;Vorschub;Tiefe;I_Z;I_Z_Luft;Fc;Ff\n" + "\n".join(
    f"{n};Längsdrehen;C45;CNMG;0,{n}5;2,0;{1000 + 90 * n};901,5;0,{n}9;0,4{n}" for n in range(1, 9)
)


def test_a_table_of_cuts_and_its_units(cli: Cli, tmp_path: Path) -> None:
    """Forces are in kN because chips take hundreds to thousands of N/mm²; currents in mA."""
    path = tmp_path / "a.csv"
    path.write_text(CUTS, "utf-8")
    (base,) = open_bases(path)
    found = propose_channels(base)
    assert found.holds_cuts
    assert {p.channel: p.unit for p in found.proposals if p.unit} == {
        "force.y": "kN",
        "force.z": "kN",
        "z.current.range": "mA",
        "z.current.air": "mA",
    }
    assert found.operations == ("Längsdrehen",)
    assert 'operation = {"Längsdrehen" = "turn"}' in side_file_of([found], path.name)
    assert cli("look", path, "--write").code == 0
    assert cli("import", path).code == 0
    assert records.read(path).texts["operation"] == ["turn"] * 8


def test_a_german_table_says_its_operation_and_its_diameter(cli: Cli, tmp_path: Path) -> None:
    """The one by its words, the other by its sign; the next command can be copied."""
    path = tmp_path / "Versuche März.csv"
    path.write_text(
        "Nr.;Art;Werkstoff;Werkzeug;Ø [mm];vc [m/min];f [mm/U];ap [mm];Fc [N]\n"
        "1;Längsdrehen;C45;CNMG 120408;60;100;0,1;1,5;320\n"
        "2;Plandrehen;C45;CNMG 120408;60;100;0,2;1,5;590\n",
        "utf-8",
    )
    done = cli("look", path, "--write").out
    assert "missing for what is not turned" not in done
    assert "autodb import 'Versuche März.csv'" in done
    assert cli("import", path).code == 0
    read = records.read(path)
    assert read.texts["operation"] == ["turn", "face"]
    assert read.channels["work.diameter"].tolist() == [60.0, 60.0]


@pytest.mark.skipif(
    not (SHARED / "data" / "emps").is_dir(), reason="the public recording is not there"
)
def test_a_real_axis_without_names() -> None:
    """EMPS (Janot, Gautier, Brunot 2019): qm is the measured position, vir the motor's voltage."""
    base = next(
        base
        for base in open_bases(SHARED / "data" / "emps" / "DATA_EMPS.mat")
        if "qm" in base.columns
    )
    found = {one.channel: one.column for one in propose_channels(base).proposals}
    assert (found["t"], found["x.position"], found["x.current"]) == ("t", "qm", "vir")


def test_a_folder_is_refused(refused: Callable[..., str]) -> None:
    for folder in (".", "there"):
        Path("there").mkdir(exist_ok=True)
        assert f"{folder}: is a folder; give one recording file" in refused("look", folder)


@pytest.mark.parametrize("end", ["", "\n"])
def test_the_last_row_counts_with_or_without_the_end_of_its_line(tmp_path: Path, end: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t;x.current\n0;1,5\n1;2,5\n2;3,5" + end)
    (base,) = open_bases(path)
    (block,) = base.blocks(base.columns, ())
    assert block["x.current"].tolist() == [1.5, 2.5, 3.5]
    assert propose_channels(base).rows == 3


def test_a_file_of_which_a_part_is_looked_at_says_so(tmp_path: Path, cli: Cli) -> None:
    path = tmp_path / "long.csv"
    path.write_text("t,x.current\n" + "0.001,1.23456789\n" * 1_000_100)
    said = cli("look", path).out
    assert said.startswith("long.csv: the first ")
    assert 900_000 < int(said.split()[3]) < 1_000_100
