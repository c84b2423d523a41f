"""The reference lathes, and the published way to calibrate them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.prove import published_lathe
from autodb.prove.published_lathe import SpindleLaw
from autodb.prove.runs import Finished, Origin
from autodb.virtual import reference_lathe

ORIGIN = Origin("published-lathe", "0", "g", "p")


def _summary(stretch: float = 1.0) -> published_lathe.Summary:
    runs = [Finished(seed, tuple(published_lathe.run(seed))) for seed in range(1, 21)]
    stretched = [
        Finished(
            run.seed,
            tuple(
                published_lathe.AxisError(one.axis, one.cuts, stretch * one.rmse_N, one.oracle_N)
                for one in run.judged
            ),
        )
        for run in runs
    ]
    return published_lathe.summary_of(stretched, ORIGIN)


def test_the_published_way_lands_on_the_published_errors() -> None:
    found = _summary()
    assert {row.axis: row.cuts for row in found.rows} == {"x": 16, "spindle": 113, "z": 180}
    assert found.passed
    assert not _summary(1.6).passed
    assert all(row.oracle_N < row.rmse_N for row in found.rows)
    assert published_lathe.Summary.from_json(found.to_json()) == found


def test_the_power_law_of_a_spindle_is_found_again() -> None:
    rng = np.random.default_rng(1)
    rpm, rise_A = rng.uniform(800.0, 2400.0, 200), rng.uniform(2.0, 40.0, 200)
    torque_Nm = np.where(rpm <= 1570.0, 1.4, 1.4 * 1570.0 / rpm) * rise_A**0.9
    law = SpindleLaw.fitted(rpm, rise_A, torque_Nm)
    assert_allclose(law(rpm, rise_A), torque_Nm, rtol=2e-3)
    assert_allclose(law(rpm, -rise_A), 0.0)


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
