"""Laws, curves and rivals are compared for what they share."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import ChannelAnswer
from autodb.explain.axis.signals import axis_signals
from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import (
    UNKNOWN,
    Candidate,
    CandidateForm,
    Choice,
    has_positive_first,
)
from autodb.explain.engine.plain.growing import grown, merged_laws
from autodb.explain.engine.plain.odds import UNSURE, of_plain
from autodb.explain.engine.plain.rows import PlainRows
from autodb.explain.engine.standing import Standing
from autodb.records.tables import Recording

Array = NDArray[np.float64]
T_S = np.arange(4000) / 100.0
NOISE_A = 0.01
TRAVEL_MM = 20.0


def _moves() -> dict[str, Array]:
    """Return position [mm], velocity and acceleration of strokes to and fro, of two paces."""
    fast, slow = 2 * np.pi * 0.4, 2 * np.pi * 0.11
    return {
        "x.position": 50 + 3 * np.sin(fast * T_S) + 7 * np.sin(slow * T_S),
        "x.velocity": 3 * fast * np.cos(fast * T_S) + 7 * slow * np.cos(slow * T_S),
        "x.acceleration": -3 * fast**2 * np.sin(fast * T_S) - 7 * slow**2 * np.sin(slow * T_S),
    }


def _friction(moved: dict[str, Array]) -> Array:
    return np.asarray(0.3 * np.sign(moved["x.velocity"]) + 0.004 * moved["x.velocity"])


def _answer(missing: Array, simulated: Array, *, includes: Sequence[str]) -> ChannelAnswer:
    moved = _moves()
    noise = np.random.default_rng(7).normal(0.0, NOISE_A, len(T_S))
    recorded = {"t": T_S, **moved, "x.current": simulated + missing + noise}
    recording = Recording(path=Path("recording.csv"), channels=recorded)
    simulation = Recording(path=Path("simulation.csv"), channels={"t": T_S, "x.current": simulated})
    done = explain(recording, simulation, includes=list(includes))
    return done.explanation.channels["x.current"]


def _rows(missing: Array, candidates: Sequence[Candidate]) -> PlainRows:
    """Return plain rows of an axis whose simulation has its friction."""
    moved = _moves()
    friction = _friction(moved)
    recorded = {"t": T_S, **moved, "x.current": friction + missing}
    signals = axis_signals(Recording(path=Path("r.csv"), channels=recorded), friction, "x.current")
    sizes = [signals.had[name] for name in signals.own]
    return PlainRows(WhiteRows(missing, dict(signals.own), 1, own_sizes=sizes, gap=25), candidates)


def _between(low_s: float, high_s: float) -> Array:
    return np.where((low_s < T_S) & (high_s > T_S), 1.0, 0.0)


def _candidate(key: str, column: Array, *, static: bool = False, term: str = "") -> Candidate:
    form = CandidateForm(lambda: column, names=("level",))
    return Candidate(key, term or key, (form,), static=static)


def _standing(rows: PlainRows, law: Candidate) -> Standing:
    return of_plain(rows, [Choice(law, 0)], Choice(law, 0))


def test_a_rival_that_does_something_else_takes_no_name_away() -> None:
    """A curve of another kind explains more than a load; one that bends with it has its place."""
    noise = np.random.default_rng(1).normal(0.0, NOISE_A, len(T_S))
    load = _between(11.0, 29.0)
    bent = np.asarray(load * (1.0 + 0.3 * np.sin(2 * np.pi * 0.7 * T_S)), dtype=np.float64)
    other = np.asarray(np.sin(2 * np.pi * 1.3 * T_S), dtype=np.float64)
    law = _candidate("external_load", load)
    alike = _candidate("a curve that bends with it", bent, term=UNKNOWN)
    curve = _candidate("a curve", other, term=UNKNOWN)
    rows = _rows(0.2 * bent + 0.3 * other + noise, [law, curve])
    assert rows.has_its_own([], Choice(law, 0), Choice(curve, 0))
    assert 0.8 < _standing(rows, law).confidence <= UNSURE
    rows = _rows(0.2 * bent + noise, [law, alike])
    assert not rows.has_its_own([], Choice(law, 0), Choice(alike, 0))
    assert _standing(rows, law).confidence <= 0.5


def test_what_acts_on_an_effect_and_was_built_on_it_is_none_of_its_rivals() -> None:
    """A gain of an effort that holds the load by now follows it better than the load itself."""
    noise = np.random.default_rng(6).normal(0.0, NOISE_A, len(T_S))
    load = _between(11.0, 29.0)
    bent = np.asarray(load * (1.0 + 0.2 * np.sin(2 * np.pi * 0.7 * T_S)), dtype=np.float64)
    law = _candidate("external_load", load)
    acting = _candidate("gain", bent)
    rows = _rows(0.2 * bent + noise, [law, acting])
    assert _standing(rows, law).confidence <= 0.5
    rows.acts_on = {"gain": frozenset({"external_load"})}
    assert _standing(rows, law).confidence > 0.9


def test_a_law_that_is_none_of_its_kind_beside_another_gives_way_to_it() -> None:
    """A dip, positive alone as it has to be, follows a ripple; beside that it is negative."""
    rng = np.random.default_rng(8)
    ripple = np.sin(2 * np.pi * 1.3 * T_S)
    column = 0.4 * ripple + np.sin(2 * np.pi * 0.31 * T_S)
    form = CandidateForm(lambda: column, names=("level",), allowed=has_positive_first)
    dip = Candidate("stribeck", "stribeck", (form,), static=True)
    law = _candidate("cogging", ripple)
    rows = _rows(0.2 * ripple - 0.02 * column + rng.normal(0.0, NOISE_A, len(T_S)), [dip, law])
    assert [value[0] > 0.0 for value in rows.coefficients([Choice(dip, 0)])] == [True]
    assert rows.coefficients([Choice(dip, 0), Choice(law, 0)])[0][0] < 0.0
    assert [choice.candidate for choice in grown(rows, [Choice(dip, 0)], [law])] == [law]


def test_useless_rivals_do_not_add_up() -> None:
    """Ten that explain nothing are one account: nothing in its place."""
    rng = np.random.default_rng(2)
    noise = rng.normal(0.0, NOISE_A, len(T_S))
    load = _between(11.0, 29.0)
    law = _candidate("external_load", load)
    idle = [_candidate(f"idle {n}", rng.normal(size=len(T_S))) for n in range(10)]
    missing = 0.004 * load + noise
    alone = _standing(_rows(missing, [law]), law)
    beside = _standing(_rows(missing, [law, *idle]), law)
    assert beside.near == ()
    assert_allclose(beside.confidence, min(alone.confidence, UNSURE), atol=1e-9)


def test_a_constant_load_is_surer_than_a_spring_that_holds_it() -> None:
    """A straight slope with a level of its own explains as much as the level alone."""
    moved = _moves()
    answer = _answer(np.full(len(T_S), 0.5), _friction(moved), includes=("coulomb", "viscous"))
    (cause,) = [c for c in answer.missing if c.kind == "missing"]
    assert cause.term == "gravity"
    assert_allclose(cause.parameters["level"].value, 0.5, rtol=0.02)
    assert cause.confidence >= 0.7


def test_what_pulls_from_far_beyond_the_travel_is_a_constant_load() -> None:
    """A spring whose rest is ten travels away differs by a twentieth of its force over them."""
    moved = _moves()
    pull = 0.5 * (moved["x.position"] - 50 + 10 * TRAVEL_MM) / (10 * TRAVEL_MM)
    answer = _answer(pull, _friction(moved), includes=("coulomb", "viscous"))
    assert answer.missing[0].term == "gravity"


def test_a_spring_is_found_beside_a_weight_that_the_simulation_has() -> None:
    moved = _moves()
    stiffness = 0.02
    spring = stiffness * (moved["x.position"] - 50.0)
    answer = _answer(spring, _friction(moved) + 0.4, includes=("coulomb", "viscous", "gravity"))
    (cause,) = [c for c in answer.missing if c.kind == "missing"]
    assert cause.term == "spring"
    assert_allclose(cause.parameters["stiffness"].value, stiffness, rtol=0.05)
    assert cause.confidence >= 0.9


def test_play_of_a_twentieth_of_a_short_travel_is_found() -> None:
    """Small strokes show the play of a worn screw: 1 mm of 20."""
    moved = _moves()
    gap, position = 1.0, moved["x.position"]
    turned = np.flatnonzero(np.diff(np.sign(moved["x.velocity"])) != 0) + 1
    last = np.zeros(len(T_S), dtype=np.intp)
    last[turned] = turned
    last = np.maximum.accumulate(last)
    way = np.where(last > 0, np.abs(position - position[last]), np.inf)
    absent = -0.2 * np.sign(moved["x.velocity"]) * (way < gap)
    answer = _answer(absent, _friction(moved), includes=("coulomb", "viscous"))
    (cause,) = [c for c in answer.missing if c.kind == "missing" and c.confidence >= 0.5]
    assert cause.term == "backlash"
    assert_allclose(cause.parameters["gap"].value, gap, rtol=0.1)


def test_a_large_load_does_not_hide_itself_in_slow_noise() -> None:
    """Over a quarter of the recording it is as slow as slow noise is."""
    noise = np.random.default_rng(4).normal(0.0, NOISE_A, len(T_S))
    load = 0.06 * _between(9.0, 19.0)
    law = _candidate("external_load", load)
    rows = _rows(load + noise, [law])
    assert rows.slow_beside(Choice(law, 0)) < 0.2 * rows.slow


def test_one_law_takes_the_place_of_two_that_are_its_halves() -> None:
    """Two that add up to it explain as much; two of which it is no sum stay."""
    noise = np.random.default_rng(3).normal(0.0, NOISE_A, len(T_S))
    whole = np.asarray(np.sin(2 * np.pi * 0.6 * T_S), dtype=np.float64)
    early, late = whole * (T_S < 20.0), whole * (T_S >= 20.0)
    halves = [_candidate("early", early, static=True), _candidate("late", late, static=True)]
    one = _candidate("whole", whole, static=True)
    both = [Choice(half, 0) for half in halves]
    rows = _rows(0.3 * whole + noise, [*halves, one])
    assert [c.candidate.key for c in merged_laws(rows, both)] == ["whole"]
    rows = _rows(0.3 * early - 0.2 * late + noise, [*halves, one])
    assert merged_laws(rows, both) == both


def test_one_law_that_soaks_up_misfit_takes_the_place_of_two_only_if_it_does_better() -> None:
    """Two that are each 1 % off in their half are better than one that is 1.5 % off in all."""
    noise = np.random.default_rng(4).normal(0.0, NOISE_A, len(T_S))
    whole = np.asarray(np.sin(2 * np.pi * 0.6 * T_S), dtype=np.float64)
    early, late = whole * (T_S < 20.0), whole * (T_S >= 20.0)
    halves = [_candidate("early", early, static=True), _candidate("late", late, static=True)]
    off = whole + 0.007 * np.sin(2 * np.pi * 1.7 * T_S)
    both = [Choice(half, 0) for half in halves]
    for static, kept in ((True, ["whole"]), (False, ["early", "late"])):
        rows = _rows(0.3 * whole + noise, [*halves, _candidate("whole", off, static=static)])
        assert [c.candidate.key for c in merged_laws(rows, both)] == kept


def test_what_scales_a_law_does_not_take_its_place() -> None:
    """Its column is the law's and more: it does better than two alone, and holds one of them."""
    noise = np.random.default_rng(3).normal(0.0, NOISE_A, len(T_S))
    whole = np.asarray(np.sin(2 * np.pi * 0.6 * T_S), dtype=np.float64)
    early, late = whole * (T_S < 20.0), whole * (T_S >= 20.0)
    halves = [_candidate("early", early, static=True), _candidate("late", late, static=True)]
    both = [Choice(half, 0) for half in halves]
    for holds, kept in ((set(), ["whole"]), ({"early"}, ["early", "late"])):
        scale = replace(_candidate("whole", whole, static=True), holds=frozenset(holds))
        rows = _rows(0.3 * whole + noise, [*halves, scale])
        assert [c.candidate.key for c in merged_laws(rows, both)] == kept
