"""What of a table dynamometer's reading is not the process: zero, weight, inertia.

F_M = S (T F_P + F_G + F_CF + F_E) + zero (P4 equation 3 through the sensor's matrix S), tared
upright with the mass m_0 on it: F_G = m g T e_z − m_0 g e_z (5), F_CF + F_E = ω × (ω × m r) +
ω' × m r (6, 7), in the dynamometer's frame. Mass m and moments m r are linear in it. S is 1 but for
shares of one component in another (``terms.table.crosstalk``), a sensor turned on its table, and
components that are not as sensitive as their calibration says; P4 leaves it out.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import constants

from autodb import signals
from autodb.errors import UnusableInput
from autodb.records.tables import Recording
from autodb.sensing.table.kinematics import Kinematics
from autodb.sensing.table.resonance import NONE, Modes, modes_of_json, modes_to_json
from autodb.sensing.table.weighing import GAIN_SD
from autodb.terms.table import table_inertia
from autodb.timing import Timing
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

G_M_S2 = constants.g
FORCES = ("force.x", "force.y", "force.z")
UP = np.array([0.0, 0.0, 1.0])
LEVER_LOST = "the lever arm was found by an older version, turned the wrong way; calibrate again"
MOVES_DEG_S, RATE_OFF = 0.5, 1.5
"""Rate, rms, from which on an axis moves, and the factor by which a recorded rate may be off that
of the angle. Chosen."""
AT_GAP = 2.0
"""Periods of a low-pass' cutoff that its rows at a gap are uncertain over. Chosen."""


@dataclass(frozen=True)
class TableModel:
    """What was identified of a table dynamometer.

    ``zero_N`` (3,): reading upright and at rest; ``mass_kg`` on the sensor; ``matrix`` (3, 3): what
    it reads of a force in each component; ``weighed`` (10, 10): covariance of the mass and the
    matrix, row by row; ``moment_kg_m`` (3,): mass times the place of its centre from the centre of
    rotation, in the dynamometer's frame, and their covariance ``swung`` (3, 3); ``noise_N`` (3,):
    what it leaves at rest, low-passed at ``cutoff_hz``; ``not_excited``: what no move determined,
    and the move that would, by sentence: its moment is then 0; ``work_kg``: what the work weighs,
    where moves without it told the sensor's gain from mass; None: the gain is as calibrated;
    ``modes``: the first resonance of each component that taps determined.
    """

    kinematics: Kinematics
    zero_N: Array
    mass_kg: float
    matrix: Array
    weighed: Array
    moment_kg_m: Array
    swung: Array
    noise_N: Array
    cutoff_hz: float
    not_excited: tuple[str, ...] = ()
    work_kg: float | None = None
    modes: Modes = NONE

    @property
    def gain_sd(self) -> float:
        """Standard deviation of the least known component's sensitivity, of it."""
        if self.work_kg is None:
            return GAIN_SD
        return float(np.sqrt(np.diag(self.weighed)[[1, 5, 9]].max()))

    @property
    def mass_sd_kg(self) -> float:
        """Standard deviation of the mass."""
        return float(np.sqrt(self.weighed[0, 0]))

    @property
    def lever_m(self) -> Array:
        """Place (3,) of the mass' centre from the centre of rotation."""
        return self.moment_kg_m / self.mass_kg

    @property
    def lever_sd_m(self) -> Array:
        """Standard deviation (3,) of the lever arm."""
        return np.asarray(np.sqrt(np.diag(self.swung)) / self.mass_kg)

    def sensed_N(self, reading_N: Array) -> Array:
        """Return the forces (3, n) of what the sensor read: without zero, through its matrix."""
        return np.asarray(np.linalg.solve(self.matrix, reading_N - self.zero_N[:, None]))

    def added_N(self, columns: Array) -> Array:
        """Return what weight and turning add (3, n), of ``TableMotion.columns``."""
        return np.asarray(columns @ np.concatenate([[self.mass_kg], self.moment_kg_m]))

    def variance(self, columns: Array, process_N: Array) -> Array:
        """Return the variance (3, n) of what was sensed less what was added, by identification.

        ``process_N`` (3, n): the force of the cut in the dynamometer's frame.
        """
        weight = columns[:, :, 0]
        inverse = np.linalg.inv(self.matrix)
        whole = process_N + self.mass_kg * weight
        found = np.zeros_like(weight)
        for i in range(3):
            by_matrix = (inverse[i][:, None, None] * whole).reshape(9, -1)
            slopes = np.concatenate([weight[i][None], by_matrix])
            found[i] = np.einsum("kn,kl,ln->n", slopes, self.weighed, slopes)
            swung = columns[i, :, 1:]
            found[i] += np.einsum("nk,kl,nl->n", swung, self.swung, swung)
        return found

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON keeps it; without what was not identified."""
        kept: dict[str, Any] = {
            "order": list(self.kinematics.order),
            "senses": list(self.kinematics.senses),
            "zero_N": self.zero_N.tolist(),
            "mass_kg": self.mass_kg,
            "matrix": self.matrix.tolist(),
            "weighed": self.weighed.tolist(),
            "moment_kg_m": self.moment_kg_m.tolist(),
            "swung": self.swung.tolist(),
            "noise_N": self.noise_N.tolist(),
            "cutoff_hz": self.cutoff_hz,
            "not_excited": list(self.not_excited),
        }
        if self.work_kg is not None:
            kept["work_kg"] = self.work_kg
        if self.modes != NONE:
            kept["modes"] = modes_to_json(self.modes)
        return kept

    @classmethod
    def of_json(cls, kept: Mapping[str, Any]) -> "TableModel":
        """Return what ``to_json`` made.

        Without ``senses`` its lever arm was found with a table that turned the other way: of that
        there is none.
        """
        turned = "senses" in kept
        return cls(
            kinematics=Kinematics(tuple(kept["order"]), tuple(kept.get("senses", ()))),
            zero_N=np.array(kept["zero_N"]),
            mass_kg=kept["mass_kg"],
            matrix=np.array(kept["matrix"]),
            weighed=np.array(kept["weighed"]),
            moment_kg_m=np.array(kept["moment_kg_m"]) * turned,
            swung=np.array(kept["swung"]) * turned,
            noise_N=np.array(kept["noise_N"]),
            cutoff_hz=kept["cutoff_hz"],
            not_excited=tuple(kept["not_excited"] if turned else [LEVER_LOST]),
            work_kg=kept.get("work_kg"),
            modes=modes_of_json(kept.get("modes")),
        )


@dataclass(frozen=True)
class TableMotion:
    """How a table moved: T (3, 3, n), ω and ω' (3, n), angles and rates (k, n) of its axes, rad."""

    rotation: Array
    omega: Array
    faster: Array
    angles: Array
    rates: Array

    def columns(self) -> Array:
        """Return what a kilogram and the moments add (3, n, 4), N a kg and a kg·m."""
        return carried_columns(self.rotation, self.omega, self.faster)


