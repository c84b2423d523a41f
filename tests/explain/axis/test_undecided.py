"""A name that is no likelier than not is not given: the names that an effect may be are."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from autodb.explain import explain
from autodb.explain.answer import Explained
from autodb.explain.axis import causes
from autodb.explain.axis.reading import AxisReading
from autodb.explain.engine.standing import Standing
from autodb.records.tables import Recording

T_S = np.arange(6000) / 250.0
PLACE_MM = 80.0 * np.sin(2.0 * np.pi * 0.2 * T_S) + 30.0 * np.sin(2.0 * np.pi * 0.33 * T_S)
SPEED_MM_S = np.gradient(PLACE_MM, T_S)
SPRING_A_MM, DRIFT_A_S = 0.004, 0.01


def _explained() -> Explained:
    """Explain a spring and a sensor that drifts, which the simulation leaves out."""
    rng = np.random.default_rng(5)
    simulated = 0.5 * np.sign(SPEED_MM_S) + 0.002 * SPEED_MM_S
    effort = simulated + SPRING_A_MM * PLACE_MM + DRIFT_A_S * T_S + rng.normal(0.0, 0.03, len(T_S))
    channels = {"t": T_S, "x.position": PLACE_MM, "x.velocity": SPEED_MM_S, "x.current": effort}
    simulation = Recording(Path("s.csv"), {"t": T_S, "x.current": simulated})
    return explain(Recording(Path("r.csv"), channels), simulation, includes=["coulomb", "viscous"])


def _as_likely_as(monkeypatch: pytest.MonkeyPatch, confidence: float) -> None:
    """Have a spring be found so probably, beside friction that differs along the travel."""
    asked = causes.standing_of

    def stands(reading: AxisReading, number: int, **but: tuple[str, ...]) -> Standing:
        found = asked(reading, number, **but)
        if reading.inquiry.choices[number].candidate.term != "spring":
            return found
        return replace(found, confidence=confidence, near=("position_friction",))

    monkeypatch.setattr(causes, "standing_of", stands)


def test_a_name_that_is_likelier_than_not_is_given(monkeypatch: pytest.MonkeyPatch) -> None:
    _as_likely_as(monkeypatch, 0.51)
    found = {one.term: one for one in _explained().explanation.channels["x.current"].missing}
    assert found.keys() == {"spring", "sensor_drift"}
    assert found["spring"].alternatives == ("position_friction",)


def test_one_that_is_not_is_among_those_it_may_be_and_takes_its_own_part_of_the_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sure = _explained()
    _as_likely_as(monkeypatch, 0.49)
    done = _explained()
    found = {one.term: one for one in done.explanation.channels["x.current"].missing}
    assert found.keys() == {"unknown", "sensor_drift"}
    entry = found["unknown"]
    assert entry.alternatives == ("spring", "position_friction")
    assert entry.confidence == pytest.approx(0.51)
    size = entry.parameters["size"]
    assert size.value == pytest.approx(SPRING_A_MM * np.abs(PLACE_MM).max(), rel=0.05)
    assert f"up to {size.value:.3g} A. It may be any of" in entry.statement
    assert done.traces["x.current"].takes == sure.traces["x.current"].takes
