"""What an hour of raw phase currents costs: three axes, three phases, 1 kHz, 32.4 million samples.

`python -m benchmarks.phase_currents`: seconds and peak memory of the demodulator on three phases
and on each phase alone, and, on the same array, of PyWavelets' db5 to level 6 and back and of
SciPy's `sosfiltfilt` (4th-order Butterworth); each in a process of its own, one thread.
"""

import resource
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RATE_HZ = 1000.0
HOUR = 3_600_000
AXES, PHASES = 3, 3


def currents() -> Array:
    """Return phase currents (3, 3, n), A: each axis sweeps its frequency; noise and offsets."""
    rng = np.random.default_rng(0)
    t = np.arange(HOUR) / RATE_HZ
    made = np.empty((AXES, PHASES, HOUR))
    for axis, highest_hz in enumerate((16.0, 16.0, 184.0)):
        theta = np.cumsum(highest_hz * np.sin(2.0 * np.pi * t / 600.0)) * 2.0 * np.pi / RATE_HZ
        for phase in range(PHASES):
            made[axis, phase] = np.sin(theta - 2.0 * np.pi * phase / 3.0)
            made[axis, phase] += 0.07 * rng.standard_normal(HOUR) + 0.05 * phase
    return made


def three_phases(made: Array) -> None:
    """Demodulate each axis from its three phases."""
    from autodb import signals

    for u, v, w in made:
        signals.three_phase_range(u, v, w, rate_hz=RATE_HZ)


def one_phase(made: Array) -> None:
    """Demodulate every phase alone."""
    from autodb import signals

    for phase in made.reshape(-1, HOUR):
        signals.one_phase_range(phase, rate_hz=RATE_HZ)


def wavelet(made: Array) -> None:
    """De-noise every phase by db5 to level 6 and back."""
    from autodb.signals.wavelets import denoised

    for phase in made.reshape(-1, HOUR):
        denoised(phase, level=6)


def butterworth(made: Array) -> None:
    """Filter every phase forwards and backwards."""
    from scipy import signal

    sos = signal.butter(4, 16.0, fs=RATE_HZ, output="sos")
    for phase in made.reshape(-1, HOUR):
        signal.sosfiltfilt(sos, phase)


STEPS: tuple[Callable[[Array], None], ...] = (three_phases, one_phase, wavelet, butterworth)


def main() -> None:
    """Run every step in its own process and print it as a ratio to the demodulator's."""
    first = 0.0
    for step in STEPS:
        command = [sys.executable, "-m", "benchmarks.phase_currents", step.__name__]
        said = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
        took, memory = float(said[0]), float(said[1])
        first = first or took
        name = step.__name__.replace("_", " ")
        print(f"{name}: {took:.1f} s, {memory:.2f} GiB, {took / first:.2f} x three phases")


if __name__ == "__main__":
    if len(sys.argv) == 1:
        main()
    else:
        chosen = next(step for step in STEPS if step.__name__ == sys.argv[1])
        array = currents()
        start = time.perf_counter()
        chosen(array)
        took = time.perf_counter() - start
        print(took, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20)
