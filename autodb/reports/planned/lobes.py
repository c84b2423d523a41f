"""Stability lobes of a job's cuts as a picture: limiting depth over speed, and the planned cut."""

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup

from autodb import __version__
from autodb.agent.answer.bounds.stable import StableCut
from autodb.files.job import Job
from autodb.reports import figures
from autodb.wording import amount_words, localized, phrase, shop_amount

PLOT_PX = 360
TOP = 3.0
"""How far a picture goes, in the median of the lobes: farther they would be pressed flat. Chosen.
"""
ABOVE = 1.2
"""How far it goes at least above the planned depth. Chosen."""


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
        "name": one.stable.name or phrase("cut {number}", number=f"{number}"),
        "plot": _plot(number, one),
        "lines": [one.stable.words, loads, *one.stable.notes, *_above(one)],
    }


def _top_mm(one: StableCut) -> float:
    """Return up to which depth a picture goes."""
    its = one.stable
    lobes = np.array(its.limit_mm)
    lobes = lobes[np.isfinite(lobes)]
    middle = float(np.median(lobes)) if len(lobes) else its.any_speed_mm.value
    return max(TOP * middle, ABOVE * its.planned_mm)


def _above(one: StableCut) -> tuple[str, ...]:
    """Say how far the upper end of the interval goes where it leaves the picture."""
    high = np.array(one.stable.high_mm)
    high = high[np.isfinite(high)]
    if not len(high) or float(np.max(high)) <= _top_mm(one):
        return ()
    return (
        phrase(
            "the picture ends at {top}; the upper end of the interval lies above it, at {least} to "
            "{most}",
            top=amount_words(_top_mm(one), "mm", ".3g"),
            least=localized(f"{shop_amount(float(np.min(high)), 'mm')[0]:.3g}"),
            most=amount_words(float(np.max(high)), "mm", ".3g"),
        ),
    )


def _plot(number: int, one: StableCut) -> Markup:
    its = one.stable
    loads = None if one.loads is None else one.loads.value
    top = _top_mm(one)
    speed = np.array(its.speeds_rpm)
    made = figures.figure([phrase("Depth of cut [mm]")], x_title=phrase("Spindle speed [rpm]"))
    for name, values, tone in (
        (phrase("limit, low end"), its.low_mm, "muted"),
        (phrase("limit"), its.limit_mm, "corrected"),
        (phrase("limit, high end"), its.high_mm, "muted"),
    ):
        depth = np.minimum(np.array(values), 2.0 * top)
        made.add_trace(figures.line_trace(speed, depth, tone=tone, name=name), row=1, col=1)
    if loads is not None and loads <= top:
        across = figures.line_trace(
            speed[[0, -1]],
            np.array([loads, loads]),
            tone="warn",
            name=phrase("machine's limits, 95 %"),
        )
        made.add_trace(across, row=1, col=1)
    planned = go.Scatter(
        x=[its.speed_rpm], y=[its.planned_mm], mode="markers", name=phrase("planned"),
        marker={"color": figures.colour("ink"), "size": 10, "symbol": "x"},
    )  # fmt: skip
    made.add_trace(planned, row=1, col=1)
    made.update_yaxes(range=[0.0, top])
    label = phrase("stability lobes of cut {number}, with 95 % intervals", number=f"{number}")
    return figures.as_html(made, f"lobes-{number}", height_px=PLOT_PX, label=label)
