"""Stamps of every kind, told apart; rows laid out where the axis truly was."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.timing import Timing, examined
from tests.helpers.stamped import effort_A, place_mm, written_mm

Array = NDArray[np.float64]
Rng = np.random.Generator
Rows = tuple[Array, Array]
"""Stamps, and the instants at which the rows were truly taken, in the order of the file."""

RATE = 400.0
SPAN_S = 20.0
MM_S = 190.0
"""Top speed of the axis, 1.5 times its mean in a move."""


def even_s(rate_hz: float = RATE) -> Array:
    return np.arange(round(SPAN_S * rate_hz)) / rate_hz


def _rounded(unit_s: float, rate_hz: float = RATE) -> Callable[[Rng], Rows]:
    return lambda _: (np.round(even_s(rate_hz) / unit_s) * unit_s, even_s(rate_hz))


def _cut_off(unit_s: float, rate_hz: float = RATE) -> Callable[[Rng], Rows]:
    def write(_: Rng) -> Rows:
        t = even_s(rate_hz)
        return np.floor(t / unit_s + 1e-9) * unit_s, t

    return write


def _jittered(rng: Rng) -> Rows:
    return even_s() + 0.2 / RATE * rng.standard_normal(len(even_s())), even_s()


def _late(rng: Rng) -> Rows:
    return even_s() + 0.3 / RATE * rng.exponential(size=len(even_s())), even_s()


def _taken_unevenly(rng: Rng) -> Rows:
    t = np.sort(even_s() + 0.15 / RATE * rng.standard_normal(len(even_s())))
    return t, t


def _adding_up(rng: Rng) -> Rows:
    t = np.cumsum(np.maximum(0.1, 1.0 + 0.15 * rng.standard_normal(len(even_s())))) / RATE
    return t, t


def _packets(rng: Rng) -> Rows:
    t = even_s()
    last = np.minimum(np.arange(len(t)) // 20 * 20 + 19, len(t) - 1)
    latency = 0.001 * rng.exponential(size=len(t) // 20 + 1)
    return t[last] + np.repeat(latency, 20)[: len(t)], t


def _without(rows: Callable[[Array, Rng], NDArray[np.bool_]]) -> Callable[[Rng], Rows]:
    def write(rng: Rng) -> Rows:
        t = even_s()[rows(even_s(), rng)]
        return t, t

    return write


def _doubled(rng: Rng) -> Rows:
    rows = np.sort(np.r_[np.arange(len(even_s())), rng.choice(len(even_s()), 30, replace=False)])
    return even_s()[rows], even_s()[rows]


def _stuck(rng: Rng) -> Rows:
    t, rows = even_s().copy(), rng.choice(len(even_s()) - 2, 30, replace=False) + 1
    t[rows] = t[rows - 1]
    return t, even_s()


def _moved(rng: Rng) -> Rows:
    rows = np.arange(len(even_s()))
    for row in rng.choice(np.arange(0, len(rows) - 3, 4), 30, replace=False):
        rows[[row, row + 1]] = rows[[row + 1, row]]
    return even_s()[rows], even_s()[rows]


def _wrapping(span_s: float, unit_s: float) -> Callable[[Rng], Rows]:
    def write(_: Rng) -> Rows:
        ticks = np.floor((even_s() + span_s - 7.0) / unit_s + 1e-6)
        return ticks * unit_s % span_s, even_s()

    return write


KINDS: dict[str, tuple[Callable[[Rng], Rows], set[str], int]] = {
    "1 ms at 400 Hz": (_rounded(1e-3), {"rounded"}, 1),
    "1 ms at 400 Hz, cut off": (_cut_off(1e-3), {"rounded"}, 1),
    "1 ms at 1600 Hz": (_rounded(1e-3, 1600.0), {"rounded"}, 1),
    "10 µs at 1600 Hz": (_rounded(1e-5, 1600.0), {"rounded"}, 1),
    "1/256 s at 250 Hz": (_cut_off(1.0 / 256.0, 250.0), {"rounded"}, 1),
    "a tick of 1/64 s": (_cut_off(1.0 / 64.0), {"rounded"}, 1),
    "jitter": (_jittered, {"jittered"}, 1),
    "latency": (_late, {"jittered"}, 1),
    "taken unevenly": (_taken_unevenly, {"uneven"}, 1),
    "unevenness adds up": (_adding_up, {"uneven"}, 1),
    "packets": (_packets, {"shared"}, 1),
    "a gap": (_without(lambda t, _: (t < 5.0) | (t > 6.5)), {"gap"}, 2),
    "rows lost": (_without(lambda t, rng: rng.random(len(t)) > 0.03), {"missing rows"}, 1),
    "rows doubled": (_doubled, {"doubled"}, 1),
    "stamps stuck": (_stuck, {"jittered"}, 1),
    "neighbours swapped": (_moved, {"out of order"}, 1),
    "backwards": (lambda _: (even_s()[::-1], even_s()[::-1]), {"backwards"}, 1),
    "32-bit µs": (_wrapping(2.0**32 * 1e-6, 1e-6), {"wrapped"}, 1),
    "16-bit ms": (_wrapping(65.536, 1e-3), {"wrapped", "rounded"}, 1),
    "midnight": (_wrapping(86400.0, 1e-6), {"wrapped"}, 1),
    "set forward": (lambda _: (even_s() + 0.5 * (even_s() > 7.0), even_s()), {"gap"}, 2),
    "set back": (lambda _: (even_s() - 0.3 * (even_s() > 7.0), even_s()), {"restarted"}, 2),
    "begun again": (lambda _: (even_s() % 10.0, even_s()), {"restarted"}, 2),
}


def rate_of(name: str) -> float:
    return next((rate for rate in (1600.0, 250.0) if f"{rate:g} Hz" in name), RATE)


def looked_at(name: str, rng: Rng) -> tuple[Timing, Array, Array]:
    """Return the verdict on a kind, the true instants of its file's rows, and its places."""
    stamps, truth = KINDS[name][0](rng)
    place, effort = written_mm(truth), effort_A(truth, rng)
    channels = {"x.position": place, "x.current": effort}
    return examined(stamps, channels, where="moves.csv"), truth, place


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_is_named_and_laid_out_where_the_axis_was(name: str) -> None:
    timing, truth, place = looked_at(name, np.random.default_rng(3))
    _, kinds, pieces = KINDS[name]
    assert kinds <= set(timing.kinds)
    assert len(timing.pieces) == pieces
    assert timing.layout is not None
    assert_allclose(timing.rate_hz, rate_of(name), rtol=2e-3)
    laid = timing.layout.laid_out(place, smooth=True)
    taken = timing.layout.laid_out(truth, smooth=True)
    for piece in timing.pieces:
        assert_allclose(np.diff(timing.layout.t_s[piece]), timing.step_s, rtol=1e-6)
        # the axis is off by its encoder, and by no more than a twentieth of a step of its way
        assert_allclose(laid[piece], place_mm(taken[piece]), atol=2e-3 + 0.05 * MM_S / RATE)
        assert_allclose(np.diff(taken[piece]), timing.step_s, atol=0.1 * timing.step_s)


