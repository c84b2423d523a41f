"""A long waveform is searched in turns spread over its time, and corrected at every row."""

from functools import cache, partial

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.explain import Explained, explain
from autodb.explain.waves import look
from autodb.explain.waves.fit import whitener_of
from autodb.explain.waves.law import NOTHING
from autodb.explain.waves.long_waveforms import rows_searched
from autodb.explain.waves.teeth import Teeth
from autodb.explain.waves.waves import Waves, mill_of
from autodb.explain.waves.world import SimulatedWaves
from autodb.proofs.cases.mill.mill_plan import draw_planned_mill
from autodb.proofs.runs.explain.left_out import tables
from autodb.records.tables import Recording
from benchmarks.explained_waves import slot

PLAIN = {1012: {"hard_spot", "table_inertia"}, 1054: {"shear", "chatter"}}
"""Milled cuts of 12 000 rows, and what is plain to see in each."""
MOST = 8000


@cache
def _world(seed: int) -> SimulatedWaves:
    """Return a mill's waves of which no law was read: where rows are asks for its angle alone."""
    recording, simulation = tables(draw_planned_mill(seed))
    assert isinstance(recording, Recording)
    rows = np.ones(len(recording.t_s))
    angle_rad = (
        2.0 * np.pi * np.cumsum(recording["spindle.speed"]) / 60.0 / recording.timing.rate_hz
    )
    teeth = Teeth(mill_of(recording), angle_rad, rows, rows)
    forces = np.array([simulation["force.x"]])
    waves = Waves(
        ("force.x",), recording.t_s, teeth, np.ones((1, 3, len(rows))), NOTHING, forces, 1.0
    )
    return SimulatedWaves(waves, recording.timing, has_edge=True)


def test_stretches_are_spread_over_all_of_the_time() -> None:
    world = _world(1001)
    count = len(world.waves.t_s)
    assert rows_searched(world, count) is None
    rows = rows_searched(world, count // 3)
    assert rows is not None
    assert rows[[0, -1]].tolist() == [0, count - 1]
    assert 0.25 * count < len(rows) < 0.45 * count
    pieces = world.timing.at(rows).pieces
    together = [piece.stop - piece.start for piece in pieces]
    assert all(
        np.ptp(rows[piece]) == last - 1 for piece, last in zip(pieces, together, strict=True)
    )
    assert min(together[:-1]) >= 200  # a twentieth of what is searched, at 5 kHz
    assert max(np.diff(rows)) < 0.07 * count


def test_pieces_of_a_recording_stay_apart() -> None:
    """Of rows 0 to 9, in pieces of five, those from 3 to 6 are in two pieces."""
    world = _world(1001)
    timing = world.timing.at(np.array([*range(5), *range(100, 105)]))
    assert timing.pieces == (slice(0, 5), slice(5, 10))
    assert timing.at(np.arange(3, 7)).pieces == (slice(0, 2), slice(2, 4))


def test_a_piece_that_is_shorter_than_the_filter_tells_nothing_of_the_noise() -> None:
    """A gap five rows before the end."""
    timing = _world(1001).timing.at(np.array([*range(3000), *range(3100, 3105)]))
    left = np.random.default_rng(5).standard_normal(3005)
    whole = whitener_of(left[:3000])
    assert_allclose(whitener_of(left, timing).coefficients, whole.coefficients)


def _explained(seed: int) -> Explained:
    case = draw_planned_mill(seed)
    return explain(*tables(case), includes=list(case.includes))


def _in_part(seed: int, monkeypatch: pytest.MonkeyPatch) -> Explained:
    monkeypatch.setattr(look, "rows_searched", partial(rows_searched, most=MOST))
    return _explained(seed)


def test_run_out_is_found_in_part_of_the_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """And what is left is that of every row of the recording: two thirds of 6000 are searched."""
    monkeypatch.setattr(look, "rows_searched", partial(rows_searched, most=4000))
    recording, simulation = slot(6000)
    part = explain(recording, simulation)
    for name in ("force.x", "force.y"):
        assert "runout" in {cause.term for cause in part.explanation.channels[name].missing}
        assert len(part.traces[name].corrected) == len(recording[name])


@pytest.mark.campaign
@pytest.mark.parametrize("seed", PLAIN)
def test_what_is_plain_is_found_in_part_of_the_rows(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And what is left is that of every row of the recording."""
    recording, _ = tables(draw_planned_mill(seed))
    part = _in_part(seed, monkeypatch)
    for name, answer in part.explanation.channels.items():
        found = {c.term for c in answer.missing if "size" in c.parameters}
        assert found
        assert found <= PLAIN[seed]
        assert len(part.traces[name].corrected) == len(recording[name])


@pytest.mark.campaign
@pytest.mark.parametrize("seed", PLAIN)
def test_part_of_the_rows_says_what_all_say(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same names, sizes within a tenth, and what is left of every row."""
    whole, part = _explained(seed), _in_part(seed, monkeypatch)
    for name, answer in part.explanation.channels.items():
        known = whole.explanation.channels[name]
        sizes = [
            {c.term: c.parameters["size"].value for c in one.missing} for one in (answer, known)
        ]
        assert sizes[0].keys() == PLAIN[seed] & sizes[1].keys() == sizes[1].keys()
        assert sizes[0] == pytest.approx(sizes[1], rel=0.1)
        assert answer.fit.heldout_after == pytest.approx(known.fit.heldout_after, rel=0.03)


@pytest.mark.campaign
def test_what_has_no_name_is_what_run_out_leaves() -> None:
    """Where the edge's force sets in at one row a curve over the turn follows it; before it was
    what run-out leaves, it had the larger part of run-out's own force, 74 N, and it came first.
    """
    found = explain(*slot(30_000)).explanation.channels["force.x"].missing
    assert [cause.term for cause in found] == ["runout", "unknown"]
    runout, unknown = (cause.parameters["size"].value for cause in found)
    assert unknown < 0.5 * runout
