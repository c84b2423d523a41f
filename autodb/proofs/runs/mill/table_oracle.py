"""What could be known of a reference table at best: by who knows its generator's laws, or its form.

The mass: by the distributions that the generator draws gains, crosstalk, zeros and noise from, not
by what it drew; the mean of the posterior, nearly. The force: by the table's mass, arm, matrix and
modes; how hot it became in a recording is fitted.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import constants, signal

from autodb.proofs.machines.mill.reference_ringing import Ringing
from autodb.proofs.machines.mill.reference_table import (
    AXIS_HZ,
    FORCE_HZ,
    GAIN_SD,
    NOISE_N,
    SHARE_SD,
    TURNED_SD_DEG,
    WANDERS_N,
    WANDERS_S,
    WORK_KG,
    Log,
    RecordedTable,
    TrueTable,
    machine_to_table,
)
from autodb.proofs.runs.mill.published_table import (
    AIR_HZ,
    CUT_HZ,
    Model,
    filtered,
    rests,
    turned_back,
)

Array = NDArray[np.float64]

POINTS = 20
"""Of a rest, in the covariance of means over rests."""


@dataclass(frozen=True)
class MassTimesMatrix:
    """Mass times the rows of the matrix (3, 3), kg, and the covariance of each row (3, 3, 3);
    ``added_kg``: what of the mass is known.
    """

    rows: Array
    covariance: Array
    added_kg: float


def mass_at_best(seen: Sequence[tuple[RecordedTable, float]]) -> float:
    """Return the sensor's mass, kg, by recordings of rests and what was weighed on it in each."""
    found = [_products(one, added_kg) for one, added_kg in seen]
    mass = float(np.mean([np.diag(one.rows).mean() - one.added_kg for one in found]))
    off_diagonal = np.hypot(SHARE_SD, np.radians(TURNED_SD_DEG))
    prior_sd = np.where(np.eye(3) > 0.0, GAIN_SD, off_diagonal).ravel()
    matrix = np.eye(3)
    for _ in range(8):
        inner, right = np.diag(np.concatenate([[0.0], prior_sd**-2])), np.zeros(10)
        right[1:] = -(matrix - np.eye(3)).ravel() / prior_sd**2
        for one in found:
            whole = mass + one.added_kg
            for i in range(3):
                slopes = np.zeros((3, 10))
                slopes[:, 0] = matrix[i]
                slopes[:, 1 + 3 * i : 4 + 3 * i] = whole * np.eye(3)
                weight = slopes.T @ np.linalg.inv(one.covariance[i])
                inner += weight @ slopes
                right += weight @ (one.rows[i] - whole * matrix[i])
        step = np.linalg.solve(inner, right)
        mass, matrix = mass + float(step[0]), matrix + step[1:].reshape(3, 3)
    return mass


def _products(seen: RecordedTable, added_kg: float) -> MassTimesMatrix:
    """Return what rests determine, by the law of the zero that wanders; the zero is unknown."""
    read = filtered(seen.reading_N, AIR_HZ, AXIS_HZ)
    down = machine_to_table(np.radians(seen.log.angle))[:, 2] - np.array([0.0, 0.0, 1.0])[:, None]
    # The second half, as P4's model has it
    halves = [slice((begin + end) // 2, end) for begin, end in rests(seen.log)]
    means = np.array([read[:, rows].mean(axis=1) for rows in halves])
    columns = np.array([[*(constants.g * down[:, rows].mean(axis=1)), 1.0] for rows in halves])
    at = np.concatenate([np.linspace(rows.start, rows.stop, POINTS) for rows in halves]) / AXIS_HZ
    alike = np.exp(-np.abs(at[:, None] - at) / WANDERS_S)
    alike = alike.reshape(len(halves), POINTS, len(halves), POINTS).mean(axis=(1, 3))
    white = (AXIS_HZ / FORCE_HZ) * NOISE_N**2 / (halves[0].stop - halves[0].start)
    rows, covariance = [], []
    for k in range(3):
        inverse = np.linalg.inv(WANDERS_N[k] ** 2 * alike + white * np.eye(len(halves)))
        known = np.linalg.inv(columns.T @ inverse @ columns)
        rows.append((known @ columns.T @ inverse @ means[:, k])[:3])
        covariance.append(known[:3, :3])
    return MassTimesMatrix(np.array(rows), np.array(covariance), added_kg)


def known_force(table: TrueTable, seen: RecordedTable, ringing: Ringing | None = None) -> Array:
    """Return the force (3, n) estimated by who knows the table, its modes and chips.

    How hot it became in this recording, in each component by both time constants, and where its
    zero was, is estimated from the rows in air.
    """
    log = with_true_zeros(table, seen.log)
    exact = Model(*table.loaded(WORK_KG))
    sensed = np.linalg.solve(table.matrix, seen.reading_N)
    if ringing is not None:
        spectrum = np.fft.rfft(sensed, axis=1)
        hz = np.asarray(np.fft.rfftfreq(sensed.shape[1], 1.0 / FORCE_HZ), dtype=np.float64)
        sensed = np.fft.irfft(spectrum / ringing.response(hz), sensed.shape[1], axis=1)
    rest = filtered(np.asarray(sensed), CUT_HZ, FORCE_HZ) - exact.added_N(log)
    return turned_back(rest - known_drift(table, seen, rest), log)


def known_drift(table: TrueTable, seen: RecordedTable, rest_N: Array) -> Array:
    """Return the drift (3, n) by the table's time constants and chips, fitted to air."""
    warm = [_warmed(seen.chips, one) for one in table.heats_s]
    columns = np.column_stack([*warm, np.ones(len(seen.chips))])
    air = ~seen.engaged
    sizes, *_ = np.linalg.lstsq(columns[air], rest_N[:, air].T, rcond=None)
    return np.asarray((columns @ sizes).T)


def with_true_zeros(table: TrueTable, log: Log) -> Log:
    """Return the log with the true zeros of its axes."""
    return Log(log.t, log.angle + np.array(table.offsets_deg)[:, None], log.rate, log.acceleration)


def _warmed(chips: Array, time_s: float) -> Array:
    keep = float(np.exp(-1.0 / (FORCE_HZ * time_s)))
    return np.asarray(signal.lfilter([0.0, 1.0 - keep], [1.0, -keep], chips))
