"""The reference mills, the published way to their forces, and autodb's."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb import signals
from autodb.proofs.machines.mill import reference_mill_moves, reference_milling
from autodb.proofs.machines.mill.reference_cuts import PLAN
from autodb.proofs.machines.mill.reference_mill import (
    Logged,
    MillAxis,
    draw_mill,
    mill_cut,
    swept_axis,
)
from autodb.proofs.runs.mill import mill_run, mill_summary
from autodb.proofs.runs.mill.mill_ours import loads_A
from autodb.proofs.runs.mill.mill_run import PUBLISHED, ForceErrors, KeptOfAxis
from autodb.proofs.runs.mill.mill_summary import PUBLISHED_N
from autodb.proofs.runs.mill.published_mill import PublishedStribeck, published_four_steps
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.sensing.drives.fit.axis_model import terms_with
from autodb.sensing.drives.fit.drive_errors import DriveErrors
from autodb.sensing.drives.reconstruct import DriveModel

ORIGIN = Origin("mill-forces", "0", "g", "p")
SEED = 101
"""Of development, none of the proof's."""


@pytest.fixture(scope="module")
def mill() -> dict[str, MillAxis]:
    """One mill."""
    return draw_mill(SEED)


def test_axes_carry_each_other(mill: dict[str, MillAxis]) -> None:
    x, y, z = (mill[name].moved_kg for name in "xyz")
    assert 0.8 * 90.0 <= z <= 1.2 * 90.0
    assert 0.8 * 130.0 <= x - z <= 1.2 * 130.0
    assert 0.8 * 170.0 <= y - x <= 1.2 * 170.0


def test_moves_are_their_own_derivatives() -> None:
    paths = [reference_mill_moves.mill_sweep_motion()]
    for cut in PLAN[3:5]:
        paths += reference_mill_moves.travelled((100.0, 100.0, 100.0), cut.legs()).axes.values()
    for motion in paths:
        gone = np.concatenate([[0.0], np.cumsum(0.5 * (motion.v[1:] + motion.v[:-1])) * 0.004])
        assert_allclose(motion.x[0] + gone, motion.x, atol=0.3)
        faster = np.cumsum(0.5 * (motion.a[1:] + motion.a[:-1])) * 0.004
        assert_allclose(faster, motion.v[1:], atol=4.0)


def test_a_ramp_has_the_published_peak_forces() -> None:
    peaks = []
    for seed in range(SEED, SEED + 5):
        ramp = mill_cut(seed, draw_mill(seed), 3, PLAN[3])
        peaks.append([np.abs(ramp.load_N[name]).max() for name in "xy"])
    assert_allclose(np.median(peaks, axis=0), [206.2, 115.5], rtol=0.15)  # P0 Table 2


def test_tooth_passing_shows_folded_in_currents_and_not_in_the_force(
    mill: dict[str, MillAxis],
) -> None:
    made = mill_cut(SEED, mill, 6, PLAN[6])
    assert made.cut.speed_rpm == 4500.0  # 300 Hz: folds to 50 Hz, where no order of the spindle is
    rows = (made.t > made.begins_s + 2.0) & (made.t < made.ends_s - 2.0)
    cut_N = made.axes["x"].current_A * mill["x"].newtons_per_ampere - made.air_N["x"]

    def at_50_hz(values: np.ndarray) -> float:
        share = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(values)))) ** 2
        hz = np.fft.rfftfreq(len(values), 0.004)
        return float(share[np.abs(hz - 50.0) < 1.0].sum())

    assert at_50_hz(cut_N[rows]) > 5.0 * at_50_hz(made.load_N["x"][rows])
    assert_allclose(made.spindle_rpm, 4500.0, rtol=0.01)
    assert made.spindle_A[rows].mean() > made.spindle_A[made.t < made.begins_s].mean() + 0.5


def test_mean_forces_of_a_slot_are_those_of_the_closed_form() -> None:
    slot = reference_milling.MillEngagement(2.0, 10.0, 0.03, False, 0.0, 0.0)
    mean = reference_milling.orders(slot)[:, 0].real
    work = reference_milling.C45
    tangential, radial = zip(work.chip_N_mm2[:2], work.edge_N_mm, strict=True)
    normal_N = 4 * 2.0 * (tangential[0] * 0.03 / 4.0 + tangential[1] / np.pi)
    feed_N = -4 * 2.0 * (radial[0] * 0.03 / 4.0 + radial[1] / np.pi)
    assert_allclose(mean[:2], [feed_N, normal_N], rtol=0.01)


def test_another_work_takes_its_own_forces_of_the_same_cut(mill: dict[str, MillAxis]) -> None:
    """Half of every coefficient is half of the load; motion and friction are as they were."""
    steel = reference_milling.C45
    half = reference_milling.TeethLaw("half", (1075.0, 425.0, 150.0), (10.0, 8.5))
    made, softer = (mill_cut(SEED, mill, 4, PLAN[4], work) for work in (steel, half))
    assert_allclose(softer.load_N["x"], 0.5 * made.load_N["x"], atol=1e-9)
    assert_allclose(softer.axes["x"].motion.x, made.axes["x"].motion.x, atol=0.0)
    assert_allclose(softer.air_N["y"], made.air_N["y"], atol=0.0)


def test_the_same_seed_gives_the_same_bytes(mill: dict[str, MillAxis]) -> None:
    made, again = (mill_cut(SEED, draw_mill(SEED), 4, PLAN[4]) for _ in range(2))
    assert made.axes["y"].current_A.tobytes() == again.axes["y"].current_A.tobytes()
    assert made.load_N["y"].tobytes() == again.load_N["y"].tobytes()
    other = mill_cut(SEED + 1, mill, 4, PLAN[4])
    assert made.axes["y"].current_A.tobytes() != other.axes["y"].current_A.tobytes()


