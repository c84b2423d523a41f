"""Zero, mass and lever arm of a table dynamometer from moves of the table without a cut.

The zero from rest upright; mass and the sensor's matrix from what rest in other tilts adds, least
squares over the rests (P4 section 4, with the mass alone): what a component reads of a weight that
does not lie along it is crosstalk. How sensitive the sensor is as a whole cannot be determined from
the mass and stays as calibrated. In which sense an angle counts is told by rests too, with both
angles off zero: the weight turns with the table. Moments m r from what turning adds. What no move
excited is said by name: a moment along the axis that turns shows only while another axis speeds up.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.errors import UnusableInput
from autodb.records.tables import Recording
from autodb.sensing.table.kinematics import Kinematics
from autodb.sensing.table.model import (
    G_M_S2,
    UP,
    TableModel,
    TableMotion,
    readings,
    table_motion,
    within_gaps,
)
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

CUTOFF_HZ = 20.0
"""Frequency up to which moves in air are used. Chosen: tables turn more slowly."""
STILL_RAD_S = 0.002
"""Rate below which an axis rests. Chosen."""
SHORTEST_S, SETTLING_S = 0.5, 0.3
"""Length of a rest that counts, and its first part, in which the table still swings. Chosen."""
UPRIGHT, TILTED = 1e-4, 0.02
"""1 − cos of the lean up to which a table is upright, and from which on it determines a mass
(11°)."""
SHARE_SD, GAIN_SD = 0.03, 0.005
"""Standard deviations of what a component reads of another (that of ``terms.table.crosstalk``),
and of its own sensitivity, before any move. Chosen."""
DETERMINED_M = 0.01
"""Standard deviation of a lever arm above which it is not determined. Chosen."""
OTHER_SENSE, SENSE_N = 4.0, 0.5
"""By how many times a sense of an angle leaves more squares of rests than the other, and more than
this many N each, where rests determine it. Chosen."""
STEPS = 6
"""Of Gauss and Newton to mass and matrix, whose product is what rests determine."""
BLOCK_S = 0.5
"""Length of blocks whose errors are taken as independent."""


@dataclass(frozen=True)
class Rest:
    """A rest: mean reading and its scatter (3,), N, and the angles (k,), rad, of the table."""

    mean_N: Array
    sd_N: Array
    angles_rad: Array

    def per_kg(self, kinematics: Kinematics) -> Array:
        """Return what a kilogram adds there (3,)."""
        angles = dict(zip(kinematics.order, self.angles_rad[:, None], strict=True))
        return np.asarray(G_M_S2 * (kinematics.rotation(angles)[:, 2, 0] - UP))

    def lean(self, kinematics: Kinematics) -> float:
        """Return 1 − cos of how far the sensor's z leans from upright."""
        return float(-self.per_kg(kinematics)[2] / G_M_S2)


@dataclass(frozen=True)
class TableMoves:
    """A recording: readings (3, n), low-passed at ``cutoff_hz``, and how the table moved."""

    recording: Recording
    read_N: Array
    motion: TableMotion
    cutoff_hz: float

    def rests(self) -> Iterator[Rest]:
        """Give every rest that is long enough, without its beginning."""
        still = np.all(np.abs(self.motion.rates) < STILL_RAD_S, axis=0)
        timing = self.recording.timing
        for rest in signals.flagged_runs(still, timing.pieces):
            rows = slice(rest.start + round(SETTLING_S * timing.rate_hz), rest.stop)
            if rest.stop - rest.start >= (SHORTEST_S + SETTLING_S) * timing.rate_hz:
                read = self.read_N[:, rows]
                angles = self.motion.angles[:, rows].mean(axis=1)
                yield Rest(read.mean(axis=1), read.std(axis=1), angles)

    def blocks(self) -> Iterator[slice]:
        """Give blocks of rows of BLOCK_S, none next to a gap, where filters see one side only."""
        timing = self.recording.timing
        length = max(1, round(BLOCK_S * timing.rate_hz))
        for inner in within_gaps(timing, cutoff_hz=self.cutoff_hz):
            for begin in range(inner.start, inner.stop, length):
                yield slice(begin, min(begin + length, inner.stop))


