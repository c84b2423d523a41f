"""What of a table dynamometer's reading is not the process: zero, weight, inertia.

F_M = T F_P + F_G + F_CF + F_E (P4 equation 3), tared upright with the mass m_0 on it:
F_G = m g T e_z − m_0 g e_z (5), F_CF + F_E = ω × (ω × m r) + ω' × m r (6, 7), in the dynamometer's
frame. Mass m and moments m r are linear in it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import constants

from autodb import signals
from autodb.errors import UnusableInput
from autodb.records import Recording
from autodb.sensing.table.kinematics import Kinematics
from autodb.terms.table import table_inertia

Array = NDArray[np.float64]

G_M_S2 = constants.g
FORCES = ("force.x", "force.y", "force.z")
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class TableModel:
    """What was identified of a table dynamometer.

    ``zero_N`` (3,): reading upright and at rest; ``mass_kg`` on the sensor; ``moment_kg_m`` (3,):
    mass times the place of its centre from the centre of rotation, in the dynamometer's frame;
    ``covariance`` (4, 4) of mass and moments; ``noise_N`` (3,): what it leaves at rest, low-passed
    at ``cutoff_hz``; ``not_excited``: what no move told, and the move that would, by sentence: its
    moment is then 0.
    """

    kinematics: Kinematics
    zero_N: Array
    mass_kg: float
    moment_kg_m: Array
    covariance: Array
    noise_N: Array
    cutoff_hz: float
    not_excited: tuple[str, ...] = ()

    @property
    def mass_sd_kg(self) -> float:
        """Standard deviation of the mass."""
        return float(np.sqrt(self.covariance[0, 0]))

    @property
    def lever_m(self) -> Array:
        """Place (3,) of the mass' centre from the centre of rotation."""
        return self.moment_kg_m / self.mass_kg

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON keeps it."""
        return {
            "order": list(self.kinematics.order),
            "zero_N": self.zero_N.tolist(),
            "mass_kg": self.mass_kg,
            "moment_kg_m": self.moment_kg_m.tolist(),
            "covariance": self.covariance.tolist(),
            "noise_N": self.noise_N.tolist(),
            "cutoff_hz": self.cutoff_hz,
            "not_excited": list(self.not_excited),
        }

    @classmethod
    def of_json(cls, kept: Mapping[str, Any]) -> "TableModel":
        """Return what ``to_json`` made."""
        return cls(
            kinematics=Kinematics(tuple(kept["order"])),
            zero_N=np.array(kept["zero_N"]),
            mass_kg=kept["mass_kg"],
            moment_kg_m=np.array(kept["moment_kg_m"]),
            covariance=np.array(kept["covariance"]),
            noise_N=np.array(kept["noise_N"]),
            cutoff_hz=kept["cutoff_hz"],
            not_excited=tuple(kept["not_excited"]),
        )


@dataclass(frozen=True)
class TableMotion:
    """How a table moved: T (3, 3, n), ω and ω' (3, n), and rates (k, n) of its axes, rad/s."""

    rotation: Array
    omega: Array
    faster: Array
    rates: Array

    def columns(self) -> Array:
        """Return what a kilogram and the moments add (3, n, 4), N a kg and a kg·m."""
        weight = G_M_S2 * (self.rotation[:, 2] - UP[:, None])
        o, f = self.omega, self.faster
        swung = np.zeros((*o.shape, 3))
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            # The columns are of the moments i, j, k in turn
            swung[i][:, [i, j, k]] = table_inertia(o[i], o[j], o[k], f[j], f[k])
        return np.concatenate([weight[:, :, None], swung], axis=2)


def table_motion(recording: Recording, kinematics: Kinematics, *, cutoff_hz: float) -> TableMotion:
    """Return how the table moved; rates that were not recorded are derived from angles.

    Raises UnusableInput for an angle that was not recorded.
    """
    angles, rates, accelerations = {}, {}, {}
    for axis in kinematics.order:
        angle = recording[f"{axis}.angle"]
        _, rate, acceleration = signals.derivatives(recording.t_s, angle, cutoff_hz=cutoff_hz)
        own = recording.get(f"{axis}.velocity"), recording.get(f"{axis}.acceleration")
        angles[axis] = np.radians(angle)
        rates[axis] = np.radians(rate if own[0] is None else own[0])
        accelerations[axis] = np.radians(acceleration if own[1] is None else own[1])
    omega = kinematics.omega(angles, rates)
    return TableMotion(
        rotation=kinematics.rotation(angles),
        omega=omega,
        faster=_faster(kinematics, angles, rates, accelerations),
        rates=np.array([rates[axis] for axis in kinematics.order]),
    )


def _faster(
    kinematics: Kinematics,
    angles: Mapping[str, Array],
    rates: Mapping[str, Array],
    accelerations: Mapping[str, Array],
) -> Array:
    """Return ω' (3, n): of the axes' accelerations, and of axes that are turned by others."""
    found = kinematics.omega(angles, accelerations)
    # d/dt of each direction in the turning frame: those nearer the table turn it
    order = kinematics.order
    for number, axis in enumerate(order):
        alone = {a: rates[a] if a == axis else np.zeros_like(rates[a]) for a in order}
        nearer = {
            a: rates[a] if a in order[number + 1 :] else np.zeros_like(rates[a]) for a in order
        }
        turned = kinematics.omega(angles, alone)
        found = found + np.cross(kinematics.omega(angles, nearer), turned, axis=0)
    return found


def readings(recording: Recording, *, cutoff_hz: float) -> Array:
    """Return what the dynamometer read (3, n), N, low-passed without a shift in time.

    Raises UnusableInput without one of the three components, or a rate that is too slow.
    """
    rate_hz = recording.rate_hz
    if cutoff_hz >= 0.5 * rate_hz:
        raise UnusableInput(
            f"{recording.path}: {cutoff_hz:g} Hz is too much at {rate_hz:g} Hz; below half of that "
            "would work"
        )
    return np.array(
        [signals.lowpass(recording[n], rate_hz=rate_hz, cutoff_hz=cutoff_hz) for n in FORCES]
    )
