"""Times of functions, and ratios of times that were taken in turn."""

import statistics
import time
from collections.abc import Callable

Work = Callable[[], object]
RUNS = 5


def median_s(function: Work, runs: int = RUNS) -> float:
    """Return the median wall time of ``runs`` calls after one warm-up."""
    function()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def in_turn_s(ours: Work, limit: Work, runs: int) -> tuple[float, float]:
    """Return the least processor time of each of two, called in turn, after one warm-up.

    The least of several is what neighbours on the machine disturb least.
    """
    limit(), ours()
    times = [(_busy_s(ours), _busy_s(limit)) for _ in range(runs)]
    return min(one for one, _ in times), min(one for _, one in times)


def _busy_s(function: Work) -> float:
    start = time.process_time()
    function()
    return time.process_time() - start
