"""A motor's cogging has many orders a turn: it is one cause, with a period and a height of each."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import ChannelAnswer
from autodb.records.tables import Recording

Array = NDArray[np.float64]
RATE_HZ, TURN_MM = 100.0, 10.0
T_S = np.arange(3200) / RATE_HZ
PLACE_MM = 0.3 * T_S + 0.4 * np.sin(0.9 * T_S)
"""Creeps on through a turn, unevenly and for some time backwards."""
ORDERS = {7: 0.8, 12: 0.3, 14: 0.4, 28: 0.25, 36: 0.15}
"""Heights by order a turn, A: seven pairs of poles and twelve slots."""
FRICTION_A, NOISE_A = 0.5, 0.03


def _answer(missing: Array) -> ChannelAnswer:
    velocity = np.gradient(PLACE_MM, T_S)
    simulated = FRICTION_A * np.sign(velocity)
    noise = np.random.default_rng(3).normal(0.0, NOISE_A, len(T_S))
    moved = {"t": T_S, "x.position": PLACE_MM}
    recording = Recording(
        Path("recording.csv"), {**moved, "x.current": simulated + missing + noise}
    )
    simulation = Recording(Path("simulation.csv"), {"t": T_S, "x.current": simulated})
    done = explain(recording, simulation, includes=["coulomb"])
    return done.explanation.channels["x.current"]


def test_all_orders_are_one_cogging() -> None:
    phase = np.random.default_rng(4).uniform(0.0, 2.0 * np.pi, len(ORDERS))
    missing = sum(
        height * np.sin(2.0 * np.pi * order * PLACE_MM / TURN_MM + shift)
        for (order, height), shift in zip(ORDERS.items(), phase, strict=True)
    )
    answer = _answer(np.asarray(missing))
    (cogging,) = [c for c in answer.missing if c.term == "cogging"]
    assert cogging.confidence >= 0.8
    values = cogging.parameters
    assert values["size"].value == pytest.approx(np.abs(missing).max(), rel=0.1)
    heights = {1: values["amplitude"].value}
    periods = {1: values["period"].value}
    for number in range(2, len(ORDERS) + 1):
        heights[number] = values[f"amplitude_{number}"].value
        periods[number] = values[f"period_{number}"].value
    found = {round(TURN_MM / periods[n]): heights[n] for n in heights}
    assert found == pytest.approx(ORDERS, rel=0.1)
    assert answer.fit.heldout_after < 0.1 * answer.fit.heldout_before


def test_a_slow_course_over_the_travel_is_no_row_of_ripples() -> None:
    """Half a wave more over the travel than at its ends, and a step of a quarter of that."""
    along = (PLACE_MM - PLACE_MM.min()) / np.ptp(PLACE_MM)
    answer = _answer(0.8 * np.sin(np.pi * along) ** 2 + 0.2 * (along > 0.6))
    assert not any("amplitude_2" in cause.parameters for cause in answer.missing)
