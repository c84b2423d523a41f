"""A linear drive of a known truth in P0's four steps, and the joint fit beside them."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.agent.sense.staging import StagedMoves, pole_of, staged_fits, stages_beside
from autodb.errors import UnusableInput
from autodb.proofs.machines.mill.reference_mill import draw_mill, swept_axis
from autodb.proofs.machines.mill.reference_mill_moves import PITCH_MM
from autodb.proofs.runs.mill import mill_ours
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import default_terms, identify
from autodb.sensing.drives.fit.axis_model import Identified
from autodb.sensing.drives.moves.prepared import Prepared, prepared
from autodb.sensing.drives.staged.agreement_linear import linear_agreement
from autodb.sensing.drives.staged.clusters import one_out
from autodb.sensing.drives.staged.linear import FourSteps, four_steps
from autodb.sensing.drives.staged.over_speed import FrictionLevels, fit_speed_law
from autodb.sensing.drives.staged.routine import Staged
from tests.conftest import Cli
from tests.helpers.files import write
from tests.helpers.staged_axis import MIDDLE_MM, POLE_MM, Axis, pole_shape, recorded

Array = NDArray[np.float64]

AXIS = Axis(stiffness=0.004, cogging=0.1, slope=0.0, ripple=0.0)
TERMS = (*default_terms("axis"), "stribeck", "spring", "cogging")
FEW_MM_S = (2.0, 4.0, 8.0, 16.0, 30.0, 60.0, 120.0)
FAR = 5.0
"""Standard deviations that a test of two sweeps allows, as Student's t of a dozen passes has them:
of 40 other axes none of slope, rest and inertia was farther off than 3.1 (benchmarks.staged_axes).
"""
LINE_SHARE = 0.08
"""Of the slope that one sweep tells: six times its standard deviation, which four long passes tell
too badly to count by."""


@pytest.fixture(scope="module")
def moves() -> Recording:
    """Return two sweeps of the axis over its speeds."""
    return recorded(AXIS, 1, repeats=2)


@pytest.fixture(scope="module")
def rows(moves: Recording) -> Prepared:
    """Return it ready to be fitted."""
    return prepared(moves)


@pytest.fixture(scope="module")
def found(rows: Prepared) -> FourSteps:
    """Return its four steps."""
    return four_steps(rows, pole_mm=POLE_MM, cold=False)


@pytest.fixture(scope="module")
def model(moves: Recording) -> Identified:
    """Return its joint fit."""
    return identify(moves, terms=TERMS)


def _near(told: tuple[float, float], truth: float) -> None:
    assert_allclose(told[0], truth, atol=FAR * told[1])


def test_the_line_is_found(found: FourSteps) -> None:
    """Slope, rest and the level over a pole: 3 numbers."""
    _near(found.load.slope, AXIS.stiffness)
    assert found.load.slope[1] < 0.03 * AXIS.stiffness
    _near(found.load.rest, MIDDLE_MM - AXIS.weight / AXIS.stiffness)
    turn = MIDDLE_MM + POLE_MM * (np.arange(36) + 0.5) / 36
    level, sd = found.load.told(turn, np.full((1, 36), 1.0 / 36))
    _near((level[0], sd[0]), float(AXIS.load(turn).mean()))
    assert sd[0] < 0.005


def test_the_table_is_found(found: FourSteps) -> None:
    """36 nodes, whose mean is 0; by the median of their sd, of which some are told low."""
    nodes, sd = found.load.table
    truth = AXIS.cogging * pole_shape(np.arange(36) * POLE_MM / 36)
    assert_allclose(nodes, truth, atol=FAR * float(np.median(sd)))
    assert 0.4 < np.sqrt(np.mean(((nodes - truth) / sd) ** 2)) < 2.5
    assert_allclose(nodes.sum(), 0.0, atol=1e-12)
    assert np.median(sd) < 0.08 * AXIS.cogging
    assert_allclose(found.load.at(np.array([60.0])), AXIS.load(np.array([60.0])), atol=0.02)


def test_friction_over_speed_and_inertia_are_found(found: FourSteps) -> None:
    """8 frictions: runs are 2 % stiffer or easier each, two of them 1.4 % (sd); 1 inertia."""
    for speed in (1.0, 4.0, 30.0, 120.0):
        for sense in (1, -1):
            size, _ = found.friction(np.array([speed]), sense)
            truth = AXIS.size(np.array([MIDDLE_MM]), np.array([speed]))
            assert_allclose(size, truth, rtol=0.07)
    assert found.inertia is not None
    assert_allclose(found.inertia.value, AXIS.inertia, atol=FAR * found.inertia.sd)
    assert found.inertia.sd < 0.1 * AXIS.inertia


def test_speeds_passed_once_will_do(found: FourSteps) -> None:
    """What the law leaves tells the error of friction; that of the load, what speeds differ by."""
    once = four_steps(prepared(recorded(AXIS, 2, repeats=1)), pole_mm=POLE_MM, cold=False)
    assert found.repeated
    assert not once.repeated
    assert_allclose(once.load.slope[0], AXIS.stiffness, rtol=LINE_SHARE)
    for sense, law in once.laws.items():
        assert law.lack > 0.0
        assert not law.levels.sd.any()
        size, sd = once.friction(np.array([8.0]), sense)
        assert_allclose(size, AXIS.size(np.array([MIDDLE_MM]), np.array([8.0])), rtol=0.12)
        assert 0.0 < sd[0] < 0.1 * size[0]


def test_a_law_that_leaves_nothing_stays_finite() -> None:
    speed = np.geomspace(1.0, 100.0, 5)
    none = np.zeros(5)
    exact = FrictionLevels(speed, 0.9 + 0.002 * speed, none, np.ones(5, dtype=bool), 0.0, none)
    value, sd = fit_speed_law(exact).at(speed)
    assert_allclose(value, exact.friction, rtol=1e-9)
    assert np.all((sd > 0.0) & (sd < 1e-4))


def test_leaving_groups_out_tells_what_least_squares_does() -> None:
    """40 groups of 50 rows of white noise: the variances' sd is 23 %, two of them."""
    rng = np.random.default_rng(11)
    design = rng.standard_normal((2000, 2))
    target = design @ np.array([1.0, -2.0]) + 0.1 * rng.standard_normal(2000)
    covariance = one_out(design, target, np.arange(2000) // 50)
    plain = 0.01 * np.linalg.inv(design.T @ design)
    assert_allclose(np.diag(covariance), np.diag(plain), rtol=0.9)


def test_a_mill_with_a_linear_drive_is_told() -> None:
    """Slope and mass; poles differ, so that line and table leave a share of the load."""
    axis = draw_mill(131)["y"]
    seen = mill_ours.mill_recording(swept_axis(131, axis), "y")
    steps = four_steps(prepared(seen), pole_mm=PITCH_MM, cold=False)
    scale = axis.newtons_per_ampere
    assert_allclose(steps.load.slope[0] * scale, axis.spring_N_mm, rtol=0.05)
    assert steps.inertia is not None
    assert_allclose(1000.0 * scale * steps.inertia.value, axis.moved_kg, rtol=0.02)
    x_mm = np.arange(15.0, 300.0, 0.2)
    left = axis.cogging.force_N(x_mm) + axis.spring_N_mm * x_mm - scale * steps.load.at(x_mm)
    assert_allclose(np.std(left), scale * steps.load.lack, rtol=0.35)


def test_an_axis_without_cogging_has_a_line_alone() -> None:
    smooth = recorded(replace(AXIS, cogging=0.0), 3, repeats=1)
    made = four_steps(prepared(smooth), pole_mm=None, cold=False)
    assert made.load.pole_mm is None
    assert not len(made.load.table[0])
    assert "fortieth of the travel" in made.length.why
    assert_allclose(made.load.slope[0], AXIS.stiffness, rtol=LINE_SHARE)
    joint = identify(smooth, terms=(*default_terms("axis"), "stribeck", "spring"))
    both = linear_agreement(made, joint, prepared(smooth).inputs)
    assert both.agrees
    assert not any(row.name.startswith("cogging") for row in both.rows)


def test_steps_and_joint_fit_agree(found: FourSteps, model: Identified, rows: Prepared) -> None:
    both = linear_agreement(found, model, rows.inputs)
    assert both.agrees
    names = [row.name for row in both.rows]
    assert {"k", "inertia"} < set(names)
    for begin, count in (("line at", 3), ("cogging, ", 6), ("friction at", 10)):
        assert sum(name.startswith(begin) for name in names) == count
    line = next(row for row in both.rows if row.name.startswith("line at"))
    place = float(line.name.split()[2])
    over = place + POLE_MM * (np.arange(360) / 360 - 0.5)
    assert_allclose([line.staged, line.joint], AXIS.load(over).mean(), atol=0.02)


def test_a_joint_fit_that_is_off_does_not_agree(
    found: FourSteps, model: Identified, rows: Prepared
) -> None:
    assert model.steady is not None
    stiff = replace(model, steady=replace(model.steady, values=1.3 * model.steady.values))
    both = linear_agreement(found, stiff, rows.inputs)
    assert not both.agrees
    differing = {row.name for row in both.differing}
    assert "k" in differing
    assert {name.split()[0] for name in differing} >= {"k", "line", "cogging,"}


def test_which_routine_runs_follows_from_the_terms_and_the_screw(
    moves: Recording, model: Identified
) -> None:
    asked = frozenset(TERMS)
    linear = staged_fits(StagedMoves(moves, None, screw=False, asked=asked), None)
    assert isinstance(linear.found, FourSteps)
    steps, both = stages_beside(model, linear)
    assert isinstance(steps, FourSteps)
    assert steps.load.pole_mm == pole_of(model) == pytest.approx(POLE_MM, rel=0.01)
    assert both.agrees
    short = recorded(AXIS, 5, repeats=2, speeds=(4.0, 8.0, 30.0, 60.0, 120.0))
    screw = staged_fits(StagedMoves(short, 10.0, screw=True, asked=asked), None)
    assert isinstance(screw.found, Staged)


def test_passes_that_tell_no_load_are_refused(rows: Prepared) -> None:
    with pytest.raises(UnusableInput, match="there and back 0 times, and the four steps"):
        four_steps(rows, pole_mm=90.0, cold=False)
    few = prepared(recorded(AXIS, 2, repeats=1, speeds=(4.0, 16.0, 30.0, 60.0, 120.0)))
    with pytest.raises(UnusableInput, match="each once, so the uncertainty of friction"):
        four_steps(few, pole_mm=POLE_MM, cold=False)


def test_identify_staged_of_a_linear_drive(cli: Cli, refused: Callable[..., str]) -> None:
    write(Path("moves.parquet"), recorded(AXIS, 4, repeats=1, speeds=FEW_MM_S).channels)
    terms = ("--terms", ",".join(TERMS))
    done = cli("identify", "moves.parquet", *terms, "--staged")
    assert done.code == 0, done.err
    said = " ".join(done.out.split())
    for line in ("P0's four steps of a linear drive", "k, 7 passes there and back", "rest s_r",
                 "no speed was passed twice", "36 to a pole of 2", "cogging, 6/6 of a pole",
                 "what friction differs by direction"):  # fmt: skip
        assert line in said
    assert "P2's stages" not in said
    few = "half of the travel, 3 poles at least"
    assert few in refused("identify", "moves.parquet", *terms, "--staged", "--pitch", "90")
