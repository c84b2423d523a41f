"""Stamped recordings carry the true law, and each kind is what it says."""

import re
from collections.abc import Callable
from datetime import datetime

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.proofs.cases.stamps.axis_rows import GRAVITY_A, LAW, RATES_HZ, draw_known_axis
from autodb.proofs.cases.stamps.programme import Array
from autodb.proofs.cases.stamps.stamp_cases import (
    STAMP_KINDS,
    StampCase,
    draw_stamped,
    stamped_of,
)
from autodb.proofs.catalogue import proof
from autodb.proofs.runs.stamps.stamp_answers import (
    answers_to,
)
from tests.helpers.campaigns import first

RUNS = 200
SEED = 1214
"""Of recordings that no run of the proof draws; short ones."""
KINDS = {kind.name: kind for kind in STAMP_KINDS}


@pytest.fixture(scope="module", params=STAMP_KINDS, ids=lambda kind: kind.name)
def case(request: pytest.FixtureRequest) -> StampCase:
    """Return a recording of every kind."""
    return stamped_of(request.param, SEED)


def test_every_kind_occurs_in_a_run_and_says_what_it_is() -> None:
    assert proof("stamps").runs == RUNS >= len(STAMP_KINDS)
    assert len(KINDS) == len(STAMP_KINDS)
    drawn = [draw_stamped(seed).kind.name for seed in (1, 2, len(STAMP_KINDS) + 1)]
    assert drawn == ["even", "even, later", "even"]
    for kind in STAMP_KINDS:
        assert kind.sentence.endswith(".")
        assert kind.reason.endswith((".", ":"))
        assert set(kind.rates_hz) <= {*RATES_HZ, 700.0}
    assert [kind.name for kind in STAMP_KINDS if kind.plain] == [
        "even", "even, later", "rotary, even"
    ]  # fmt: skip


def test_the_same_seed_has_the_same_bytes_and_another_seed_others() -> None:
    one, same, other = draw_stamped(17), draw_stamped(17), draw_stamped(17 + len(STAMP_KINDS))
    assert one.recording(one.stamped) == same.recording(same.stamped)
    assert one.kind == other.kind
    assert one.recording(one.stamped) != other.recording(other.stamped)


def test_currents_are_those_of_the_law_at_the_true_instants(case: StampCase) -> None:
    """Least squares over the motion where each current was really taken gives the three."""
    rows, programme = case.stamped.rows, case.axis.programme
    moved = programme.motion(rows.current_s)
    shapes = np.array([moved.a, moved.v, np.sign(moved.v), np.ones(len(rows))]).T
    found = np.linalg.lstsq(shapes, rows.current, rcond=None)[0]
    of_noise = case.kind.name == "on change, held"  # what is reported depends on the noise itself
    assert_allclose(found[:3], list(LAW.values()), rtol=0.03 if of_noise else 0.01)
    assert_allclose(found[3], 0.0 if case.axis.rotary else GRAVITY_A, atol=0.01)
    assert_allclose(np.std(rows.current - shapes @ found), 0.02, rtol=0.3 if of_noise else 0.1)


def test_positions_are_true_but_for_what_wraps(case: StampCase) -> None:
    rows = case.stamped.rows
    off = rows.position - case.axis.programme.motion(rows.position_s).x
    modulus = case.stamped.drawn.get("wraps at", case.stamped.drawn.get("falls by", np.inf))
    turns = np.round(off / modulus)
    wraps = {"16 bit position", "angle of 0 to 360", "angle of ±180", "position overflows"}
    assert np.any(turns != 0.0) == (case.kind.name in wraps)
    wrapped = np.where(turns == 0.0, 0.0, turns * np.nan_to_num(modulus, posinf=0.0))
    assert np.max(np.abs(off - wrapped)) <= 0.006  # half a count of 16 bits over 0.6 of the travel


def test_a_simulation_lacks_one_term_and_has_the_same_stamps(case: StampCase) -> None:
    stamps, law = case.stamped, case.axis
    lines = case.simulation(stamps).splitlines()
    assert len(lines) == len(stamps.rows) + 1 == len(case.recording(stamps).splitlines())
    cells = [line.rpartition(",") for line in lines[1:]]
    assert [stamp for stamp, _, _ in cells] == list(stamps.stamps)
    lacking = law.law_A(stamps.rows.true_s) - np.array([float(text) for _, _, text in cells])
    moved = law.programme.motion(stamps.rows.true_s)
    part = {"inertia": moved.a, "viscous": moved.v, "coulomb": np.sign(moved.v), "": 0.0 * moved.v}
    size = LAW.get(law.left_out, 0.0)
    assert_allclose(lacking, size * part[law.left_out], atol=2e-6)


