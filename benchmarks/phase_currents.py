"""What an hour of raw phase currents costs: three axes, three phases, 1 kHz, 32.4 million samples.

`python -m benchmarks.phase_currents`: seconds and peak memory of the demodulator on three phases
and on each phase alone, and, on the same array, of PyWavelets' db5 to level 6 and back and of
SciPy's `sosfiltfilt` (4th-order Butterworth); each in a process of its own, one thread.
`python -m benchmarks.phase_currents errors` prints how far ranges are off at 40 frequencies: the
table in docs/method/signals.md.
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


GAINS = (1.05, 0.97, 1.0)
EQUAL = (1.0, 1.0, 1.0)
DISTURBED = (
    ("offsets", 0.0, EQUAL, 0.0),
    ("and a fifth harmonic of 2 %", 0.02, EQUAL, 0.0),
    ("and unequal gains", 0.0, GAINS, 0.0),
    ("and white noise at 20 dB", 0.0, EQUAL, 0.1),
    ("and all of these", 0.02, GAINS, 0.1),
)


def errors() -> None:
    """Print rms errors of one phase and three, worst and median over 0.1 to 200 Hz."""
    for name, harmonic, gains, noise in DISTURBED:
        found = np.array([_errors(f, harmonic, gains, noise) for f in np.geomspace(0.1, 200.0, 40)])
        for count, rms in zip(("one phase", "three phases"), 100.0 * found.T, strict=True):
            print(f"{name}, {count}: worst {np.max(rms):.2f} %, median {np.median(rms):.2f} %")


def _errors(
    hertz: float, harmonic: float, gains: tuple[float, float, float], noise: float
) -> tuple[float, float]:
    """Return the rms error of one phase and of three, away from the ends."""
    from autodb import signals
    from autodb.proofs.machines.lathe.phases import phases

    true_A = np.full(round(RATE_HZ * max(20.0, 9.0 / hertz)), 3.4)
    inside = slice(margin := round(RATE_HZ * max(2.0, 2.8 / hertz)), -margin)
    made = phases(
        np.random.default_rng(3), true_A, np.full(true_A.size, hertz), RATE_HZ, harmonic,
        gains=gains, noise_share=noise,
    )  # fmt: skip
    u, v, w = made.values()
    one = signals.one_phase_range(u, rate_hz=RATE_HZ).range_A[inside] / (3.4 * gains[0])
    three = signals.three_phase_range(u, v, w, rate_hz=RATE_HZ).range_A[inside]
    three = three / (3.4 * float(np.mean(gains)))
    return float(np.sqrt(np.mean((one - 1.0) ** 2))), float(np.sqrt(np.mean((three - 1.0) ** 2)))


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
    elif sys.argv[1] == errors.__name__:
        errors()
    else:
        chosen = next(step for step in STEPS if step.__name__ == sys.argv[1])
        array = currents()
        start = time.perf_counter()
        chosen(array)
        took = time.perf_counter() - start
        print(took, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20)
