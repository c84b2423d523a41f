"""The plots of a card: reference over estimate, and what is left against every input."""

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup
from numpy.typing import NDArray

from autodb.reports import figures
from autodb.reports.card.axis_figures import AxisCard

Array = NDArray[np.float64]

PLOT_PX, SMALL_PX = 310, 210


def sensed_as(axis: AxisCard) -> str:
    """Return what the axis senses: a torque, or which force."""
    c = axis.calibration
    return "Torque" if c.unit == "N·m" else f"Force {c.component.upper()}"


def reference_over_estimate(axis: AxisCard, *, id_: str) -> Markup:
    """Draw the reference over the estimate of cuts left out, and the line where both agree.

    ``id_``: the axis' name within the page.
    """
    c = axis.calibration
    made = figures.figure(
        [f"{sensed_as(axis)}, reference [{c.unit}]"],
        x_title=f"{sensed_as(axis)}, estimate of held-out cuts [{c.unit}]",
    )
    everything = np.concatenate([axis.estimate, axis.target])
    ends = np.array([np.min(everything), np.max(everything)])
    same = {"dash": "dash", "width": 1}
    made.add_trace(figures.line_trace(ends, ends, tone="muted", name="agreement", line=same))
    _add(made, axis, axis.estimate, axis.target)
    label = f"{c.axis}: reference over the estimate of held-out cuts, {c.verdict}"
    return figures.as_html(made, f"{id_}-agreement", height_px=PLOT_PX, label=label)


def residuals(axis: AxisCard, *, id_: str) -> tuple[list[Markup], list[str]]:
    """Draw reference less estimate against every input; return also the inputs that show nothing.

    Those are not known in all cuts, or the same in all.
    """
    c, sensed = axis.calibration, axis.sensed
    inputs = (
        (f"Current [{c.current_unit}]", sensed.current),
        ("Feed speed [mm/s]", sensed.feed_mm_s),
        ("Spindle speed [rpm]", sensed.speed_rpm),
        ("Feed [mm/rev]", sensed.feed_mm),
        ("Depth of cut [mm]", sensed.depth_mm),
        ("Spindle temperature [°C]", sensed.temperature_C),
        ("Cut, in the order of the table", axis.order),
    )
    drawn, still = [], []
    for number, (name, values) in enumerate(inputs):
        if np.isfinite(values).all() and np.ptp(values) > 0.0:
            drawn.append(_against(axis, name, values, id_=f"{id_}-left-{number}"))
        else:
            still.append(name.split(" [", maxsplit=1)[0].lower())
    return drawn, still


def _against(axis: AxisCard, name: str, values: Array, *, id_: str) -> Markup:
    c = axis.calibration
    made = figures.figure([f"Residual [{c.unit}]"], x_title=name)
    _add(made, axis, values, axis.target - axis.estimate)
    label = f"{c.axis}: reference less estimate against {name}"
    return figures.as_html(made, id_, height_px=SMALL_PX, label=label)


def _add(made: go.Figure, axis: AxisCard, x: Array, y: Array) -> None:
    """Add the cuts, those excluded in another tone; each says its number."""
    for rows, tone, name in (
        (~axis.sudden, "corrected", "cut"),
        (axis.sudden, "warn", "transient, cut"),
    ):
        if rows.any():
            kept = np.flatnonzero(rows)[figures.thinned(y[rows])]
            text = [f"{name} {axis.cut[row]:g}" for row in kept]
            made.add_trace(
                figures.points(x[kept], y[kept], tone=tone, name=name, text=text,
                               hoverinfo="x+y+text")
            )  # fmt: skip
