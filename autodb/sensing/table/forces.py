"""Process forces in machine axes from what a dynamometer on a table read.

F_P = T⁻¹ (S⁻¹ (F_M − zero) − F_G − F_CF − F_E − heat), P4 equation 8 with what it leaves out. Chips
heat the sensor (P4 section 5.2): in each recording its drift, level · u with T du/dt = cutting − u
(``terms.table.thermal_drift``), is estimated from the rows in which nothing is cut, each component
by its own level, all by one time constant.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.records.tables import Recording
from autodb.sensing.table.model import G_M_S2, UP, TableModel, readings, table_motion
from autodb.signals import by_piece
from autodb.terms.table import thermal_drift
from autodb.wording import phrase

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]

TIMES_S = (2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
"""Time constants of heating that are tried. Chosen."""
AIR_S = 1.0
"""Time without a cut, before and after one, that a drift is estimated from at least."""


@dataclass(frozen=True)
class TableForces:
    """Force of the work on the tool in machine axes and its sd (3, n), N.

    ``heat_N`` (3, n): what was taken off in the dynamometer's frame; ``time_constant_s``: None
    where no drift was estimated, and ``why`` then says why.
    """

    force_N: Array
    sd_N: Array
    heat_N: Array
    time_constant_s: float | None
    why: str | None = None


@dataclass(frozen=True)
class Heat:
    """A drift (3, n), N, and the variance (3, n) of what is not known of it, with that of what air
    leaves beside it.
    """

    drift_N: Array
    variance: Array
    time_constant_s: float | None
    why: str | None = None


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
    left = model.sensed_N(readings(recording, cutoff_hz=cutoff_hz)) - known
    heat = heat_of(left, cutting, recording.t_s)
    process = left - heat.drift_N
    share = np.sqrt(max(1.0, cutoff_hz / model.cutoff_hz))
    variance = model.variance(columns, process) + np.maximum(
        (share * model.noise_N[:, None]) ** 2, heat.variance
    )
    back = np.swapaxes(motion.rotation, 0, 1)
    force = np.einsum("ijn,jn->in", back, process)
    sd = np.sqrt(np.einsum("ijn,jn->in", back**2, variance))
    return TableForces(force, sd, heat.drift_N, heat.time_constant_s, heat.why)


def heat_of(left_N: Array, cutting: Rows, t_s: Array) -> Heat:
    """Return the drift of a sensor from what it reads (3, n) while nothing is cut.

    Beside it a constant each, which is what the zero has moved by since it was measured. Without
    air before and after the cut it is not estimated, and nothing taken off.
    """
    none = np.zeros_like(left_N)
    air = np.flatnonzero(~cutting)
    cuts = np.flatnonzero(cutting)
    step_s = float(np.median(np.diff(t_s)))
    if not len(cuts):
        return Heat(none, none, None, "nothing is cut")
    before, after = np.sum(air < cuts[0]), np.sum(air > cuts[-1])
    if min(before, after) * step_s < AIR_S:
        return Heat(
            none, none, None,
            f"drift is not estimated; record {AIR_S:g} s of air before and after the cut",
        )  # fmt: skip
    tried = [_heated(left_N, cutting, t_s, air, time_s) for time_s in TIMES_S]
    drift, variance, _, time_s = min(tried, key=lambda one: one[2])
    # What other time constants that fit nearly as well say is not known either
    best = min(one[2] for one in tried)
    near = [one[0] for one in tried if one[2] <= 1.05 * best]
    spread = np.max([(one - drift) ** 2 for one in near], axis=0)
    return Heat(drift, variance + spread, time_s)


def _heated(
    left_N: Array, cutting: Rows, t_s: Array, air: NDArray[np.intp], time_s: float
) -> tuple[Array, Array, float, float]:
    """Return drift and its variance (3, n) with a time constant, the squares left, and that."""
    u = thermal_drift(cutting.astype(np.float64), t_s, time_constant_s=time_s)
    columns = np.column_stack([u, np.ones(len(u))])
    inner = np.linalg.inv(columns[air].T @ columns[air])
    sizes = left_N[:, air] @ columns[air] @ inner
    rest = left_N[:, air] - sizes @ columns[air].T
    drift = sizes @ columns.T
    # Neighbouring rows err alike: as many are independent as their sum's spread says
    alike = max(1.0, _together(rest))
    scatter = rest.var(axis=1) * alike
    variance = scatter[:, None] * np.einsum("ni,ij,nj->n", columns, inner, columns)
    variance = variance + rest.var(axis=1)[:, None]
    return drift, variance, float(np.sum(rest**2)), time_s


def _together(rest: Array) -> float:
    """Return by what factor sums of neighbouring errors vary more than independent ones."""
    length = max(1, rest.shape[1] // 20)
    count = rest.shape[1] // length
    sums = rest[:, : count * length].reshape(len(rest), count, length).sum(axis=2)
    return float(np.mean(sums.var(axis=1) / np.maximum(length * rest.var(axis=1), 1e-300)))


def envelopes(force_N: Array, pieces: Sequence[slice], *, rows: int) -> tuple[Array, Array]:
    """Return lower and upper envelope (n,) of a force (n,) over ``rows``, of a spindle's turn say,
    within each of its pieces.

    Single tooth passes scatter, so that envelopes are compared (P4 section 5.2).
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    low = by_piece(lambda own: minimum_filter1d(own, rows, mode="nearest"), force_N, pieces)
    high = by_piece(lambda own: maximum_filter1d(own, rows, mode="nearest"), force_N, pieces)
    return np.asarray(low), np.asarray(high)
