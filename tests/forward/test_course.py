"""A cut that goes from one diameter to another: its mean, start, end and peak."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.files.job_cut import JobCut
from autodb.files.machine import AxisLimits
from autodb.fitting.gaussian import Gaussian
from autodb.forward import job_cuts
from autodb.forward.limits import exceeding
from autodb.forward.predictedfile import prediction_as_csv
from autodb.forward.prediction import Moment, Peaks, PredictedCut
from autodb.pairs.posterior import WEAR, PairPosterior, PairTerms, Shared, Wear
from tests.helpers.known_pairs import INSERT, known

FACE = JobCut(
    name="f", operation="face", diameter_mm=60, end_diameter_mm=20, depth_mm=1.5, feed_mm_rev=0.2,
    speed_rpm=1000,
)  # fmt: skip
TAPER = FACE.model_copy(update={"operation": "taper", "length_mm": 30.0})
QUANTITIES = ("force_x_N", "force_y_N", "force_z_N", "torque_N_m", "power_W")


def one(cut: JobCut, posterior: PairPosterior | None = None) -> PredictedCut:
    (found,) = job_cuts.predict(posterior or known(), INSERT, [cut])
    return found


def at(cut: JobCut, diameter_mm: float, posterior: PairPosterior | None = None) -> PredictedCut:
    """Return what a cut takes that stays at one diameter, in the same direction."""
    direction = {} if cut.operation == "face" else {"direction_deg": cut.inward_deg}
    stays = {"diameter_mm": diameter_mm, "end_diameter_mm": None, "length_mm": None, **direction}
    return one(cut.model_copy(update=stays), posterior)


def _three(found: PredictedCut | Moment | Peaks, name: str) -> list[float]:
    given = getattr(found, name)
    return [given.value, given.low, given.high]


@pytest.mark.parametrize("cut", [FACE, TAPER], ids=["face", "taper"])
def test_start_and_end_are_those_of_cuts_that_stay_there(cut: JobCut) -> None:
    found = one(cut)
    assert found.start is not None
    assert found.end is not None
    for moment, diameter_mm in ((found.start, 60.0), (found.end, 20.0)):
        stays = at(cut, diameter_mm)
        assert moment.diameter_mm == diameter_mm
        assert_allclose([moment.speed_rpm, moment.speed_m_min], [1000.0, np.pi * diameter_mm])
        for name in QUANTITIES:
            assert_allclose(_three(moment, name), _three(stays, name), rtol=1e-9)


@pytest.mark.parametrize("cut", [FACE, TAPER], ids=["face", "taper"])
def test_the_mean_is_that_of_many_moments_of_equal_time(cut: JobCut) -> None:
    """At one feed a revolution and one spindle speed the radius falls evenly in time."""
    diameters = 60.0 - 40.0 * (np.arange(200) + 0.5) / 200
    many = [at(cut, diameter_mm) for diameter_mm in diameters.tolist()]
    found = one(cut)
    for name in QUANTITIES:
        mean = np.mean([getattr(each, name).value for each in many])
        assert_allclose(getattr(found, name).value, mean, rtol=1e-3)


@pytest.mark.parametrize("cut", [FACE, TAPER], ids=["face", "taper"])
def test_power_is_torque_times_angular_speed_at_every_statistic(cut: JobCut) -> None:
    found = one(cut)
    assert [name for name, _ in found.statistics] == ["start", "end", "peak along the cut"]
    for some in (found, *(one for _, one in found.statistics)):
        omega = 1000 * np.pi / 30
        torque = np.array(_three(some, "torque_N_m"))
        assert_allclose(_three(some, "power_W"), torque * omega, rtol=1e-9)


def test_a_peak_is_the_largest_along_the_cut_and_limits_are_of_it() -> None:
    found = one(FACE)
    assert found.peaks is not None
    assert found.start is not None
    assert found.peaks.torque_N_m == found.start.torque_N_m
    assert found.peaks.torque_N_m.value > 1.4 * found.torque_N_m.value
    between = 0.5 * (found.torque_N_m.value + found.peaks.torque_N_m.value)
    (said,) = exceeding([found], {"spindle": AxisLimits(torque_N_m=between)})
    assert said.probability > 0.5


def test_facing_to_the_centre_ends_without_torque() -> None:
    found = one(FACE.model_copy(update={"end_diameter_mm": 0.0}))
    assert found.end is not None
    assert_allclose([found.end.torque_N_m.high, found.end.power_W.high], 0.0, atol=1e-9)
    assert np.isfinite(found.end.force_y_N.high)
    assert_allclose(found.torque_N_m.value, 0.015 * found.force_y_N.value, rtol=0.02)


def test_a_cut_that_stays_at_its_diameter_has_no_course() -> None:
    for operation in ("turn", "face"):
        stays = {"operation": operation, "end_diameter_mm": None}
        assert one(FACE.model_copy(update=stays)).start is None
    assert one(FACE.model_copy(update={"end_diameter_mm": 60.0})).statistics == ()


def test_the_wear_of_one_edge_is_shared_by_its_steps() -> None:
    """What an edge differs by does not average out along the cut that it makes."""
    worn = known().also((Shared(WEAR, np.diag([100.0, 100.0])),))
    mean = worn.state.mean.copy()
    mean[worn.columns(WEAR)] = [40.0, 60.0]
    posterior = replace(
        worn,
        state=Gaussian(mean, worn.state.covariance),
        terms=PairTerms(Wear(reference_s=100.0, power=1.0, between=0.3, size=(40.0, 60.0))),
    )
    used = FACE.model_copy(update={"cutting_time_s": 100.0, "end_diameter_mm": 59.999})
    stays, found = at(used, 60.0, posterior), one(used, posterior)
    for name in QUANTITIES:
        assert_allclose(_three(found, name), _three(stays, name), rtol=1e-4)
    assert found.force_y_N.value > one(FACE, posterior).force_y_N.value + 10.0


def test_a_table_has_start_end_and_peak_by_name() -> None:
    stays = FACE.model_copy(update={"operation": "turn", "end_diameter_mm": None})
    cuts = job_cuts.predict(known(), INSERT, [FACE, stays])
    head, face, turn = (row.split(",") for row in prediction_as_csv(cuts, {}).splitlines())
    rows = [dict(zip(head, row, strict=True)) for row in (face, turn)]
    statistics = {"start": cuts[0].start, "end": cuts[0].end, "peak": cuts[0].peaks}
    for channel, field in (("torque.spindle", "torque_N_m"), ("spindle.power", "power_W")):
        for name, some in statistics.items():
            written = float(rows[0][f"{channel}.{name}"])
            assert_allclose(written, getattr(some, field).value, rtol=1e-5)
            assert rows[1][f"{channel}.{name}"] == ""
