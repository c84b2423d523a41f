"""Terms that a simulation is said to include, read off it with their shape, and set wrong."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import Cause
from autodb.records.tables import Recording
from tests.helpers.trapezoids import COULOMB, INERTIA, NOISE, VISCOUS, WEIGHT, moves

Array = NDArray[np.float64]
OWN = ["coulomb", "viscous", "inertia", "gravity"]
DIP_A, DIP_MM_S, STIFFNESS, RISE, HARDER = 0.5, 20.0, 0.004, 0.003, (0.2, 0.001)


def _recording(*, noise: float = 0.0, dip_mm_s: float = DIP_MM_S, **share: float) -> Recording:
    """Return an axis with shares of the terms of that name."""
    channels = moves(2)
    x, v, a = (channels[f"x.{what}"] for what in ("position", "velocity", "acceleration"))
    sense = np.clip(v / 0.05, -1.0, 1.0)
    parts = {
        "stribeck": DIP_A * sense / np.exp((v / dip_mm_s) ** 2),
        "spring": STIFFNESS * (x - 100.0),
        "asymmetry": sense**2 * HARDER[0] + HARDER[1] * sense * v,
        "position_friction": RISE * sense * (x - x.mean()),
    }
    effort = COULOMB * sense + VISCOUS * v + INERTIA * a + WEIGHT
    effort = sum((share[name] * parts[name] for name in share), start=effort)
    effort = effort + noise * np.random.default_rng(7).normal(0, 1, len(v))
    return Recording(Path("moves.csv"), {**channels, "x.current": effort})


def _causes(recording: Recording, simulation: Recording, *terms: str) -> dict[str, Cause]:
    done = explain(recording, simulation, includes=[*OWN, *terms])
    return {cause.term: cause for cause in done.explanation.channels["x.current"].missing}


@pytest.mark.parametrize("term", ["stribeck", "asymmetry", "position_friction"])
def test_an_included_term_that_is_set_wrong_is_named_with_its_factor(term: str) -> None:
    found = _causes(_recording(noise=NOISE, **{term: 1.0}), _recording(**{term: 0.7}), term)
    cause = found.pop(term)
    assert cause.kind == "mistuned"
    assert cause.confidence >= 0.9
    assert cause.alternatives == ()
    assert_allclose(cause.parameters["factor"].value, 1.0 / 0.7, rtol=0.02)
    assert all(other.kind == "mistuned" for other in found.values())


def test_one_of_several_is_named() -> None:
    terms = ("stribeck", "spring", "asymmetry")
    right = dict.fromkeys(terms, 1.0)
    found = _causes(_recording(noise=NOISE, **right), _recording(**right | {"spring": 0.7}), *terms)
    spring = found["spring"]
    assert (spring.kind, spring.alternatives) == ("mistuned", ())
    assert spring.confidence >= 0.9
    assert_allclose(spring.parameters["factor"].value, 1.0 / 0.7, rtol=0.02)
    assert found.keys() <= {"spring", "gravity"}


def test_one_in_another_shape_is_named_with_what_is_added_to_it() -> None:
    found = _causes(
        _recording(noise=NOISE, stribeck=1.0), _recording(dip_mm_s=30.0, stribeck=1.0), "stribeck"
    )
    cause = found["stribeck"]
    assert cause.kind == "mistuned"
    assert_allclose(cause.parameters["speed"].value, DIP_MM_S, rtol=0.1)


def test_what_cannot_be_read_off_is_left_in_the_rest() -> None:
    """Laws that remember, are searched for, have no term, or take an axis that is not there."""
    terms = ("warmup", "external_load", "chatter", "cross_coupling")
    assert _causes(_recording(noise=NOISE), _recording(), *terms) == {}


def test_nothing_is_said_of_terms_that_are_right() -> None:
    terms = ("stribeck", "spring", "asymmetry")
    right = dict.fromkeys(terms, 1.0)
    assert _causes(_recording(noise=NOISE, **right), _recording(**right), *terms) == {}