def test_cogging_is_of_a_pole_and_no_few_clean_harmonics() -> None:
    x, beyond = 0.1 * np.arange(230.0), []
    for seed in range(SEED, SEED + 10):
        cogging = replace(draw_mill(seed)["x"].cogging, changes=(), shifts_mm=())
        force_N = cogging.force_N(x)
        next_N = cogging.force_N(np.add(x, reference_mill_moves.PITCH_MM))
        assert_allclose(force_N, next_N, atol=1e-9)
        assert_allclose(float(np.std(force_N)), cogging.rms_N, rtol=0.02)
        power = np.abs(np.fft.rfft(force_N)[1:]) ** 2
        beyond.append(float(np.sum(power[4:]) / np.sum(power)))
    assert np.median(beyond) > 0.05, "above the fourth harmonic"


def test_four_steps_find_a_machine_of_their_own_form_again() -> None:
    motion = reference_mill_moves.mill_sweep_motion()
    x, v = motion.x, motion.v
    turn = 2.0 * np.pi * x / reference_mill_moves.PITCH_MM
    cogging_N = 30.0 * np.sin(turn) + 10.0 * np.cos(3.0 * turn)
    law = PublishedStribeck(np.array([180.0, 230.0, 4.0, 0.5]))
    effort_N = 0.3 * (x - 120.0) + cogging_N + law(v) + 0.25 * motion.a
    found = published_four_steps(Logged(motion, effort_N / 90.0), 90.0)
    assert_allclose(found.slope, 0.3, rtol=0.02)
    assert_allclose(found.rest_mm, 120.0, atol=2.0)
    assert_allclose(found.friction.p, law.p, rtol=0.01)
    assert_allclose(found.mass, 0.25, rtol=0.005)
    place = np.linspace(0.0, 23.0, 40)
    found_N = found.placed_N(place) - found.slope * (place - found.rest_mm)
    assert_allclose(found_N, np.interp(place, x[:40000], cogging_N[:40000], period=23.0), atol=2.0)


def test_the_published_way_is_far_off_only_where_axes_turn(mill: dict[str, MillAxis]) -> None:
    cuts = [mill_cut(SEED, mill, number, PLAN[number]) for number in (0, 4)]
    made = mill_run.force_errors(PUBLISHED, mill_run.published_forces(SEED, mill, cuts), cuts)
    slot, pocket = (max(one.rmse_N for one in made if one.cut == cut.cut.name) for cut in cuts)
    assert slot < 60.0 < pocket
    assert isinstance(swept_axis(SEED, mill["z"]), Logged)


def test_what_another_day_leaves_is_less_than_the_published_way_leaves_in_a_pocket(
    mill: dict[str, MillAxis],
) -> None:
    cuts = [mill_cut(SEED, mill, 4, PLAN[4])]
    ways = (mill_run.published_forces(SEED, mill, cuts), mill_run.known(mill, cuts))
    published, known = (mill_run.force_errors("", loads, cuts) for loads in ways)
    for one, other in zip(known, published, strict=True):
        assert one.rmse_N < 0.5 * other.rmse_N
        assert one.slow_N < one.rmse_N


def test_the_load_is_what_a_model_leaves_of_the_current(mill: dict[str, MillAxis]) -> None:
    made = mill_cut(SEED, mill, 0, PLAN[0])
    errors = DriveErrors(((0.0,) * 3,) * 6, 0.0, 100.0, 1000.0, (0.0, 330.0))
    terms = terms_with({"gravity": 0.5}, "A")
    model = DriveModel("x", "x.current", "A", terms, np.zeros((1, 1)), errors)
    load_A = loads_A({"x": model}, [made], bandwidth_hz=10.0)[made.cut.name, "x"]
    slow_A = signals.lowpass(made.axes["x"].current_A, rate_hz=250.0, cutoff_hz=10.0)
    assert_allclose(load_A, slow_A - 0.5, atol=1e-9)


def _errors(way: str, factor: float) -> list[ForceErrors | KeptOfAxis]:
    return [ForceErrors(way, cut, axis, factor * n, n) for (cut, axis), n in PUBLISHED_N.items()]


def _runs(factor: float) -> list[Finished[ForceErrors | KeptOfAxis]]:
    return [Finished(1, tuple(_errors(PUBLISHED, factor)))]


def _forces(factor: float, pole_mm: float = 23.1) -> mill_summary.ForcesGate:
    kept = [KeptOfAxis(axis, "a table", pole_mm, 201.0, 200.0) for axis in "xy"]
    made = [*_errors(PUBLISHED, 1.0), *_errors(mill_run.OURS, factor), *kept]
    return mill_summary.forces_of([Finished(1, tuple(made))], ORIGIN)


def test_limits_of_the_forces() -> None:
    good = _forces(0.49)
    assert good.passed
    assert mill_summary.ForcesGate.from_json(good.to_json()) == good
    assert_allclose([row.mass for row in good.kept], 0.005)
    assert [len(table.rows) for table in good.tables()] == [4, 2, 8, 2]
    assert not _forces(0.6).passed, "a pocket has a lower limit than a slot"
    assert not _forces(0.49, pole_mm=7.67).passed


def test_limits_of_the_gate() -> None:
    good = mill_summary.mill_gate_of(_runs(0.9), ORIGIN)
    assert good.passed
    assert mill_summary.MillGate.from_json(good.to_json()) == good
    assert not mill_summary.mill_gate_of(_runs(0.7), ORIGIN).passed
    assert not mill_summary.mill_gate_of(_runs(1.3), ORIGIN).passed
    assert not replace(good, mean_N=90.0).passed
