"""The move that tells two explanations apart, on recordings that cannot."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain.axis.apart import account_distances, instead, move_that_tells, noise, separation
from autodb.explain.axis.effects import candidates_of_axis
from autodb.explain.axis.elsewhere import account_columns, fit_axis_account
from autodb.explain.axis.friction import (
    asymmetry_candidate,
    play,
    position_friction_candidate,
    soft_start,
    warmup_candidate,
)
from autodb.explain.axis.loads import (
    cross_couplings,
    inertia_candidate,
    spring_candidate,
    weights,
)
from autodb.explain.axis.moves import LIBRARY, AxisMove, Reach
from autodb.explain.axis.reading import AxisReading
from autodb.explain.axis.scan import rough_place, travel_ripple
from autodb.explain.axis.sensors_of_axis import drift, gain_candidate
from autodb.explain.axis.signals import AxisSignals, axis_signals
from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.fitted import fit_white_rows
from autodb.explain.engine.inquiry import Inquiry
from autodb.explain.engine.noise import Whitener
from autodb.explain.engine.search import CandidateSearch
from autodb.explain.engine.telling import SEPARATES, Separation
from autodb.explain.engine.tuning import tuned_together
from autodb.records.tables import Recording
from autodb.terms.friction import backlash, direction

Array = NDArray[np.float64]
Pair = Callable[[AxisSignals], list[Candidate]]

RATE_HZ = 100.0
NOISE_A = 0.02
T_S = np.arange(6000) / RATE_HZ


def _to_and_fro(amplitude_mm: float = 200.0, period_s: float = 12.0) -> Array:
    """Return a position that is never at rest."""
    return np.asarray(250.0 - amplitude_mm * np.cos(2 * np.pi * T_S / period_s))


def _one_way() -> Array:
    return np.asarray(50.0 + 6.0 * T_S)


def _reading(
    position: Array, known: Array, left_out: Array, pair: Pair, **further: Array
) -> AxisReading:
    """Return a recording explained by the first of a pair of candidates, the others its rivals."""
    velocity = np.gradient(position, T_S)
    rng = np.random.default_rng(7)
    channels = {
        "t": T_S,
        "x.position": position,
        "x.velocity": velocity,
        "x.acceleration": np.gradient(velocity, T_S),
        "x.current": known + left_out + rng.normal(0.0, NOISE_A, len(T_S)),
        **further,
    }
    recording = Recording(path=Path("recording.csv"), channels=channels)
    signals = axis_signals(recording, known, "x.current")
    bench = WhiteRows(channels["x.current"] - known, signals.own, 1)
    white, candidates = (Whitener(np.zeros(1)), NOISE_A**2), pair(signals)
    search = CandidateSearch(bench.products(bench.blocks(candidates), white), candidates)
    found = search.settled((Choice(candidates[0], 0),))
    inquiry = Inquiry(found, search, *white, {}, bench)
    choices = tuned_together(bench, found.choices, white)
    fitted = fit_white_rows(bench, choices, white)
    return AxisReading(
        bench, inquiry, white, choices, fitted, signals, frozenset(signals.own), "A", bench
    )


def _friction(position: Array) -> Array:
    velocity = np.gradient(position, T_S)
    return 0.6 * direction(velocity) + 0.001 * velocity


def _gravity_or_asymmetry() -> AxisReading:
    position = _to_and_fro()
    return _reading(
        position,
        _friction(position),
        np.full_like(T_S, 0.3),
        lambda s: [weights(s)[0], asymmetry_candidate(s)],
    )


def _warmup_or_gain() -> AxisReading:
    position = _to_and_fro()
    known = _friction(position)
    inertia = 0.002 * np.gradient(np.gradient(position, T_S), T_S)
    warming = -0.3 * known * (1 - np.exp(-T_S / 20.0))
    return _reading(
        position, known + inertia, warming, lambda s: [warmup_candidate(s), gain_candidate(s)]
    )


def _backlash_or_presliding() -> AxisReading:
    position = _to_and_fro()
    sense = direction(np.gradient(position, T_S))
    left_out = 0.4 * backlash(sense, position, gap_mm=0.1)
    return _reading(position, _friction(position), left_out, lambda s: [play(s), soft_start(s)])


def _spring_or_position_friction() -> AxisReading:
    position = _one_way()
    left_out = 0.002 * (position - position.mean())
    return _reading(
        position,
        _friction(position),
        left_out,
        lambda s: [spring_candidate(s), position_friction_candidate(s)],
    )


def _coupling_or_inertia() -> AxisReading:
    """Return a recording whose two axes run one straight line."""
    position = _to_and_fro(period_s=6.0)
    velocity = np.gradient(position, T_S)
    other = {
        "y.position": 0.5 * position,
        "y.velocity": 0.5 * velocity,
        "y.acceleration": 0.5 * np.gradient(velocity, T_S),
    }
    return _reading(
        position,
        _friction(position),
        0.002 * other["y.acceleration"],
        lambda s: [*cross_couplings(s), inertia_candidate(s)],
        **other,
    )


def _standing() -> AxisReading:
    """Return an axis that stood: a drift that settles, or a weight."""
    return _reading(
        np.full_like(T_S, 80.0),
        np.zeros_like(T_S),
        0.3 * (1.0 - np.exp(-T_S / 9.0)),
        lambda s: [drift(s), weights(s)[0]],
    )


def _by_words(reading: AxisReading, rival: str) -> dict[str, Separation]:
    swapped = instead(reading, 0, rival)
    assert swapped is not None
    accounts = fit_axis_account(reading, reading.choices), fit_axis_account(reading, swapped)
    return {gap.words: gap for gap in account_distances(reading, accounts)}


def _best(reading: AxisReading, rival: str) -> Separation:
    swapped = instead(reading, 0, rival)
    assert swapped is not None
    best = separation(reading, reading.choices, swapped)
    assert best is not None
    return best


def test_a_standstill_tells_weight_from_friction_that_differs_by_direction() -> None:
    best = _best(_gravity_or_asymmetry(), "asymmetry")
    assert best.words.startswith("Stand still")
    assert_allclose(best.peak, 0.3, rtol=0.02)
    # the recording's rows and those of the standstill share the refitted level of the weight
    rows = 20.0 * RATE_HZ
    share = len(T_S) / (len(T_S) + rows)
    assert_allclose(best.odds, rows * share * (0.3 / NOISE_A) ** 2, rtol=0.02)


def test_inertia_tells_warm_up_from_a_gain() -> None:
    """The friction of both is alike after the recording; a gain scales inertia too."""
    gaps = _by_words(_warmup_or_gain(), "gain")
    sharp = next(gap for words, gap in gaps.items() if "accelerating" in words)
    still = next(gap for words, gap in gaps.items() if words.startswith("Stand still"))
    assert sharp.odds > SEPARATES
    assert still.odds < 1.0


def test_slow_reversals_tell_play_from_presliding() -> None:
    best = _best(_backlash_or_presliding(), "presliding")
    assert best.words.startswith("Reverse slowly")
    assert best.peak > 0.1


def test_the_way_back_tells_a_spring_from_friction_along_the_travel() -> None:
    reading = _spring_or_position_friction()
    gaps = _by_words(reading, "position_friction")
    best = _best(reading, "position_friction")
    assert "there and back" in best.words or "in thirds" in best.words
    still = next(gap for words, gap in gaps.items() if words.startswith("Stand still"))
    again = next(gap for words, gap in gaps.items() if "programme" in words)
    assert best.peak > 0.3
    assert again.odds < 1.0
    assert still.distance < best.distance


def test_another_axis_alone_tells_a_coupling_from_inertia() -> None:
    reading = _coupling_or_inertia()
    gaps = _by_words(reading, "inertia")
    words, alone = next(item for item in gaps.items() if item[0].startswith("Let this axis stand"))
    assert "from 25 to 225 mm" in words
    assert alone.odds > SEPARATES
    # the move accelerates so that its top speed is reached in a second, or as the recording did
    its = reading.signals.others
    tops = [
        float(np.quantile(np.abs(its[f"y.{what}"]), 0.999)) for what in ("velocity", "acceleration")
    ]
    assert_allclose(alone.peak, 0.002 * max(tops), rtol=0.05)


def test_an_axis_that_stood_is_not_asked_to_move() -> None:
    words = _by_words(_standing(), "gravity")
    assert len(words) == 2
    assert any(w.startswith("Stand still") for w in words)
    assert any("programme once more" in w for w in words)


def test_the_sentence_carries_what_was_computed() -> None:
    reading = _gravity_or_asymmetry()
    best = _best(reading, "asymmetry")
    said = move_that_tells(reading, 0, ["asymmetry"], ())
    assert said == (
        f"{best.words}: there gravity and asymmetry would differ by up to {best.peak:.2g} A, noise "
        f"is {noise(reading):.2g} A."
    )
    assert_allclose(noise(reading), NOISE_A, rtol=0.05)


def test_what_the_accounts_say_of_a_standstill_is_their_coefficients() -> None:
    """At standstill a weight is its level and friction that differs by direction nothing."""
    reading = _gravity_or_asymmetry()
    swapped = instead(reading, 0, "asymmetry")
    assert swapped is not None
    one, two = fit_axis_account(reading, reading.choices), fit_axis_account(reading, swapped)
    still = next(g for g in account_distances(reading, (one, two)) if g.words.startswith("Stand"))
    assert_allclose(still.peak, one.of(0)[0], rtol=0.01)
    # a weight half as large is half as far
    half = replace(one, coefficients=0.5 * one.coefficients)
    nearer = next(g for g in account_distances(reading, (half, two)) if g.words.startswith("Stand"))
    assert_allclose(nearer.distance, 0.5 * still.distance, rtol=0.02)


@pytest.mark.parametrize(
    ("make", "rival"),
    [(_gravity_or_asymmetry, "asymmetry"), (_backlash_or_presliding, "presliding")],
)
def test_two_accounts_differ_alike_from_either_side(
    make: Callable[[], AxisReading], rival: str
) -> None:
    reading = make()
    swapped = instead(reading, 0, rival)
    assert swapped is not None
    there = separation(reading, reading.choices, swapped)
    back = separation(reading, swapped, reading.choices)
    assert there is not None
    assert back is not None
    assert there.words == back.words
    assert_allclose([there.odds, there.peak], [back.odds, back.peak], rtol=1e-6)


def test_an_account_does_not_differ_from_itself() -> None:
    reading = _gravity_or_asymmetry()
    assert separation(reading, reading.choices, reading.choices) is None


def test_without_an_alternative_nothing_is_asked_for() -> None:
    assert move_that_tells(_gravity_or_asymmetry(), 0, [], ()) is None


def test_what_no_move_separates_is_said() -> None:
    said = move_that_tells(_gravity_or_asymmetry(), 0, [], ("sensor_drift",))
    assert said is not None
    assert said.startswith("No move in the library separates gravity and sensor_drift. ")
    assert "drive disabled" in said


def _same_as_recorded(forms: tuple[CandidateForm, ...], again: tuple[CandidateForm, ...]) -> None:
    assert len(forms) == len(again)
    for one, other in zip(forms, again, strict=True):
        assert one.shape == other.shape
        assert_allclose(other.build(), one.build(), atol=1e-12)


OUT_OF_REACH = 25
"""Rows at the ends of a part that a shape takes from beyond: the longest delay has 22."""


def test_shapes_carried_to_part_of_the_recording_are_the_recording_s() -> None:
    """Scales, middles and knots come from the recording, whatever the move covers."""
    s = _warmup_or_gain().signals
    rows = slice(0, 2500)
    arrays: dict[str, Any] = {
        name: value[rows] for name, value in vars(s).items() if isinstance(value, np.ndarray)
    }
    part = replace(s, **arrays, own={n: c[rows] for n, c in s.own.items()}, like=s)
    for whole, again in zip(candidates_of_axis(s), candidates_of_axis(part), strict=True):
        for one, other in zip(whole.forms, again.forms, strict=True):
            assert one.shape == other.shape
            inner = slice(OUT_OF_REACH, -OUT_OF_REACH)
            assert_allclose(
                other.build()[inner], one.build()[rows][inner], atol=1e-9, err_msg=whole.key
            )


def test_what_scans_found_is_built_anew_with_its_values() -> None:
    s = _gravity_or_asymmetry().signals
    for found in (
        travel_ripple(s, 0, (17.3, 30.2), 9, along=True),
        rough_place(s, 0, 100.0, 180.0),
    ):
        assert found.anew is not None
        _same_as_recorded(found.forms, found.anew(replace(s, like=s)).forms)


def test_the_finest_ripple_keeps_its_place_at_every_period() -> None:
    """However far a period may give: three waves more would fit about as well."""
    s = _gravity_or_asymmetry().signals
    waves = (4.2, 17.3, 90.1)
    for form in travel_ripple(s, 0, waves, 9, along=False).forms[3:]:
        columns = form.build().shape[1] // 2
        period = form.shape["period"]
        more = max(waves[:columns]) * np.abs(period / np.array(form.within["period"]) - 1.0)
        assert_allclose(more, 0.2, rtol=0.05)


def test_a_shape_that_another_move_does_not_have_adds_nothing_there() -> None:
    """Signs that were fitted to what was recorded are not there where nothing was recorded."""
    reading = _gravity_or_asymmetry()
    form = CandidateForm(lambda: np.ones(len(T_S)), names=("level",))
    other = replace(reading.choices[0].candidate, forms=(form,))
    of = fit_axis_account(reading, (Choice(other, 0),))
    columns = account_columns(of, replace(reading.signals, like=reading.signals))
    assert columns.shape == (len(T_S), len(of.own) + 1)
    assert not columns[:, -1].any()


def test_an_account_on_its_own_recording_is_its_fit() -> None:
    reading = _backlash_or_presliding()
    of = fit_axis_account(reading, reading.choices)
    columns = account_columns(of, replace(reading.signals, like=reading.signals))
    given = columns @ of.coefficients
    assert_allclose(given, reading.bench.difference, atol=6 * NOISE_A)
    assert_allclose(given[1:].mean(), reading.bench.difference[1:].mean(), atol=NOISE_A)


@pytest.mark.parametrize("move", LIBRARY, ids=lambda move: move.words(Reach(0, 1, 1, 1))[:24])
def test_a_move_stays_in_the_travel_and_within_the_speed(move: AxisMove) -> None:
    limits = Reach(low_mm=20.0, high_mm=420.0, top_mm_s=150.0, top_mm_s2=900.0)
    path = move.path(limits, RATE_HZ)
    assert path.position.min() >= limits.low_mm - 1e-9
    assert path.position.max() <= limits.high_mm + 1e-9
    assert np.abs(path.velocity).max() <= limits.top_mm_s + 1e-9
    assert np.abs(path.acceleration).max() <= limits.top_mm_s2 + 1e-9
    assert_allclose(np.diff(path.t_s), 1 / RATE_HZ, rtol=1e-6)
    mean = 0.5 * (path.velocity[1:] + path.velocity[:-1]) / RATE_HZ
    assert_allclose(np.diff(path.position), mean, atol=limits.top_mm_s2 / RATE_HZ**2)
    assert path.t_s[-1] < 900.0
