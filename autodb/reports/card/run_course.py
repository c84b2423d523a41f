"""What moved over a run of calibration cuts whose first one was made again at its end."""

import numpy as np
from numpy.typing import NDArray

from autodb import standard
from autodb.agent.sense.calibrating import Calibrated, its_own, known_forces
from autodb.explain.answer import Cause
from autodb.explain.calibration_run import Ends, cause_sentences, explain_moved
from autodb.explain.cuts.candidates.currents import StandardRun
from autodb.records.tables import CutTable
from autodb.reports.card import axis_figures
from autodb.reports.card.conditions import codes, last_less_first
from autodb.sensing.ranges.calibration import Calibration
from autodb.sensing.ranges.chosen import current_of
from autodb.sensing.ranges.outliers import transients
from autodb.sensing.ranges.points import FEED_AXES, Points

Array = NDArray[np.float64]


def moved_over(done: Calibrated, protocol: standard.CutProtocol | None) -> list[tuple[str, ...]]:
    """Return what is said of what moved, for each calibration; ``protocol`` as they were made."""
    forces = known_forces(done.table, protocol)
    return [
        tuple(cause_sentences(what_moved(one, done.table, force_N=own, protocol=protocol)))
        for one in done.calibrations
        for own in (its_own(done.table, one, forces),)
    ]


def what_moved(
    calibration: Calibration,
    table: CutTable,
    *,
    force_N: Array | None,
    protocol: standard.CutProtocol | None,
) -> tuple[Cause, ...]:
    """Return what moved over the cuts that an axis was calibrated on.

    ``force_N`` (n,) and ``protocol`` as it was calibrated with. Nothing where the last of these
    cuts does not repeat the first, or moved no more than repeats scatter.
    """
    points, rows = axis_figures.by_row(table, calibration.axis, force_N)
    kept = axis_figures.cuts_of_run(transients(points.sensed.current, points.target, points.groups))
    points, rows = points.at(kept), rows[kept]
    alike = codes(axis_figures.conditions_of(calibration, table, protocol, rows))
    if alike is None:
        return ()
    air = axis_figures.air_of(calibration, table, rows)
    measured = protocol is None
    moved = Ends(
        conditions=alike,
        rise=last_less_first(points.sensed.current, alike),
        air=None if air is None else last_less_first(air, alike),
        force=last_less_first(points.target, alike) if measured else None,
        force_unit=calibration.unit,
    )
    run = _run(calibration, _rows_of(table, rows), points, alike, air, measured=measured)
    return explain_moved(run, moved)


def _run(
    calibration: Calibration,
    table: CutTable,
    points: Points,
    conditions: NDArray[np.intp],
    air: Array | None,
    *,
    measured: bool,
) -> StandardRun:
    sensed = points.sensed
    expected = current_of(calibration.form, calibration.coefficients, sensed, points.target)
    return StandardRun(
        table=table,
        conditions=conditions,
        rise=sensed.current,
        expected=expected,
        air=air,
        speed=sensed.feed_mm_s if calibration.axis in FEED_AXES else sensed.speed_rpm,
        measured=measured,
        unit=calibration.current_unit,
    )


def _rows_of(table: CutTable, rows: NDArray[np.intp]) -> CutTable:
    return CutTable(
        path=table.path,
        channels={name: values[rows] for name, values in table.channels.items()},
        texts={name: [values[row] for row in rows] for name, values in table.texts.items()},
    )
