"""Reference tables whose dynamometer rings: P4's kind, with natural frequencies within its band.

P4 reads at 5000 Hz up to 2000 Hz (section 3) and leaves the dynamometer's dynamics out. Here what
it reads of a force in each component is

    H(s) = (1 − c) G_1(s) + c G_2(s),   G_k(s) = ω_k² / (s² + 2 ζ_k ω_k s + ω_k²):

work on it that a first mode carries, and a second one beyond it. Frequencies, damping and shares
are *chosen*: no published figure is of a dynamometer with this work on it. Forces are made at
FINER times P4's rate; what reads them passes P4's low-pass.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from autodb.proofs.machines.mill.reference_table import (
    AFTER_S,
    BEFORE_S,
    BETWEEN_S,
    FORCE_HZ,
    PASS_S,
    PASSES_MM,
    SETUPS_DEG,
    STAYS,
    WORK_KG,
    Log,
    RecordedTable,
    TrueTable,
    heat,
    machine_to_table,
    noisy,
    passes,
    truth,
)

Array = NDArray[np.float64]

FINER = 8  # chosen
LOWPASS_HZ = 2000.0  # P4 section 3
FIRST_HZ = ((600.0, 900.0), (600.0, 900.0), (800.0, 1200.0))  # of x, y, z; chosen
SECOND = (1.9, 2.5)  # of the first's frequency; chosen
DAMPING = (0.02, 0.05)  # of both; chosen
SHARE = (0.04, 0.12)  # of the second mode; chosen
TAPS, TAPS_S = 4, 0.6  # along each component, and between them; chosen
HAMMER_N, HAMMER_S = (100.0, 300.0), (0.0005, 0.001)  # a half sine's height and length; chosen
ASIDE = 0.1  # of a tap in the other components, at most; chosen


@dataclass(frozen=True)
class Ringing:
    """Modes of a dynamometer's components: frequencies Hz and damping (2, 3), shares of the second
    (3,).
    """

    natural_hz: Array
    damping: Array
    second: Array

    def read(self, force_N: Array) -> Array:
        """Return what it reads (3, n) of a force (3, n) in its frame, at FINER times FORCE_HZ."""
        found = np.zeros_like(force_N)
        for k in range(3):
            for mode, share in enumerate((1.0 - self.second[k], self.second[k])):
                omega = 2.0 * np.pi * self.natural_hz[mode, k]
                whole = ([omega**2], [1.0, 2.0 * self.damping[mode, k] * omega, omega**2])
                b, a, _ = signal.cont2discrete(whole, 1.0 / (FINER * FORCE_HZ), method="foh")
                found[k] += share * signal.lfilter(b.ravel(), a, force_N[k])
        return found

    def response(self, frequency_hz: Array) -> NDArray[np.complex128]:
        """Return H (3, n) at frequencies (n,)."""
        ratio = frequency_hz / self.natural_hz[:, :, None]
        modes = 1.0 / (1.0 - ratio**2 + 2j * self.damping[:, :, None] * ratio)
        return np.asarray((1.0 - self.second)[:, None] * modes[0] + self.second[:, None] * modes[1])


def draw_ringing(seed: int) -> Ringing:
    """Draw the modes of a seed's dynamometer."""
    rng = np.random.default_rng([seed, 95])
    first = np.array([rng.uniform(*one) for one in FIRST_HZ])
    return Ringing(
        natural_hz=np.array([first, first * rng.uniform(*SECOND, 3)]),
        damping=rng.uniform(*DAMPING, (2, 3)),
        second=rng.uniform(*SHARE, 3),
    )


def tap_table(seed: int, table: TrueTable, ringing: Ringing) -> RecordedTable:
    """Record taps of a hammer whose force nobody measured, the table at rest and upright."""
    rng = np.random.default_rng([seed, 96])
    count = round(FORCE_HZ * TAPS_S * (3 * TAPS + 1))
    fine = np.arange(count * FINER) / (FINER * FORCE_HZ)
    force_N = np.zeros((3, len(fine)))
    for number in range(3 * TAPS):
        begins, lasts = TAPS_S * (number + rng.uniform(0.4, 0.6)), rng.uniform(*HAMMER_S)
        inside = (fine >= begins) & (fine <= begins + lasts)
        direction = rng.uniform(-ASIDE, ASIDE, 3)
        direction[number % 3] = rng.choice([-1.0, 1.0])
        shape = rng.uniform(*HAMMER_N) * np.sin(np.pi * (fine[inside] - begins) / lasts)
        force_N[:, inside] += direction[:, None] * shape
    none, no = np.zeros((2, count)), np.zeros(count, dtype=np.bool_)
    log = Log(np.arange(count) / FORCE_HZ, none, none, none)
    read = noisy(rng, table.matrix @ _read(ringing.read(force_N)), FORCE_HZ)
    return RecordedTable(log, read, _read(force_N), no, no, np.zeros(count), np.zeros((3, count)))


def mill_ringing(
    seed: int, table: TrueTable, ringing: Ringing | None, setup: int, times: int = 1
) -> RecordedTable:
    """Record the passes of P4's work in a set-up, each ``times`` times; None: nothing rings."""
    rng = np.random.default_rng([seed, 97, setup, times])
    many = PASSES_MM * times
    count = round(FORCE_HZ * (BEFORE_S + AFTER_S + len(many) * (PASS_S + BETWEEN_S)))
    finer = 1 if ringing is None else FINER
    true_N, engaged, whole, chips = passes(rng, np.arange(count * finer) / (finer * FORCE_HZ), many)
    engaged, whole, chips = engaged[::finer], whole[::finer], chips[::finer]
    angle = np.repeat(np.array(SETUPS_DEG[setup])[:, None], count, axis=1)
    turned = machine_to_table(np.radians(np.array(SETUPS_DEG[setup]) + table.offsets_deg))
    felt_N = true_N
    if ringing is not None:
        felt_N, true_N = _read(turned.T @ ringing.read(turned @ true_N)), _read(true_N)
    heat_N = heat(rng, table, STAYS[setup], chips)
    still = np.zeros_like(angle)
    log = Log(np.arange(count) / FORCE_HZ, angle, still, still)
    mass, lever = table.loaded(WORK_KG)
    exact = truth(table, log, mass, lever, felt_N, follows=False) + heat_N
    return RecordedTable(log, noisy(rng, exact, FORCE_HZ), true_N, engaged, whole, chips, heat_N)


def _read(values: Array) -> Array:
    """Return values (3, n FINER) through P4's low-pass, at its rate (3, n)."""
    sos = signal.butter(4, LOWPASS_HZ, fs=FINER * FORCE_HZ, output="sos")
    return np.asarray(signal.sosfiltfilt(sos, values, axis=1)[:, ::FINER])
