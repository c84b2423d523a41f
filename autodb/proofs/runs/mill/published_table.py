"""The published model of a table dynamometer: the gate that reference tables must pass.

P4's own: the sensor's effective mass by least squares from each rest and component, the median of
all (section 4); work weighed; the lever arm of drawings; what weight and turning add by equations 5
to 7, taken off, and turned back (8). Envelopes are over a turn of the spindle; rests count
after their first half. Frequencies of the zero-phase filters are not printed: *chosen*.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import constants, ndimage, signal

from autodb.proofs.machines.mill.reference_table import (
    FORCE_HZ,
    SPEED_RPM,
    WORK_KG,
    Log,
    RecordedTable,
    TrueTable,
)

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]

AIR_HZ, CUT_HZ = 20.0, 1000.0
"""Up to what air and cuts are scored."""
RANGES_N = (388.9, 291.0, 72.0)
"""P4, Table 2: of the cut's forces."""
AIR = (0.003, 0.003, 0.009)
"""P4, Table 1: mean absolute error over the range."""
REPEATS = ((0.009, 0.015), (0.022, 0.012), (0.019, 0.037))
"""P4, Table 2: of envelopes, lower and upper, of x, y, z of upright repeats from their mean."""
SIDEWAYS, ALONG, WITHIN = 0.133, 0.383, 0.08
"""P4, Table 2: the largest of tilted cuts in x and y, and in z; by what share of the range the
median of reference tables may differ in z, their x and y being no larger."""
LEANS = 0.1
"""Share of g by which a component must change for a rest to determine the mass by it."""


@dataclass(frozen=True)
class Model:
    """P4's model of a table with work on it: mass kg and lever arm (3,) m."""

    mass_kg: float
    lever_m: Array

    def added_N(self, log: Log) -> Array:
        """Return what weight and turning add (3, n), equations 5 to 7."""
        turned = _turned(log)
        (a, c), (da, dc), (dda, ddc) = np.radians([log.angle, log.rate, log.acceleration])
        omega = -np.array([da * np.cos(c), da * np.sin(c), dc])  # of equation 1's T
        faster = -np.array([
            dda * np.cos(c) - da * dc * np.sin(c), dda * np.sin(c) + da * dc * np.cos(c), ddc
        ])  # fmt: skip
        arm = np.repeat(self.lever_m[:, None], len(a), axis=1)
        pull = np.cross(omega, np.cross(omega, arm, axis=0), axis=0)
        pull += np.cross(faster, arm, axis=0)
        return np.asarray(self.mass_kg * (_weight(turned) + pull))

    def process_N(self, seen: RecordedTable) -> Array:
        """Return the force (3, n) in machine axes, equation 8, up to CUT_HZ."""
        read = filtered(seen.reading_N, CUT_HZ, FORCE_HZ)
        return turned_back(read - self.added_N(seen.log), seen.log)


def model(alone: RecordedTable, fixed: RecordedTable, fixed_kg: float, table: TrueTable) -> Model:
    """Return P4's model from rests of the sensor alone and with a mass that was weighed."""
    found = np.concatenate([masses(alone), masses(fixed) - fixed_kg])
    return Model(float(np.median(found)) + WORK_KG, table.drawn_m)


def masses(seen: RecordedTable) -> Array:
    """Return the mass, kg, that each tilted rest and component gives."""
    read = filtered(seen.reading_N, AIR_HZ, 1.0 / (seen.log.t[1] - seen.log.t[0]))
    weight = _weight(_turned(seen.log))
    found = []
    for begin, end in rests(seen.log):
        rows = slice((begin + end) // 2, end)
        for k in range(3):
            change = float(weight[k, rows].mean())
            if abs(change) > LEANS * constants.g:
                found.append(float(read[k, rows].mean()) / change)
    return np.array(found)


def rests(log: Log) -> list[tuple[int, int]]:
    """Return begin and end rows of where both axes rest for a second or more."""
    still = (np.abs(log.rate) < 0.1).all(axis=0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    long = 1.0 / (log.t[1] - log.t[0])
    return [(int(b), int(e)) for b, e in zip(edges[::2], edges[1::2], strict=True) if e - b >= long]


def filtered(values: Array, cutoff_hz: float, rate_hz: float) -> Array:
    """Return values (k, n) low-passed forwards and backwards."""
    sos = signal.butter(4, cutoff_hz, fs=rate_hz, output="sos")
    return np.asarray(signal.sosfiltfilt(sos, values, axis=1))


def published_envelopes(force_N: Array) -> Array:
    """Return lower and upper envelope (2, 3, n) of a force (3, n), over a turn of the spindle."""
    rows = round(60.0 / SPEED_RPM * FORCE_HZ)
    return np.array([
        ndimage.minimum_filter1d(force_N, rows, axis=1),
        ndimage.maximum_filter1d(force_N, rows, axis=1),
    ])  # fmt: skip


def envelope_errors(estimated_N: Array, known: Array, whole: Rows) -> Array:
    """Return mean absolute errors (2, 3), N, of a force's envelopes where passes are whole."""
    return np.asarray(
        np.abs(published_envelopes(estimated_N) - known)[:, :, inner(whole)].mean(axis=2)
    )


def inner(whole: Rows) -> Rows:
    """Return rows at which an envelope is of whole engagement alone."""
    rows = round(60.0 / SPEED_RPM * FORCE_HZ)
    return np.asarray(ndimage.binary_erosion(whole, np.ones(rows, dtype=np.bool_)))


def between(upright: Sequence[Array], whole: Rows) -> tuple[Array, Array, Array]:
    """Return mean envelopes (2, 3, n) of upright cuts, errors from it (2, 3), ranges (3,)."""
    every = np.array([published_envelopes(one) for one in upright])
    mean = every.mean(axis=0)
    rows = inner(whole)
    errors = np.abs(every - mean)[..., rows].mean(axis=(0, 3))
    return mean, errors, (mean[1] - mean[0])[:, rows].mean(axis=1)


def turned_back(force_N: Array, log: Log) -> Array:
    """Return forces (3, n) of the dynamometer's frame in machine axes."""
    return np.asarray(np.einsum("ijn,in->jn", _turned(log), force_N))


def _turned(log: Log) -> Array:
    a, c = np.radians(log.angle)
    sa, ca, sc, cc = np.sin(a), np.cos(a), np.sin(c), np.cos(c)
    return np.array([[cc, -sc * ca, sc * sa], [sc, cc * ca, -cc * sa], [0.0 * a, sa, ca]])


def _weight(turned: Array) -> Array:
    """Return what a kilogram weighs (3, n), tared upright."""
    return np.asarray(constants.g * (turned[:, 2] - np.array([0.0, 0.0, 1.0])[:, None]))
