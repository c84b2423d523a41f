"""Process forces in machine axes from what a dynamometer on a table read.

F_P = T⁻¹ (S⁻¹ (F_M − zero) − F_G − F_CF − F_E − heat), P4 equation 8 with what it leaves out. Chips
heat the sensor (P4 section 5.2): in each recording its drift is estimated from the rows in which
nothing is cut (``heat``). Where taps determined how the sensor rings, what it sensed is corrected
for that first (``resonance``).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.records.tables import Recording
from autodb.sensing.table.heat import Heat, heat_of
from autodb.sensing.table.model import FORCES, G_M_S2, UP, TableModel, readings, table_motion
from autodb.sensing.table.resonance import NONE, without_ringing
from autodb.signals import by_piece
from autodb.wording import phrase

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]


@dataclass(frozen=True)
class TableForces:
    """Force of the work on the tool in machine axes and its sd (3, n), N.

    ``heat``: the drift that was taken off in the dynamometer's frame.
    """

    force_N: Array
    sd_N: Array
    heat: Heat


def table_forces(
    model: TableModel,
    recording: Recording,
    cutting: Rows,
    *,
    cutoff_hz: float,
    removed_kg: Array | None = None,
) -> TableForces:
    """Return the process forces of a recording.

    ``cutting`` (n,): where chips are made; ``removed_kg`` (n,): mass that left since the tare, of
    removed volume and density; None: none. Raises UnusableInput without a force component or an
    angle of the table, or where ``cutoff_hz`` is too high for its rate.
    """
    if len(cutting) != len(recording):
        raise UnusableInput(
            phrase(
                "{file}: {n} rows say where it cuts, of {n_2}",
                file=recording.path,
                n=len(cutting),
                n_2=len(recording),
            )
        )
    motion = table_motion(recording, model.kinematics, cutoff_hz=model.cutoff_hz)
    columns = motion.columns()
    known = model.added_N(columns)
    if removed_kg is not None:
        # What left the sensor weighs no more, upright neither
        known -= removed_kg * (columns[:, :, 0] + G_M_S2 * UP[:, None])
    sensed, unsure = model.sensed_N(readings(recording, cutoff_hz=cutoff_hz)), None
    if model.modes != NONE:
        raw = np.array([recording[name] for name in FORCES])
        sensed, unsure = without_ringing(
            model.modes, model.sensed_N(raw), recording.timing, cutoff_hz=cutoff_hz
        )
    left = sensed - known
    heat = heat_of(left, cutting, recording.t_s)
    process = left - heat.drift_N
    share = np.sqrt(max(1.0, cutoff_hz / model.cutoff_hz))
    # Beside a drift what air leaves up to this cutoff is known; else that of rests is scaled up
    share = share if heat.why is not None else 1.0
    noise = np.maximum((share * model.noise_N[:, None]) ** 2, heat.variance)
    variance = model.variance(columns, process) + noise
    variance = variance if unsure is None else variance + unsure**2
    back = np.swapaxes(motion.rotation, 0, 1)
    force = np.einsum("ijn,jn->in", back, process)
    sd = np.sqrt(np.einsum("ijn,jn->in", back**2, variance))
    return TableForces(force, sd, heat)


def envelopes(force_N: Array, pieces: Sequence[slice], *, rows: int) -> tuple[Array, Array]:
    """Return lower and upper envelope (n,) of a force (n,) over ``rows``, of a spindle's turn say,
    within each of its pieces.

    Single tooth passes scatter, so that envelopes are compared (P4 section 5.2).
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    low = by_piece(lambda own: minimum_filter1d(own, rows, mode="nearest"), force_N, pieces)
    high = by_piece(lambda own: maximum_filter1d(own, rows, mode="nearest"), force_N, pieces)
    return np.asarray(low), np.asarray(high)
