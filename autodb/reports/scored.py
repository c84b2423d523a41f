"""Past predictions as one picture: each cut as it was predicted, and as it was then made."""

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup

from autodb import __version__
from autodb.agent.matching.past_predictions import PastCut
from autodb.agent.matching.scoring import PredictionScores
from autodb.fitting.gaussian import NORMAL_95
from autodb.forward.limits import QUANTITIES, PredictedQuantity
from autodb.forward.scored import Scored
from autodb.reports import amounts, figures
from autodb.reports.against import PredictedMade, plot_against
from autodb.wording import msgid, phrase

PLOT_PX = 190
"""Height of one quantity."""
GAP = 0.06
"""What is left between two quantities, a share of the picture."""
SHOWN = 200
"""Cuts that are drawn, the newest ones. Chosen: more hide one another."""
NUMBERED = 24
"""Cuts up to which each has its number at the axis. Chosen: more do not fit beside each other."""
TONES = {msgid("predicted"): "corrected", msgid("made"): "simulation"}
BESIDE = 0.12
"""How far what was made stands beside what was predicted, in cuts."""


def render_scores(found: PredictionScores) -> str:
    """Return the page: a page that loads nothing from outside."""
    return figures.whole_page(
        "scored.html.j2",
        title=phrase("{machine}: predicted and made", machine=found.machine),
        machine=found.machine,
        by_basis=found.by_basis,
        plot=plot_of_scores(found),
        against=plots_against(found),
        most=SHOWN,
        made=len(found.cuts),
        scored=found.scored,
        version=__version__,
    )


def plot_of_scores(found: PredictionScores) -> Markup | None:
    """Return the picture of the newest cuts; None where nothing was sensed or measured of any."""
    cuts = [cut for cut in found.cuts if cut.scored][-SHOWN:]
    there = {one.quantity for cut in cuts for one in cut.scored}
    rows = [one for one in QUANTITIES if one.channel in there]
    if not rows:
        return None
    titles = [figures.bracketed(one.channel, one.unit) for one in rows]
    made = figures.figure(titles, x_title=phrase("Cut"), shares=[1.0] * len(rows), gap=GAP)
    for row, one in enumerate(rows, start=1):
        for trace in _traces(one, cuts):
            made.add_trace(trace, row=row, col=1)
    made.update_xaxes(range=[0.5, len(cuts) + 0.5])
    if len(cuts) <= NUMBERED:
        made.update_xaxes(dtick=1)
    label = phrase("predicted and made forces of {count} cuts with 95 % intervals", count=len(cuts))
    return figures.as_html(made, "scored", height_px=PLOT_PX * len(rows), label=label)


def plots_against(found: PredictionScores) -> list[Markup]:
    """Return for each quantity what was predicted of all cuts against what was made."""
    every = [(cut, one) for cut in found.cuts for one in cut.scored]
    plots = []
    for quantity in QUANTITIES:
        some = [(cut, one) for cut, one in every if one.quantity == quantity.channel]
        if not some:
            continue
        ends = np.array([(s.predicted.value, s.predicted.low, s.predicted.high) for _, s in some])
        made = PredictedMade(
            title=quantity.channel,
            unit=quantity.unit,
            label=[f"{cut.job}, {cut.name}" for cut, _ in some],
            predicted=ends[:, 0],
            low=ends[:, 1],
            high=ends[:, 2],
            made=np.array([s.made for _, s in some]),
            made_sd=np.array([s.sd or 0.0 for _, s in some]),
            held=np.array([s.held for _, s in some]),
        )
        inside = int(np.sum(made.held))
        words = phrase(
            "{inside} of {count} lie in their predicted interval", inside=inside, count=len(some)
        )
        plots.append(plot_against(f"against-{quantity.channel}", made, words=words))
    return plots


def _traces(one: PredictedQuantity, cuts: Sequence[PastCut]) -> list[go.Scatter]:
    """Return what was predicted with its interval, and what was made with its own."""
    places, some, names = [], [], []
    for number, cut in enumerate(cuts, start=1):
        for scored in cut.scored:
            if scored.quantity == one.channel:
                places.append(float(number))
                some.append(scored)
                names.append(f"{cut.job}, {cut.name}")
    scale = figures.plot_scale(one.unit)
    asked = scale * np.array([(s.predicted.value, s.predicted.low, s.predicted.high) for s in some])
    half = scale * np.array([NORMAL_95 * (s.sd or 0.0) for s in some])
    x, value, low, high = np.array(places), asked[:, 0], asked[:, 1], asked[:, 2]
    made = scale * np.array([s.made for s in some])
    hover = [_hover(name, s, one.unit) for name, s in zip(names, some, strict=True)]
    return [
        _marks(x - BESIDE, np.array([value, low, high]), "predicted", hover),
        _marks(x + BESIDE, np.array([made, made - half, made + half]), "made", hover),
    ]


def _hover(name: str, one: Scored, unit: str) -> str:
    ends = amounts.span(one.predicted.low, one.predicted.high, unit)
    value = amounts.number(figures.plot_scale(unit) * one.predicted.value)
    predicted = phrase("predicted {value} ({reach})", value=value, reach=ends)
    made = phrase("made {value}", value=amounts.quantity(one.made, unit))
    return "<br>".join((figures.plain_text(name), predicted, made))


def _marks(x: figures.Array, ends: figures.Array, name: str, hover: list[str]) -> go.Scatter:
    """Return marks at values with their intervals: ``ends`` (3, n), value, low and high."""
    value, low, high = ends
    tone = figures.colour(TONES[name])
    bars = {
        "type": "data", "symmetric": False, "array": high - value, "arrayminus": value - low,
        "color": tone, "thickness": 1.6, "width": 3,
    }  # fmt: skip
    return go.Scatter(
        x=x,
        y=value,
        mode="markers",
        name=phrase(name),
        marker={"color": tone, "size": 7},
        error_y=bars,
        text=hover,
        hoverinfo="text",
    )
