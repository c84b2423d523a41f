"""Columns with a quantity and no axis, times without a name, and what only looks like a slope."""

from pathlib import Path

import numpy as np
import pytest

from autodb.readers import open_bases
from autodb.records.proposed.columns import propose_channels
from autodb.records.proposed.cut_names import of_a_cut
from autodb.records.proposed.names import said_by
from tests.conftest import Cli
from tests.helpers.files import write

T = np.arange(600) / 50.0
RNG = np.random.default_rng(3902)


def _channels(path: Path) -> dict[str, tuple[str, str]]:
    (base,) = open_bases(path)
    return {one.channel: (one.column, one.unit) for one in propose_channels(base).proposals}


def test_a_letter_behind_a_low_line_is_a_unit_unless_there_are_axes() -> None:
    for name, unit in (
        ("current_a", "A"),
        ("power_w", "W"),
        ("temp_c", "degC"),
        ("torque_nm", "N*m"),
    ):
        assert (said_by(name).axis, said_by(name).unit) == ("", unit)
    assert said_by("current_a", ("current_x", "current_a")).axis == "a"
    assert said_by("Strom A").axis == said_by("A_current").axis == "a"
    assert said_by("thrust_raw").foreign
    assert (said_by("F [kN]").quantity, said_by("f").quantity) == ("force", "")


def test_a_motor_that_turns_is_a_spindle(cli: Cli, tmp_path: Path) -> None:
    """Its speed is in revolutions; wanted ones and raw ones are left."""
    speed = 1200.0 + 100.0 * np.sin(T)
    path = write(
        tmp_path / "a.csv",
        {
            "time [s]": T,
            "speed setpoint [RPM]": speed,
            "speed measured [RPM]": speed + RNG.normal(size=len(T)),
            "motor current [mA]": 900.0 + 40.0 * RNG.normal(size=len(T)),
            "torque_raw": 1000.0 * RNG.normal(size=len(T)),
            "thrust (gf)": 5.0 + RNG.normal(size=len(T)),
        },
    )
    assert _channels(path) == {
        "t": ("time [s]", "s"),
        "force.z": ("thrust (gf)", "gf"),
        "spindle.speed": ("speed measured [RPM]", "RPM"),
        "spindle.current": ("motor current [mA]", "mA"),
    }
    assert cli("look", path, "--write").code == 0
    assert cli("import", path).code == 0


def test_of_two_currents_and_speeds_without_units_nothing_is_said(tmp_path: Path) -> None:
    columns = {name: RNG.normal(size=len(T)) for name in ("current 1", "current 2", "velocity")}
    assert _channels(write(tmp_path / "a.csv", {"time": T, **columns})) == {"t": ("time", "")}
    columns = {"current": RNG.normal(size=len(T)), "velocity": RNG.normal(size=len(T))}
    assert _channels(write(tmp_path / "b.csv", {"time": T, **columns})) == {
        "t": ("time", ""),
        "x.current": ("current", ""),
    }


def test_what_hardly_changes_is_no_slope(tmp_path: Path) -> None:
    """Of stamps that scatter, beside a reading that drifts: a time, and nothing else."""
    uneven = np.cumsum(RNG.choice([0.01, 0.05], size=600))
    path = tmp_path / "a.txt"
    np.savetxt(path, np.column_stack([uneven, -1.8 + 1e-4 * RNG.normal(size=600)]), fmt="%.6f")
    assert _channels(path) == {"t": ("column 1", "")}


def test_a_row_takes_no_seconds(tmp_path: Path) -> None:
    """Rows three seconds apart are no recording of a drive: the velocity is in another unit."""
    place = 40.0 * np.sin(0.7 * T)
    path = write(tmp_path / "a.csv", {"Pos X": place, "Vel X": np.gradient(place) / 3.0})
    assert "t" not in _channels(path)


def test_numbers_beyond_any_measurement_are_no_channel(tmp_path: Path) -> None:
    place = 40.0 * np.sin(T)
    place[7] = 1e300
    path = write(tmp_path / "a.csv", {"time": T, "Pos X": place, "Vel X": 40.0 * np.cos(T)})
    assert set(_channels(path)) == {"t", "x.velocity"}


@pytest.mark.parametrize(
    ("names", "channel"),
    [
        (
            "Feed (mm/rev)|feed_mm_per_rev|Vorschub f [mm/U]|Avance (mm/tr)|Feed rate",
            "cutting.feed",
        ),
        ("Depth of cut (mm)|ap_mm|Schnitttiefe ap [mm]|Profondeur de passe", "cutting.depth"),
        ("Cutting speed Vc (m/min)|Velocidad de corte|speed (m/min)", "cutting.speed"),
        ("n [U/min]|Speed (RPM)|Drehzahl n", "spindle.speed"),
        ("Feed force (N)|Fz_N|Vorschubkraft|Axial force", "force.z"),
        ("Schnittkraft Fc [N]|Forza di taglio|Fy (kN)|Force Y", "force.y"),
        ("Lfd. Nr.|Exp. No|S.No|run", "cut"),
        ("Tool wear|Tool life (min)|Material removal rate|speed|feed_mm_min|Thrust force", ""),
    ],
)
def test_columns_of_cuts_in_five_languages(names: str, channel: str) -> None:
    assert {of_a_cut(name) for name in names.split("|")} == {channel}


def test_a_unit_of_another_kind_is_no_channel(tmp_path: Path) -> None:
    """A feed in mm/min is none of a revolution."""
    path = tmp_path / "a.csv"
    rows = [f"{n},{100 * n},{0.5 * n},{800 * n}" for n in range(1, 6)]
    path.write_text("\n".join(["No,Feed (mm/min),ap (mm),n (rpm)", *rows]))
    assert set(_channels(path)) == {"cut", "cutting.depth", "spindle.speed"}


def test_seconds_that_a_name_states_are_believed(cli: Cli, tmp_path: Path) -> None:
    """Of a test of many loads a row takes six seconds."""
    load = np.linspace(1.0, 9.0, 80) + 0.1 * RNG.normal(size=80)
    path = write(tmp_path / "a.csv", {"Time (s)": 6.0 * np.arange(80), "Current (A)": load})
    assert cli("look", path, "--write").code == 0
    done = cli("import", path)
    assert done.code == 0, done.err
