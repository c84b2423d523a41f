"""What the pages show beside what commands say: maps, how pairs tightened, drives, usual cuts."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.answer.explaining import explain_recording, explain_with_machine
from autodb.agent.answer.force_map import force_map
from autodb.agent.answer.looking_up import PairReader
from autodb.agent.answer.overview import machines_seen
from autodb.agent.answer.prediction_basis import PredictionBasis
from autodb.agent.learn.precision_history import precision_history
from autodb.agent.learn.usual_cut import OTHERWISE, usual_cut
from autodb.agent.operate.deciding import mismatches
from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.drive_maps import drive_map, modelled_channels
from autodb.assets import kit
from autodb.errors import NotThere, UnusableInput
from autodb.files.job_cut import JobCut
from autodb.files.machine import AxisLimits
from autodb.forward.prediction import ToolOf, chance_beyond
from autodb.pairs.engaged import DEPTH, FEED
from autodb.reports.pair import force_map_plots
from autodb.store import Store, models, open_store
from tests.helpers.site import STRANGE, filled

pytestmark = pytest.mark.usefixtures("one_law")

MACHINE = "lathe-1"
CUT = JobCut(operation="turn", diameter_mm=50.0, depth_mm=2.0, feed_mm_rev=0.25, speed_m_min=200.0)


@pytest.fixture(scope="module")
def learnt(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a database whose machine has learnt a pair."""
    path = tmp_path_factory.mktemp("shown") / "made.sqlite3"
    filled(path)
    return path


@pytest.fixture
def store(learnt: Path, tmp_path: Path) -> Iterator[Store]:
    """Return a copy of it, opened."""
    path = tmp_path / "copy.sqlite3"
    path.write_bytes(learnt.read_bytes())
    opened = open_store(f"sqlite:///{path}")
    yield opened
    opened.close()


@pytest.fixture
def session(store: Store) -> Iterator[Session]:
    """Return a session that reads it."""
    with store.reading() as made:
        yield made


@pytest.fixture
def basis(session: Session) -> PredictionBasis:
    """Return what is known of the pair."""
    pair_reader = PairReader(session, MACHINE)
    one = pair_reader.pairs()[0]
    return pair_reader.basis(one.material, one.tool)


# Maps


def test_a_cell_of_a_map_is_the_cut_that_it_stands_for(basis: PredictionBasis) -> None:
    found = force_map(basis, CUT)
    row, column = 3, 5
    there = CUT.model_copy(
        update={"feed_mm_rev": found.feeds[column], "depth_mm": found.across[row]}
    )
    (alone,), _ = basis.predict([there])
    by_field = {layer.quantity.field: layer for layer in found.layers}
    assert_allclose(by_field["force_y_N"].mean[row, column], alone.force_y_N.value, rtol=1e-9)
    torque = by_field["torque_N_m"]
    assert torque.limit == 30.0
    assert_allclose(torque.chance[row, column], chance_beyond(alone.torque_N_m, 30.0), rtol=1e-6)
    assert by_field["power_W"].limit is None
    assert not by_field["power_W"].chance.any()


def test_a_map_holds_what_was_cut_and_the_cut(basis: PredictionBasis) -> None:
    assert basis.states is not None
    ranges = basis.states.usual.ranges
    for cut in (CUT, CUT.model_copy(update={"depth_mm": 9.0})):
        found = force_map(basis, cut)
        assert found.cut_range == (ranges[FEED], ranges[DEPTH])
        for values, own, (low, high) in (
            (found.feeds, cut.feed_mm_rev, ranges[FEED]),
            (found.across, cut.depth_mm, ranges[DEPTH]),
        ):
            assert own is not None
            assert values[0] < min(low, own)
            assert values[-1] > max(high, own)


def test_a_map_of_a_drill_goes_over_speed(session: Session) -> None:
    unknown = PairReader(session, MACHINE).basis("C45", "twist drill")
    drilled = replace(unknown, known=replace(unknown.known, tool=_drill()))
    found = force_map(drilled, OTHERWISE["drill"])
    assert (found.across_key, found.feed_key) == ("speed_m_min", "feed_mm_rev")
    assert found.cut_range is None
    assert len(force_map_plots(found)) < len(found.layers)  # a drill has no force across its axis


def _drill() -> ToolOf:
    return ToolOf("twist drill", {"diameter_mm": 8.0, "teeth": 2.0, "point_angle_deg": 118.0})


def test_limits_that_no_cut_of_a_map_reaches_are_not_drawn(basis: PredictionBasis) -> None:
    near = force_map(basis, CUT)
    far = force_map(replace(basis, limits={"spindle": AxisLimits(torque_N_m=1e6)}), CUT)
    assert sum("chance to exceed the limit" in str(plot) for _, plot in force_map_plots(near)) >= 1
    assert not any("chance to exceed the limit" in str(plot) for _, plot in force_map_plots(far))


