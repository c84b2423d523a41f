"""Friction over speed that no term stands for is not named by one that fits it: it is unknown."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import ChannelAnswer
from autodb.explain.axis.friction import falls_with_speed, is_a_dip
from autodb.proofs.runs.explain.outside_run import run_outside
from autodb.records.tables import Recording
from autodb.terms.friction import stribeck
from tests.helpers.campaigns import first

Array = NDArray[np.float64]
T_S = np.arange(5000) / 100.0
SPEED_MM_S = (
    70.0 * np.sin(2.0 * np.pi * 0.11 * T_S)
    + 45.0 * np.sin(2.0 * np.pi * 0.047 * T_S + 1.0)
    + 40.0 * np.sin(2.0 * np.pi * 0.23 * T_S + 2.0)
)
"""Not of one frequency: a speed is then met at many places."""
PLACE_MM = 400.0 + np.cumsum(SPEED_MM_S) / 100.0
TOP_MM_S = float(np.abs(SPEED_MM_S).max())
DRY_A, WET_A_S_MM, NOISE_A = 0.8, 0.003, 0.03
SENSE = np.sign(SPEED_MM_S)
DRAG = 0.9 * SENSE * (np.abs(SPEED_MM_S) / TOP_MM_S) ** 2.2
FROM_A_SPEED_ON = 1.2 * SENSE * np.maximum(np.abs(SPEED_MM_S) / TOP_MM_S - 0.4, 0.0)
SATURATING = 0.25 * SENSE * np.tanh(np.abs(SPEED_MM_S) / 25.0)
DIP = 0.3 * stribeck(SENSE, SPEED_MM_S, speed_mm_s=6.0, exponent=1.0)


@dataclass(frozen=True)
class Explained:
    """An answer, and the rms by which the simulation and its correction are off the truth, A."""

    answer: ChannelAnswer
    before_A: float
    after_A: float


def _explained(missing: Array) -> Explained:
    simulated = DRY_A * SENSE + WET_A_S_MM * SPEED_MM_S
    noise = np.random.default_rng(7).normal(0.0, NOISE_A, len(T_S))
    moved = {"t": T_S, "x.position": PLACE_MM, "x.velocity": SPEED_MM_S}
    recording = Recording(
        Path("recording.csv"), {**moved, "x.current": simulated + missing + noise}
    )
    simulation = Recording(Path("simulation.csv"), {"t": T_S, "x.current": simulated})
    done = explain(recording, simulation, includes=["coulomb", "viscous"])
    off = done.traces["x.current"].corrected - simulated - missing
    return Explained(
        done.explanation.channels["x.current"],
        float(np.sqrt(np.mean(missing**2))),
        float(np.sqrt(np.mean(off**2))),
    )


@pytest.mark.parametrize("missing", first(1, [FROM_A_SPEED_ON, DRAG, SATURATING]))
def test_what_no_term_stands_for_is_unknown_and_own_terms_stay_right(missing: Array) -> None:
    """Dry, viscous and a dip of friction, in other sizes, would give each of them nearly."""
    found = _explained(missing)
    sure = [c for c in found.answer.missing if c.confidence >= 0.5]
    assert [(c.term, c.kind) for c in sure] == [("unknown", "missing")]
    assert sure[0].variables == ("x.velocity",)
    assert found.after_A < 0.15 * found.before_A


def test_what_one_curve_gives_several_laws_do_not_make_up() -> None:
    """A drag, case 1001 of development, that a dip, compliance, drift and gain gave together."""
    (answered,) = run_outside(1001)
    assert (answered.kind, answered.outside) == ("drag", True)
    assert {entry.term for entry in answered.entries} == {"unknown"}


def test_a_dip_is_named_and_its_correction_is_what_the_held_out_error_says() -> None:
    """A dip beside dry friction is nearly the same in other sizes of both."""
    found = _explained(DIP)
    (dip,) = [c for c in found.answer.missing if c.term == "stribeck"]
    assert dip.confidence >= 0.9
    assert dip.parameters["size"].value == pytest.approx(np.abs(DIP).max(), rel=0.15)
    assert found.after_A < 0.2 * found.before_A
    assert found.answer.fit.heldout_after == pytest.approx(NOISE_A, rel=0.1)


@pytest.mark.parametrize(("level_A", "falls"), [(0.3, True), (0.02, False)])
def test_a_dip_is_one_where_all_friction_falls(level_A: float, falls: bool) -> None:
    speed = np.linspace(0.5, TOP_MM_S, 400)
    there_and_back = np.concatenate([speed, -speed])
    sense = np.sign(there_and_back)
    dip = level_A * stribeck(sense, there_and_back, speed_mm_s=10.0, exponent=1.0)
    beside = {"coulomb": DRY_A * sense, "viscous": WET_A_S_MM * there_and_back}
    assert falls_with_speed(dip, beside) is falls


@pytest.mark.parametrize(("speed_mm_s", "is_one"), [(5.0, True), (60.0, False)])
def test_a_dip_that_no_drag_gives_is_one_where_friction_only_bends(
    speed_mm_s: float, is_one: bool
) -> None:
    """Beside much viscous friction all of the friction rises with a dip in it, too."""
    speed = np.linspace(0.5, TOP_MM_S, 400)
    there_and_back = np.concatenate([speed, -speed])
    sense = np.sign(there_and_back)
    dip = 0.1 * stribeck(sense, there_and_back, speed_mm_s=speed_mm_s, exponent=1.0)
    beside = {"coulomb": DRY_A * sense, "viscous": 0.1 * there_and_back}
    assert not falls_with_speed(dip, beside)
    assert is_a_dip(dip, beside) is is_one