@pytest.mark.parametrize("seed", first(1, [SEED, 3]))
def test_an_axis_with_even_stamps_is_identified_within_one_percent(seed: int) -> None:
    case = stamped_of(KINDS["even"], seed)
    found = answers_to(case, case.twin)
    assert found.identified.outcome == "answered"
    assert all(e is not None and abs(e) < 1.0 for e in found.errors_percent().values())


# ---- each kind is what it says ----


def _numbers(case: StampCase) -> Array:
    return np.array([float(text) for text in case.stamped.stamps])


def _steps(case: StampCase) -> Array:
    """Return steps of the stamps in steps of even sampling."""
    return np.asarray(np.diff(_numbers(case)) * case.axis.rate_hz)


def _off(case: StampCase) -> Array:
    """Return how far stamps are off the true instants, but for a constant, s."""
    off = _numbers(case) - case.stamped.rows.true_s
    return np.asarray(off - off[0])


def _is_even(case: StampCase) -> None:
    assert_allclose(_steps(case), 1.0, atol=4e-3)
    assert_allclose(_off(case), 0.0, atol=2e-6)


def _has_steps_of(step_s: float) -> Callable[[StampCase], None]:
    def check(case: StampCase) -> None:
        stamps = _numbers(case)
        assert_allclose(stamps / step_s, np.round(stamps / step_s), atol=0.04)
        assert np.max(np.abs(_off(case))) <= step_s * 1.01
        assert np.std(_steps(case)) > 0.0
        assert np.all(_steps(case) >= 0.0)

    return check


def _has_digits(case: StampCase) -> None:
    _has_steps_of(1e-3 if case.stamped.drawn["start"] < 1000.0 else 1e-2)(case)


def _is_single(case: StampCase) -> None:
    last_s = max(_numbers(case))
    _has_steps_of(float(np.spacing(np.float32(last_s))))(case)


def _shares_stamps(case: StampCase) -> None:
    assert np.mean(_steps(case) == 0.0) > 0.3


def _scatters(case: StampCase) -> None:
    share = next(iter(case.stamped.drawn.values()))
    steps = np.diff(_off(case)) * case.axis.rate_hz
    assert 0.2 * share < np.std(steps) < 4.0 * share + 0.1
    assert_allclose(np.diff(case.stamped.rows.true_s) * case.axis.rate_hz, 1.0, atol=1e-6)


def _is_honest(case: StampCase) -> None:
    assert_allclose(_numbers(case), case.stamped.rows.true_s, atol=1e-6)
    assert np.std(np.diff(case.stamped.rows.true_s)) > 0.0


def _runs_at_another_rate(case: StampCase) -> None:
    ends = _off(case)[-1] / case.stamped.rows.true_s[-1]
    assert np.max(np.abs(np.diff(_off(case)))) * case.axis.rate_hz < 3e-3 + 1e-6 * 2000
    assert 0.0 < abs(ends) < 3e-3 or case.kind.name == "clock wanders"
    assert np.max(np.abs(_off(case))) > 1e-4


def _jumps_once(low: float, high: float) -> Callable[[StampCase], None]:
    def check(case: StampCase) -> None:
        jumps = np.diff(_off(case))
        (where,) = np.flatnonzero(np.abs(jumps) > 0.05)
        assert low <= jumps[where] <= high

    return check


def _wraps(period: float) -> Callable[[StampCase], None]:
    """The stamps fall by a period, once, or in a short one twice; between they are true."""

    def check(case: StampCase) -> None:
        unit = 1.0 if not case.stamped.side else 1e6 if '"us"' in case.stamped.side else 1e3
        off = _numbers(case) / unit - case.stamped.rows.true_s
        falls = np.round((off[0] - off) / period)
        assert set(falls) in ({0.0, 1.0}, {0.0, 1.0, 2.0}, {0.0, 1.0, 2.0, 3.0})
        assert_allclose(off - off[0] + falls * period, 0.0, atol=1.1e-3)

    return check


def _lacks(low: float, high: float) -> Callable[[StampCase], None]:
    def check(case: StampCase) -> None:
        share = 1.0 - len(case.stamped.rows) / len(case.axis.grid_s)
        assert low <= share <= high
        assert_allclose(_off(case), 0.0, atol=1e-6)
        assert np.max(_steps(case)) > 1.5
        assert_allclose(_steps(case), np.round(_steps(case)), atol=4e-3)

    return check


