"""The plots of a card: reference over estimate, and what is left against every input."""

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup
from numpy.typing import NDArray

from autodb.reports import figures
from autodb.reports.card.axis_figures import AxisCard
from autodb.wording import phrase, presentation

Array = NDArray[np.float64]

PLOT_PX, SMALL_PX = 310, 210


def sensed_as(axis: AxisCard) -> str:
    """Return what the axis senses: a torque, or which force."""
    c = axis.calibration
    return phrase("Torque") if c.unit == "N·m" else figures.force_of(c.component)


def reference_over_estimate(axis: AxisCard, *, id_: str) -> Markup:
    """Draw the reference over the estimate of cuts left out, and the line where both agree.

    ``id_``: the axis' name within the page.
    """
    c = axis.calibration
    made = figures.figure(
        [figures.bracketed(phrase("{quantity}, reference", quantity=sensed_as(axis)), c.unit)],
        x_title=figures.bracketed(
            phrase("{quantity}, estimate of held-out cuts", quantity=sensed_as(axis)), c.unit
        ),
    )
    scale = figures.plot_scale(c.unit)
    estimate, target = scale * axis.estimate, scale * axis.target
    everything = np.concatenate([estimate, target])
    ends = np.array([np.min(everything), np.max(everything)])
    same = {"dash": "dash", "width": 1}
    made.add_trace(
        figures.line_trace(ends, ends, tone="muted", name=phrase("agreement"), line=same)
    )
    _add(made, axis, estimate, target)
    label = phrase("{axis}: reference over the estimate of held-out cuts", axis=c.axis)
    return figures.as_html(made, f"{id_}-agreement", height_px=PLOT_PX, label=label)


def residuals(axis: AxisCard, *, id_: str) -> tuple[list[Markup], list[str]]:
    """Draw reference less estimate against every input; return also the inputs that show nothing.

    Those are not known in all cuts, or the same in all.
    """
    c, sensed = axis.calibration, axis.sensed
    inputs = (
        (phrase("Current"), c.current_unit, sensed.current),
        (phrase("Feed speed"), "mm/s", sensed.feed_mm_s),
        (phrase("Spindle speed"), "rpm", sensed.speed_rpm),
        (phrase("Feed"), "mm/rev", sensed.feed_mm),
        (phrase("Depth of cut"), "mm", sensed.depth_mm),
        (phrase("Spindle temperature"), "°C", sensed.temperature_C),
        (phrase("Cut, in the order of the table"), "", axis.order),
    )
    drawn, still = [], []
    for number, (name, unit, values) in enumerate(inputs):
        if np.isfinite(values).all() and np.ptp(values) > 0.0:
            shown = figures.bracketed(name, unit), figures.plot_scale(unit) * values
            drawn.append(_against(axis, *shown, id_=f"{id_}-left-{number}"))
        else:
            still.append(name.lower() if presentation().language == "en" else name)
    return drawn, still


def _against(axis: AxisCard, name: str, values: Array, *, id_: str) -> Markup:
    c = axis.calibration
    title = figures.bracketed(phrase("Residual"), c.unit)
    made = figures.figure([title], x_title=name)
    _add(made, axis, values, figures.plot_scale(c.unit) * (axis.target - axis.estimate))
    label = phrase("{axis}: reference less estimate against {input}", axis=c.axis, input=name)
    return figures.as_html(made, id_, height_px=SMALL_PX, label=label)


def _add(made: go.Figure, axis: AxisCard, x: Array, y: Array) -> None:
    """Add the cuts, those excluded in another tone; each says its number."""
    for rows, tone, name in (
        (~axis.sudden, "corrected", phrase("cut")),
        (axis.sudden, "warn", phrase("transient, cut")),
    ):
        if rows.any():
            kept = np.flatnonzero(rows)[figures.thinned(y[rows])]
            text = [f"{name} {axis.cut[row]:g}" for row in kept]
            made.add_trace(
                figures.points(x[kept], y[kept], tone=tone, name=name, text=text,
                               hoverinfo="x+y+text")
            )  # fmt: skip
