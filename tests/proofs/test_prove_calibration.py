"""The reference lathes, the published way to calibrate them, and autodb's."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.proofs.machines.lathe import reference_lathe
from autodb.proofs.runs.lathe import lathe_summary
from autodb.proofs.runs.lathe.lathe_run import AxisErrors, run_lathe
from autodb.proofs.runs.lathe.lathe_summary import PairedRatio
from autodb.proofs.runs.lathe.published_lathe import SpindleLaw
from autodb.proofs.runs.run_file import Finished, Origin

ORIGIN = Origin("calibration", "0", "g", "p")
MACHINES = range(1, 3)


@pytest.fixture(scope="module")
def runs() -> list[Finished[AxisErrors]]:
    """Two machines of the proof."""
    return [Finished(seed, tuple(run_lathe(seed))) for seed in MACHINES]


def _changed(runs: list[Finished[AxisErrors]], **factors: float) -> lathe_summary.LatheSummary:
    changed = [
        Finished(
            one.seed,
            tuple(
                AxisErrors(**{**vars(e), **{n: f * getattr(e, n) for n, f in factors.items()}})
                for e in one.judged
            ),
        )
        for one in runs
    ]
    return lathe_summary.lathe_summary_of(changed, ORIGIN)


@pytest.mark.campaign
def test_forces_of_calibrated_lathes(runs: list[Finished[AxisErrors]]) -> None:
    found = _changed(runs)
    assert {(row.plan, row.axis): row.cuts for row in found.rows} == {
        ("regression", "x"): 16, ("regression", "spindle"): 113, ("regression", "z"): 180,
        ("ANFIS", "spindle"): 100, ("ANFIS", "z"): 63,
    }  # fmt: skip
    assert [row.rules_N is None for row in found.rows] == [True, False, False, False, False]
    for row in found.rows:
        assert row.rmse_N < 1.2 * row.oracle_N
        assert row.covered or (row.axis == "spindle" and row.held > 0.93), "too wide, never narrow"
        if row.axis == "z":
            assert row.rmse_N < 0.9 * row.published_method_N
    assert found.straight
    assert lathe_summary.LatheSummary.from_json(found.to_json()) == found


@pytest.mark.campaign
def test_worse_lathes_and_worse_forces_fail(runs: list[Finished[AxisErrors]]) -> None:
    softer = _changed(runs, published_N=1.8).rows
    assert not any(row.as_hard for row in softer if row.published_N is not None)
    assert not any(row.better or row.near for row in _changed(runs, ours_N=1.4).rows)
    assert not any(row.covered for row in _changed(runs, held=0.8).rows)
    assert not _changed(runs, product=0.9, reference=0.9).straight


def test_an_error_is_below_another_where_most_machines_say_so() -> None:
    rng = np.random.default_rng(3)
    others = rng.uniform(20.0, 40.0, 200)
    below = PairedRatio.of(others * rng.normal(0.95, 0.1, 200), others)
    same = PairedRatio.of(others * rng.normal(1.0, 0.1, 200), others)
    assert 0.92 < below.low < below.median < below.high < 1.0
    assert same.low < 1.0 < same.high
    assert PairedRatio.of(np.array([1.0, 3.0]), np.array([2.0, 2.0])) == PairedRatio(1.0, 0.5, 1.5)


def test_the_power_law_of_a_spindle_is_found_again() -> None:
    rng = np.random.default_rng(1)
    rpm, rise_A = rng.uniform(800.0, 2400.0, 200), rng.uniform(2.0, 40.0, 200)
    torque_Nm = np.where(rpm <= 1570.0, 1.4, 1.4 * 1570.0 / rpm) * rise_A**0.9
    law = SpindleLaw.fitted(rpm, rise_A, torque_Nm)
    assert_allclose(law(rpm, rise_A), torque_Nm, rtol=2e-3)
    assert_allclose(law(rpm, -rise_A), 0.0)


@pytest.mark.parametrize("seed", [1, 20])
def test_the_plan_of_the_rules_has_the_published_cuts(seed: int) -> None:
    made = reference_lathe.campaign(seed, reference_lathe.RULES)
    for table, turned in ((made.calibration, 240), (made.test, 63)):
        assert np.isin(table["operation"], ("turn", "taper")).sum() == turned
    assert made.spindle_calibration.sum() == 103
    assert made.spindle_test.sum() == 100


@pytest.mark.parametrize("seed", [1, 20])
def test_a_campaign_has_the_published_cuts(seed: int) -> None:
    made = reference_lathe.campaign(seed)
    for table, turned, faced in ((made.calibration, 105, 13), (made.test, 180, 16)):
        operations = table["operation"].tolist()
        assert operations.count("face") == faced
        assert len(operations) - faced == turned
        assert np.all((table["spindle.speed"] > 800.0) & (table["spindle.speed"] < 2400.0))
    assert made.spindle_calibration.sum() == 102
    assert made.spindle_test.sum() == 113
    assert set(made.calibration["work.material"]) == {"steel bar"}
    assert len(set(made.test["work.material"])) == 3
    again = reference_lathe.campaign(seed)
    assert_allclose(again.test["force.x"], made.test["force.x"], rtol=0.0)
