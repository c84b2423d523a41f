"""Wrong units and clipped sensors are seen; what is right is left alone."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.records import source as records
from autodb.records.plausible import doubts
from autodb.records.summary import summarise
from tests.conftest import Cli
from tests.helpers.bad_files import MOVES, T, V, X
from tests.helpers.bad_files import I as CURRENT
from tests.helpers.files import write


def _doubts(path: Path, columns: Path | None = None) -> list[str]:
    source = records.open_source(path, columns=columns)
    return [line for base in summarise(source) for line in doubts(base, source.side)]


def _side(folder: Path, text: str) -> None:
    (folder / "a.toml").write_text(text)


def test_no_real_recording_is_doubted(
    vicomtech: Path, emps: Path, tryout: Path, sample_jobs: Path
) -> None:
    sides = {
        vicomtech: sample_jobs / "vicomtech_turning_wear" / "columns.toml",
        emps: sample_jobs / "emps" / "columns.toml",
        emps.with_name("DATA_EMPS_PULSES.mat"): sample_jobs / "emps" / "columns.toml",
    }
    files = [*sides, *sorted(tryout.glob("*/*.csv"))]
    assert len(files) == 21
    for path in files:
        assert _doubts(path, sides.get(path)) == [], path


def test_the_samples_are_not_doubted(sample_jobs: Path) -> None:
    files = [p for p in sample_jobs.glob("*/recordings/*") if p.suffix in (".csv", ".parquet")]
    assert files
    for path in files:
        assert _doubts(path) == [], path


@pytest.mark.parametrize("limit_A", [1.5, 2.0, 3.0])
def test_a_clipped_current_is_seen(tmp_path: Path, limit_A: float) -> None:
    clipped = {**MOVES, "x.current": np.clip(CURRENT, -limit_A, limit_A)}
    (line,) = _doubts(write(tmp_path / "a.csv", clipped))
    assert f"clipped at -{limit_A:g} A" in line
    _side(tmp_path, '[channels]\n"x.current" = {column = "x.current", clips = true}\n')
    assert _doubts(tmp_path / "a.csv") == []


def test_a_phase_current_clipped_at_the_top_only_is_seen(tmp_path: Path) -> None:
    t = np.arange(4000) * 0.001
    phase = np.minimum(5 * np.sin(2 * np.pi * 8 * t), 4.0)
    path = write(tmp_path / "a.csv", {"t": t, "spindle.current.u": phase})
    assert "clipped at 4 A" in _doubts(path)[0]


def test_plateaus_that_are_no_clipping(tmp_path: Path) -> None:
    """A calculated trapezoid, a coarse converter, a standstill at zero, a speed that is held, an
    idle level, dry friction without noise, a slow display, a switched load.
    """
    rng = np.random.default_rng(2)
    smooth = np.clip(np.sin(T) * 3, -1.5, 1.5)
    coarse = np.round(rng.normal(0, 1.2, len(T)))
    idle = np.where(T < 2.0, 0.0, np.abs(rng.normal(3, 0.5, len(T))))
    spindle = np.round(np.where(T < 2.0, 3.0, 12.0 + rng.normal(0, 0.5, len(T))), 1)
    display = np.repeat(np.round(rng.normal(9, 2, len(T) // 40), 2), 40)
    path = write(
        tmp_path / "a.csv",
        {"t": T, "x.current": smooth, "y.current": coarse, "z.current": idle,
         "spindle.speed": np.where(T < 1, 0.0, 1500.0), "spindle.current": spindle,
         "u.current": 0.7 * np.sign(V), "v.current": np.where(T < 2.5, 0.0, display),
         "force.z": np.where(T % 1 < 0.5, 0.0, 1000.0)},
    )  # fmt: skip
    assert _doubts(path) == []


def test_clipping_beside_a_standstill_is_seen(tmp_path: Path) -> None:
    rng = np.random.default_rng(6)
    t = np.arange(8000) * 0.004
    load = np.clip(5 * np.sin(3 * t) + rng.normal(0, 0.1, len(t)), -3, 3)
    path = write(tmp_path / "a.csv", {"t": t, "x.current": np.where(t % 8 < 5, 0.0, load)})
    assert "clipped at -3 A" in _doubts(path)[0]


def test_a_small_groove_far_from_zero_is_not_in_metres(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"t": T, "x.position": 50.0 + X / 400, "z.position": 0 * T})
    assert _doubts(path) == []


def test_a_velocity_against_the_slope_is_seen(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {**MOVES, "x.velocity": -V})
    assert "runs against the slope" in _doubts(path)[0]


def test_a_temperature_below_absolute_zero_is_seen(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {**MOVES, "x.temperature": -300.0 + 0 * T})
    assert "absolute zero" in _doubts(path)[0]


def test_metres_are_seen_only_where_the_unit_was_assumed(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"t": T, "x.position": X / 1000, "y.position": 0 * X})
    assert "x.position travels 0.2 mm" in _doubts(path)[0]
    for unit in ("m", "mm"):
        _side(tmp_path, f'[channels]\n"x.position" = {{column = "x.position", unit = "{unit}"}}\n')
        assert _doubts(path) == []


def test_a_standing_axis_is_not_in_metres(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    held = 12.5 + rng.normal(0, 0.001, len(T))
    assert _doubts(write(tmp_path / "a.csv", {"t": T, "y.position": held})) == []
    moved = {"t": T, "y.position": X / 1000, "x.position": X}
    assert _doubts(write(tmp_path / "b.csv", moved)) == []


@pytest.mark.parametrize(("factor", "seen"), [(60.0, True), (0.001, True), (2.0, False)])
def test_a_velocity_in_another_unit_is_seen(tmp_path: Path, factor: float, seen: bool) -> None:
    path = write(tmp_path / "a.csv", {**MOVES, "x.velocity": factor * V})
    assert [f"{factor:.3g} times" in line for line in _doubts(path)] == [True] * seen


@pytest.mark.parametrize(
    ("channel", "value"),
    [("spindle.speed", 1e6), ("force.z", 1e9), ("x.temperature", 1e5), ("spindle.current", -1e7)],
)
def test_what_no_machine_does_is_refused(
    tmp_path: Path, refused: Callable[..., str], channel: str, value: float
) -> None:
    path = write(tmp_path / "a.csv", {**MOVES, channel: value + T})
    assert f"as {channel} is beyond any machine" in refused("import", path)


def test_counts_are_not_judged(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {**MOVES, "z.current": 1e9 + T})
    _side(tmp_path, '[channels]\n"z.current" = {column = "z.current", unit = "raw"}\n')
    assert _doubts(path) == []


def test_speed_and_diameter_must_fit(tmp_path: Path) -> None:
    cuts = {"cut": [1, 2], "work.diameter": [0.05, 0.06], "spindle.speed": [1200.0, 1000.0],
            "cutting.speed": [188.0, 188.0]}  # fmt: skip
    (line,) = _doubts(write(tmp_path / "a.csv", cuts))
    assert "as if cutting.speed in mm/min or work.diameter in m; state its unit" in line
    cuts["work.diameter"] = [2.0, 2.36]
    assert (
        'as if work.diameter in inch; state unit = "inch"'
        in _doubts(write(tmp_path / "a.csv", cuts))[0]
    )
    cuts["work.diameter"] = [7.0, 9.0]
    assert "one of them in another unit" in _doubts(write(tmp_path / "a.csv", cuts))[0]
    cuts["work.diameter"] = [50.0, 60.0]
    assert _doubts(write(tmp_path / "a.csv", cuts)) == []


def test_constant_surface_speed_over_all_diameters_fits(tmp_path: Path) -> None:
    """Cut by cut, not by the means; what a cut does not state is not compared."""
    diameter_mm = np.array([6.0, 8.0, 10.0, 15.0, 300.0, 340.0, np.nan, 0.0])
    cuts = {"cut": np.arange(8), "work.diameter": diameter_mm, "cutting.speed": [200.0] * 8,
            "spindle.speed": [*(200e3 / np.pi / diameter_mm[:6]), 12000.0, 900.0]}  # fmt: skip
    assert _doubts(write(tmp_path / "a.csv", cuts)) == []


def test_explain_says_what_it_doubts_and_goes_on(tmp_path: Path, cli: Cli) -> None:
    rng = np.random.default_rng(9)
    t = np.arange(0, 40, 0.01)
    moves = {"t": t, "x.position": 100 * np.sin(t), "x.velocity": 6000 * np.cos(t)}
    current = 1.5 * np.sign(np.cos(t))
    measured = write(
        tmp_path / "r.csv", {**moves, "x.current": current + rng.normal(0, 0.05, 4000)}
    )
    simulated = write(tmp_path / "s.csv", {**moves, "x.current": current})
    done = cli("explain", measured, "--simulation", simulated)
    assert done.code == 0
    assert "doubtful: " in done.err
    assert "x.velocity is 60 times the slope" in done.err


def _clipped(path: Path, current: NDArray[np.float64]) -> list[str]:
    t = np.arange(len(current)) * 0.002
    return _doubts(write(path, {"t": t, "spindle.current": current}))


def test_an_idle_floor_is_no_limit(tmp_path: Path) -> None:
    rng = np.random.default_rng(391)
    load = 30.0 + 3.0 * rng.normal(size=1000)
    ramp = np.linspace(1.0, 30.0, 200) + 0.05 * rng.normal(size=200).clip(0)
    idle = np.full(800, 1.0)
    current = np.concatenate([idle, ramp, load, ramp[::-1], idle])
    assert _clipped(tmp_path / "a.csv", current) == []
    assert _clipped(tmp_path / "b.csv", -current) == []
    assert len(_clipped(tmp_path / "c.csv", np.minimum(current, 28.0))) == 1


@pytest.mark.parametrize("step", [0.02, 0.1, 0.5])
def test_the_top_of_a_signal_in_few_digits_is_no_limit(tmp_path: Path, step: float) -> None:
    t = np.arange(4000) * 0.002
    smooth = 10.0 * np.sin(2.0 * np.pi * 0.7 * t) + 2.0 * np.sin(2.0 * np.pi * 13.0 * t)
    coarse = step * np.round(smooth / step)
    assert _clipped(tmp_path / "a.csv", coarse) == []
    limited = np.clip(0.02 * np.round(smooth / 0.02), -9.0, 9.0)
    assert len(_clipped(tmp_path / "b.csv", limited)) == 1


@pytest.mark.parametrize("name", ["cut.duration", "tool.cutting_time"])
def test_no_time_is_less_than_none(tmp_path: Path, name: str) -> None:
    cuts = {"cut": [1.0, 2.0], "t": [0.0, 60.0], "force.y": [900.0, 950.0], name: [3.0, -3.0]}
    (line,) = _doubts(write(tmp_path / "a.csv", {k: np.array(v) for k, v in cuts.items()}))
    assert f"column '{name}': -3 s as {name} is less than none" in line