@pytest.mark.parametrize("name", KINDS)
def test_a_shift_of_the_origin_changes_nothing(name: str) -> None:
    rng = np.random.default_rng(4)
    stamps, truth = KINDS[name][0](rng)
    channels = {"x.position": written_mm(truth), "x.current": effort_A(truth, rng)}
    one, other = (examined(stamps + by, channels, where="f") for by in (0.0, 4096.0))
    assert one.kinds == other.kinds
    assert one.pieces == other.pieces
    assert_allclose(one.step_s, other.step_s, rtol=1e-6)


@pytest.mark.parametrize("name", KINDS)
def test_what_was_laid_out_comes_back_to_the_rows_of_the_file(name: str) -> None:
    timing, _, place = looked_at(name, np.random.default_rng(5))
    assert timing.layout is not None
    back = timing.layout.of_file(timing.layout.laid_out(place, smooth=True))
    known = np.isfinite(back)
    assert np.mean(known) > 0.95
    assert_allclose(back[known], place[known], atol=0.02 * MM_S / RATE)


def test_even_stamps_stay_as_they_are() -> None:
    t = even_s()
    timing = examined(t, {"x.position": written_mm(t)}, where="moves.csv")
    assert timing.is_even
    assert timing.layout is None
    assert timing.pieces == (slice(0, len(t)),)
    assert timing.step_s == float(np.median(np.diff(t)))
    assert str(timing) == "even, 400 Hz"


def test_a_clock_that_is_set_leaves_even_rows_even() -> None:
    """It jumps by 10.37 steps: a gap, on whose sides rows keep their numbers and their step."""
    t = even_s()
    t[3000:] += 10.37 / RATE
    place = written_mm(even_s())
    timing = examined(np.round(t, 6), {"x.position": place}, where="f")
    assert timing.kinds == ("gap",)
    assert timing.rate_hz == pytest.approx(RATE, rel=1e-8)
    assert timing.layout is not None
    assert_array_equal(timing.layout.laid_out(place, smooth=True), place)
    assert_allclose(timing.layout.t_s, t, atol=2e-6)


