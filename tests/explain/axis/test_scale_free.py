"""No unit, direction, clock or rate changes what is said of a recording."""

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import ChannelAnswer
from autodb.explain.axis.scales import axis_scales
from autodb.explain.axis.signals import AxisSignals, axis_signals
from autodb.proofs.machines.axis.axis import air_moves
from autodb.records import source as records
from autodb.records.tables import Recording
from autodb.sensing.drives.moves.motion import axis_motion, standstill_speed
from autodb.terms.friction import STANDSTILL_MM_S
from tests.helpers.campaigns import first

Array = NDArray[np.float64]
Channels = dict[str, Array]

MOTION = ("position", "velocity", "acceleration")
REAL = Path(os.environ.get("AUTODB_SHARED", "")) / "data" / "real" / "laas-acc-no_inertia-kept"


@dataclass(frozen=True)
class Pair:
    """A recording, its simulation, and by what their efforts were multiplied."""

    recording: Channels
    simulation: Channels
    includes: tuple[str, ...]
    effort: float = 1.0


def _is_motion(name: str) -> bool:
    return name.partition(".")[2] in MOTION


def _scaled(pair: Pair, motion: float = 1.0, effort: float = 1.0) -> Pair:
    def one(channels: Channels) -> Channels:
        by = {n: 1.0 if n == "t" else motion if _is_motion(n) else effort for n in channels}
        return {name: values * by[name] for name, values in channels.items()}

    return Pair(one(pair.recording), one(pair.simulation), pair.includes, abs(effort))


def _each(pair: Pair, change: Callable[[str, Array], Array]) -> Pair:
    def one(channels: Channels) -> Channels:
        return {name: change(name, values) for name, values in channels.items()}

    return Pair(one(pair.recording), one(pair.simulation), pair.includes)


def _named(pair: Pair, axis: str) -> Pair:
    """Return a pair whose axis has another name, a rotary one's angle too."""

    def called(name: str) -> str:
        what = name.partition(".")[2]
        return "t" if name == "t" else f"{axis}.{'angle' if what == 'position' else what}"

    recording, simulation = (
        {called(n): values for n, values in channels.items()}
        for channels in (pair.recording, pair.simulation)
    )
    return Pair(recording, simulation, pair.includes)


def _doubled(name: str, values: Array) -> Array:
    del name
    rows = np.arange(2 * len(values) - 1) / 2.0
    return np.interp(rows, np.arange(len(values)), values)


ALIKE: dict[str, Callable[[Pair], Pair]] = {
    "ways / 50": lambda pair: _scaled(pair, motion=0.02),
    "effort × 10": lambda pair: _scaled(pair, effort=10.0),
    "another clock": lambda pair: _each(pair, lambda n, v: v + 64.0 * (n == "t")),
    "in degrees": lambda pair: _named(pair, "c"),
    "effort / 1000": lambda pair: _scaled(pair, effort=0.001),
    "reversed": lambda pair: _scaled(pair, motion=-1.0, effort=-1.0),
    "ways × 10": lambda pair: _scaled(pair, motion=10.0),
}
RATES: dict[str, Callable[[Pair], Pair]] = {
    "half": lambda pair: _each(pair, lambda _, values: values[::2]),
    "double": lambda pair: _each(pair, _doubled),
}


@cache
def _synthetic() -> Pair:
    channels, parts = air_moves(21, rate_hz=100.0, seconds=30.0)
    had = ("viscous", "inertia", "gravity")
    simulation = np.asarray(sum(parts[name] for name in had), dtype=np.float64)
    recording = {**channels, "x.current": channels["x.current"] - parts["stribeck"]}
    return Pair(recording, {"t": channels["t"], "x.current": simulation}, had)


@cache
def _real(folder: Path = REAL) -> Pair:
    recording, simulation = (records.read(folder / f"{n}.csv") for n in ("recording", "simulation"))
    truth = json.loads((folder / "truth.json").read_text())
    return Pair(dict(recording.channels), dict(simulation.channels), tuple(truth["includes"]))


def _answer(pair: Pair) -> ChannelAnswer:
    recording = Recording(path=Path("recording.csv"), channels=pair.recording)
    simulation = Recording(path=Path("simulation.csv"), channels=pair.simulation)
    done = explain(recording, simulation, includes=list(pair.includes))
    (answer,) = done.explanation.channels.values()
    return answer


@cache
def _plain(of: Callable[[], Pair]) -> ChannelAnswer:
    return _answer(of())


def _alike(answer: ChannelAnswer, plain: ChannelAnswer, effort: float) -> None:
    assert [(c.term, c.kind) for c in answer.missing] == [(c.term, c.kind) for c in plain.missing]
    for one, other in zip(answer.missing, plain.missing, strict=True):
        size, was = one.parameters["size"], other.parameters["size"]
        assert_allclose(size.value / effort, was.value, atol=0.1 * (was.high - was.low))
        assert_allclose(one.confidence, other.confidence, atol=0.02)
    assert_allclose(answer.fit.heldout_after / effort, plain.fit.heldout_after, rtol=0.01)


