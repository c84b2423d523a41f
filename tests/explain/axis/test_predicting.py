"""What a correction takes has to predict rows that its fit did not see."""

from pathlib import Path

import numpy as np
import pytest

from autodb.explain import explain
from autodb.explain.engine.fit import fold_of_block
from autodb.proofs.cases.plan import FIXED, PlannedCase, draw_concealed
from autodb.proofs.cases.real.real_case import RealSpec
from autodb.proofs.cases.real.real_cases import made_case
from autodb.proofs.runs.explain.left_out import tables
from autodb.proofs.runs.real.real_answers import explained_real
from autodb.records.tables import Recording
from tests.conftest import shared


def test_what_a_law_gets_wrong_in_shape_goes_where_it_predicts_worse(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A dip of 42 N in the friction of a real axis: white rows show a deviation of its shape whose
    error is 9.2 N on rows left out, without the deviation 3.3 N, and of the simulation 8.4 N."""
    shared("data", "emps", "DATA_EMPS.mat")
    monkeypatch.setenv("AUTODB_SHARED", str(shared("data").parent))
    case = made_case(RealSpec("injected", "emps", "stribeck", "strong", "mistuned"))
    answer = explained_real(case)
    assert answer.before is not None
    assert answer.after is not None
    assert answer.after < 0.5 * answer.before
    (dip,) = [one for one in answer.entries if one.term == "stribeck"]
    assert dip.confidence > 0.9
    assert dip.size == pytest.approx(case.true_size, rel=0.25)


def test_own_terms_are_retuned_where_rows_left_out_ask_for_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A law's coefficient is that beside free own terms: a fit has taken up a third of the warm-up,
    which slow noise hides."""
    shared("data", "emps", "DATA_EMPS.mat")
    monkeypatch.setenv("AUTODB_SHARED", str(shared("data").parent))
    case = made_case(RealSpec("injected", "emps", "warmup", "strong", "refitted"))
    answer = explained_real(case)
    assert answer.after is not None
    assert answer.after < 0.75 * case.rms_full
    (warming,) = [one for one in answer.entries if one.term == "warmup"]
    assert warming.size == pytest.approx(case.true_size, rel=0.1)


def test_what_an_own_term_would_have_to_double_for_is_counted_to_the_effect(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Friction that differs by direction is a constant but for the turns: rows hardly tell it from
    the simulation's own constant load, which would have to grow to six times its size."""
    shared("data", "odrive_cogging")
    monkeypatch.setenv("AUTODB_SHARED", str(shared("data").parent))
    case = made_case(RealSpec("injected", "odrive-beside-fed", "asymmetry", "weak", "exact"))
    (uneven,) = [one for one in explained_real(case).entries if one.term == "asymmetry"]
    assert uneven.size == pytest.approx(case.true_size, rel=0.1)


def test_a_correction_harms_no_rows_that_it_was_fitted_to(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """White rows of a trembling axis gave a mass by which the rows were missed by 0.25 A, 0.21 A
    without it, while one fitted to plain rows left out missed them by 0.14 A."""
    shared("data", "odrive_cogging")
    monkeypatch.setenv("AUTODB_SHARED", str(shared("data").parent))
    case = made_case(RealSpec("null", "odrive-beside", variant="exact"))
    recording = Recording(Path("a.csv"), case.channels)
    simulation = Recording(Path("b.csv"), case.simulation)
    answer = explain(recording, simulation, includes=list(case.includes)).explanation
    fit = answer.channels[case.channel].fit
    assert fit.rms_after < fit.rms_before


def test_own_terms_that_one_turn_alone_tells_apart_undo_no_answer() -> None:
    """A simulation's friction, read off it, is the simulation but for its only turn: without that
    stretch both are one column, and their free fit to the others was 130 times off there, so that
    nothing was said of a mass that is 93 % of the squares."""
    rng, t = np.random.default_rng(1), np.arange(0.0, 1500.0, 0.4)
    sense, phase = np.where(t < 750.0, 1.0, -1.0), 2.0 * np.pi * 0.1 * t
    way = 0.4 * np.cumsum(0.012 * sense + 0.006 * np.sin(phase))
    mass, friction = 26.0 * 0.006 * 2.0 * np.pi * 0.1 * np.cos(phase), 0.05 * sense
    channels = {
        "t": t,
        "x.position": way + rng.normal(0.0, 2e-4, len(t)),
        "x.current": friction + mass + rng.normal(0.0, 0.01, len(t)),
    }
    recording = Recording(Path("recording.csv"), channels)
    simulation = Recording(Path("simulation.csv"), {"t": t, "x.current": friction})
    (answer,) = explain(recording, simulation, includes=["coulomb"]).explanation.channels.values()
    assert answer.fit.heldout_after < 0.3 * answer.fit.heldout_before
    assert answer.missing[0].term == "inertia"
    assert answer.missing[0].confidence >= 0.9


def test_of_laws_that_are_one_column_the_usual_one_is_likelier() -> None:
    """Moves one way only: friction and a load are one constant, and every axis has friction."""
    rng, t = np.random.default_rng(7), np.arange(0.0, 20.0, 0.01)
    speed = 10.0 + 8.0 * np.sin(2.0 * np.pi * 0.2 * t)
    simulated = 0.02 * speed
    channels = {
        "t": t,
        "x.position": 0.01 * np.cumsum(speed),
        "x.current": simulated + 1.5 + rng.normal(0.0, 0.05, len(t)),
    }
    recording = Recording(Path("recording.csv"), channels)
    simulation = Recording(Path("simulation.csv"), {"t": t, "x.current": simulated})
    (answer,) = explain(recording, simulation, includes=["viscous"]).explanation.channels.values()
    (cause,) = answer.missing
    assert cause.term == "coulomb"
    assert cause.confidence == pytest.approx(2.0 / 3.0, abs=0.02)  # of odds 4 : 1 : 1
    assert set(cause.alternatives) == {"asymmetry", "gravity"}


@pytest.mark.parametrize(("left_out", "size"), [("coulomb", 0.35), ("viscous", 2.16)])
def test_a_move_that_repeats_does_not_hide_its_reversals_from_every_fit(
    left_out: str, size: float
) -> None:
    """A slide driven by a sine of 0.5 Hz for 8 s, at 1 kHz, its place in steps of an encoder: dealt
    in turn, the blocks left out came back at the reversals of every period, and the friction that
    acts there had no rows to be fitted to; the answer was thrown away."""
    t = np.arange(0.0, 8.0, 0.001)
    speed = 180.0 * np.sin(2.0 * np.pi * 0.5 * t)
    place = np.round(np.cumsum(speed) * 0.001 / 0.00466) * 0.00466
    turned = np.where(np.diff(np.sign(speed), prepend=0.0) != 0.0, np.arange(len(t)), 0)
    way = np.abs(place - place[np.maximum.accumulate(turned)])
    rubs = 0.35 * np.sign(speed) * (1.0 - np.exp(-way / 2.0))
    effort = 0.012 * speed + rubs + 0.001 * np.gradient(speed, t)
    noisy = effort + np.random.default_rng(29).normal(0.0, 0.02, len(t))
    measured = Recording(Path("a.csv"), {"t": t, "x.position": place, "x.current": noisy})
    mass, sharp = 0.001 * np.gradient(speed, t), 0.3 * np.sign(speed)
    simulated = {"coulomb": mass + 0.012 * speed, "viscous": mass + sharp}
    known = Recording(Path("b.csv"), {"t": t, "x.current": simulated[left_out]})
    others = [name for name in ("coulomb", "viscous", "inertia") if name != left_out]
    (answer,) = explain(measured, known, includes=others).explanation.channels.values()
    assert answer.fit.heldout_after < 0.1 * answer.fit.heldout_before
    assert answer.missing[0].term == left_out
    assert answer.missing[0].confidence >= 0.9
    assert answer.missing[0].parameters["size"].value == pytest.approx(size, rel=0.15)


def test_the_blocks_of_a_fold_are_at_every_phase() -> None:
    dealt = fold_of_block(40, 5)
    assert np.array_equal(np.bincount(dealt), [8] * 5)
    for every in range(2, 13):  # blocks that a period of the motion has
        for fold in range(5):
            phases = np.flatnonzero(dealt == fold) % every
            assert len(set(phases)) >= min(every, 3), (every, fold)
    assert np.array_equal(np.sort(fold_of_block(8, 8)), np.arange(8))


def test_an_effect_is_compared_with_none_beside_the_same_own_terms() -> None:
    """A play that is twenty times as clear as noise: without it one own term more was re-tuned,
    which follows slow noise, and rows left out seemed to be predicted better."""
    case = draw_concealed(204, family=FIXED, asked=PlannedCase(("backlash",), 20.0))
    recording, simulation = tables(case)
    answers = explain(recording, simulation, includes=list(case.includes)).explanation.channels
    (answer,) = answers.values()
    assert [cause.term for cause in answer.missing] == ["backlash"]
    assert answer.missing[0].confidence > 0.8
