"""Moves that go one way each: what they leave open, and blocks that alone hold a speed."""

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

import autodb
from autodb.explain.answer import Cause, ChannelAnswer
from autodb.proofs.cases.real.real_case import RealSpec
from autodb.proofs.cases.real.real_cases import made_case
from autodb.proofs.runs.real.real_answers import explained_real
from autodb.proofs.runs.real.real_score import own_within
from autodb.terms.drive import tilt
from tests.conftest import shared

Array = NDArray[np.float64]


def _fitted(columns: list[Array], effort: Array) -> Array:
    matrix = np.column_stack(columns)
    return np.asarray(matrix @ np.linalg.lstsq(matrix, effort, rcond=None)[0])


def _derived(moves: list[Array], step_s: float) -> tuple[Array, Array]:
    """Return speed and acceleration of moves, one behind the other."""
    speeds = [np.gradient(move, step_s) for move in moves]
    return np.concatenate(speeds), np.concatenate([np.gradient(v, step_s) for v in speeds])


def _explained(channels: dict[str, Array], simulation: Array, includes: list[str]) -> ChannelAnswer:
    simulated = pd.DataFrame({"t": channels["t"], "a.drive_torque": simulation})
    done = autodb.explain(pd.DataFrame(channels), simulated, includes=includes)
    return done.answer.explanation.channels["a.drive_torque"]


def _by_term(answer: ChannelAnswer) -> dict[str, Cause]:
    return {cause.term: cause for cause in answer.missing}


def test_a_block_that_alone_holds_a_speed_undoes_no_law() -> None:
    """A joint driven forth and back at five speeds, as a sweep of its friction; its simulation was
    fitted without dry friction, the weight has taken it up. The arm beyond it turns as well."""
    rng, step_s = np.random.default_rng(1), 0.015
    t = np.arange(0.0, 5.0, step_s)
    speeds = np.multiply.outer([5.0, 10.0, 20.0, 30.0, 40.0], [1.0, -1.0]).ravel()
    moves = [np.cumsum(speed * (1.0 - np.exp(-t / 0.1))) * step_s for speed in speeds]
    velocity, acceleration = _derived(moves, step_s)
    time, angle = np.concatenate([t + 6.0 * k for k in range(len(moves))]), np.concatenate(moves)
    effort = 38.0 * np.sin(np.radians(angle)) + 13.0 * np.tanh(velocity / 0.5) + 0.05 * velocity
    effort += 0.04 * acceleration + 4.0 * np.sin(np.radians(2.0 * angle) + 0.5)
    effort += rng.normal(0.0, 2.0, len(time))
    answer = _explained(
        {"t": time, "a.angle": angle, "a.drive_torque": effort},
        _fitted([tilt(angle), velocity], effort),
        ["gravity", "viscous"],
    )
    found = _by_term(answer)
    assert found.keys() == {"coulomb", "inertia", "cogging"}
    assert found["coulomb"].confidence >= 0.9
    assert found["coulomb"].parameters["level"].value == pytest.approx(13.0, rel=0.15)
    assert found["inertia"].parameters["coefficient"].value == pytest.approx(0.04, rel=0.15)
    assert answer.fit.heldout_after < 1.1 * 2.0  # the noise; 2.7 with friction along the travel


def _one_way(seed: int) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return six moves of a joint from one place to another, and what its torque is made of."""
    rng, step_s, t = np.random.default_rng(seed), 0.004, np.arange(0.0, 3.0, 0.004)
    ways = [np.clip(t / (2.2 + 0.1 * k), 0.0, 1.0) for k in range(6)]
    moves = [
        2.0 * k - 40.0 + 60.0 * (way - np.sin(2.0 * np.pi * way) / (2.0 * np.pi))
        for k, way in enumerate(ways)
    ]
    velocity, acceleration = _derived(moves, step_s)
    angle = np.concatenate(moves)
    velocity = velocity + rng.normal(0.0, 0.05, len(angle))
    parts = {
        "gravity": 2.5 * np.sin(np.radians(angle - 20.0)), "coulomb": 0.5 * np.tanh(velocity / 0.5),
        "viscous": 0.18 * velocity, "inertia": 0.003 * acceleration,
    }  # fmt: skip
    slow, push = np.zeros(len(angle)), rng.normal(0.0, 0.3, len(angle))
    for row in range(1, len(angle)):
        slow[row] = 0.98 * slow[row - 1] + 0.2 * push[row]
    effort = sum(parts.values(), start=slow) + rng.normal(0.0, 0.2, len(angle))
    time = np.concatenate([t + 4.0 * k for k in range(6)])
    channels = {"t": time, "a.angle": angle, "a.velocity": velocity, "a.drive_torque": effort}
    return channels, parts


@pytest.mark.parametrize(
    ("term", "seed", "size"), [("viscous", 1, 0.18), ("gravity", 2, 2.5)], ids=["speed", "weight"]
)
def test_one_way_the_usual_law_is_named(term: str, seed: int, size: float) -> None:
    """Friction by direction says there what viscous friction does; a spring, and friction along the
    travel, what a weight that turns does."""
    channels, parts = _one_way(seed)
    left = [part for name, part in parts.items() if name != term]
    answer = _explained(channels, np.asarray(sum(left)), [n for n in parts if n != term])
    (cause,) = answer.missing
    assert cause.term == term
    assert cause.confidence >= 0.8
    name = "coefficient" if term == "viscous" else "level"
    assert cause.parameters[name].value == pytest.approx(size, rel=0.2)


def test_effects_that_are_one_constant_one_way_take_nothing_back_from_each_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The second half of a motor's steps of speed, 92 % of them one way, beside its own full model:
    dry friction of 0.85 A, which the simulation has with 0.18 A, was said together with as much
    drift and as much friction by direction the other way, of a difference of 0.1 A."""
    shared("data", "real")
    monkeypatch.setenv("AUTODB_SHARED", str(shared("data").parent))
    case = made_case(RealSpec("null", "laas-speed", variant="second half"))
    answer = explained_real(case)
    assert own_within(case, answer)
    assert "coulomb" not in {one.term for one in answer.entries}
    assert max(one.size for one in answer.entries) < 0.6
    assert answer.before is not None
    assert answer.after is not None
    assert answer.after < 0.4 * answer.before