@pytest.mark.parametrize("change", first(2, ALIKE))
def test_a_part_left_out_is_the_same_in_any_unit(change: str) -> None:
    pair = ALIKE[change](_synthetic())
    plain = _plain(_synthetic)
    assert [c.term for c in plain.missing if c.kind == "missing"] == ["coulomb"]
    _alike(_answer(pair), plain, pair.effort)


@pytest.mark.parametrize("rate", first(1, RATES))
def test_a_part_left_out_is_named_at_another_rate(rate: str) -> None:
    answer = _answer(RATES[rate](_synthetic()))
    (was,) = [c.parameters["size"] for c in _plain(_synthetic).missing if c.kind == "missing"]
    (cause,) = [c for c in answer.missing if c.kind == "missing"]
    assert cause.term == "coulomb"
    assert_allclose(cause.parameters["size"].value, was.value, rtol=0.1)


@pytest.mark.skipif(not REAL.exists(), reason="no real recordings: set AUTODB_SHARED")
@pytest.mark.parametrize("change", first(1, ["ways / 50", "effort / 1000", "reversed"]))
def test_a_real_recording_is_the_same_in_any_unit(change: str) -> None:
    pair = ALIKE[change](_real())
    _alike(_answer(pair), _plain(_real), pair.effort)


@pytest.mark.skipif(not REAL.exists(), reason="no real recordings: set AUTODB_SHARED")
@pytest.mark.parametrize("of", first(1, ["laas-map-no_cogging-kept", "tx40-j4-no_coulomb-kept"]))
def test_a_part_left_out_of_a_real_axis_is_named_at_half_the_rate(of: str) -> None:
    """The first is logged at 2.5 Hz: at half of that a test move has few rows for the filter, and a
    faint dip of friction comes before the ripple, beside which it is none.
    """
    folder = REAL.parent / of
    term = json.loads((folder / "truth.json").read_text())["concealed"]
    pair = _real(folder)
    sizes = [
        [c.parameters["size"].value for c in _answer(one).missing if c.term == term]
        for one in (pair, RATES["half"](pair))
    ]
    assert_allclose(sizes[1], sizes[0], rtol=0.1)
    assert len(sizes[0]) == 1


def _signals(pair: Pair) -> AxisSignals:
    recording = Recording(path=Path("r.csv"), channels=pair.recording)
    (channel,) = (name for name in pair.simulation if name != "t")
    return axis_signals(recording, pair.simulation[channel], channel)


def test_grids_go_with_the_ways() -> None:
    plain, scaled = (_signals(pair).scales for pair in (_synthetic(), _scaled(_synthetic(), 50.0)))
    for of in ("widths", "dips", "starts", "softening", "plays", "turns"):
        assert_allclose(getattr(scaled, of)(), 50.0 * np.array(getattr(plain, of)()), rtol=1e-6)


@pytest.mark.parametrize(
    ("of", "least", "most"),
    [("widths", 0.1, 1.0), ("dips", 0.5, 60.0), ("softening", 0.03, 1.0), ("plays", 0.03, 1.0)],
)
def test_grids_of_a_feed_axis_reach_from_what_rows_show(of: str, least: float, most: float) -> None:
    channels, parts = air_moves(3)
    simulation = {"t": channels["t"], "x.current": np.asarray(sum(parts.values()))}
    grid = getattr(_signals(Pair(channels, simulation, ())).scales, of)()
    assert min(grid) <= 1.05 * least
    assert max(grid) >= most
    assert len(grid) <= 14


def test_delays_are_of_rows() -> None:
    t = np.arange(500) / 10.0
    x = 100.0 * np.sin(t)
    scales = axis_scales(t, x, np.cos(t), np.sign(np.cos(t)), np.abs(x))
    delays = scales.delays((0.0004, 0.004, 0.03, 0.045))
    assert delays[0] == 0.03
    assert 0.2 <= delays[-1] < 0.31
    fast = axis_scales(t / 1000.0, x, np.cos(t), np.sign(np.cos(t)), np.abs(x))
    assert fast.delays((0.0004, 0.004, 0.03)) == [0.0004, 0.004, 0.03]


def test_a_slow_axis_has_a_direction_of_its_own() -> None:
    """0.03 mm/s, below the speed at which a fast axis stands."""
    t = np.arange(6000) / 100.0
    position = 0.15 * np.sin(0.2 * t)
    channels = {"t": t, "x.position": position, "x.velocity": 0.03 * np.cos(0.2 * t)}
    recording = Recording(path=Path("r.csv"), channels=channels)
    sense = axis_motion(recording, "x", cutoff_hz=20.0, own_speeds=True).direction
    assert np.mean(np.abs(sense) >= 1.0) > 0.95


def test_an_axis_that_flickers_stands() -> None:
    step = np.where(np.random.default_rng(0).random(5000) > 0.5, 1e-4, 0.0)
    speed = np.asarray(np.gradient(step, 0.001), dtype=np.float64)
    assert standstill_speed(step, speed, 0.0) == STANDSTILL_MM_S
