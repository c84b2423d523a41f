"""Figures of the Vicomtech table: current and force, residuals by tool, wear."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.fitting.scores import leave_group_out, straight_line
from autodb.records import source as records
from autodb.records.tables import CutTable
from autodb.reports.figures import keep_peaks
from autodb.sensing.ranges.outliers import transients
from autodb.sensing.ranges.points import Points, calibration_points
from docs.make.style import CORRECTED, INK, MUTED, RECORDING, RULE, SIMULATION, WARN, drawn, legend

Array = NDArray[np.float64]


def draw(data: Path, columns: Path) -> None:
    """Draw every figure of the turning table."""
    table = records.read(data, columns=columns)
    assert isinstance(table, CutTable)
    points = calibration_points(table, "z")
    sudden = transients(points.sensed.current, points.target, points.groups)
    _lines(points, sudden)
    _by_tool(points, sudden)
    _wear(table)


def _lines(points: Points, sudden: NDArray[np.bool_]) -> None:
    """Force against current, with one line for each tool left out."""
    kept = ~sudden
    few = np.flatnonzero(kept)[::3]
    with drawn("turning-lines", height_in=3.6) as (axes,):
        cloud: Any = {"color": RECORDING, "ms": 3, "label": "rows, 1 in 3"}
        axes.plot(points.sensed.current[few], points.target[few], ".", **cloud)
        ends = np.array([points.sensed.current[kept].min(), points.sensed.current[kept].max()])
        for tool in np.unique(points.groups):
            used = kept & (points.groups != tool)
            c0, c1 = straight_line(points.sensed.current[used], points.target[used]).coefficients
            axes.plot(ends, c0 + c1 * ends, color=CORRECTED, lw=0.7)
        axes.plot([], [], color=CORRECTED, lw=0.7, label="fitted without one tool")
        crosses: Any = {"color": WARN, "ms": 6, "mew": 1.6, "label": "transient"}
        axes.plot(points.sensed.current[sudden], points.target[sudden], "x", **crosses)
        axes.set(title="Feed force, N", xlabel="current of the z drive, raw counts", ylim=(0, None))
        legend(axes)


def _by_tool(points: Points, sudden: NDArray[np.bool_]) -> None:
    """Error of the force sensed on each tool by the line that never saw it."""
    kept = ~sudden
    groups = points.groups[kept]
    errors = leave_group_out(points.sensed.current[kept], points.target[kept], groups)
    tools = np.unique(groups)
    with drawn("turning-residuals", height_in=3.6) as (axes,):
        axes.axhline(0, color=MUTED, lw=0.8)
        parts = axes.boxplot(
            [errors[groups == tool] for tool in tools],
            whis=(2.5, 97.5), showfliers=False, patch_artist=True, widths=0.55,
            boxprops={"facecolor": RULE, "edgecolor": CORRECTED},
            medianprops={"color": SIMULATION, "linewidth": 1.8},
            whiskerprops={"color": CORRECTED}, capprops={"color": CORRECTED},
        )  # fmt: skip
        assert len(parts["boxes"]) == len(tools)
        for place, tool in enumerate(tools, start=1):
            rmse = np.sqrt(np.mean(errors[groups == tool] ** 2))
            axes.text(place, 252, f"{rmse:.0f}", ha="center", color=INK, fontsize=9)
        axes.set_xticks(range(1, len(tools) + 1), [f"{tool:g}" for tool in tools])
        axes.set(
            title="Dynamometer − sensed, N; above each tool its RMSE, N",
            xlabel="tool left out",
            ylim=(-330, 290),
        )


def _wear(table: CutTable) -> None:
    """Force over the rows against a simulation of fresh edges; the correction; the flank wear."""
    fresh = table["tool.cutting_time"] < 10.0
    force = np.full(len(table), table["force.z"][fresh].mean())
    simulation = CutTable(
        path=table.path, channels={"cut": table.cut, "t": table["t"], "force.z": force}, texts={}
    )
    trace = explain(table, simulation).traces["force.z"]
    with drawn("turning-wear", height_in=5.0, rows=2, share_x=True) as (above, below):
        for axes in (above, below):
            _edge_changes(axes, table)
        _rows(above, trace.x, trace.recording, RECORDING, "dynamometer", lw=1.6)
        _rows(above, trace.x, trace.simulation, SIMULATION, "simulated, always fresh", lw=1.4)
        _rows(above, trace.x, trace.corrected, CORRECTED, "corrected", lw=1.0)
        above.set(title="Feed force, N", ylim=(0, None))
        legend(above)
        below.plot(trace.x, 1000.0 * table["tool.flank_wear"], color=INK, lw=1.1)
        below.set(title="Flank wear from microscope readings, µm", xlabel="row (1 s each)")
        below.set(xlim=(0, trace.x[-1]), ylim=(0, None))


def _rows(axes: Axes, x: Array, y: Array, colour: str, label: str, *, lw: float) -> None:
    kept = keep_peaks(y, 1200)
    axes.plot(x[kept], y[kept], color=colour, label=label, lw=lw)


def _edge_changes(axes: Axes, table: CutTable) -> None:
    for cut in table.cut[1:][np.diff(table["tool.edge"]) != 0]:
        axes.axvline(cut, color=RULE, lw=0.7)
