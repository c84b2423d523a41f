"""Places as loggers give them: wraps counted on, leaps parted, seldom refreshed ones filled."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from autodb.timing import examined
from autodb.timing.places import drawn_between, filled_between, leaping, unwrapped
from tests.helpers.stamped import effort_A, place_mm, written_mm

T = np.arange(8000) / 400.0


@pytest.mark.parametrize("span_mm", [32.768, 65.536, 100.0])
def test_a_position_counter_is_counted_on(span_mm: float) -> None:
    on, found, why = unwrapped("x.position", written_mm(T) % span_mm)
    assert not why
    assert found is not None
    assert found.kind == "wrapped place"
    assert_allclose(on - on[0], written_mm(T) - written_mm(T)[0], atol=0.02)


@pytest.mark.parametrize("low_deg", [0.0, -180.0])
def test_an_angle_is_counted_on_over_turns(low_deg: float) -> None:
    angle = 700.0 * np.sin(0.8 * T)
    on, found, _ = unwrapped("a.angle", (angle - low_deg) % 360.0 + low_deg)
    assert found is not None
    assert_allclose(np.diff(on), np.diff(angle), atol=1e-6)


def test_an_angle_that_turns_too_fast_is_refused() -> None:
    _, found, why = unwrapped("spindle.angle", (170.0 * np.arange(500.0)) % 360.0)
    assert found is None
    assert "too far to count turns; record it at a higher rate" in why


def test_an_angle_that_counts_on_stays_as_it_is() -> None:
    angle = 200.0 * np.arange(500.0)
    on, found, why = unwrapped("spindle.angle", angle)
    assert on is angle
    assert found is None
    assert not why


def test_what_an_axis_does_is_no_leap() -> None:
    rng = np.random.default_rng(1)
    for place in (written_mm(T), written_mm(T, 0.01), 80.0 * T, rng.normal(0.0, 1e-3, len(T))):
        assert not leaping(place).size
        assert_array_equal(unwrapped("x.position", place)[0], place)
        assert filled_between("x.position", place)[1] is None


def test_runs_that_were_joined_are_parted_where_the_axis_leaps() -> None:
    place = np.where(T > 9.0, written_mm(T) + 40.0, written_mm(T))
    timing = examined(T, {"x.position": place}, where="f")
    assert timing.kinds == ("leap",)
    assert "x.position leaps as no axis moves (at 9.0025 s): parted there" in str(timing)
    assert [piece.stop - piece.start for piece in timing.pieces] == [3601, len(T) - 3601]


@pytest.mark.parametrize("every", [2, 4, 7])
def test_a_place_refreshed_on_some_rows_is_filled_between(every: int) -> None:
    row = np.arange(len(T))
    held = written_mm(T)[row - row % every]
    assert np.abs(held - place_mm(T)).max() > 0.3 * every / 2
    filled, found = filled_between("x.position", held)
    assert found is not None
    assert found.kind == "polled place"
    inside = slice(0, len(T) - every)
    assert_allclose(filled[inside], place_mm(T)[inside], atol=0.02)


@pytest.mark.parametrize("every", [3, 8, 20])
def test_an_effort_refreshed_on_some_rows_is_drawn_between(every: int) -> None:
    """Held, it is late by half of that time: straight lines between are not."""
    effort = effort_A(T, np.random.default_rng(3))
    row = np.arange(len(T))
    held = effort[row - row % every]
    drawn, found = drawn_between("x.current", held)
    assert found is not None
    assert found.sentence.startswith(f"x.current is refreshed every {every} rows only")
    inside = row[: len(T) - every]
    assert_array_equal(drawn[inside[::every]], effort[inside[::every]])
    smooth = effort_A(T, np.random.default_rng(3), noise_A=0.0)
    late, off = (np.mean((one - smooth)[inside] ** 2) for one in (held, drawn))
    assert off < 0.7 * late


def test_an_effort_of_every_row_or_of_few_steps_stays_as_it_is() -> None:
    effort = effort_A(T, np.random.default_rng(3))
    coarse = np.round(effort / 0.5) * 0.5
    for one in (effort, coarse, np.sign(effort), np.zeros_like(effort)):
        drawn, found = drawn_between("x.current", one)
        assert found is None
        assert_array_equal(drawn, one)


def test_an_effort_is_no_place() -> None:
    rng = np.random.default_rng(2)
    effort = effort_A(T, rng)
    timing = examined(T, {"x.position": written_mm(T), "x.current": effort}, where="f")
    assert timing.is_even