def test_a_clock_that_slowly_gains_leaves_rows_as_they_came() -> None:
    """By 0.05 %, then back: no row is resampled, and none is dated wrong by more than 3 ms."""
    t = even_s()
    gains = t + 5e-4 * np.minimum(t, np.maximum(t[-1] - t, 0.0))
    place = written_mm(t)
    timing = examined(gains, {"x.position": place}, where="f")
    assert timing.kinds == ("wanders",)
    assert "rows left as they came" in str(timing)
    assert timing.layout is not None
    assert_array_equal(timing.layout.laid_out(place, smooth=True), place)
    assert_allclose(timing.layout.t_s, gains, atol=3e-3)


def test_what_lies_next_to_rows_that_were_not_written_is_not_known() -> None:
    t = even_s()
    place = written_mm(t, 0.01)
    rows = np.append(True, np.diff(place) != 0)
    timing = examined(t[rows], {"x.position": place[rows]}, where="f")
    assert timing.layout is not None
    assert timing.placed is not None
    known, reach = timing.known_within(0.01), round(0.01 * RATE)
    assert known is not None
    unknown = np.convolve(~timing.placed, np.ones(2 * reach + 1), mode="same") > 0.5
    assert_array_equal(known, ~unknown)
    filled = examined(np.delete(t, [700, 2200]), {}, where="f")
    assert filled.known_within(0.01) is filled.measured


def test_rows_written_on_change_hold_their_value() -> None:
    """Held at rest, straight where the axis creeps; a rest that is held was not measured."""
    t, rng = even_s(), np.random.default_rng(6)
    place, effort = written_mm(t, 0.01), np.round(effort_A(t, rng) / 0.1) * 0.1
    rows = np.append(True, (np.diff(place) != 0) | (np.diff(effort) != 0))
    timing = examined(t[rows], {"x.position": place[rows], "x.current": effort[rows]}, where="f")
    assert timing.kinds == ("on change",)
    assert timing.layout is not None
    assert_allclose(timing.layout.laid_out(effort[rows]), effort[: len(timing.layout.t_s)])
    assert_allclose(
        timing.layout.laid_out(place[rows], smooth=True),
        place[: len(timing.layout.t_s)],
        atol=0.0101,
    )
    assert timing.measured is not None
    assert timing.measured.sum() == rows.sum()


def test_a_rate_that_changes_makes_two_pieces_of_one_step() -> None:
    t = np.r_[np.arange(4000) / 400.0, 10.0 + np.arange(2500) / 250.0]
    timing = examined(t, {"x.position": written_mm(t)}, where="f")
    assert "other rate" in timing.kinds
    assert len(timing.pieces) == 2
    assert timing.layout is not None
    for piece in timing.pieces:
        assert_allclose(np.diff(timing.layout.t_s[piece]), 1.0 / 400.0, rtol=1e-6)


def test_stamps_that_are_missing_cost_their_rows() -> None:
    t, lost = even_s().copy(), np.array([100, 2000, 2001, 5000])
    t[lost] = np.nan
    timing = examined(t, {"x.position": written_mm(even_s())}, where="f")
    assert timing.kinds == ("no stamp", "missing rows")
    assert timing.layout is not None
    assert_array_equal(np.flatnonzero(np.isnan(timing.layout.of_file(timing.layout.t_s))), lost)


def _lost_in_shared(rng: Rng) -> Array:
    return np.round(even_s(1600.0)[rng.random(len(even_s(1600.0))) > 0.02], 3)


def _uneven_and_coarse(rng: Rng) -> Array:
    return np.round(np.cumsum(1.0 + 0.2 * rng.standard_normal(8000)) / RATE, 3)


@pytest.mark.parametrize(
    ("write", "says"),
    [
        (lambda _: np.zeros(200), "column 't' stands still"),
        (_lost_in_shared, "several rows share a stamp, and their rate varies"),
        (_uneven_and_coarse, "rows taken unevenly, about every 2.5. ms, with stamps rounded to"),
        (lambda rng: np.cumsum(rng.exponential(size=40)), "record even steps, or at least 50 rows"),
        (lambda _: np.where(np.arange(200) % 5 == 0, np.nan, np.arange(200.0)), "row 1: no finite"),
    ],
)  # fmt: skip
def test_what_cannot_be_told_is_refused_in_one_line(
    write: Callable[[Rng], Array], says: str
) -> None:
    with pytest.raises(UnusableInput, match=says) as caught:
        examined(write(np.random.default_rng(7)), {}, where="moves.csv")
    assert str(caught.value).startswith("moves.csv: ")
    assert "\n" not in str(caught.value)