# How a pair tightened


def test_what_is_open_of_a_cut_falls_from_the_start_on(
    session: Session, basis: PredictionBasis
) -> None:
    owner = find_machine(session, MACHINE)
    curves = precision_history(session, owner.id, basis.material, basis.known.tool, CUT)
    assert [one.component for one in curves] == ["y", "z"]
    (expected,), _ = basis.predict([CUT])
    for curve, own in zip(curves, (expected.force_y_N, expected.force_z_N), strict=True):
        assert (curve.n[0], curve.n[-1]) == (0.0, basis.known.behind.cuts)
        assert curve.sd[-1] < 0.2 * curve.sd[0]
        assert_allclose(curve.mean[-1], own.value, rtol=1e-9)


def test_a_pair_that_is_not_learnt_has_no_curve(session: Session, basis: PredictionBasis) -> None:
    owner = find_machine(session, MACHINE)
    assert precision_history(session, owner.id, "C45", basis.known.tool, CUT) == ()


# Usual cuts


def test_a_usual_cut_is_one_that_was_made_near_the_middle(
    session: Session, basis: PredictionBasis
) -> None:
    owner = find_machine(session, MACHINE)
    found = usual_cut(session, owner.id, basis.material, basis.known.tool.name)
    feeds, depths = (
        [cut.conditions[name] for cut in session.scalars(select(models.Cut)) if cut.pair_id]
        for name in (FEED, DEPTH)
    )
    assert found.operation == "turn"
    assert found.feed_mm_rev is not None
    assert found.depth_mm is not None
    assert min(abs(found.feed_mm_rev - feed) for feed in feeds) < 0.005 * found.feed_mm_rev
    assert abs(found.depth_mm - np.median(depths)) < 0.5 * np.ptp(depths)


def test_a_pair_without_cuts_has_one_that_its_kind_of_tool_makes(store: Store) -> None:
    with store.writing() as session:
        session.add(models.Tool(name="mill", kind="end_mill", diameter_mm=10.0, teeth=4))
    with store.reading() as session:
        owner = find_machine(session, MACHINE)
        assert usual_cut(session, owner.id, "C45", "mill") == OTHERWISE["end_mill"]
        assert usual_cut(session, owner.id, "C45", "none") == OTHERWISE["turning_insert"]


# Drives and recordings


def test_a_drive_is_drawn_over_its_moves_as_long_as_they_are_there(
    store: Store, tmp_path: Path
) -> None:
    with store.reading() as session:
        owner = find_machine(session, MACHINE)
        assert modelled_channels(session, owner.id) == ["z.current"]
        found = drive_map(session, MACHINE, "z.current")
        assert found.field is not None
        assert found.field.error_share < 0.1
        assert found.of == "air-moves.csv"
        with pytest.raises(NotThere, match=r"z\.current"):
            drive_map(session, MACHINE, "y.current")
    moves = tmp_path / "air-moves.csv"
    with store.writing() as session:
        row = session.scalars(
            select(models.StoredRecording).where(models.StoredRecording.path.like("%air-moves.csv"))
        ).one()
        row.path = str(moves)
    with store.reading() as session:
        gone = drive_map(session, MACHINE, "z.current")
        assert (gone.field, gone.of) == (None, None)
        assert gone.terms == found.terms


def test_a_recording_is_explained_again_as_when_it_was_given(store: Store) -> None:
    path = kit("sample_jobs") / "stepped_shaft" / "recordings" / "shop-week-1.csv"
    given = explain_with_machine(store, MACHINE, path).explained
    with store.reading() as session:
        row = session.scalars(
            select(models.StoredRecording).where(models.StoredRecording.path == str(path.resolve()))
        ).one()
        assert explain_recording(session, row).explanation == given.explanation


def test_what_is_not_there_any_more_is_not_explained(store: Store) -> None:
    with store.writing() as session:
        row = session.scalars(select(models.StoredRecording)).first()
        assert row is not None
        row.path, number = "/nowhere/cuts.csv", row.id
    with (
        store.reading() as session,
        pytest.raises(UnusableInput, match="missing or has changed since its"),
    ):
        explain_recording(session, session.get_one(models.StoredRecording, number))


# Machines at a glance


def test_machines_are_seen_with_what_waits(session: Session) -> None:
    one, lathe = machines_seen(session, most=10)
    assert (one.name, one.feels, one.recordings, one.last_refreshed_at) == (STRANGE, (), 0, None)
    assert (lathe.feels, lathe.recordings) == (("x", "y", "z"), 5)
    waiting = mismatches(session, MACHINE, decided=False)
    assert lathe.open_mismatches == len(waiting) > 0
    assert lathe.last_refreshed_at is not None
    assert [one.name for one in machines_seen(session, most=10, like="ATHE")] == [MACHINE]
    assert machines_seen(session, most=10, like="%") == []
