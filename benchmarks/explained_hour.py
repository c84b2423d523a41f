"""What explaining an axis costs: seconds, and memory, from two minutes at 250 Hz to 8 h at 1 kHz.

`python -m benchmarks.explained_hour`: a ripple is left out, position and current are recorded; each
length in a process of its own, whose memory holds what was recorded too.
"""

import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

LENGTHS = ((30_000, 250), (225_000, 250), (900_000, 250), (3_600_000, 1000), (28_800_000, 1000))
"""Rows, and rows a second."""
CORRELATION = 0.9


def explained(rows: int, rate_hz: float = 250.0) -> None:
    """Explain a recording of so many rows, and print what it took and what is named."""
    from autodb.explain import explain
    from autodb.records.tables import Recording

    t = np.arange(rows) / rate_hz
    v = 120.0 * np.sin(0.9 * t) * np.sin(0.031 * t)
    x = 250.0 + np.cumsum(v) / rate_hz
    simulated = 0.6 * np.tanh(v / 0.1) + 8e-4 * v + 6e-4 * np.gradient(v, 1.0 / rate_hz)
    del v
    fresh = np.random.default_rng(0).normal(0.0, 0.02 * np.sqrt(1.0 - CORRELATION**2), rows)
    sensed = np.asarray(lfilter([1.0], [1.0, -CORRELATION], fresh))
    sensed += simulated + 0.03 * np.sin(2.0 * np.pi * x / 20.0)
    del fresh
    moves = {"t": t, "x.position": x, "x.current": sensed}
    recording = Recording(path=Path("recording"), channels=moves)
    simulation = Recording(path=Path("simulation"), channels={"t": t, "x.current": simulated})
    begun, worked = time.perf_counter(), time.process_time()
    done = explain(recording, simulation)
    took, worked = time.perf_counter() - begun, time.process_time() - worked
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    named = [cause.term for cause in done.explanation.channels["x.current"].missing]
    print(
        f"{rows} rows at {rate_hz:g} Hz: {took:.1f} s, {worked:.1f} s of a processor, "
        f"{peak:.2f} GiB, named {', '.join(named)}"
    )


def main() -> None:
    """Explain every length in a process of its own."""
    for rows, rate_hz in LENGTHS:
        arguments = [str(rows), str(rate_hz)]
        subprocess.run([sys.executable, "-m", __spec__.name, *arguments], check=True)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        explained(int(sys.argv[1]), float(sys.argv[2]))
    else:
        main()
