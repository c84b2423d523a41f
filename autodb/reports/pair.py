"""Pictures of a pair: its forces over feed and depth, with the limits of the machine drawn in."""

from collections.abc import Mapping

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup
from scipy.special import ndtri

from autodb.agent.answer.force_map import ForceMap, Layer
from autodb.forward.limits import probability_words
from autodb.reports import figures
from autodb.reports.page import translucent

MAP_PX = 380
SURE = 1e-12
"""Chances nearer to none or all are drawn as this."""
CHANCES = ((0.05, "dot"), (0.5, "solid"))
"""Chances to exceed a limit that are drawn as lines, and how."""
WORDS = {
    "torque.spindle": "Spindle torque", "spindle.power": "Cutting power",
}  # fmt: skip
ACROSS = {
    "depth_mm": "Depth [mm]", "speed_m_min": "Cutting speed [m/min]", "speed_rpm": "Speed [rpm]",
}  # fmt: skip
FEED = {"feed_mm_rev": "Feed [mm/rev]", "feed_mm_tooth": "Feed [mm/tooth]"}


def _quantity(layer: Layer, operation: str) -> str:
    channel = layer.quantity.channel
    return WORDS.get(channel) or figures.force_title(channel[-1], [operation])


def title(layer: Layer, operation: str) -> str:
    """Return what a layer is called, with its limit."""
    name = f"{_quantity(layer, operation)} [{layer.quantity.unit}]"
    limit = "" if layer.limit is None else f", limit {layer.limit:g} {layer.quantity.unit}"
    return f"{name}{limit}"


def force_map_plots(found: ForceMap) -> list[tuple[str, Markup]]:
    """Return a map of each quantity, as words and plot; of a force that is nowhere, none."""
    return [
        (_quantity(layer, found.cut.operation), _map(found, layer, f"map-{n}"))
        for n, layer in enumerate(found.layers)
        if np.any(np.abs(layer.mean) > 0.0)
    ]


def _map(found: ForceMap, layer: Layer, name: str) -> Markup:
    made = figures.figure([title(layer, found.cut.operation)], x_title=FEED[found.feed_key])
    over = {"x": found.feeds, "y": found.across}
    made.add_trace(
        go.Contour(
            **over, z=np.abs(layer.mean), name="mean", showscale=False, ncontours=12,
            contours={
                "coloring": "none", "showlabels": True, "labelformat": ".3~r",
                "labelfont": {"color": figures.colour("ink"), "size": 12},
            },
            line={"color": figures.colour("corrected"), "width": 1.5},
            hovertemplate=f"feed %{{x:.3g}}, across %{{y:.3g}}: %{{z:.4g}} {layer.quantity.unit}"
            "<extra></extra>",
        )
    )  # fmt: skip
    for chance, dash in CHANCES:
        if layer.chance.min() < chance < layer.chance.max():
            made.add_trace(_line(over, layer, chance, dash))
    _draw_range(made, found)
    here = [getattr(found.cut, key) for key in (found.feed_key, found.across_key)]
    made.add_trace(
        figures.points(
            np.array(here[:1]), np.array(here[1:]), tone="simulation", name="this cut",
            marker={"size": 11, "symbol": "cross", "color": figures.colour("simulation")},
        )
    )  # fmt: skip
    made.update_yaxes(
        title={"text": ACROSS[found.across_key], "font": {"size": 13}}, zeroline=False
    )
    return figures.as_html(made, name, height_px=MAP_PX, label=_label(found, layer))


def _line(over: Mapping[str, object], layer: Layer, chance: float, dash: str) -> go.Contour:
    """Return the line of a chance, drawn where its normal quantile is: that is nearly straight."""
    level = float(ndtri(chance))
    return go.Contour(
        **over,
        z=ndtri(np.clip(layer.chance, SURE, 1.0 - SURE)),
        name=f"{100 * chance:g} % chance to exceed the limit",
        showscale=False,
        contours={"coloring": "none", "start": level, "end": level, "size": 1.0},
        line={"color": figures.colour("warn"), "width": 3, "dash": dash, "smoothing": 1.0},
        hoverinfo="skip",
    )


def _draw_range(made: go.Figure, found: ForceMap) -> None:
    """Draw what the pair was learnt from."""
    if found.cut_range is not None:
        (x0, x1), (y0, y1) = found.cut_range
        made.add_shape(
            type="rect", x0=x0, x1=x1, y0=y0, y1=y1, fillcolor=translucent("simulation"),
            line={"color": figures.colour("simulation"), "width": 1.5, "dash": "dash"},
        )  # fmt: skip


def _label(found: ForceMap, layer: Layer) -> str:
    low, high = np.min(np.abs(layer.mean)), np.max(np.abs(layer.mean))
    reach = figures.span(float(low), float(high), layer.quantity.unit)
    most = float(layer.chance.max())
    risk = "" if layer.limit is None else f"; at most {probability_words(most)} chance to exceed it"
    axes = f"{FEED[found.feed_key]} and {ACROSS[found.across_key]}"
    return f"{title(layer, found.cut.operation)} over {axes}: {reach}{risk}"
