"""The depth of cut at which a tool point chatters, at a speed: the regenerative limit.

Forces that answer to a tool's motion, B (per the stated depth), and receptances G make a loop that
is at its limit, at the chatter frequency w and the tooth period T, where

    1 = s (1 - e^(-iwT)) m(w),    m an eigenvalue of B G,    s = limiting over stated depth

so that, with c = Im(1/m)/Re(1/m),

    s = Re(1/m) (1 + c²)/2,    w T = pi - 2 arctan c + 2 pi j

Of a mill, whose B is the mean over a turn, that is the zero-order solution of Altintas and Budak
1995 (CIRP Annals 44:357); of a turned cut, whose B does not change, it is exact, and that of Tlusty
with the oriented receptance, s = -1/(2 Re G_o). Mills engaged over a small part of a turn also
chatter with half the tooth frequency, which is not in it; nor is what a worn edge damps at low
speeds.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

LINES_A_LOBE = 12.0
"""Lines of frequency over which the phase may turn once. Chosen: limits are then within 0.3 %."""
MOST_LINES = 20_000


@dataclass(frozen=True)
class Loop:
    """Limits by chatter frequency: ``frequency_Hz`` (f,), of each eigenvalue (f, e) the scale of
    the stated depth, infinite where it is stable at any, and the phase w T modulo 2 pi.
    """

    frequency_Hz: Array
    scale: Array
    phase_rad: Array

    @property
    def critical(self) -> float:
        """The scale below which no speed chatters."""
        return float(np.min(self.scale))


def loop_of(stiffness_N_mm: Array, frequency_Hz: Array, receptance: Complex) -> Loop:
    """Return the limits of B (3, 3) with receptances (f, 3), mm/N, of machine axes."""
    flexible = np.flatnonzero(np.any(receptance != 0.0, axis=0))
    both = stiffness_N_mm[np.ix_(flexible, flexible)] * receptance[:, None, flexible]
    values = np.linalg.eigvals(both)
    values = np.where(np.abs(values) > 0.0, values, np.finfo(float).tiny)
    # Branches go on from line to line: those of two axes are in the order of their size
    values = np.take_along_axis(values, np.argsort(np.abs(values), axis=1), axis=1)
    inverse = 1.0 / values
    turned = inverse.imag / np.where(inverse.real == 0.0, np.finfo(float).tiny, inverse.real)
    limited = inverse.real > 0.0
    with np.errstate(over="ignore"):
        scale = np.where(limited, 0.5 * inverse.real * (1.0 + turned**2), np.inf)
    return Loop(frequency_Hz, scale, np.pi - 2.0 * np.arctan(turned))


def lines_for(frequency_Hz: Array, receptance: Complex, period_s: float) -> tuple[Array, Complex]:
    """Return receptances on lines that are close enough for the longest tooth period."""
    step = 1.0 / (LINES_A_LOBE * period_s)
    low, high = float(frequency_Hz[0]), float(frequency_Hz[-1])
    count = int(min(np.ceil((high - low) / step), MOST_LINES))
    every = np.unique(np.concatenate([frequency_Hz, np.linspace(low, high, count + 2)]))
    parts = [
        np.interp(every, frequency_Hz, receptance[:, k].real)
        + 1j * np.interp(every, frequency_Hz, receptance[:, k].imag)
        for k in range(receptance.shape[1])
    ]
    return every, np.stack(parts, axis=1)


def limit_at(loop: Loop, periods_s: Array) -> tuple[Array, Array]:
    """Return the limiting scales at tooth periods (n,), and the chatter frequencies, Hz.

    Infinite, and NaN, where no frequency closes the loop.
    """
    scale = np.full(len(periods_s), np.inf)
    frequency = np.full(len(periods_s), np.nan)
    omega = 2.0 * np.pi * loop.frequency_Hz
    limited = np.isfinite(loop.scale)
    line, branch = np.nonzero(limited[:-1] & limited[1:])
    (low_omega, low_phase), (high_omega, high_phase) = (
        (omega[one], loop.phase_rad[one, branch]) for one in (line, line + 1)
    )
    for k, period in enumerate(periods_s.tolist()):
        low = (low_omega * period - low_phase) / (2.0 * np.pi)
        high = (high_omega * period - high_phase) / (2.0 * np.pi)
        whole = np.floor(low), np.floor(high)
        at = np.flatnonzero((whole[0] != whole[1]) & (np.abs(high - low) < 0.5))
        if not len(at):
            continue
        share = (np.maximum(whole[0][at], whole[1][at]) - low[at]) / (high[at] - low[at])
        first, last = loop.scale[line[at], branch[at]], loop.scale[line[at] + 1, branch[at]]
        found = first + share * (last - first)
        best = int(np.argmin(found))
        scale[k] = found[best]
        there = loop.frequency_Hz[line[at[best]]], loop.frequency_Hz[line[at[best]] + 1]
        frequency[k] = there[0] + share[best] * (there[1] - there[0])
    return scale, frequency