def _is_disordered(case: StampCase) -> None:
    assert_allclose(_off(case), 0.0, atol=1e-6)
    assert np.any(_steps(case) < 0.0)


def _repeats_rows(case: StampCase) -> None:
    stamps = case.stamped.stamps
    assert len(set(stamps)) == len(case.axis.grid_s) < len(stamps)
    lines = case.recording(case.stamped).splitlines()[1:]
    assert len(set(lines)) == len(case.axis.grid_s)


def _repeats_stamps(case: StampCase) -> None:
    assert len(set(case.stamped.stamps)) < len(case.stamped.stamps) == len(case.axis.grid_s)
    lines = set(case.recording(case.stamped).splitlines()[1:])
    assert len(lines) > 0.99 * len(case.axis.grid_s)  # few are equal by chance


def _holds(case: StampCase) -> None:
    rows = case.stamped.rows
    late = rows.true_s - rows.position_s
    assert np.min(late) == 0.0
    assert np.max(late) > 0.9 / case.axis.rate_hz
    assert np.min(rows.true_s - rows.current_s) >= 0.0


def _counts(per_s: float, tolerance: float = 1e-4) -> Callable[[StampCase], None]:
    """Stamps go on by so many units a second; exactly, whatever a floating number holds."""

    def check(case: StampCase) -> None:
        digits = len(case.stamped.stamps[0].partition(".")[2])
        first = int(case.stamped.stamps[0].replace(".", ""))
        counts = [int(text.replace(".", "")) - first for text in case.stamped.stamps]
        assert_allclose(np.array(counts) / 10.0**digits / per_s, case.axis.grid_s, atol=tolerance)

    return check


