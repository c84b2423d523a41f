"""A correction has the sizes of white rows where these and plain ones agree."""

from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from autodb.explain import explain
from autodb.proofs.machines.axis.axis import air_moves
from autodb.records.tables import Recording


def test_a_law_of_plain_rows_is_sized_in_white_ones() -> None:
    """Dry friction left out, the mass off by 3 %, under slow noise of a quarter of the friction:
    of the error 4.3 % is left where plain rows size it."""
    channels, parts = air_moves(1, rate_hz=62.5)
    rng, truth = np.random.default_rng(1), np.asarray(sum(parts.values()))
    slow = lfilter([1.0], [1.0, -0.97], rng.normal(0.0, 0.03, len(truth)))
    recorded = truth + slow + rng.normal(0.0, 0.01, len(truth))
    simulated = truth - parts["coulomb"] + 0.03 * parts["inertia"]
    done = explain(
        Recording(Path("a.csv"), {**channels, "x.current": recorded}),
        Recording(Path("b.csv"), {"t": channels["t"], "x.current": simulated}),
        includes=["stribeck", "viscous", "inertia", "gravity"],
    )
    off = done.traces["x.current"].corrected - truth
    assert np.sum(off**2) < 0.035**2 * np.sum((simulated - truth) ** 2)
    assert done.explanation.channels["x.current"].missing[0].term == "coulomb"