def identify_table(
    recordings: Sequence[Recording], kinematics: Kinematics, *, cutoff_hz: float = CUTOFF_HZ
) -> TableModel:
    """Return what recordings of moves without a cut determine of a table dynamometer.

    The senses of its angles too, where rests tell them; else they are those of ``kinematics``.

    Raises UnusableInput where no rest upright or no tilted one is among them, or a channel is
    missing.
    """
    seen = [_moved(one, kinematics, cutoff_hz) for one in recordings]
    rests = [rest for one in seen for rest in one.rests()]
    leans = np.array([rest.lean(kinematics) for rest in rests])
    _refuse_few(recordings[0], leans)
    read_N = np.array([rest.mean_N for rest in rests])
    zero_N = read_N[leans < UPRIGHT].mean(axis=0)
    noise_N = np.sqrt(np.mean([rest.sd_N**2 for rest in rests], axis=0))
    kinematics, open_senses = _sensed_ways(kinematics, rests, read_N - zero_N)
    per_kg = np.array([rest.per_kg(kinematics) for rest in rests])
    tilted = int(np.sum(leans > TILTED))
    mass_kg, matrix, weighed = _weighed(per_kg, read_N - zero_N, tilted)
    seen = [_moved(one, kinematics, cutoff_hz) for one in recordings]
    moments, swung, lacking = _moments(seen, zero_N, mass_kg, matrix)
    return TableModel(
        kinematics, zero_N, mass_kg, matrix, weighed, moments, swung, noise_N, cutoff_hz,
        (*open_senses, *lacking),
    )  # fmt: skip


def _moved(recording: Recording, kinematics: Kinematics, cutoff_hz: float) -> TableMoves:
    read_N = readings(recording, cutoff_hz=cutoff_hz)
    motion = table_motion(recording, kinematics, cutoff_hz=cutoff_hz)
    return TableMoves(recording, read_N, motion, cutoff_hz)


def _sensed_ways(
    kinematics: Kinematics, rests: Sequence[Rest], added_N: Array
) -> tuple[Kinematics, list[str]]:
    """Return the axes with the senses in which the weight turns at rests, and what these leave
    open, in words: there the sense stays as it was.

    ``added_N`` (rests, 3): what each reads beyond the zero.
    """
    left: dict[tuple[int, ...], float] = {}
    for senses in product((1, -1), repeat=len(kinematics.order)):
        per_kg = np.array([one.per_kg(replace(kinematics, senses=senses)) for one in rests])
        mass = max(0.0, float(np.sum(per_kg * added_N) / np.sum(per_kg**2)))
        left[senses] = float(np.sum((added_N - mass * per_kg) ** 2))
    best = min(left, key=lambda senses: left[senses])
    found, words = list(best), []
    for k, axis in enumerate(kinematics.order):
        other = min(squares for senses, squares in left.items() if senses[k] != best[k])
        if other < OTHER_SENSE * left[best] + len(rests) * SENSE_N**2:
            found[k] = kinematics.senses[k]
            words.append(
                f"the sense of {axis}.angle is not determined, taken as {found[k]:+d}; rest in "
                "tilts with all angles of the table away from 0 and 180°"
            )
    return replace(kinematics, senses=tuple(found)), words


def air_left_N(model: TableModel, recordings: Sequence[Recording]) -> Array:
    """Return the rms (3,), N, that a model leaves of recordings without a cut."""
    squares, rows = np.zeros(3), 0
    for one in recordings:
        columns = table_motion(one, model.kinematics, cutoff_hz=model.cutoff_hz).columns()
        left = model.sensed_N(readings(one, cutoff_hz=model.cutoff_hz)) - model.added_N(columns)
        for inner in within_gaps(one.timing, cutoff_hz=model.cutoff_hz):
            squares += np.sum(left[:, inner] ** 2, axis=1)
            rows += inner.stop - inner.start
    return np.asarray(np.sqrt(squares / rows))


