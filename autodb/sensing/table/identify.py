"""Zero, mass and lever arm of a table dynamometer from moves of the table without a cut.

The zero from rest upright; mass and the sensor's matrix from what rest in other tilts adds
(``weighing``; P4 section 4 has the mass alone): what a component reads of a weight that does not
lie along it is crosstalk. How sensitive the sensor is as a whole cannot be told from the mass and
stays as calibrated, unless the table moves without its work, too, and that was weighed. In which
sense an angle counts is told by rests too, with both
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
    FORCES,
    G_M_S2,
    UP,
    TableModel,
    TableMotion,
    readings,
    table_motion,
    within_gaps,
)
from autodb.sensing.table.resonance import FEWEST, modes_of, taps
from autodb.sensing.table.weighing import Weighing, weigh
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
DETERMINED_M = 0.01
"""Standard deviation of a lever arm above which it is not determined. Chosen."""
OTHER_SENSE, SENSE_N = 4.0, 0.5
"""By how many times a sense of an angle leaves more squares of rests than the other, and more than
this many N each, where rests determine it. Chosen."""
TURNS_DEG = 1.0
"""Range of an angle from which on a table turns. Chosen."""
BLOCK_S = 0.5
"""Length of blocks whose errors are taken as independent."""


@dataclass(frozen=True)
class Rest:
    """A rest: mean reading and its scatter (3,), N, the angles (k,), rad, of the table, and from
    when to when, s.
    """

    mean_N: Array
    sd_N: Array
    angles_rad: Array
    begin_s: float
    end_s: float

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
                t_s = self.recording.t_s[rows]
                yield Rest(read.mean(axis=1), read.std(axis=1), angles, t_s[0], t_s[-1])

    def blocks(self) -> Iterator[slice]:
        """Give blocks of rows of BLOCK_S, none next to a gap, where filters see one side only."""
        timing = self.recording.timing
        length = max(1, round(BLOCK_S * timing.rate_hz))
        for inner in within_gaps(timing, cutoff_hz=self.cutoff_hz):
            for begin in range(inner.start, inner.stop, length):
                yield slice(begin, min(begin + length, inner.stop))


@dataclass(frozen=True)
class BareMoves:
    """Moves of the table without the work, which was weighed: ``work_kg``."""

    recordings: Sequence[Recording]
    work_kg: float


def identify_table(
    recordings: Sequence[Recording],
    kinematics: Kinematics,
    *,
    cutoff_hz: float = CUTOFF_HZ,
    bare: BareMoves | None = None,
) -> TableModel:
    """Return what recordings of moves without a cut determine of a table dynamometer.

    The senses of its angles too, where rests tell them; else they are those of ``kinematics``.
    ``bare``: the same table without its work; what that weighs tells the sensor's gain from mass.
    Recordings of taps on a table at rest, angles or not, tell how the sensor rings.

    Raises UnusableInput where no rest upright or no tilted one is among either, a channel is
    missing, or the work weighs nothing.
    """
    moves = moves_among(recordings, kinematics)
    seen = [_moved(one, kinematics, cutoff_hz) for one in moves]
    rests = [rest for one in seen for rest in one.rests()]
    leans = np.array([rest.lean(kinematics) for rest in rests])
    _refuse_few(moves[0], leans)
    read_N = np.array([rest.mean_N for rest in rests])
    zero_N = read_N[leans < UPRIGHT].mean(axis=0)
    noise_N = np.sqrt(np.mean([rest.sd_N**2 for rest in rests], axis=0))
    kinematics, open_senses = _sensed_ways(kinematics, rests, read_N - zero_N)
    seen = [_moved(one, kinematics, cutoff_hz) for one in moves]
    weighings = [_weighing(seen, kinematics)]
    if bare is not None:
        weighings.append(_bare_weighing(bare, kinematics, cutoff_hz))
    mass_kg, matrix, weighed = weigh(weighings)
    moments, swung, lacking = _moments(seen, zero_N, mass_kg, matrix)
    sensed = [
        (one, np.asarray(np.linalg.solve(matrix, _forces(one)), dtype=np.float64))
        for one in recordings
    ]
    return TableModel(
        kinematics, zero_N, mass_kg, matrix, weighed, moments, swung, noise_N, cutoff_hz,
        (*open_senses, *lacking), None if bare is None else bare.work_kg, modes_of(sensed),
    )  # fmt: skip


def moves_among(recordings: Sequence[Recording], kinematics: Kinematics) -> list[Recording]:
    """Return the recordings that are of moves, not of taps on a table at rest."""
    return [one for one in recordings if not _is_tapped(one, kinematics)] or list(recordings)


def _forces(recording: Recording) -> Array:
    return np.array([recording[name] for name in FORCES])


def _is_tapped(recording: Recording, kinematics: Kinematics) -> bool:
    """Return whether a recording is of taps, and of no table that turns."""
    angles = [recording.get(f"{axis}.angle") for axis in kinematics.order]
    turns = any(one is not None and np.ptp(one) > TURNS_DEG for one in angles)
    return not turns and len(taps(_forces(recording), recording.timing)) >= FEWEST


def _weighing(
    seen: Sequence[TableMoves], kinematics: Kinematics, *, less_kg: float = 0.0
) -> Weighing:
    """Return the rests of recordings with one zero."""
    rests = [(rest, number) for number, one in enumerate(seen) for rest in one.rests()]
    return Weighing(
        per_kg=np.array([rest.per_kg(kinematics) for rest, _ in rests]),
        read_N=np.array([rest.mean_N for rest, _ in rests]),
        begin_s=np.array([rest.begin_s for rest, _ in rests]),
        end_s=np.array([rest.end_s for rest, _ in rests]),
        number=np.array([number for _, number in rests]),
        less_kg=less_kg,
    )


def _bare_weighing(bare: BareMoves, kinematics: Kinematics, cutoff_hz: float) -> Weighing:
    """Return the rests without the work."""
    if not bare.work_kg > 0.0:
        raise UnusableInput(
            phrase(
                "the work weighs {mass} kg; state more than 0", mass=localized(f"{bare.work_kg:g}")
            )
        )
    seen = [_moved(one, kinematics, cutoff_hz) for one in bare.recordings]
    leans = np.array([rest.lean(kinematics) for one in seen for rest in one.rests()])
    _refuse_few(bare.recordings[0], leans)
    return _weighing(seen, kinematics, less_kg=bare.work_kg)


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
