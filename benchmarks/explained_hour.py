"""What explaining an axis costs: seconds and peak memory from two minutes to an hour at 250 Hz.

`python -m benchmarks.explained_hour`: a ripple is left out; each length in a process of its own.
"""

import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

RATE_HZ = 250.0
LENGTHS = (30_000, 225_000, 450_000, 900_000)
CORRELATION = 0.9


def explained(rows: int) -> None:
    """Explain a recording of so many rows, and print what it took and what is named."""
    from autodb.explain import explain
    from autodb.records.tables import Recording

    t = np.arange(rows) / RATE_HZ
    v = 120.0 * np.sin(0.9 * t) * np.sin(0.031 * t)
    x = 250.0 + np.cumsum(v) / RATE_HZ
    a = np.gradient(v, 1.0 / RATE_HZ)
    simulated = 0.6 * np.tanh(v / 0.1) + 8e-4 * v + 6e-4 * a
    fresh = np.random.default_rng(0).normal(0.0, 0.02 * np.sqrt(1.0 - CORRELATION**2), rows)
    noise = np.asarray(lfilter([1.0], [1.0, -CORRELATION], fresh))
    sensed = simulated + 0.03 * np.sin(2.0 * np.pi * x / 20.0) + noise
    moves = {"t": t, "x.position": x, "x.velocity": v, "x.acceleration": a, "x.current": sensed}
    recording = Recording(path=Path("recording"), channels=moves)
    simulation = Recording(path=Path("simulation"), channels={"t": t, "x.current": simulated})
    begun = time.perf_counter()
    done = explain(recording, simulation)
    took = time.perf_counter() - begun
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    named = [cause.term for cause in done.explanation.channels["x.current"].missing]
    print(f"{rows} rows: {took:.1f} s, {peak:.2f} GiB, named {', '.join(named)}")


def main() -> None:
    """Explain every length in a process of its own."""
    for rows in LENGTHS:
        subprocess.run([sys.executable, "-m", __spec__.name, str(rows)], check=True)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        explained(int(sys.argv[1]))
    else:
        main()
