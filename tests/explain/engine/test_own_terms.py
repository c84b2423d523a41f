"""What is said of a simulation's own terms that may be off, alone and together."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from autodb.explain.answer import Cause, ChannelAnswer, FitQuality, IntervalValue, Where
from autodb.explain.axis.read_off import own_terms_of
from autodb.explain.engine.candidates import UNKNOWN
from autodb.explain.engine.confidence import Mistuned
from autodb.explain.engine.entries import own_term_entries, told_entries
from autodb.explain.engine.standing import standing
from autodb.records.tables import Recording
from autodb.reports.explanation import headline
from autodb.terms.friction import direction

CLEAR = Mistuned(30.0, standing({}, nothing=40.0), ())
OPEN = Mistuned(30.0, standing({"sensor_drift": 0.0, UNKNOWN: 0.0}, nothing=40.0), ("t",))
NONE = Mistuned(-5.0, standing({}, nothing=0.0), ())


def _cause(term: str, size: float) -> Cause:
    value = IntervalValue(value=size, low=0.5 * size, high=1.5 * size, unit="A")
    return Cause(
        term=term, kind="mistuned", confidence=0.9, statement="It is off.",
        parameters={"size": value},
    )  # fmt: skip


CAUSES = {"viscous": _cause("viscous", 0.2), "coulomb": _cause("coulomb", 0.3)}


@pytest.mark.parametrize(
    ("off", "together", "said"),
    [
        ({"viscous": CLEAR, "coulomb": NONE}, CLEAR, [("viscous", "mistuned", ())]),
        (
            {"viscous": OPEN, "coulomb": OPEN}, CLEAR,
            [(UNKNOWN, "mistuned", ("coulomb", "viscous"))],
        ),
        (
            {"viscous": OPEN, "coulomb": OPEN}, OPEN,
            [(UNKNOWN, "missing", ("coulomb", "viscous", "sensor_drift"))],
        ),
        (
            {"viscous": OPEN, "coulomb": NONE}, CLEAR,
            [(UNKNOWN, "missing", ("viscous", "sensor_drift"))],
        ),
        ({"viscous": NONE, "coulomb": NONE}, CLEAR, []),
    ],
    ids=["one is", "one of two is", "two may be", "one may be", "none is"],
)  # fmt: skip
def test_own_terms(
    off: dict[str, Mistuned], together: Mistuned, said: list[tuple[str, str, tuple[str, ...]]]
) -> None:
    entries = own_term_entries(off, CAUSES, beside=[], jointly=lambda _: together)
    assert [(one.term, one.kind, one.alternatives) for one in entries] == said
    if entries:
        assert entries[0].confidence > 0.5


@pytest.mark.parametrize(
    ("names", "said"),
    [(["viscous"], "viscous"), (["viscous", "coulomb"], UNKNOWN)],
    ids=["one", "one of two"],
)
def test_an_own_term_that_is_likelier_than_each_other_account_is_called(
    names: list[str], said: str
) -> None:
    """Several rarer effects would do as well: all together they are likelier than its size."""
    others = dict.fromkeys(("gain", "stribeck", "warmup"), 5.0)
    likely = Mistuned(30.0, standing(others, nothing=40.0), ())
    assert likely.standing.confidence < 0.5
    off = {name: likely if name in names else NONE for name in CAUSES}
    (entry,) = own_term_entries(off, CAUSES, beside=[], jointly=lambda _: OPEN)
    assert (entry.term, entry.kind) == (said, "mistuned")
    assert entry.confidence == likely.standing.confidence
    assert set(others) < {*entry.alternatives} | {said}
    nearer = Mistuned(30.0, standing({**others, "gain": 0.0}, nothing=40.0), ())
    off = {name: nearer if name in names else NONE for name in CAUSES}
    (entry,) = own_term_entries(off, CAUSES, beside=[], jointly=lambda _: OPEN)
    assert (entry.term, entry.kind) == (UNKNOWN, "missing")


@pytest.mark.parametrize(("worth", "said"), [(1.8, False), (7.9, False), (8.1, True)])
def test_what_is_rather_something_left_out_needs_the_evidence_of_an_effect(
    worth: float, said: bool
) -> None:
    """Noise alone makes a change worth so little, and something else as good an account."""
    rather = Mistuned(worth, standing({"gain": 0.0}, nothing=worth), ())
    likelier = Mistuned(worth, standing({"gain": 1.0}, nothing=worth), ())
    for one, expected in ((rather, said), (likelier, True)):
        entries = own_term_entries(
            {"viscous": one, "coulomb": NONE}, CAUSES, beside=[], jointly=lambda _: CLEAR
        )
        assert bool(entries) is expected


def test_beside_a_name_what_may_be_is_not_said() -> None:
    off = {"viscous": OPEN, "coulomb": OPEN}
    assert (
        own_term_entries(off, CAUSES, beside=[_cause("backlash", 1.0)], jointly=lambda _: CLEAR)
        == []
    )


def test_the_headline_has_all_of_which_one_is_off() -> None:
    (entry,) = own_term_entries(
        {"viscous": OPEN, "coulomb": OPEN}, CAUSES, beside=[], jointly=lambda _: CLEAR
    )
    fit = FitQuality(
        rms_before=1.0, rms_after=0.5, heldout_before=1.0, heldout_after=0.5, noise_floor=0.5
    )
    answer = ChannelAnswer(unit="A", mismatch=True, where=Where(), missing=(entry,), fit=fit)
    said = "dry friction or friction that grows with speed is set wrong"
    assert f": {said} (" in headline(answer)


@pytest.mark.parametrize("seed", range(20))
def test_where_a_simulation_has_no_friction_no_rounding_chooses_how_it_turns(seed: int) -> None:
    t = np.arange(4000) / 250.0
    velocity = 80.0 * np.sin(1.7 * t) * np.sin(0.31 * t)
    inputs = {
        "position": np.cumsum(velocity) / 250.0,
        "velocity": velocity, "acceleration": np.gradient(velocity, t),
        "direction": direction(velocity),
    }  # fmt: skip
    simulation = 0.2 * velocity + 0.1 * inputs["acceleration"] - 3.0
    rounded = simulation * (1.0 + 1e-15 * np.random.default_rng(seed).standard_normal(4000))
    channels = {"t": t, "x.position": inputs["position"], "x.velocity": velocity}
    recording = Recording(path=Path("r.csv"), channels=channels)
    read = own_terms_of(rounded, inputs, recording, "x", np.zeros_like(t))
    assert_array_equal(read.sense, inputs["direction"])
    assert set(read.had) == {"viscous", "inertia", "gravity"}
    assert read.share > 1.0 - 1e-9


def test_another_size_of_what_the_simulation_has_is_said_where_it_is_likelier_than_not() -> None:
    """A ripple that the simulation has by name, found as an effect: at 19 % it may be any of five
    things, and is said beside nothing else only."""
    faint = _cause("cogging", 0.8).model_copy(update={"confidence": 0.19})
    missing = faint.model_copy(update={"term": "asymmetry", "kind": "missing"})
    clear = _cause("coulomb", 0.3)
    assert told_entries([faint, missing, clear]) == [missing, clear]
    assert told_entries([faint]) == [faint]
