"""Print what the main steps cost, and how they grow: medians of repeated runs in one process."""

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import csv as arrow_csv

from autodb import fitting, records
from autodb.demo import run as run_demo
from autodb.explain import explain
from autodb.records import Recording
from autodb.virtual.axis import air_moves

Array = NDArray[np.float64]

RUNS = 5


def median_s(function: Callable[[], object], runs: int = RUNS) -> float:
    """Return the median wall time of ``runs`` calls after one warm-up."""
    function()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def reading() -> None:
    """Time reading CSV recordings as a ratio to pyarrow's own reader."""
    with tempfile.TemporaryDirectory() as folder:
        for seconds in (600.0, 12_000.0):
            path = Path(folder) / f"{seconds:g}.csv"
            channels = _repeated(seconds)
            arrow_csv.write_csv(pa.table({k: np.round(v, 6) for k, v in channels.items()}), path)
            ours = median_s(lambda p=path: records.read(p))  # type: ignore[misc]
            peer = median_s(lambda p=path: arrow_csv.read_csv(p))  # type: ignore[misc]
            size = f"{len(channels['t'])} rows, {path.stat().st_size / 1e6:.0f} MB"
            print(f"read CSV, {size}: {1e3 * ours:.0f} ms, {ours / peer:.2f} x pyarrow's reader")


def _repeated(seconds: float, *, part_s: float = 600.0) -> dict[str, Array]:
    """Return air moves of a multiple of ``part_s``, the same over and over, in running time."""
    channels, _ = air_moves(1, seconds=part_s)
    times = round(seconds / part_s)
    long = {name: np.tile(values, times) for name, values in channels.items()}
    step_s = float(channels["t"][1] - channels["t"][0])
    long["t"] = np.asarray(np.arange(len(long["t"])) * step_s, dtype=np.float64)
    return long


def least_squares() -> None:
    """Time least squares as a ratio to NumPy's ``lstsq`` on the same columns."""
    rng = np.random.default_rng(0)
    design, values = rng.normal(size=(200_000, 10)), rng.normal(size=200_000)
    ours = median_s(lambda: fitting.least_squares(design, values))
    peer = median_s(lambda: np.linalg.lstsq(design, values, rcond=None))
    print(f"least squares, 200000 x 10: {1e3 * ours:.0f} ms, {ours / peer:.2f} x numpy's lstsq")


def explaining() -> None:
    """Time explain against doubled lengths."""
    before = 0.0
    for seconds in (60.0, 120.0, 240.0):
        channels, parts = air_moves(1, seconds=seconds)
        simulation = sum(part for name, part in parts.items() if name != "gravity")
        recording = Recording(path=Path("a"), channels=dict(channels))
        simulated = Recording(
            path=Path("b"), channels={"t": channels["t"], "x.current": np.asarray(simulation)}
        )
        took = median_s(lambda r=recording, s=simulated: explain(r, s), runs=3)  # type: ignore[misc]
        grown = f", {took / before:.2f} x the half" if before else ""
        print(f"explain, {len(recording)} samples: {took:.2f} s{grown}")
        before = took


def demo() -> None:
    """Time the whole demo."""
    with tempfile.TemporaryDirectory() as folder:
        took = median_s(lambda: run_demo(Path(folder) / "out", progress=lambda _: None), runs=3)
    print(f"demo: {took:.2f} s")


if __name__ == "__main__":
    reading()
    least_squares()
    explaining()
    demo()
