"""Stability lobes of a job's cuts as a picture: limiting depth over speed, and the planned cut."""

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup

from autodb import __version__
from autodb.agent.answer.bounds.stable import StableCut
from autodb.files.job import Job
from autodb.reports import figures

PLOT_PX = 360
TOP = 4.0
"""How far a picture goes above what any speed is stable to. Chosen."""


def render_lobes(job: Job, cuts: Sequence[StableCut]) -> str:
    """Return the page: a page that loads nothing from outside."""
    return figures.whole_page(
        "lobes.html.j2",
        title=f"{job.name}: stability",
        name=job.name,
        pair=f"{job.material} / {job.tool}",
        cuts=[_shown(k, one) for k, one in enumerate(cuts, start=1)],
        version=__version__,
    )


def _shown(number: int, one: StableCut) -> dict[str, object]:
    loads = one.why if one.loads is None else one.loads.statement
    return {
        "name": one.stable.name or f"cut {number}",
        "plot": _plot(number, one),
        "lines": [one.stable.words, loads, *one.stable.notes],
    }


def _plot(number: int, one: StableCut) -> Markup:
    its = one.stable
    loads = None if one.loads is None else one.loads.value
    top = max(TOP * its.any_speed_mm.high, 1.2 * its.planned_mm)
    speed = np.array(its.speeds_rpm)
    made = figures.figure(["Depth of cut [mm]"], x_title="Spindle speed [rpm]")
    for name, values, tone in (
        ("limit, low end", its.low_mm, "muted"),
        ("limit", its.limit_mm, "corrected"),
        ("limit, high end", its.high_mm, "muted"),
    ):
        depth = np.minimum(np.array(values), 2.0 * top)
        made.add_trace(figures.line_trace(speed, depth, tone=tone, name=name), row=1, col=1)
    if loads is not None and loads <= top:
        across = figures.line_trace(
            speed[[0, -1]], np.array([loads, loads]), tone="warn", name="machine's limits, 95 %"
        )
        made.add_trace(across, row=1, col=1)
    planned = go.Scatter(
        x=[its.speed_rpm], y=[its.planned_mm], mode="markers", name="planned",
        marker={"color": figures.colour("ink"), "size": 10, "symbol": "x"},
    )  # fmt: skip
    made.add_trace(planned, row=1, col=1)
    made.update_yaxes(range=[0.0, top])
    label = f"stability lobes of cut {number}, with 95 % intervals"
    return figures.as_html(made, f"lobes-{number}", height_px=PLOT_PX, label=label)
