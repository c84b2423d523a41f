"""The reference axes, the published way to their friction field, the oracle's, and autodb's."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.proofs.machines.axis import reference_axis, reference_friction, reference_moves
from autodb.proofs.machines.axis.motion import TrueMotion
from autodb.proofs.machines.axis.reference_axis import Traced, recorded_axis
from autodb.proofs.runs.axis import axis_oracle, axis_run, axis_summary
from autodb.proofs.runs.axis.axis_cells import segments
from autodb.proofs.runs.axis.axis_errors import field_error
from autodb.proofs.runs.axis.axis_ours import axis_recording, ours
from autodb.proofs.runs.axis.axis_run import ORACLE, OURS, PUBLISHED, AxisModelErrors
from autodb.proofs.runs.axis.published_axis import SevenParameters, published_axis, published_weight
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.sensing.drives.moves.protocol import FilterProtocol, means_by_way
from autodb.timing import Timing

ORIGIN = Origin("axis-field", "0", "g", "p")
SEED = 101
"""Of development, none of the proof's."""


@pytest.fixture(scope="module")
def made() -> Traced:
    """One axis, with its recordings."""
    return recorded_axis(SEED, "x")


def test_the_sweep_is_the_published_one() -> None:
    speeds = reference_moves.speeds_mm_s()
    assert len(speeds) == 27
    assert_allclose(60.0 * speeds[[0, 8, 9, 17, 18, 26]], [10, 90, 100, 900, 1000, 9000])
    for motion in (reference_moves.axis_sweep_motion()[0], reference_moves.contour_motion()[0]):
        step_s = motion.t[1] - motion.t[0]
        gone = np.concatenate([[0.0], np.cumsum(0.5 * (motion.v[1:] + motion.v[:-1])) * step_s])
        assert_allclose(motion.x[0] + gone, motion.x, atol=0.5)
        assert motion.x.min() >= 0.0
        assert motion.x.max() <= 500.0


def test_friction_falls_as_published_while_it_warms() -> None:
    for seed in range(SEED, SEED + 40):
        warming = reference_axis.draw_reference_axis(seed, "x").friction.warming
        fallen = warming.drop * warming.warmth(np.ones(5001), 0.01)
        assert 0.05 <= fallen[1000] <= 0.10
        assert 0.145 <= fallen[5000] <= 0.205
        rest = warming.warmth(np.zeros(30_000), 0.01, start=0.8)
        assert rest[-1] < 0.3, "after five minutes at rest"


def test_runs_differ_by_a_tenth() -> None:
    made = recorded_axis(SEED, "y")
    sd = np.sqrt(reference_axis.RUN_SD**2 + reference_axis.SLOW_SD**2 + reference_axis.PLACE_SD**2)
    assert_allclose(2.0 * sd, 0.10, rtol=0.01)
    moving = np.abs(made.sweep.motion.v) > 0.1
    shown = made.sweep.current_A[moving] / made.sweep.expected_A[moving] - 1.0
    assert 0.5 * sd < np.std(shown) < 2.0 * sd


def test_sliders_turn_over_their_way_and_hold_at_standstill() -> None:
    x = np.concatenate([np.linspace(0.0, 1.0, 101), np.full(20, 1.0), np.linspace(1.0, 0.0, 101)])
    z = reference_friction.slid_state(x, (0.01, 0.02, 0.05, 0.1))
    assert_allclose(z[[50, 100, 119]], 1.0)
    assert_allclose(z[-1], -1.0)
    assert np.all(np.diff(z[121:]) <= 1e-12)
    assert_allclose(
        z[122], 1.0 - 2.0 * (0.4 * 0.5 + 0.3 * 0.25 + 0.2 * 0.1 + 0.1 * 0.05), atol=1e-9
    )


def test_the_same_seed_gives_the_same_bytes(made: Traced) -> None:
    again = recorded_axis(SEED, "x")
    assert made.sweep.current_A.tobytes() == again.sweep.current_A.tobytes()
    assert made.contour.current_A.tobytes() == again.contour.current_A.tobytes()
    assert made.sweep.current_A.tobytes() != recorded_axis(SEED + 1, "x").sweep.current_A.tobytes()


def test_a_field_of_the_published_form_is_found_again(made: Traced) -> None:
    where = segments(made)
    p = np.array([0.9, 1.3, 2.0, 1.2, 0.05, 3.0, 0.001])
    law, v, x = SevenParameters(p), where.v_mm_s, where.x_mm
    current_A = np.sign(v) * (law(np.abs(v)) + 0.0004 * (x - 255.0)) + 3.0
    cells = replace(where.cells(made.sweep.current_A), current_A=current_A)
    assert_allclose(published_weight(cells), 3.0, atol=1e-9)
    model = published_axis(cells, vertical=True)
    assert field_error(cells, model.current_A(x, v), 3.0) < 0.003
    bent = cells.of(current_A + 0.2 * np.sign(v) * np.sin(x / 60.0))
    published = published_axis(bent, vertical=True)
    assert field_error(bent, published.current_A(x, v), 3.0) > 0.02, "a line along the travel"


