"""Of two effects that act on others, and that plain rows do not tell apart, white rows decide."""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Candidate, CandidateForm
from autodb.explain.engine.noise import Whitener
from autodb.explain.engine.plain.founded import founded

Array = NDArray[np.float64]
ROWS = 6000
T_S = np.arange(ROWS) / 250.0


class _Two:
    """A warm-up and a gain: neither stands beside the other."""

    def __init__(self, warming: Array, gain: Array) -> None:
        columns = {"warmup": warming, "gain": gain}
        self.candidates = [
            Candidate(
                term,
                term,
                (CandidateForm(lambda column=column: column, names=("share",)),),
                excludes=frozenset(columns.keys() - {term}),
            )
            for term, column in columns.items()
        ]

    def beside(self, retuned: Array, parts: list[tuple[str, Array]]) -> list[Candidate]:
        """Return both."""
        del retuned, parts
        return self.candidates

    def scanned(self, columns: Array, whitener: Whitener, number: int) -> list[Candidate]:
        """Return none."""
        del columns, whitener, number
        return []


def test_white_rows_tell_a_warm_up_from_a_gain_that_follows_slow_noise() -> None:
    """Both fall alike over the recording. The warm-up alone turns with the friction, at 12 Hz; a
    gain that happens to go with the slow noise leaves less of plain rows."""
    rng = np.random.default_rng(8)
    slow = np.asarray(lfilter([1.0], [1.0, -0.995], rng.normal(0.0, 0.02, ROWS)))
    fast = 0.08 * np.sign(np.sin(2.0 * np.pi * 12.0 * T_S))
    course = 0.5 * np.sin(2.0 * np.pi * 0.3 * T_S)
    warming, gain = course + fast, course + 0.1 * slow
    bench = WhiteRows(warming + slow, {}, 1, gap=25)
    left = [float(np.sum((bench.difference - one) ** 2)) for one in (warming, gain)]
    assert left[1] < left[0]
    field = _Two(warming, gain)
    (law,) = founded(bench, [], field)
    assert law.candidate.term == "warmup"
