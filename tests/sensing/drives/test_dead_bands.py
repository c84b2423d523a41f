"""Rows written on change: coefficients as of every row, or a refusal that says what to record."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.explain import explain
from autodb.proofs.cases.stamps.axis_rows import LAW, AxisDraw, draw_known_axis
from autodb.records.tables import Recording
from autodb.records.timed import on_even_rows
from autodb.sensing.drives.feed_axis import identify

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

AXIS = draw_known_axis(11, (500.0,), rotary=False)
ROWS = AXIS.rows(AXIS.grid_s)
TOP_MM = float(np.quantile(np.abs(np.diff(ROWS.position)), 0.99))
"""Way in a row at top speed."""


def _reported(values: Array, band: float) -> Flags:
    """Return where a value differs by a dead band from the last that was reported."""
    said, last = np.zeros(len(values), dtype=np.bool_), np.inf
    for row, value in enumerate(values.tolist()):
        if abs(value - last) >= band:
            said[row], last = True, value
    return said


def _recording(axis: AxisDraw, rows: Flags, place: Array, current: Array) -> Recording:
    channels = {"t": axis.grid_s[rows], "x.position": place[rows], "x.current": current[rows]}
    return on_even_rows(Recording(Path("moves.csv"), channels))


def _on_change_of_place(share: float) -> Recording:
    return _recording(AXIS, _reported(ROWS.position, share * TOP_MM), ROWS.position, ROWS.current)


def _held(share: float, band_A: float) -> Recording:
    moved, drawn = _reported(ROWS.position, share * TOP_MM), _reported(ROWS.current, band_A)
    row = np.arange(len(moved))
    place = ROWS.position[np.maximum.accumulate(np.where(moved, row, 0))]
    current = ROWS.current[np.maximum.accumulate(np.where(drawn, row, 0))]
    return _recording(AXIS, moved | drawn, place, current)


@pytest.mark.parametrize("share", [0.01, 0.03, 0.06])
def test_a_place_written_on_change_gives_the_coefficients(share: float) -> None:
    """Taken for true, rows next to those not written put friction 2 to 9 % off."""
    found = {one.term: one for one in identify(_on_change_of_place(share)).terms}
    for term, truth in LAW.items():
        assert found[term].value == pytest.approx(truth, rel=0.01)


def test_a_place_whose_slow_motion_is_not_seen_is_refused() -> None:
    with pytest.raises(UnusableInput, match=r"too coarse to derive .*x\.velocity besides"):
        identify(_on_change_of_place(0.4))


def test_an_effort_that_is_held_lags_behind_and_is_refused() -> None:
    with pytest.raises(UnusableInput, match=r"x\.current is written .*record it on every row"):
        identify(_held(0.005, 0.2))


def test_a_place_of_an_earlier_row_is_refused() -> None:
    with pytest.raises(UnusableInput, match=r"x\.position is written when it has changed by"):
        identify(_held(0.04, 0.03))


def test_causes_are_not_told_where_the_effort_at_rest_is_not_known() -> None:
    recording = _on_change_of_place(0.03)
    simulated = {"t": recording.written["t"], "x.current": 0.9 * recording.written["x.current"]}
    simulation = on_even_rows(Recording(Path("simulation.csv"), simulated), like=recording)
    with pytest.raises(UnusableInput, match=r"effort at rest is not known, .*record every row"):
        explain(recording, simulation)