def _dated(form: str) -> Callable[[StampCase], None]:
    """Stamps are read back by a format of strptime, to the digits that they have."""

    def check(case: StampCase) -> None:
        texts = [text.strip('"') for text in case.stamped.stamps[:: len(case.stamped.stamps) // 50]]
        moments = [datetime.strptime(text, form) for text in texts]
        since = np.array([(one - moments[0]).total_seconds() for one in moments])
        rows = case.axis.grid_s[:: len(case.axis.grid_s) // 50]
        coarse = 1.0 if "%f" not in form else 1e-3 if ":%f" in form else 1.1e-4
        jumps = np.round((since - rows) / 3600.0)
        assert bool(np.any(jumps != 0.0)) == (case.kind.name == "summer time, bare")
        assert np.max(np.abs(since - 3600.0 * jumps - rows)) <= coarse

    return check


def _begins_again(case: StampCase) -> None:
    true_s, n = case.stamped.rows.true_s, len(case.axis.grid_s)
    assert true_s[n] == 0.0
    step = _numbers(case)[n] - _numbers(case)[n - 1]
    named = case.kind.name
    assert (step < 0.0) == ("at 0" in named)
    assert (step > 4.9) == ("later" in named or named == "second run slower")
    second = np.diff(_numbers(case)[n:]) * case.axis.rate_hz
    assert_allclose(second, 2.0 if "slower" in named else 1.0, atol=4e-3)


def _changes_its_rate(case: StampCase) -> None:
    steps = np.round(_steps(case))
    assert steps[0] == 1.0
    assert steps[-1] == case.stamped.drawn["divided"]
    assert np.all(np.diff(steps[1:-1]) >= -1e-9)


def _has_texts(text: str) -> Callable[[StampCase], None]:
    def check(case: StampCase) -> None:
        assert case.stamped.stamps.count(text) == case.stamped.drawn["rows"] >= 1

    return check


def _is_one(case: StampCase) -> None:
    assert len(set(case.stamped.stamps)) <= 2


KIND_CHECKS: dict[str, Callable[[StampCase], None]] = {
    **dict.fromkeys(("even", "even, later", "rotary, even", "16 bit position", "position overflows",
                     "angle of 0 to 360", "angle of ±180"), _is_even),
    **dict.fromkeys(("1 ms, rounded", "1 ms, cut off", "1 ms, several rows"), _has_steps_of(1e-3)),
    **dict.fromkeys(("10 µs, rounded", "10 µs, cut off"), _has_steps_of(1e-5)),
    **dict.fromkeys(("0.1 s, rounded", "0.1 s, cut off"), _has_steps_of(0.1)),
    "10 ms, rounded": _has_steps_of(0.01),
    "Windows tick": _has_steps_of(0.015625),
    "six digits": _has_digits,
    "single, POSIX": _is_one,
    **dict.fromkeys(("single, time of day", "single, uptime"), _is_single),
    "packets": _shares_stamps,
    **dict.fromkeys(("stamps jitter", "stamps late"), _scatters),
    **dict.fromkeys(("sampling jitters", "sampling wanders", "loop overruns"), _is_honest),
    **dict.fromkeys(("clock drifts", "clock wanders", "clock slewed"), _runs_at_another_rate),
    "clock set forward": _jumps_once(0.1, 1.0),
    "clock set back": _jumps_once(-1.0, -0.1),
    **dict.fromkeys(("32 bit µs, s", "32 bit µs, stated"), _wraps(4294.967296)),
    **dict.fromkeys(("16 bit ms", "16 bit ms, stated"), _wraps(65.536)),
    "32 bit 100 ns": _wraps(429.4967296),
    "24 bit µs": _wraps(16.777216),
    "midnight": _wraps(86_400.0),
    "one gap": _lacks(0.005, 0.3),
    "several gaps": _lacks(0.02, 0.5),
    "rows lost": _lacks(0.0005, 0.06),
    "bursts lost": _lacks(0.001, 0.5),
    **dict.fromkeys(("on change of position", "on change of either"), _lacks(0.02, 0.9)),
    **dict.fromkeys(("rows doubled", "block doubled"), _repeats_rows),
    **dict.fromkeys(("stamp doubled", "stamps doubled"), _repeats_stamps),
    **dict.fromkeys(("neighbours swapped", "block moved", "backwards"), _is_disordered),
    **dict.fromkeys(("on change, held", "position polled"), _holds),
    **dict.fromkeys(("ms", "ms, stated", "POSIX ms"), _counts(1e3)),
    **dict.fromkeys(("µs", "µs, stated"), _counts(1e6)),
    **dict.fromkeys(("ns", "ns, stated", "POSIX ns", "POSIX ns, stated", "EtherCAT ns"),
                    _counts(1e9)),
    "FILETIME": _counts(1e7),
    **dict.fromkeys(("minutes", "minutes, stated"), _counts(1.0 / 60.0)),
    **dict.fromkeys(("Excel days", "Excel days, stated"), _counts(1.0 / 86_400.0)),
    **dict.fromkeys(("POSIX s", "POSIX s, stated"), _counts(1.0)),
    **dict.fromkeys(("row number", "row number, stated"),
                    lambda case: _counts(case.axis.rate_hz)(case)),
    "ISO 8601": _dated("%Y-%m-%dT%H:%M:%S.%f"),
    **dict.fromkeys(("ISO 8601 Z", "ISO 8601 +02:00", "summer time, offset"),
                    _dated("%Y-%m-%dT%H:%M:%S.%f%z")),
    "summer time, bare": _dated("%Y-%m-%dT%H:%M:%S.%f"),
    "ISO, space": _dated("%Y-%m-%d %H:%M:%S.%f"),
    "ISO, comma": _dated("%Y-%m-%d %H:%M:%S,%f"),
    "German date": _dated("%d.%m.%Y %H:%M:%S.%f"),
    "American date": _dated("%m/%d/%Y %I:%M:%S.%f %p"),
    "time of day": _dated("%H:%M:%S.%f"),
    "time, colon ms": _dated("%H:%M:%S:%f"),
    "ISO, whole seconds": _dated("%Y-%m-%dT%H:%M:%S"),
    **dict.fromkeys(("second run at 0", "second run later", "second run at once",
                     "second run slower", "second run slower, at 0"), _begins_again),
    "rate changes": _changes_its_rate,
    "empty stamps": _has_texts(""),
    "NaN stamps": _has_texts("NaN"),
    "text in one": _has_texts("overrun"),
    "constant": _is_one,
}  # fmt: skip


def test_each_kind_is_what_it_says(case: StampCase) -> None:
    KIND_CHECKS[case.kind.name](case)


def test_a_unit_that_is_stated_stands_in_the_side_file(case: StampCase) -> None:
    stated = "stated" in case.kind.name
    assert bool(case.stamped.side) == stated
    if stated:
        assert re.match(r'\[channels]\n"t" = \{column = "t", ', case.stamped.side)


def test_two_rates_of_one_seed_have_the_same_moves() -> None:
    slow, fast = (draw_known_axis(5, (hz,), rotary=False).programme for hz in (200.0, 400.0))
    assert_allclose(slow.motion(np.array([3.0])).x, fast.motion(np.array([3.0])).x)
