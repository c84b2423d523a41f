"""Figures of the EMPS recording: effort and model, residual, filters, what explain finds."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from autodb import signals
from autodb.explain import explain
from autodb.explain.answer import ChannelTrace
from autodb.records import source as records
from autodb.records.tables import Recording
from autodb.reports.figures import keep_peaks, thinned
from autodb.sensing.drives import feed_axis
from autodb.sensing.drives.fit.axis_model import Identified, IdentifiedTerm, PlainFit
from autodb.sensing.drives.moves.motion import AxisMotion, axis_motion
from docs.make.style import CORRECTED, INK, MUTED, RECORDING, SHADE, SIMULATION, drawn, legend

Array = NDArray[np.float64]

PUBLISHED = {
    "inertia": ("inertia M, kg", 1000.0, 95.1089, 0.1085),
    "viscous": ("viscous F_v, N·s/m", 1000.0, 203.5034, 1.146),
    "coulomb": ("Coulomb F_c, N", 1.0, 20.3935, 0.1012),
    "gravity": ("offset, N", 1.0, -3.1648, 0.0444),
}
"""Title, factor from the drive model's unit, value and standard deviation: Janot, Gautier, Brunot
2019, symmetric model."""
DIRECTION_DEPENDENT = ("inertia", "viscous", "coulomb", "asymmetry")
PUBLISHED_FRICTION = {1: (20.1440, 0.1667061), -1: (20.6277, 0.2404236)}
"""Coulomb N and viscous N·s/mm by direction: Janot 2019, direction-dependent model."""
LINE_POINTS = 1400
SHOWN_S = 10.0
STEADY_MM_S2 = 100.0
"""Acceleration below which the axis counts as moving at constant speed, for the figure."""
TURN_MM = 2.5
"""Travel of one motor turn (data sheet of the recording)."""


def draw(data: Path, columns: Path) -> None:
    """Draw every figure of the EMPS recording."""
    moves = records.read(data, columns=columns)
    assert isinstance(moves, Recording)
    model = feed_axis.identify(moves)
    fitted = feed_axis.predict_effort(moves, "x", model.terms)
    cutoff_hz = model.protocol.cutoff_hz
    effort = signals.lowpass(moves[model.channel], rate_hz=moves.rate_hz, cutoff_hz=cutoff_hz)
    _effort(moves.t_s, effort, fitted)
    _over_position(axis_motion(moves, "x", cutoff_hz=cutoff_hz), effort - fitted)
    _friction(feed_axis.identify(moves, terms=DIRECTION_DEPENDENT))
    _spread(feed_axis.spread_over_filters(moves))
    _left_out(moves, model.terms)


def _effort(t_s: Array, effort: Array, fitted: Array) -> None:
    part = slice(*np.searchsorted(t_s, (0.0, SHOWN_S)))
    t_s, effort, fitted = t_s[part], effort[part], fitted[part]
    with drawn("emps-effort", height_in=4.6, rows=2, share_x=True) as (above, below):
        _line(above, t_s, effort, RECORDING, "recorded", lw=2.6)
        _line(above, t_s, fitted, SIMULATION, "model of four terms", lw=0.9)
        above.set(title="Drive force, N")
        legend(above)
        _line(below, t_s, effort - fitted, CORRECTED, "", lw=1.0)
        below.set(title="Recorded − model, N", xlabel="time, s", xlim=(0, SHOWN_S))


def _line(axes: Axes, x: Array, y: Array, colour: str, label: str, *, lw: float) -> None:
    kept = keep_peaks(y, LINE_POINTS)
    axes.plot(x[kept], y[kept], color=colour, label=label, lw=lw)


def _over_position(moved: AxisMotion, residual: Array) -> None:
    """Residual at steady speed by direction: its mean over each motor turn, and over one turn."""
    steady = np.abs(moved.acceleration) < STEADY_MM_S2
    with drawn("emps-residual", height_in=4.8, rows=2) as (travel, turn):
        for sign, colour, label in ((1, SIMULATION, "forwards"), (-1, CORRECTED, "backwards")):
            rows = np.flatnonzero(steady & (sign * moved.velocity > 10.0))
            position, left = moved.position[rows], residual[rows]
            few = thinned(left)[::2]
            travel.plot(position[few], left[few], ".", color=colour, ms=2.2, alpha=0.4)
            travel.plot(*_means(position, left, step=TURN_MM), color=colour, lw=1.8, label=label)
            slow = left - _slow(position, left)
            turn.plot(*_means(position % TURN_MM, slow, step=0.05), color=colour, lw=1.8)
        travel.set(title="Recorded − model, N", xlabel="position, mm", ylim=(-8, 8))
        turn.set(title="The same over one motor turn, its mean over each turn taken off, N")
        turn.set(xlabel="position within a turn of 2.5 mm, mm", xlim=(0, TURN_MM))
        legend(travel)
        for axes in (travel, turn):
            axes.axhline(0, color=MUTED, lw=0.8)


def _friction(model: Identified) -> None:
    """Friction over speed in both directions with its 95 % interval, and the published law."""
    assert model.steady is not None
    speed = np.linspace(1.0, model.steady.off_law.highest_mm_s, 120)
    with drawn("emps-friction", height_in=3.6) as (axes,):
        for sign, colour, label in ((1, SIMULATION, "forwards"), (-1, CORRECTED, "backwards")):
            value, sd = model.steady.friction(sign * speed)
            low, high = sign * value - 1.96 * sd, sign * value + 1.96 * sd
            axes.fill_between(speed, low, high, color=colour, alpha=0.25, lw=0)
            axes.plot(speed, sign * value, color=colour, lw=1.6, label=label)
            coulomb, viscous = PUBLISHED_FRICTION[sign]
            axes.plot(speed, coulomb + viscous * speed, color=MUTED, lw=0.9, ls="--")
        axes.plot([], [], color=MUTED, lw=0.9, ls="--", label="published law")
        axes.set(title="Friction against the motion, N", xlabel="speed, mm/s")
        axes.set(xlim=(0, float(speed[-1])))
        legend(axes)


def _slow(position: Array, values: Array) -> Array:
    """Return, for every row, the mean of ``values`` over the motor turn that it lies in."""
    centres, means = _means(position, values, step=TURN_MM)
    return np.interp(position, centres, means)


def _means(x: Array, y: Array, *, step: float) -> tuple[Array, Array]:
    """Return centres and means of ``y`` over bins of ``x`` that hold at least 20 rows."""
    place = np.floor(x / step).astype(np.intp)
    names, index, count = np.unique(place, return_inverse=True, return_counts=True)
    means = np.bincount(index, weights=y) / count
    enough = count >= 20
    return np.asarray((names[enough] + 0.5) * step, dtype=np.float64), means[enough]


def _spread(spread: list[PlainFit]) -> None:
    with drawn("emps-filters", height_in=4.4, rows=2, columns=2) as panels:
        for axes, (term, (title, factor, value, sd)) in zip(panels, PUBLISHED.items(), strict=True):
            band = (value - 2 * sd, value + 2 * sd)
            axes.axhspan(*band, color=SHADE, alpha=0.35, lw=0, label="published ± 2 sd")
            axes.axhline(value, color=INK, lw=0.8)
            for anti_alias, colour in ((True, CORRECTED), (False, SIMULATION)):
                chosen = [m for m in spread if m.protocol.anti_alias is anti_alias]
                hz = [m.protocol.cutoff_hz for m in chosen]
                values = [factor * m.value(term) for m in chosen]
                label = f"{'with' if anti_alias else 'without'} anti-alias filter"
                axes.plot(hz, values, "o-", color=colour, ms=4, label=label)
            axes.set(title=title, xlim=(40, 210), xticks=[50, 100, 150, 200])
        for axes in panels[2:]:
            axes.set_xlabel("low-pass, Hz")
        figure = panels[0].get_figure()
        assert figure is not None
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)


def _left_out(moves: Recording, terms: tuple[IdentifiedTerm, ...]) -> None:
    """A simulation without Coulomb friction: what is missing, and what is left after explain."""
    kept = [term for term in terms if term.term != "coulomb"]
    effort = feed_axis.predict_effort(moves, "x", kept)
    simulation = Recording(path=moves.path, channels={"t": moves.t_s, "x.drive_force": effort})
    trace: ChannelTrace = explain(moves, simulation).traces["x.drive_force"]
    with drawn("emps-explain", height_in=4.6, rows=2, share_x=True) as (above, below):
        part = slice(*np.searchsorted(trace.x, (0.0, SHOWN_S)))
        t_s, missing = trace.x[part], (trace.recording - trace.simulation)[part]
        _line(above, t_s, missing, RECORDING, "recorded − simulated", lw=1.0)
        _line(above, t_s, (trace.corrected - trace.simulation)[part], SIMULATION, "found", lw=1.4)
        above.set(title="What the simulation leaves out, N", ylim=(-55, 70))
        legend(above)
        _line(below, t_s, (trace.recording - trace.corrected)[part], CORRECTED, "", lw=1.0)
        below.set(
            title="Recorded − corrected, N", xlabel="time, s", xlim=(0, SHOWN_S), ylim=(-55, 70)
        )
