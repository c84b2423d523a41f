"""What is read off a simulation: its terms, and the motion that it was computed with."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.signal import butter, filtfilt

from autodb.explain import explain
from autodb.explain.axis.signals import AxisSignals, axis_signals
from autodb.records.tables import Recording
from autodb.terms.friction import direction

Array = NDArray[np.float64]

RATE_HZ = 200.0
T_S = np.arange(6000) / RATE_HZ
TRUTH = {"coulomb": 0.9, "viscous": 0.004, "inertia": 0.0015, "gravity": 1.3}


def _position() -> Array:
    return 150.0 * np.sin(0.7 * T_S) + 30.0 * np.sin(3.1 * T_S)


def _simulated(turning: Callable[[Array], Array], velocity: Array, acceleration: Array) -> Array:
    friction = TRUTH["coulomb"] * turning(velocity) + TRUTH["viscous"] * velocity
    return np.asarray(friction + TRUTH["inertia"] * acceleration + TRUTH["gravity"])


def _read(
    simulation: Array, recorded: dict[str, Array] | None = None, includes: list[str] | None = None
) -> AxisSignals:
    channels = {"t": T_S, "x.position": _position(), "x.current": simulation, **(recorded or {})}
    recording = Recording(path=Path("r.csv"), channels=channels)
    return axis_signals(recording, simulation, "x.current", includes=includes)


TURNINGS: dict[str, Callable[[Array], Array]] = {
    "tanh over 0.05": lambda v: np.tanh(v / 0.05),
    "tanh over 1.7": lambda v: np.tanh(v / 1.7),
    "tanh over 6": lambda v: np.tanh(v / 6.0),
    "straight over 2.6": lambda v: direction(v, standstill_mm_s=2.6),
    "sign": np.sign,
}


@pytest.mark.parametrize("turning", TURNINGS)
def test_friction_that_turns_over_another_speed_is_read_with_its_level(turning: str) -> None:
    velocity = np.gradient(_position(), T_S)
    acceleration = np.gradient(velocity, T_S)
    simulation = _simulated(TURNINGS[turning], velocity, acceleration)
    recorded: dict[str, Array] = {"x.velocity": velocity, "x.acceleration": acceleration}
    read = _read(simulation, recorded)
    assert read.read_share > 0.999
    for name, value in TRUTH.items():
        assert_allclose(read.had[name], value, rtol=0.01)


@pytest.mark.parametrize("cutoff_hz", [3.0, 8.0])
def test_an_acceleration_through_another_filter_is_found(cutoff_hz: float) -> None:
    """Of a noisy velocity: with the acceleration that is derived here friction would take it up."""
    rng = np.random.default_rng(3)
    velocity = np.gradient(_position(), T_S) + rng.normal(0.0, 1.0, len(T_S))
    b, a = butter(2, cutoff_hz, fs=RATE_HZ)
    acceleration = np.gradient(filtfilt(b, a, velocity), T_S)
    simulation = _simulated(lambda v: np.tanh(v / 5.0), velocity, acceleration)
    read = _read(simulation, {"x.velocity": velocity})
    assert read.read_share > 0.99
    for name in ("coulomb", "viscous", "gravity"):
        assert_allclose(read.had[name], TRUTH[name], rtol=0.05)
    assert_allclose(read.had["inertia"], TRUTH["inertia"], rtol=0.1)


def test_only_what_it_includes_is_read() -> None:
    velocity = np.gradient(_position(), T_S)
    simulation = 0.9 * np.tanh(velocity / 2.0) + 0.004 * velocity
    simulation += 0.1 * np.sin(0.7 * T_S + 0.4)
    assert set(_read(simulation).had) > {"coulomb", "viscous"}
    read = _read(simulation, includes=["viscous", "coulomb", "stribeck"])
    assert set(read.had) == {"coulomb", "viscous"}
    assert set(read.own) == {"coulomb", "viscous"}
    assert _read(simulation, includes=["stribeck"]).had == {}


def test_friction_of_the_wrong_sign_is_read_only_where_it_is_written_so() -> None:
    """With something else in the simulation a negative coefficient would only follow that."""
    velocity = np.gradient(_position(), T_S)
    simulation = 0.9 * np.tanh(velocity / 2.0) - 0.004 * velocity
    read = _read(simulation, {"x.velocity": velocity})
    assert_allclose(read.had["viscous"], -0.004, rtol=1e-3)
    assert read.read_share > 0.999
    read = _read(simulation + 0.3 * np.sin(0.7 * T_S + 0.4), {"x.velocity": velocity})
    assert all(read.had[name] > 0.0 for name in {"coulomb", "viscous", "inertia"} & set(read.had))


@pytest.mark.parametrize("orders", [(6, 12, 18, 24), (7, 12, 21, 36, 84)])
def test_the_ripples_of_a_simulation_are_read_off_it(orders: tuple[int, ...]) -> None:
    """Their periods are not stated; without them the friction takes some of them up."""
    rng = np.random.default_rng(8)
    position = _position()
    velocity = np.gradient(position, T_S)
    turns = 2.0 * np.pi * (position - position.min()) / np.ptp(position)
    waves = [
        np.cos(k * turns + phase) for k, phase in zip(orders, rng.uniform(0, 6, 9), strict=False)
    ]
    cogging = sum(rng.uniform(0.2, 1.0) * wave for wave in waves)
    simulation = (
        _simulated(lambda v: np.tanh(v / 2.0), velocity, np.gradient(velocity, T_S)) + cogging
    )
    includes = ["coulomb", "viscous", "inertia", "gravity", "cogging"]
    read = _read(simulation, {"x.velocity": velocity}, includes=includes)
    assert read.read_share > 0.999
    assert_allclose(
        read.own["cogging"] - read.own["cogging"].mean(), cogging - cogging.mean(), atol=0.02
    )
    for name in ("coulomb", "viscous", "gravity"):
        assert_allclose(read.had[name], TRUTH[name], rtol=0.02)


@pytest.mark.parametrize("bent", [0.0, 0.2])
def test_a_simulation_that_is_not_well_read_is_not_quoted(bent: float) -> None:
    position = _position()
    velocity = np.gradient(position, T_S)
    acceleration = np.gradient(velocity, T_S)
    simulation = _simulated(lambda v: np.tanh(v / 0.3), velocity, acceleration)
    simulation += bent * np.sin(2.0 * np.pi * T_S / 1.3)
    noise = np.random.default_rng(5).normal(0.0, 0.03, len(T_S))
    channels = {
        "t": T_S, "x.position": position, "x.velocity": velocity, "x.acceleration": acceleration,
        "x.current": simulation + 0.15 * np.tanh(velocity / 0.3) + noise,
    }  # fmt: skip
    made = {"t": T_S, "x.current": simulation}
    answer = explain(
        Recording(path=Path("r.csv"), channels=channels),
        Recording(path=Path("s.csv"), channels=made),
    ).explanation.channels["x.current"]
    (cause,) = answer.missing
    assert (cause.term, cause.kind) == ("coulomb", "mistuned")
    if bent:
        assert "The simulation has" not in cause.statement
        assert "off by a factor" in cause.statement
        assert_allclose(cause.parameters["factor"].value, 1.05 / 0.9, rtol=0.02)
    else:
        assert cause.statement.startswith("The simulation has coulomb with level 0.9")
        assert_allclose(cause.parameters["level"].value, 1.05, rtol=0.01)


def test_ripples_of_a_simulation_are_read_beside_the_motion_that_it_has() -> None:
    """A joint turns forth and back by 60°, at a speed that trembles, and its simulation has less of
    that: what the recorded motion left of the mass was read as waves over the angle, a hundred
    times as large as the ripple, beside a weight that took them back."""
    rng, t = np.random.default_rng(3), np.arange(700) / 250.0
    rises = np.clip(np.minimum(t - 0.1, 2.7 - t) / 0.3, 0.0, 1.0)
    clean = 45.0 * rises * np.where(t < 1.4, 1.0, -1.0) * np.clip(np.abs(t - 1.4) / 0.2, 0.0, 1.0)
    angle, velocity = np.cumsum(clean) / 250.0 - 30.0, clean + rng.normal(0.0, 0.5, len(t))
    smooth = filtfilt(*butter(2, 10.0, fs=250.0), velocity)
    ripple = 0.2 * np.sin(2.0 * np.pi * angle / 3.9)
    weight = 3.1 * np.cos(np.radians(angle - 70.0))
    simulation = 0.0055 * np.gradient(smooth, t) + weight + ripple
    channels = {"t": t, "a.angle": angle, "a.velocity": velocity, "a.current": simulation}
    terms = ["inertia", "gravity", "cogging"]
    recording = Recording(path=Path("r.csv"), channels=channels)
    read = axis_signals(recording, simulation, "a.current", includes=terms)
    assert_allclose(read.had["inertia"], 0.0055, rtol=0.05)
    assert_allclose(read.had["gravity"], 3.1, rtol=0.05)
    assert_allclose(np.abs(read.own["cogging"]).max(), 0.2, rtol=0.2)


def test_an_included_term_turns_as_the_friction_that_it_is_read_beside() -> None:
    """Friction by direction of a simulation that turns over 3 mm/s was left in the rest, and then
    found missing beside it."""
    velocity = np.gradient(_position(), T_S)
    sense = np.tanh(velocity / 3.0)
    harder = 0.5 * np.abs(sense)
    simulation = TRUTH["coulomb"] * sense + harder
    recorded: dict[str, Array] = {"x.velocity": velocity}
    read = _read(simulation, recorded, ["coulomb", "asymmetry"])
    assert read.read_share > 0.999
    assert_allclose(read.had["coulomb"], TRUTH["coulomb"], rtol=0.01)
    assert_allclose(read.own["asymmetry"], harder, atol=0.02)
