"""Calibration recovers a known line, says what it cannot sense, and uses reference forces."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb import standard
from autodb.errors import UnusableInput
from autodb.records.tables import CutTable
from autodb.sensing.ranges import calibration as ranges
from autodb.sensing.ranges.outliers import transients
from autodb.sensing.ranges.sensed_force import sense

SEED = 4
N = 60


def _table(**extra: NDArray[np.float64]) -> CutTable:
    """Return cuts whose Z range rises by F/200 A over air, and whose X stands still in turning."""
    rng = np.random.default_rng(SEED)
    feed = rng.choice([0.1, 0.2, 0.3, 0.4], N)
    depth = rng.choice([1.0, 1.5, 2.0], N)
    force = 1200.0 * feed * depth + 100.0 * depth
    noise = rng.normal(0, 0.05, N)
    channels = {
        "cut": np.arange(N, dtype=float),
        "spindle.speed": np.full(N, 1000.0),
        "cutting.feed": feed,
        "cutting.depth": depth,
        "force.z": force,
        "force.x": 0.4 * force,
        "z.current.range": 3.0 + force / 200.0 + noise,
        "z.current.air": np.full(N, 3.0),
        "x.current.range": rng.normal(0.9, 0.01, N),
        "x.current.air": np.full(N, 0.9),
    }
    return CutTable(
        path=Path("cuts.csv"), channels=channels | extra, texts={"operation": ["turn"] * N}
    )


def test_a_known_line_is_recovered() -> None:
    found = ranges.calibrate(_table(), "z")
    sd = np.sqrt(np.diag(found.covariance))
    assert abs(found.coefficients[1] - 200.0) < 4 * sd[1]
    assert abs(found.coefficients[0]) < 4 * sd[0]
    assert found.channel == "z.current.range − z.current.air"
    assert found.offered
    assert found.scores.grouped_by == "cutting condition"


def test_a_passive_axis_is_not_calibrated_and_not_sensed() -> None:
    with pytest.raises(UnusableInput, match="0 independent groups"):
        ranges.calibrate(_table(), "x")
    facing = _table()
    calibration = ranges.calibrate(facing, "z")
    turned = CutTable(path=facing.path, channels=facing.channels, texts={"operation": ["face"] * N})
    sensed = sense(turned, calibration)
    assert np.isnan(sensed.force_N).all()
    assert all("stands still" in str(reason) for reason in sensed.not_sensed)


def test_spindle_is_calibrated_in_torque_where_the_arm_is_known() -> None:
    table = _table()
    diameter = np.random.default_rng(5).uniform(30, 80, N)
    force_y = 2.0 * table["force.z"]
    torque = force_y * (0.5 * diameter + 0.5 * table["cutting.depth"]) / 1000.0
    extra = {"work.diameter": diameter, "force.y": force_y, "spindle.current.range": torque / 3.0}
    found = ranges.calibrate(
        CutTable(path=table.path, channels=table.channels | extra, texts=table.texts), "spindle"
    )
    assert found.unit == "N·m"
    assert_allclose(found.coefficients, [0.0, 3.0], atol=1e-9)


def _warming(rng: np.random.Generator, n: int, *, recorded: bool) -> CutTable:
    """Torques over currents of a spindle that reads 0.2 % less a kelvin, from 20 to 45 °C."""
    torque, rpm = rng.uniform(5.0, 60.0, n), rng.uniform(600.0, 2400.0, n)
    theta = 20.0 + 25.0 * rng.permutation(np.linspace(0.0, 1.0, n))
    current = torque / 3.0 * np.exp(-0.002 * (theta - 20.0)) + rng.normal(0.0, 0.05, n)
    depth, diameter = np.full(n, 2.0), np.full(n, 58.0)
    channels = {
        "cut": np.arange(1.0, n + 1.0),
        "cutting.depth": depth,
        "cutting.feed": rng.uniform(0.1, 0.4, n),
        "spindle.speed": rpm,
        "work.diameter": diameter,
        "force.y": 1000.0 * torque / 30.0,
        "spindle.current.range": current + 2.0,
        "spindle.current.air": np.full(n, 2.0),
    } | ({"spindle.temperature": theta} if recorded else {})
    return CutTable(path=Path("warm.csv"), channels=channels, texts={"operation": ["turn"] * n})


def test_a_spindles_gain_follows_its_temperature_where_that_is_recorded() -> None:
    """0.05 A of noise are 0.15 N·m; not knowing the temperature costs 1.5 % of 5 to 60 N·m."""
    with_it = ranges.calibrate(_warming(np.random.default_rng(8), 60, recorded=True), "spindle")
    without = ranges.calibrate(_warming(np.random.default_rng(8), 60, recorded=False), "spindle")
    assert with_it.form.kind.endswith("-warmed")
    k, sd = with_it.coefficients[-1], float(np.sqrt(with_it.covariance[-1, -1]))
    assert abs(k - 0.002) < 4.0 * sd < 0.001
    assert with_it.scores.rmse < 0.25
    assert without.scores.rmse > 0.4
    fresh = _warming(np.random.default_rng(9), 400, recorded=True)
    error = sense(fresh, with_it).force_N - fresh["force.y"]
    assert float(np.sqrt(np.mean(error**2))) < 1.3 * 150.0 / 30.0
    blind = sense(_warming(np.random.default_rng(9), 4, recorded=False), with_it)
    assert np.isnan(blind.force_N).all()
    assert all("spindle temperature" in str(reason) for reason in blind.not_sensed)


def test_facing_turns_the_work_on_the_machined_radius() -> None:
    from autodb.cutting.turning import effective_radius_mm

    diameter, depth = np.array([40.0, 40.0]), np.array([2.0, 2.0])
    radius = effective_radius_mm(diameter, depth, inward_rad=np.array([0.0, 0.5 * np.pi]))
    assert_allclose(radius, [21.0, 20.0])


def test_sensed_force_carries_both_kinds_of_error() -> None:
    table = _table()
    calibration = ranges.calibrate(table, "z")
    sensed = sense(table, calibration)
    assert_allclose(sensed.force_N, table["force.z"], atol=5 * 10.0)
    assert_allclose(sensed.sd_N, calibration.errors.cut_sd)
    assert_allclose(calibration.errors.cut_sd, calibration.scores.rmse, rtol=0.05)
    change = np.array([5.0, -2.0])
    moved = sense(
        table,
        ranges.Calibration(
            **{**vars(calibration), "coefficients": calibration.coefficients + change}
        ),
    )
    assert_allclose(moved.force_N - sensed.force_N, sensed.common[:, :2] @ change, rtol=1e-9)


def test_a_sudden_row_is_a_transient_and_a_sudden_force_is_not() -> None:
    current = np.linspace(1, 2, 50) + np.random.default_rng(1).normal(0, 0.01, 50)
    target = 100 * current + np.random.default_rng(2).normal(0, 1, 50)
    groups = np.repeat([1, 2], 25)
    jump = current.copy()
    jump[10] += 5.0
    assert np.flatnonzero(transients(jump, target, groups)).tolist() == [10]
    worn = target.copy()
    worn[10] += 500.0
    assert not transients(current, worn, groups).any()


def test_every_shipped_protocol_reads_and_its_references_are_ordered() -> None:
    from autodb.assets import kit

    names = [path.stem for path in kit("calibration").glob("*.toml")]
    assert "turning-aluminium" in names
    for name in names:
        for cut in standard.read_protocol(name).cut:
            for reference in cut.reference.values():
                assert reference.lower < reference.value < reference.upper
                assert reference.source


def test_published_reference_is_within_its_scatter_of_the_paper() -> None:
    """Shipped interval: mean ± t(0.975, 11)·√variance of P1 table 2, within 0.01 N."""
    cut = standard.read_protocol("turning-aluminium").cut[0]
    for component, mean, variance in (("y", 485.78, 84.0), ("z", 325.78, 320.0)):
        reference = cut.reference[component]
        half = 2.2009852 * variance**0.5
        assert_allclose([reference.lower, reference.upper], [mean - half, mean + half], atol=0.01)


def _protocol(tmp_path: Path, table: CutTable) -> standard.CutProtocol:
    text = 'name = "mine"\nmaterial = "m"\ntool = "t"\n'
    pairs = sorted({*zip(table["cutting.feed"], table["cutting.depth"], strict=True)})
    for feed, depth in pairs:
        value = 1200.0 * feed * depth + 100.0 * depth
        text += (
            f'[[cut]]\nname = "{feed}-{depth}"\noperation = "turn"\nspeed_rpm = 1000\n'
            f"feed_mm_rev = {feed}\ndepth_mm = {depth}\nrepeats = 1\n[cut.reference.z]\n"
            f"value = {value}\nlower = {value * 0.9216}\nupper = {value * 1.0784}\n"
            'source = "test"\nstatus = "known"\ndate = "2026-01-01"\n'
        )
    path = tmp_path / "mine.toml"
    path.write_text(text)
    return standard.read_protocol(str(path))


def test_reference_forces_stand_in_for_a_dynamometer(tmp_path: Path) -> None:
    table = _table()
    bare = CutTable(
        path=table.path,
        channels={k: v for k, v in table.channels.items() if not k.startswith("force")},
        texts=table.texts,
    )
    references = standard.reference_forces(bare, _protocol(tmp_path, table), "z")
    assert_allclose(references.force_N, table["force.z"])
    assert_allclose(references.share, 0.04, rtol=1e-6)
    found = ranges.calibrate(
        bare, "z", force_N=references.force_N, reference_share=references.share
    )
    assert_allclose(found.coefficients[1], 200.0, rtol=0.02)
    assert np.sqrt(found.shared_covariance[1, 1]) > 0.04 * 199.0


def test_a_protocol_that_does_not_fit_says_so() -> None:
    table = _table()
    shipped = standard.read_protocol("turning-aluminium")
    with pytest.raises(UnusableInput, match=r"no reference for force\.x yet"):
        standard.reference_forces(table, shipped, "x")
    slow = CutTable(
        path=table.path,
        channels={**table.channels, "spindle.speed": np.full(N, 77.0)},
        texts=table.texts,
    )
    with pytest.raises(UnusableInput, match="no row is a standard cut"):
        standard.reference_forces(slow, shipped, "z")
    with pytest.raises(UnusableInput, match="did you mean turning-aluminium"):
        standard.read_protocol("turning-aluminum")


def test_too_few_different_cuts_end_in_one_line(
    tmp_path: Path, refused: Callable[..., str]
) -> None:
    """Five cuts of which three share one current: with groups left out no line is determined."""
    current = [2.0, 2.0, 2.0, 2.0, 3.0]
    columns = {"cut": range(5), "z.current": current, "force.z": [100.0, 101.0, 99.0, 100.0, 150.0]}
    path = tmp_path / "cuts.csv"
    rows = zip(*columns.values(), strict=True)
    path.write_text("\n".join([",".join(columns), *(",".join(map(str, row)) for row in rows)]))
    assert "too few different currents" in refused("calibrate", path)


def _of_three_materials(current_tells: float) -> CutTable:
    """90 cuts of three materials; the z current holds ``current_tells`` of the force, and noise."""
    rng = np.random.default_rng(31)
    n = 90
    material = np.repeat(["steel", "brass", "aluminium"], n // 3)
    k_N_mm2 = np.repeat([1100.0, 600.0, 400.0], n // 3)
    feed_mm, depth_mm = rng.uniform(0.1, 0.4, n), rng.uniform(1.0, 2.5, n)
    force_N = k_N_mm2 * feed_mm * depth_mm + 60.0 * depth_mm
    channels = {
        "cut": np.arange(1.0, n + 1.0),
        "t": 60.0 * np.arange(float(n)),
        "cutting.feed": feed_mm,
        "cutting.depth": depth_mm,
        "spindle.speed": rng.uniform(800.0, 2400.0, n),
        "z.current": current_tells * force_N / 200.0 + 0.2 * rng.standard_normal(n),
        "force.z": force_N,
    }
    texts = {"operation": ["turn"] * n, "work.material": material.tolist()}
    return CutTable(path=Path("three.csv"), channels=channels, texts=texts)


def test_what_is_learned_of_a_material_must_hold_for_another() -> None:
    """Rules that see feed and depth are tried on three materials, each left out in turn."""
    found = ranges.calibrate(_of_three_materials(1.0), "z")
    assert found.scores.grouped_by == "work material"
    assert found.scores.groups == 3
    assert {"ANFIS {current, feed}", "ANFIS {current, depth of cut}"} < set(found.trials)
    assert found.form.label == "line"
    assert found.trials["ANFIS {current, feed}"] > 0.9 * found.trials["line"]


def test_a_current_that_tells_nothing_is_refused_though_feed_and_depth_tell_much() -> None:
    found = ranges.calibrate(_of_three_materials(0.0), "z")
    assert not found.offered


def test_one_material_alone_gets_no_rules_that_see_feed_or_depth() -> None:
    three = _of_three_materials(1.0)
    texts = {**three.texts, "work.material": ["steel"] * len(three)}
    found = ranges.calibrate(replace(three, texts=texts), "z")
    assert found.scores.grouped_by == "cutting condition"
    assert not any("depth" in name or ", feed}" in name for name in found.trials)
