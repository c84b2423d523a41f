"""Pictures of a pair: its forces over feed and depth, with the limits of the machine drawn in."""

from collections.abc import Mapping

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup
from scipy.special import ndtri

from autodb.agent.answer.force_map import ForceMap, Layer
from autodb.forward.limits import probability_words
from autodb.reports import amounts, figures
from autodb.reports.page import translucent
from autodb.wording import amount_words, msgid, phrase, shop_amount

MAP_PX = 380
SURE = 1e-12
"""Chances nearer to none or all are drawn as this."""
CHANCES = ((0.05, "dot"), (0.5, "solid"))
"""Chances to exceed a limit that are drawn as lines, and how."""
AXES = {
    "depth_mm": (msgid("Depth"), "mm"),
    "speed_m_min": (msgid("Cutting speed"), "m/min"),
    "speed_rpm": (msgid("Speed"), "rpm"),
    "feed_mm_rev": (msgid("Feed"), "mm/rev"),
    "feed_mm_tooth": (msgid("Feed"), "mm/tooth"),
}
"""What axes are called, and their units."""


def _quantity(layer: Layer, operation: str) -> str:
    return figures.quantity_title(layer.quantity.channel, [operation])


def _axis(key: str) -> str:
    name, unit = AXES[key]
    return figures.bracketed(phrase(name), unit)


def title(layer: Layer, operation: str) -> str:
    """Return what a layer is called, with its limit."""
    unit = layer.quantity.unit
    name = figures.bracketed(_quantity(layer, operation), unit)
    if layer.limit is None:
        return name
    return phrase("{quantity}, limit {limit}", quantity=name, limit=amount_words(layer.limit, unit))


def force_map_plots(found: ForceMap) -> list[tuple[str, Markup]]:
    """Return a map of each quantity, as words and plot; of a force that is nowhere, none."""
    return [
        (_quantity(layer, found.cut.operation), _map(found, layer, f"map-{n}"))
        for n, layer in enumerate(found.layers)
        if np.any(np.abs(layer.mean) > 0.0)
    ]


def _map(found: ForceMap, layer: Layer, name: str) -> Markup:
    made = figures.lone_figure(
        title(layer, found.cut.operation),
        x_title=_axis(found.feed_key),
        y_axis={
            "title": {"text": _axis(found.across_key), "font": {"size": 13}},
            "zeroline": False,
        },
    )
    x_scale, y_scale = (
        figures.plot_scale(AXES[key][1]) for key in (found.feed_key, found.across_key)
    )
    over = {"x": x_scale * found.feeds, "y": y_scale * found.across}
    scale, unit = shop_amount(1.0, layer.quantity.unit)
    made.add_trace(
        go.Contour(
            **over, z=scale * np.abs(layer.mean), name=phrase("mean"), showscale=False,
            ncontours=12,
            contours={
                "coloring": "none", "showlabels": True, "labelformat": ".3~r",
                "labelfont": {"color": figures.colour("ink"), "size": 12},
            },
            line={"color": figures.colour("corrected"), "width": 1.5},
            hovertemplate=phrase(
                "feed {x}, across {y}: {z}", x="%{x:.3g}", y="%{y:.3g}", z=f"%{{z:.4g}} {unit}"
            )
            + "<extra></extra>",
        )
    )  # fmt: skip
    for chance, dash in CHANCES:
        if layer.chance.min() < chance < layer.chance.max():
            made.add_trace(_line(over, layer, chance, dash))
    _draw_range(made, found, x_scale, y_scale)
    here = [
        scale * getattr(found.cut, key)
        for scale, key in ((x_scale, found.feed_key), (y_scale, found.across_key))
    ]
    made.add_trace(
        figures.points(
            np.array(here[:1]), np.array(here[1:]), tone="simulation", name=phrase("this cut"),
            marker={"size": 11, "symbol": "cross", "color": figures.colour("simulation")},
        )
    )  # fmt: skip
    return figures.as_html(made, name, height_px=MAP_PX, label=_label(found, layer))


def _line(over: Mapping[str, object], layer: Layer, chance: float, dash: str) -> go.Contour:
    """Return the line of a chance, drawn where its normal quantile is: that is nearly straight."""
    level = float(ndtri(chance))
    return go.Contour(
        **over,
        z=ndtri(np.clip(layer.chance, SURE, 1.0 - SURE)),
        name=phrase("{chance} % chance to exceed the limit", chance=f"{100 * chance:g}"),
        showscale=False,
        contours={"coloring": "none", "start": level, "end": level, "size": 1.0},
        line={"color": figures.colour("warn"), "width": 3, "dash": dash, "smoothing": 1.0},
        hoverinfo="skip",
    )


def _draw_range(made: go.Figure, found: ForceMap, x_scale: float, y_scale: float) -> None:
    """Draw what the pair was learnt from."""
    if found.cut_range is not None:
        (x0, x1), (y0, y1) = found.cut_range
        made.add_shape(
            type="rect", x0=x_scale * x0, x1=x_scale * x1, y0=y_scale * y0, y1=y_scale * y1,
            fillcolor=translucent("simulation"),
            line={"color": figures.colour("simulation"), "width": 1.5, "dash": "dash"},
        )  # fmt: skip


def _label(found: ForceMap, layer: Layer) -> str:
    low, high = np.min(np.abs(layer.mean)), np.max(np.abs(layer.mean))
    reach = amounts.span(float(low), float(high), layer.quantity.unit)
    said = phrase(
        "{quantity} over {x} and {y}: {reach}",
        quantity=title(layer, found.cut.operation),
        x=_axis(found.feed_key),
        y=_axis(found.across_key),
        reach=reach,
    )
    if layer.limit is None:
        return said
    most = probability_words(float(layer.chance.max()))
    return phrase("{said}; at most {chance} chance to exceed it", said=said, chance=most)