def test_the_oracle_of_a_run_without_noise_is_the_truth(made: Traced) -> None:
    quiet = replace(made, sweep=replace(made.sweep, current_A=made.sweep.expected_A))
    sweep_A, contour_A = axis_oracle.currents_A(quiet, segments(made))
    assert_allclose(sweep_A, made.sweep.expected_A, atol=1e-3)
    assert_allclose(contour_A, made.contour.expected_A, atol=1e-3)


@pytest.mark.campaign
def test_autodb_is_nearer_to_the_true_field_and_contour_than_the_published_way(
    made: Traced,
) -> None:
    where = segments(made)
    found = ours(made, where)
    true = where.cells(made.sweep.expected_A)
    published = published_axis(where.cells(made.sweep.current_A), vertical=False)
    published_error = field_error(true, published.current_A(true.x_mm, true.v_mm_s), 0.0)
    assert field_error(true, where.means(found.sweep_A), 0.0) < 0.75 * published_error
    assert field_error(true, where.means(found.sweep_terms_A), 0.0) > published_error
    motion, contour_A = made.contour.motion, made.contour.expected_A
    moves = np.abs(motion.v) > 1.0
    off, published_off = (
        float(np.mean(np.abs(one - contour_A)[moves]))
        for one in (found.contour_A, published.current_A(motion.x, motion.v))
    )
    assert off < 0.5 * published_off


def _errors(way: str, axis: str, measured: float) -> AxisModelErrors:
    return AxisModelErrors(
        way, axis, measured, measured, 0.03, 0.03, 0.12, 0.005 if axis == "z" else None
    )


def _runs(**measured: float) -> list[Finished[AxisModelErrors]]:
    size = {"x": 0.032, "y": 0.024, "z": 0.10}
    made = tuple(
        _errors(way, axis, measured.get(way.split()[0].replace(",", ""), 0.5) * size[axis])
        for axis in size
        for way in (PUBLISHED, OURS, axis_run.TERMS_ALONE, ORACLE, axis_run.KNOWN)
    )
    return [Finished(1, made)]


def test_limits() -> None:
    good = axis_summary.fields_of(_runs(**{"as": 1.0, "autodb": 0.58, "oracle": 0.4}), ORIGIN)
    assert good.passed
    assert_allclose(good.limit("x"), 0.6 * 0.032)
    assert axis_summary.Fields.from_json(good.to_json()) == good
    near = axis_summary.fields_of(_runs(**{"as": 1.0, "autodb": 0.9, "oracle": 0.8}), ORIGIN)
    assert near.passed, "near the oracle is enough"
    assert not axis_summary.fields_of(_runs(**{"as": 1.0, "autodb": 0.7}), ORIGIN).passed
    gate = axis_summary.axis_gate_of(_runs(**{"as": 1.0}), ORIGIN)
    assert gate.passed
    assert axis_summary.AxisGate.from_json(gate.to_json()) == gate
    assert not axis_summary.axis_gate_of(_runs(**{"as": 0.5}), ORIGIN).passed
    light = [Finished(1, tuple(replace(one, weight=0.02) for one in _runs()[0].judged))]
    assert not axis_summary.fields_of(light, ORIGIN).passed
    far = [Finished(1, tuple(replace(one, contour=0.2) for one in _runs(**{"as": 1.0})[0].judged))]
    assert not axis_summary.axis_gate_of(far, ORIGIN).passed


def test_means_by_way_are_short_at_turns_and_long_at_creep() -> None:
    v = np.concatenate([np.full(6000, 0.5), np.zeros(500), np.full(500, -50.0)])
    timing = Timing(0.02, (slice(0, len(v)),), len(v))
    made = means_by_way(FilterProtocol(20.0, 5), v, timing=timing)
    count = np.diff([*made.edges, len(v)])
    assert count[0] == 5, "after a turn"
    assert count[made.edges.index(6000)] == 500, "a standstill is one mean"
    assert 400 < count[1] <= 505, "5 mm at 0.5 mm/s take 500 rows"
    assert np.all(count[made.edges.index(6500) :] == 5), "50 mm/s go 5 mm in 5 rows"
    values = np.arange(len(v), dtype=float)
    assert_allclose(np.sum(made.reduced(values, timing=timing) * count), values.sum())
    both = made.reduced(np.column_stack([values, v]), timing=timing)
    assert both.shape == (len(count), 2)


def test_the_recording_is_what_a_control_traces(made: Traced) -> None:
    seen = axis_recording(made.sweep, "x")
    assert set(seen.channels) == {"t", "x.position", "x.velocity", "x.current"}
    assert isinstance(made.sweep.motion, TrueMotion)
