"""Stability lobes of a job's cuts as a picture: limiting depth over speed, and the planned cut."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup
from numpy.typing import NDArray

from autodb import __version__
from autodb.agent.answer.bounds.stable import StableCut, loads_words, why_of_all
from autodb.files.job import Job
from autodb.forward.limits import probability_words
from autodb.forward.stability.depths import NEAR, depth_words
from autodb.reports import figures
from autodb.wording import amount_words, localized, phrase, shop_amount

Array = NDArray[np.float64]

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
        title=phrase("{job}: stability", job=job.name),
        name=job.name,
        pair=f"{job.material} / {job.tool}",
        **shown_lobes(cuts),
        version=__version__,
    )


def shown_lobes(cuts: Sequence[StableCut]) -> dict[str, Any]:
    """Return what a template shows: of each cut its picture, figures and lines; lines of all."""
    whys = why_of_all(cuts)
    return {
        "cuts": [
            {
                "name": one.stable.name or phrase("cut {number}", number=f"{number}"),
                "plot": _plot(number, one),
                "figures": _figures(one),
                "lines": [*loads_words(one, whys), *one.stable.notes, *_above(one)],
            }
            for number, one in enumerate(cuts, start=1)
        ],
        "of_all": list(whys),
    }


def _figures(one: StableCut) -> list[tuple[str, list[str]]]:
    """Return what a planner reads of a cut: what it is, and how much, a line each."""
    its = one.stable
    planned = phrase(
        "{depth} at {speed}",
        depth=amount_words(its.planned_mm, "mm", ".3g"),
        speed=amount_words(its.speed_rpm, "rpm", ".0f"),
    )
    nothing = phrase(
        "none from {low} to {high} times the planned one",
        low=localized(f"{NEAR[0]:g}"),
        high=localized(f"{NEAR[1]:g}"),
    )
    said: list[tuple[str, list[str]]] = [(phrase("Planned"), [planned])]
    if its.depth_mm is None:
        said.append((phrase("Stable up to"), [phrase("any depth")]))
    else:
        chatter = amount_words(its.chatter_Hz or 0.0, "Hz", ".0f")
        said += [
            (phrase("Stable up to"), [depth_words(its.depth_mm)]),
            (phrase("Chance that it chatters"), [probability_words(its.chance)]),
            (phrase("Chatter frequency"), [chatter]),
        ]
    said.append((phrase("Stable at any speed up to"), [depth_words(its.any_speed_mm)]))
    return [*said, (phrase("Better speeds nearby"), its.better_words or [nothing])]


def _depths(values: Sequence[float | None]) -> Array:
    """Return depths as numbers, infinite where none limits."""
    return np.array([np.inf if one is None else one for one in values])


def _top_mm(one: StableCut) -> float:
    """Return up to which depth a picture goes."""
    its = one.stable
    lobes = _depths(its.limit_mm)
    lobes = lobes[np.isfinite(lobes)]
    middle = float(np.median(lobes)) if len(lobes) else its.any_speed_mm.value
    return max(TOP * middle, ABOVE * its.planned_mm)


def _above(one: StableCut) -> tuple[str, ...]:
    """Say how far the upper end of the interval goes where it leaves the picture."""
    high = _depths(one.stable.high_mm)
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
    scale = figures.plot_scale("mm")
    title = figures.bracketed(phrase("Depth of cut"), "mm")
    made = figures.figure([title], x_title=phrase("Spindle speed [rpm]"))
    for name, values, tone in (
        (phrase("limit, low end"), its.low_mm, "muted"),
        (phrase("limit"), its.limit_mm, "corrected"),
        (phrase("limit, high end"), its.high_mm, "muted"),
    ):
        depth = scale * np.minimum(_depths(values), 2.0 * top)
        made.add_trace(figures.line_trace(speed, depth, tone=tone, name=name), row=1, col=1)
    if loads is not None and loads <= top:
        across = figures.line_trace(
            speed[[0, -1]],
            scale * np.array([loads, loads]),
            tone="warn",
            name=phrase("machine's limits, 95 %"),
        )
        made.add_trace(across, row=1, col=1)
    planned = go.Scatter(
        x=[its.speed_rpm], y=[scale * its.planned_mm], mode="markers", name=phrase("planned"),
        marker={"color": figures.colour("ink"), "size": 10, "symbol": "x"},
    )  # fmt: skip
    made.add_trace(planned, row=1, col=1)
    made.update_yaxes(range=[0.0, scale * top])
    label = phrase("stability lobes of cut {number}, with 95 % intervals", number=f"{number}")
    return figures.as_html(made, f"lobes-{number}", height_px=PLOT_PX, label=label)
