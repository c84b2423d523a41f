"""What was predicted, with its interval, against what was then made."""

from dataclasses import dataclass

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup
from numpy.typing import NDArray

from autodb.reports import amounts, figures
from autodb.wording import phrase

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

PLOT_PX = 360


@dataclass(frozen=True)
class PredictedMade:
    """A quantity of cuts (n,) in ``unit``: predicted with its 95 % interval, and as it was made.

    ``made`` is NaN where it was neither measured nor sensed; ``made_sd`` its standard deviation;
    ``held``: whether the interval holds it.
    """

    title: str
    unit: str
    label: list[str]
    predicted: Array
    low: Array
    high: Array
    made: Array
    made_sd: Array
    held: Flags


def plot_against(name: str, one: PredictedMade, *, words: str) -> Markup:
    """Return the plot of predicted against made, of a page's id; ``words`` say what it shows."""
    scale = figures.plot_scale(one.unit)
    made = figures.figure(
        [figures.bracketed(phrase("{quantity} predicted", quantity=one.title), one.unit)],
        x_title=figures.bracketed(phrase("{quantity} measured", quantity=one.title), one.unit),
    )
    sensed = np.isfinite(one.made)
    for rows, tone, called in (
        (sensed & one.held, "corrected", phrase("inside")),
        (sensed & ~one.held, "warn", phrase("outside")),
    ):
        if np.any(rows):
            made.add_trace(_intervals(one, rows, tone, called))
    if np.any(sensed):
        everything = np.concatenate([one.low[sensed], one.high[sensed], one.made[sensed]])
        ends = scale * np.array([np.min(everything), np.max(everything)])
        dash = {"dash": "dash", "width": 1}
        made.add_trace(
            figures.line_trace(
                ends, ends, tone="muted", name=phrase("exactly as predicted"), line=dash
            )
        )
    return figures.as_html(made, name, height_px=PLOT_PX, label=f"{one.title}: {words}")


def _intervals(one: PredictedMade, rows: Flags, tone: str, name: str) -> go.Scatter:
    kept = np.flatnonzero(rows)
    kept = kept[figures.thinned(one.made[kept])]
    predicted, scale = one.predicted[kept], figures.plot_scale(one.unit)
    return figures.points(
        scale * one.made[kept],
        scale * predicted,
        tone=tone,
        name=name,
        text=[_hover(one, row) for row in kept],
        hoverinfo="text",
        error_y={
            "type": "data",
            "symmetric": False,
            "array": scale * (one.high[kept] - predicted),
            "arrayminus": scale * (predicted - one.low[kept]),
            "color": figures.colour(tone),
            "thickness": 1.2,
            "width": 3,
        },
    )


def _hover(one: PredictedMade, row: np.intp) -> str:
    reach = amounts.span(float(one.low[row]), float(one.high[row]), one.unit)
    made = amounts.number(figures.plot_scale(one.unit) * float(one.made[row]))
    sd = amounts.quantity(2.0 * float(one.made_sd[row]), one.unit)
    lines = (
        phrase("predicted {reach}", reach=reach),
        phrase("measured {value} ± {sd}", value=made, sd=sd),
    )
    return "<br>".join((figures.plain_text(one.label[row]), *lines))
