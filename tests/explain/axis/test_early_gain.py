"""What a simulation lacks has its size in most rows, however early a gain settles."""

from pathlib import Path

import numpy as np
import pytest

from autodb.explain import explain
from autodb.records.tables import Recording

RATE_HZ, SECONDS = 100.0, 60.0
VISCOUS_A_S_MM, MASS_A_S2_MM, DRY_A, NOISE_A = 0.01, 0.002, 0.6, 0.03
AT_FIRST, SETTLED_S = 0.6, 10.0
"""Share of the effort that is recorded at first, and when all of it is."""


def test_friction_beside_a_gain_that_settles_early() -> None:
    rng = np.random.default_rng(20261129)
    t = np.arange(0.0, SECONDS, 1.0 / RATE_HZ)
    waves = [(20.0, 0.23), (9.0, 0.41), (4.0, 0.77)]
    place = np.sum([size * np.sin(2.0 * np.pi * hz * t) for size, hz in waves], axis=0)
    speed = np.gradient(place, t)
    simulated = VISCOUS_A_S_MM * speed + MASS_A_S2_MM * np.gradient(speed, t)
    recorded_share = AT_FIRST + (1.0 - AT_FIRST) * np.clip(t / SETTLED_S, 0.0, 1.0)
    effort = recorded_share * (simulated + DRY_A * np.tanh(speed / 0.5))
    measured = {"t": t, "x.position": place, "x.velocity": speed}
    measured["x.current"] = effort + rng.normal(0.0, NOISE_A, len(t))
    answer = explain(
        Recording(Path("a.csv"), measured),
        Recording(Path("b.csv"), {"t": t, "x.current": simulated}),
        includes=["viscous", "inertia"],
    )
    found = {cause.term: cause for cause in answer.explanation.channels["x.current"].missing}
    assert found["gain"].kind == "missing"
    assert found["coulomb"].parameters["size"].value == pytest.approx(DRY_A, rel=0.05)
