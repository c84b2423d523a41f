"""What scales others holds what these add: it is found with them, and never in their place."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.effects import acting_candidates
from autodb.explain.axis.signals import AxisSignals, axis_signals
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.evidence import Products
from autodb.explain.engine.search import CandidateSearch
from autodb.records.tables import Recording

Array = NDArray[np.float64]
HELD = frozenset({"gravity"})


def _candidate(key: str, holds: frozenset[str] = frozenset()) -> Candidate:
    return Candidate(key, key, (CandidateForm(np.ones),), ("t",), holds=holds)


def _search(weight: Array, scaled: Array, left: Array, holds: frozenset[str]) -> CandidateSearch:
    """Return the search for a weight and for what scales all, in rows (n,) of noise 1."""
    columns = np.column_stack([left, weight, scaled])
    widths = {("gravity", 0): 1, ("gain", 0): 1}
    products = Products(columns.T @ columns, own=0, widths=widths, rows=len(left), variance=1.0)
    return CandidateSearch(products, [_candidate("gravity"), _candidate("gain", holds)])


def _rows() -> tuple[Array, Array, Array]:
    """Return a weight, what the simulation has beside it, and noise, (n,) each."""
    rng = np.random.default_rng(5)
    t = np.linspace(0.0, 1.0, 2000)
    return np.cos(2.0 * t), np.sin(40.0 * t), rng.normal(size=len(t))


def test_a_scale_of_what_was_found_does_not_stand_in_for_it() -> None:
    """Its column is the weight and a little more, so that alone it explains most."""
    weight, simulated, noise = _rows()
    scaled = weight + 0.05 * simulated
    left = 2.0 * scaled + noise
    assert _search(weight, scaled, left, frozenset()).best().keys == ("gain",)
    assert _search(weight, scaled, left, HELD).best().keys == ("gravity",)


def test_what_a_scale_holds_is_found_beside_it() -> None:
    """Beside a scale that holds it a weight explains little: it counts as where that is not."""
    weight, simulated, noise = _rows()
    ramp = np.linspace(0.0, 1.0, len(weight))
    left = 2.0 * weight + 0.8 * ramp * (simulated + 2.0 * weight) + noise
    found = _search(weight, ramp * (simulated + 2.0 * weight), left, HELD).best()
    assert set(found.keys) == {"gravity", "gain"}
    assert not found.without("gravity")
    assert [c.candidate.key for c in found.without("gain")] == ["gravity"]


def test_a_rival_of_what_a_scale_holds_is_compared_without_the_scale() -> None:
    weight, simulated, noise = _rows()
    ramp = np.linspace(0.0, 1.0, len(weight))
    scaled = ramp * (simulated + 2.0 * weight)
    left = 2.0 * weight + 0.8 * scaled + noise
    columns = np.column_stack([left, weight, scaled, weight + 0.2 * simulated])
    widths = {("gravity", 0): 1, ("gain", 0): 1, ("spring", 0): 1}
    products = Products(columns.T @ columns, own=0, widths=widths, rows=len(left), variance=1.0)
    law, rival = _candidate("gravity"), _candidate("spring")
    search = CandidateSearch(products, [law, _candidate("gain", HELD), rival])
    both = search.settled((Choice(law, 0), Choice(search.candidates[1], 0)))
    alone, other = search.settled((Choice(law, 0),)), search.settled((Choice(rival, 0),))
    falls = search.rivals(both, "gravity")
    assert falls.keys() == {"spring"}
    assert falls["spring"] == alone.score - other.score


def test_a_candidate_holds_what_it_scales_and_was_found() -> None:
    """A gain holds all, warming friction alone; what a simulation has is always there."""
    t = np.arange(1000) / 100.0
    position, velocity = 40.0 * np.sin(t), 40.0 * np.cos(t)
    friction = 0.4 * np.tanh(velocity)
    channels = {"t": t, "x.position": position, "x.velocity": velocity, "x.current": friction}
    signals = axis_signals(Recording(path=Path("r.csv"), channels=channels), friction, "x.current")
    found = [("gravity", np.ones(len(t))), ("viscous", 0.01 * velocity)]

    def held(of: AxisSignals) -> dict[str, frozenset[str]]:
        return {c.term: c.holds for c in acting_candidates(of) if c.term in ("gain", "warmup")}

    nothing = np.zeros(len(t))
    assert held(signals) == {"gain": frozenset(), "warmup": frozenset()}
    beside = held(signals.beside(nothing, found))
    assert beside == {"gain": frozenset({"gravity", "viscous"}), "warmup": frozenset({"viscous"})}
    assert held(signals.completed(nothing, found)) == held(signals)
