"""A law that is too faint for plain rows is left to white ones, whatever stands in for it."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Candidate, CandidateForm
from autodb.explain.engine.plain.growing import GAIN, completed
from autodb.explain.engine.plain.rows import PlainRows

Array = NDArray[np.float64]
ROWS = 8000
RUN = np.linspace(0.0, 1.0, ROWS)


def _candidate(term: str, column: Array, *, static: bool = False) -> Candidate:
    form = CandidateForm(lambda: column, names=("size",))
    return Candidate(term, term, (form,), static=static)


def _joined(difference: Array, drift: Array, gain: Array) -> set[str]:
    candidates = [
        _candidate("sensor_drift", drift, static=True),
        _candidate("gain", gain),
    ]
    rows = PlainRows(WhiteRows(difference, {}, 1, gap=10), candidates)
    return {choice.candidate.term for choice in completed(rows, [])}


def test_a_gain_takes_no_place_of_a_drift_that_is_nearly_clear() -> None:
    """A drift that lowers the error by less than GAIN, and a gain that follows it and some noise
    by a little more: which of them it is plain rows do not say."""
    noise = np.random.default_rng(3).normal(0.0, 1.0, ROWS)
    drift, luck = RUN - 0.5, np.sin(40.0 * np.pi * RUN)
    difference = 0.95 * drift + 0.2 * luck + noise
    assert _joined(difference, drift, 0.95 * drift + 0.2 * luck) == set()
    assert 1.0 - 1.0 / np.sqrt(1.0 + 0.95**2 / 12.0) < GAIN
    assert _joined(difference + 0.3 * luck, drift, 0.95 * drift + 0.5 * luck) == {"gain"}
