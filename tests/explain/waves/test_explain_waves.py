"""explain on the forces of a mill: known numbers come back, files, pages, refused inputs."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.explain import explain
from autodb.explain.answer import Cause, Explained
from autodb.explain.waves.answers import APART, STATEMENTS, words_that_tell
from autodb.explain.waves.teeth import Mill, StandsOut, Teeth
from autodb.files.side import SideFile
from autodb.proofs.cases.mill.mill_families import MILL_KINDS
from autodb.records.tables import Recording
from autodb.records.timed import on_even_rows
from autodb.reports.explanation import explanation_fragment
from autodb.reports.written import LIBRARY
from autodb.terms.vocabulary import vocabulary
from tests.conftest import Cli
from tests.helpers.remedies import has_remedy

Array = NDArray[np.float64]

RATE_HZ, RPM, FEED, DEPTH, DIAMETER, TEETH = 2000.0, 2400.0, 0.06, 2.0, 10.0, 4
SIDE: dict[str, dict[str, float | str]] = {
    "tool": {"diameter_mm": DIAMETER, "teeth": TEETH, "helix_deg": 30.0},
    "cut": {
        "operation": "side-up", "depth_mm": DEPTH, "width_mm": 3.0, "feed_mm_tooth": FEED,
        "speed_rpm": RPM,
    },
}  # fmt: skip
K_N_MM2, EDGE_N_MM = (1800.0, 600.0, 300.0), (20.0, 25.0, 3.0)
NOISE_N = 4.0
T = np.arange(0.0, 0.9, 1.0 / RATE_HZ)
ANGLE = 2.0 * np.pi * RPM / 60.0 * T
INSIDE = (T > 0.1) & (T < 0.8)
MILL = Mill(
    TEETH,
    float(DEPTH * np.tan(np.radians(30.0)) / (0.5 * DIAMETER)),
    DEPTH,
    FEED,
    (0.0, float(np.arccos(1.0 - 2.0 * 3.0 / DIAMETER))),
    slices=20,
)
SENDS = Teeth(MILL, ANGLE, INSIDE.astype(np.float64), np.ones(len(T)))


def _law(chip_mm: Array) -> tuple[Array, Array, Array]:
    pairs = zip(K_N_MM2, EDGE_N_MM, strict=True)
    t, r, a = (k * chip_mm + edge * (chip_mm > 0.0) for k, edge in pairs)
    return t, r, a


def _shear(chip_mm: Array) -> tuple[Array, Array, Array]:
    t, r, a = (k * chip_mm for k in K_N_MM2)
    return t, r, a


def _table(forces: Array) -> dict[str, Array]:
    return {"t": T, **{f"force.{axis}": forces[i] for i, axis in enumerate("xyz")}}


def _recording(forces: Array, *, angle: bool = True) -> Recording:
    noise = NOISE_N * np.random.default_rng(11).standard_normal(forces.shape)
    turned = {"spindle.angle": np.degrees(ANGLE)} if angle else {}
    side = SideFile.model_validate(SIDE)
    return Recording(Path("cut.csv"), {**_table(forces + noise), **turned}, side=side)


def _explained(forces: Array, simulated: Array, *, angle: bool = True) -> Explained:
    simulation = Recording(Path("simulation.csv"), _table(simulated))
    return explain(_recording(forces, angle=angle), simulation)


def _causes(explained: Explained, channel: str) -> dict[str, Cause]:
    return {cause.term: cause for cause in explained.explanation.channels[channel].missing}


def _holds(cause: Cause, name: str, truth: float, *, within: float) -> bool:
    """Say whether a number is right within a share of it, or five standard deviations."""
    found = cause.parameters[name]
    return abs(found.value - truth) <= max(within * abs(truth), 2.6 * (found.high - found.low) / 2)


PLAIN = SENDS.forces(_law)


def test_how_far_each_tooth_stands_out() -> None:
    out = (0.012, -0.004, -0.009, 0.001)
    explained = _explained(SENDS.forces(_law, StandsOut(out)), PLAIN)
    for channel in ("force.x", "force.y"):
        causes = _causes(explained, channel)
        assert set(causes) == {"runout"}
        mean = float(np.mean(out))
        for tooth, mm in enumerate(out):
            assert _holds(causes["runout"], f"tooth {tooth}", mm - mean, within=0.03)
    trace = explained.traces["force.y"]
    assert np.std(trace.recording - trace.corrected) == pytest.approx(NOISE_N, rel=0.05)


def test_chatter_and_a_hard_stretch_beside_each_other() -> None:
    """The stretch is 10 % harder; the tone is no multiple of 40 Hz, nor of one folded at 2 kHz."""
    hard = 1.0 + 0.1 * ((T > 0.4) & (T < 0.55))
    ring = 6.0 * np.sin(2.0 * np.pi * 713.3 * T) * INSIDE
    forces = PLAIN * hard + np.array([1.0, 0.6, 0.2])[:, None] * ring
    explained = _explained(forces, PLAIN)
    causes = _causes(explained, "force.x")
    assert set(causes) == {"chatter", "hard_spot"}
    assert _holds(causes["chatter"], "frequency", 713.3, within=1e-4)
    assert _holds(causes["hard_spot"], "factor", 1.1, within=0.01)
    assert _holds(causes["hard_spot"], "start", 0.4, within=0.02)
    assert _holds(causes["hard_spot"], "end", 0.55, within=0.02)
    (stretch,) = explained.explanation.channels["force.x"].where.intervals
    np.testing.assert_allclose(stretch, (0.4, 0.55), atol=0.02)
    answer, trace = explained.explanation.channels["force.x"], explained.traces["force.x"]
    np.testing.assert_allclose(
        sum(trace.takes), 1.0 - (answer.fit.rms_after / answer.fit.rms_before) ** 2
    )
    squares = {"chatter": ring, "hard_spot": (PLAIN * (hard - 1.0))[0]}
    assert list(causes) == sorted(squares, key=lambda name: -float(np.sum(squares[name] ** 2)))
    assert list(trace.takes) == sorted(trace.takes, reverse=True)


def _with_a_gap(*, angle: bool) -> tuple[Recording, Recording]:
    """A cut of 1.5 s that rings at 713.3 Hz, of which rows 0.6 to 0.9 s are missing."""
    t = np.arange(0.0, 1.5, 1.0 / RATE_HZ)
    turned = 2.0 * np.pi * RPM / 60.0 * t
    inside = (t > 0.1) & (t < 1.4)
    plain = Teeth(MILL, turned, inside.astype(np.float64), np.ones(len(t))).forces(_law)
    ring = 6.0 * np.sin(2.0 * np.pi * 713.3 * t) * inside
    noise = NOISE_N * np.random.default_rng(12).standard_normal(plain.shape)
    forces = plain + np.array([1.0, 0.6, 0.2])[:, None] * ring + noise
    there = (t < 0.6) | (t >= 0.9)

    def table(values: Array) -> dict[str, Array]:
        return {"t": t[there], **{f"force.{a}": values[i, there] for i, a in enumerate("xyz")}}

    channels = table(forces) | ({"spindle.angle": np.degrees(turned[there])} if angle else {})
    side = SideFile.model_validate(SIDE)
    recording = on_even_rows(Recording(Path("cut.csv"), channels, side=side))
    return recording, on_even_rows(Recording(Path("s.csv"), table(plain)), like=recording)


def test_chatter_is_followed_over_a_gap() -> None:
    recording, simulation = _with_a_gap(angle=True)
    assert len(recording.pieces) == 2
    explained = explain(recording, simulation)
    causes = _causes(explained, "force.x")
    assert set(causes) == {"chatter"}
    assert _holds(causes["chatter"], "frequency", 713.3, within=1e-4)
    assert causes["chatter"].parameters["size"].value == pytest.approx(6.0, abs=0.4)
    assert any("2 pieces of even rows" in note for note in explained.notes)


def test_teeth_that_only_forces_tell_are_not_followed_over_a_gap() -> None:
    with pytest.raises(UnusableInput, match=r"record spindle\.angle, or give one piece"):
        explain(*_with_a_gap(angle=False))


def test_a_recording_that_is_mostly_gap_is_refused() -> None:
    t = np.concatenate([T, T + 5.0])
    turned = 2.0 * np.pi * RPM / 60.0 * t
    forces = np.tile(PLAIN, 2)
    channels = {"t": t, **{f"force.{a}": forces[i] for i, a in enumerate("xyz")}}
    simulation = Recording(Path("s.csv"), channels)
    more = {"spindle.angle": np.degrees(turned), "force.x": 1.1 * forces[0]}
    side = SideFile.model_validate(SIDE)
    recording = on_even_rows(Recording(Path("cut.csv"), channels | more, side=side))
    with pytest.raises(UnusableInput, match=r"gaps last longer .* one piece as a file of its own"):
        explain(recording, on_even_rows(simulation, like=recording))


def test_an_edge_left_out_and_a_sensor_that_wanders_angle_unrecorded() -> None:
    """The simulation has no edge force; the sensor of x drifts by 9 N/s, in air too."""
    forces = PLAIN + np.array([9.0, 0.0, 0.0])[:, None] * T
    explained = _explained(forces, SENDS.forces(_shear), angle=False)
    causes = _causes(explained, "force.x")
    assert set(causes) == {"edge_force", "sensor_drift"}
    assert _holds(causes["edge_force"], "coefficient", EDGE_N_MM[0], within=0.05)
    assert _holds(causes["edge_force"], "radial", EDGE_N_MM[1], within=0.05)
    assert _holds(causes["sensor_drift"], "rate", 9.0, within=0.03)
    assert "sensor_drift" not in _causes(explained, "force.y")


def test_a_depth_that_is_off_and_own_terms_that_are() -> None:
    """Cut 0.1 mm deeper than simulated, of material that is 6 % harder tangentially.

    What a millimetre more of depth adds is the simulation's, so that its error is right to as much.
    """
    tangential = np.array([1.06, 1.0, 1.0])

    def harder(chip_mm: Array) -> tuple[Array, Array, Array]:
        t, r, a = (
            factor * k * chip_mm + edge * (chip_mm > 0.0)
            for factor, k, edge in zip(tangential, K_N_MM2, EDGE_N_MM, strict=True)
        )
        return t, r, a

    explained = _explained(SENDS.deeper(0.1).forces(harder), PLAIN)
    causes = _causes(explained, "force.y")
    assert {name for name, cause in causes.items() if cause.kind == "missing"} == {"depth_error"}
    assert _holds(causes["depth_error"], "error", 0.1, within=0.12)
    assert causes["shear"].kind == "mistuned"


def test_the_same_numbers_twice_are_no_mismatch() -> None:
    simulation = Recording(Path("simulation.csv"), _table(PLAIN))
    explained = explain(replace(_recording(PLAIN), channels=dict(_table(PLAIN))), simulation)
    assert not any(answer.mismatch for answer in explained.explanation.channels.values())
    assert "Some turns" not in explanation_fragment(explained)


def test_every_effect_has_its_words() -> None:
    assert set(STATEMENTS) == set(MILL_KINDS) - {"outside"}
    assert {name for pair in APART for name in pair} <= vocabulary()


def test_what_would_tell_two_apart_is_said_once() -> None:
    said = words_that_tell("runout", ["depth_error", "chatter", "gain"])
    assert said is not None
    assert said.count(".") == 2
    assert words_that_tell("chatter", ["gain"]) is None


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("mill")
    recording = _recording(SENDS.forces(_law, StandsOut((0.01, -0.01, 0.01, -0.01))))
    for name, channels in (
        ("cut", recording.channels),
        ("simulation", _table(PLAIN)),
        ("other", _recording(PLAIN).channels),
    ):
        pd.DataFrame(channels).iloc[:1000].to_csv(folder / f"{name}.csv", index=False)
    for stem, tool in (("cut", "mill-7"), ("other", "mill-8")):
        side: dict[str, dict[str, float | str]] = {
            "recording": {"machine": "m-1", "work": "steel"}, **SIDE,
        }  # fmt: skip
        side["tool"] = {**SIDE["tool"], "name": tool}
        lines = [
            f"[{table}]\n"
            + "\n".join(f"{key} = {json.dumps(value)}" for key, value in values.items())
            for table, values in side.items()
        ]
        (folder / f"{stem}.toml").write_text("\n".join(lines))
    return folder


@pytest.mark.campaign  # of an axis at every change: tests/terms/test_a_term_from_outside.py
def test_recordings_are_explained_together(cli: Cli, files: Path, tmp_path: Path) -> None:
    done = cli(
        "explain", files / "cut.csv", files / "other.csv", "--simulation",
        files / "simulation.csv", "--simulation", files / "simulation.csv",
        "--out", tmp_path / "both",
    )  # fmt: skip
    assert done.code == 0
    assert "force.y: runout shows in 1 of 2 recordings and goes with the tool." in done.out
    assert sorted(p.name for p in (tmp_path / "both").iterdir()) == [
        "1-cut", "2-other", LIBRARY, "together.html", "together.json",
    ]  # fmt: skip
    found = json.loads((tmp_path / "both" / "together.json").read_text())
    assert [one["tool"] for one in found["recordings"]] == ["mill-7", "mill-8"]
    assert {one["sits_in"][0]["factor"] for one in found["effects"]} == {"tool"}
    page = (tmp_path / "both" / "together.html").read_text()
    assert "mill-8" in page
    assert "1-cut/report.html" in page
    corrected = pd.read_csv(tmp_path / "both" / "1-cut" / "corrected.csv")
    assert list(corrected) == ["t", "force.x", "force.y", "force.z"]
    report = (tmp_path / "both" / "1-cut" / "report.html").read_text()
    assert "Some turns of the spindle, close up" in report


def test_each_recording_needs_its_simulation(refused: Callable[..., str], files: Path) -> None:
    line = refused(
        "explain", files / "cut.csv", files / "other.csv",
        "--simulation", files / "simulation.csv",
    )  # fmt: skip
    assert "2 recordings and 1 simulations" in line
    assert "would" in line or "give --simulation" in line


def test_a_machine_has_no_model_of_a_mills_forces(
    cli: Cli, refused: Callable[..., str], files: Path
) -> None:
    assert cli("init").code == 0
    assert cli("machine", "add", "m-1").code == 0
    line = refused("explain", files / "cut.csv", "--machine", "m-1")
    assert "use --simulation FILE with force.*" in line


def test_a_side_file_without_the_mill_is_refused(
    refused: Callable[..., str], files: Path, tmp_path: Path
) -> None:
    (tmp_path / "cut.csv").write_bytes((files / "cut.csv").read_bytes())
    line = refused("explain", tmp_path / "cut.csv", "--simulation", files / "simulation.csv")
    assert "[tool] diameter_mm" in line
    assert has_remedy(line)