def _refuse_few(recording: Recording, leans: Array) -> None:
    if not np.any(leans < UPRIGHT):
        raise UnusableInput(
            phrase(
                "{file}: the table never rests upright for {settling} s; let it rest upright, "
                "which determines the sensor's zero",
                file=recording.path,
                settling=localized(f"{SHORTEST_S + SETTLING_S:g}"),
            )
        )
    if not np.any(leans > TILTED):
        raise UnusableInput(
            phrase(
                "{file}: the table never rests tilted by 12° or more; let it rest in several "
                "tilts, which determine the mass",
                file=recording.path,
            )
        )


def _weighed(per_kg: Array, added: Array, tilted: int) -> tuple[float, Array, Array]:
    """Return mass, matrix (3, 3) and the covariance (10, 10) of both, each rest one reading.

    ``per_kg`` (rests, 3) what a kilogram adds, ``added`` what was read beyond the zero, N.
    """
    mass = float(np.sum(per_kg * added) / np.sum(per_kg**2))
    matrix, scatter = np.eye(3), np.var(added - mass * per_kg, axis=0)
    prior_sd = np.where(np.eye(3) > 0.0, GAIN_SD, SHARE_SD).ravel()
    prior = np.diag(np.concatenate([[0.0], prior_sd**-2]))
    for _ in range(STEPS):
        slopes = np.zeros((len(added), 3, 10))
        slopes[:, :, 0] = per_kg @ matrix.T
        for i in range(3):
            slopes[:, i, 1 + 3 * i : 4 + 3 * i] = mass * per_kg
        left = added - mass * per_kg @ matrix.T
        scatter = np.maximum(np.sum(left**2, axis=0) / max(tilted - 3, 1), 1e-12)
        inner = np.einsum("rij,i,rik->jk", slopes, 1.0 / scatter, slopes) + prior
        right = np.einsum("rij,i,ri->j", slopes, 1.0 / scatter, left)
        right[1:] -= (matrix - np.eye(3)).ravel() / prior_sd**2
        step = np.linalg.solve(inner, right)
        mass, matrix = mass + float(step[0]), matrix + step[1:].reshape(3, 3)
    return mass, matrix, np.linalg.inv(inner)


def _moments(
    seen: Sequence[TableMoves], zero_N: Array, mass_kg: float, matrix: Array
) -> tuple[Array, Array, list[str]]:
    """Return moments (3,), their covariance (3, 3), and what no move determined of them, in
    words."""
    inner, right = np.zeros((3, 3)), np.zeros(3)
    blocks = []
    for one in seen:
        columns = one.motion.columns()
        sensed = np.linalg.solve(matrix, one.read_N - zero_N[:, None])
        left = sensed - mass_kg * columns[:, :, 0]
        for rows in one.blocks():
            swung, rest = columns[:, rows, 1:].reshape(-1, 3), left[:, rows].ravel()
            inner += swung.T @ swung
            right += swung.T @ rest
            blocks.append((swung, rest))
    if np.max(np.abs(inner)) == 0.0:
        return np.zeros(3), np.zeros((3, 3)), [_not_determined(k) for k in range(3)]
    moments = np.linalg.pinv(inner, rcond=1e-9) @ right
    # Errors go together within a block: the covariance is that of the blocks' sums
    pushes = np.array([swung.T @ (rest - swung @ moments) for swung, rest in blocks])
    inverse = np.linalg.pinv(inner, rcond=1e-9)
    covariance = inverse @ (pushes.T @ pushes) @ inverse
    weak = np.diag(inner) < 1e-9 * np.max(np.diag(inner))
    unknown = weak | (np.sqrt(np.diag(covariance)) > DETERMINED_M * mass_kg)
    moments = np.where(unknown, 0.0, moments)
    covariance[unknown, :] = covariance[:, unknown] = 0.0
    return moments, covariance, [_not_determined(int(k)) for k in np.flatnonzero(unknown)]


def _not_determined(component: int) -> str:
    name = "xyz"[component]
    return (
        f"the lever arm's {name} is not determined; turn the table about an axis that is not "
        f"along the sensor's {name}, with sharp starts and stops"
    )