def carried_columns(rotation: Array, omega: Array, faster: Array) -> Array:
    """Return what a kilogram on a table, and its moments, add (3, n, 4), N a kg and a kg·m.

    Of T (3, 3, n), ω [rad/s] and dω/dt [rad/s²] (3, n) in the table's frame; tared upright.
    """
    weight = G_M_S2 * (rotation[:, 2] - UP[:, None])
    swung = np.zeros((*omega.shape, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        # The columns are of the moments i, j, k in turn
        pulled = table_inertia(omega[i], omega[j], omega[k], faster[j], faster[k])
        swung[i][:, [i, j, k]] = pulled
    return np.concatenate([weight[:, :, None], swung], axis=2)


def table_motion(recording: Recording, kinematics: Kinematics, *, cutoff_hz: float) -> TableMotion:
    """Return how the table moved; rates that were not recorded are derived from angles.

    Raises UnusableInput for an angle that was not recorded, or a rate that is not its angle's.
    """
    angles, rates, accelerations = {}, {}, {}
    for axis in kinematics.order:
        angle = recording[f"{axis}.angle"]
        _, rate, acceleration = signals.derivatives(
            recording.t_s, angle, cutoff_hz=cutoff_hz, timing=recording.timing
        )
        own = recording.get(f"{axis}.velocity"), recording.get(f"{axis}.acceleration")
        _refuse_other_rate(recording, axis, own[0], rate)
        angles[axis] = np.radians(angle)
        rates[axis] = np.radians(rate if own[0] is None else own[0])
        accelerations[axis] = np.radians(acceleration if own[1] is None else own[1])
    return TableMotion(
        rotation=kinematics.rotation(angles),
        omega=kinematics.omega(angles, rates),
        faster=kinematics.omega_dot(angles, rates, accelerations),
        angles=np.array([angles[axis] for axis in kinematics.order]),
        rates=np.array([rates[axis] for axis in kinematics.order]),
    )


def _refuse_other_rate(recording: Recording, axis: str, own: Array | None, derived: Array) -> None:
    """Refuse a recorded rate that is not that of its angle, of another sense or unit."""
    if own is None or np.sqrt(np.mean(derived**2)) < MOVES_DEG_S:
        return
    share = float(own @ derived / (derived @ derived))
    if not 1.0 / RATE_OFF < share < RATE_OFF:
        raise UnusableInput(
            phrase(
                "{file}: {axis}.velocity is {share} times the rate at which {axis}.angle "
                "changes; give it in deg/s, in the angle's sense, or leave it out",
                file=recording.path,
                axis=axis,
                share=localized(f"{share:.3g}"),
            )
        )


def readings(recording: Recording, *, cutoff_hz: float) -> Array:
    """Return what the dynamometer read (3, n), N, low-passed without a shift in time, by piece.

    Raises UnusableInput without one of the three components, or a rate that is too slow.
    """
    rate_hz = recording.timing.rate_hz
    if cutoff_hz >= 0.5 * rate_hz:
        raise UnusableInput(
            phrase(
                "{file}: {cutoff} Hz is too much at {rate} Hz; use less than half of that",
                file=recording.path,
                cutoff=localized(f"{cutoff_hz:g}"),
                rate=localized(f"{rate_hz:g}"),
            )
        )
    return np.array(
        [
            signals.lowpass_pieces(recording[n], recording.timing, cutoff_hz=cutoff_hz)
            for n in FORCES
        ]
    )


def within_gaps(timing: Timing, *, cutoff_hz: float) -> list[slice]:
    """Return the pieces of a recording without their rows at a gap.

    Over AT_GAP periods of the cutoff a low-pass and the derivatives have but one side to go by.
    """
    edge = round(AT_GAP / cutoff_hz * timing.rate_hz)
    first, last = timing.pieces[0].start, timing.pieces[-1].stop
    inner = (
        slice(piece.start + edge * (piece.start > first), piece.stop - edge * (piece.stop < last))
        for piece in timing.pieces
    )
    return [piece for piece in inner if piece.stop > piece.start]
