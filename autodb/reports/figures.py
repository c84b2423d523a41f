"""What the reports share: plots as HTML, one page shell.

Plots are SVG with at most ``MAX_POINTS`` a trace. Every colour is named in ``PALETTE`` as a pair
(light, dark): figures are drawn in the light one and the style sheet exchanges it in the dark.
"""

import html
import json
import math
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
import plotly.graph_objects as go
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from numpy.typing import NDArray
from plotly.subplots import make_subplots

from autodb.cutting.turning import ROLE_WORDS, force_role
from autodb.reports import said_in_pages
from autodb.reports.amounts import number, quantity, span, suffix
from autodb.reports.plot_words import locale_config
from autodb.reports.written import library_tag
from autodb.wording import amount_words, day, localized, msgid, phrase, presentation, shop_amount

Array = NDArray[np.float64]
Index = NDArray[np.intp]

MAX_POINTS = 1200
"""Points a trace: the extremes of every second pixel of a plot; a page of three forces over time is
then below 500 kB."""
DRAWN_SHARE = 1e-4
"""Share of its range by which a number in a plot may be off: a tenth of a pixel."""
SCATTER_POINTS = 800
"""Points of a cloud: each is a mark of its own, and more hide one another."""

PALETTE: dict[str, tuple[str, str]] = {
    "paper": ("#f6f3ec", "#13181b"),
    "card": ("#fffdf9", "#1b2226"),
    "ink": ("#202c34", "#ebe7dd"),
    "muted": ("#616d75", "#a0abb1"),
    "rule": ("#ddd8cc", "#333e44"),
    "recording": ("#8e999f", "#85929a"),
    "simulation": ("#c0701d", "#e9a554"),
    "corrected": ("#0e6a75", "#55c5ca"),
    "good": ("#2c7a4e", "#6cc68f"),
    "warn": ("#b04a1c", "#f08d5c"),
    "shade": ("#e0b45f", "#e2b761"),
}
FONT = '"Avenir Next", "Segoe UI", "Helvetica Neue", Roboto, "Noto Sans", Arial, sans-serif'
CONFIG = {
    "displaylogo": False,
    "showSendToCloud": False,  # a report sends nothing anywhere
    "responsive": True,
    "modeBarButtonsToRemove": ["select2d", "lasso2d", "autoScale2d"],
}

TALL_PX = 500
"""A plot this tall can be zoomed: it has buttons, on a shorter one they would hide its title."""
BUTTONS_PX = 28
"""What a tall plot leaves above its title for the buttons."""


def force_title(component: str, operations: Iterable[str]) -> str:
    """Return the title of a force, with its name in turning where all operations give it one.

    >>> force_title("y", ["turn", "face"]), force_title("x", ["turn", "face"])
    ('Force Y (cutting force Fc)', 'Force X')
    """
    role = ROLE_WORDS[force_role(component, operations)]
    axis = component.upper()
    return phrase("Force {axis} ({role})", axis=axis, role=phrase(role)) if role else force_of(axis)


def force_of(axis: str) -> str:
    """Return what the force along an axis is called, whatever is made."""
    return phrase("Force {axis}", axis=axis.upper())


QUANTITY_TITLES = {
    "torque.spindle": msgid("Spindle torque"), "spindle.power": msgid("Cutting power"),
}  # fmt: skip


def quantity_title(channel: str, operations: Iterable[str]) -> str:
    """Return the title of a predicted quantity by its channel."""
    named = QUANTITY_TITLES.get(channel)
    return phrase(named) if named else force_title(channel[-1], operations)


def bracketed(what: str, unit: str) -> str:
    """Return the title of an axis, with its unit as the reader has it; of the unit 1 none.

    >>> bracketed("Time", "s"), bracketed("Share", "1")
    ('Time [s]', 'Share')
    """
    return what if unit in ("", "1") else f"{what} [{shop_amount(1.0, unit)[1]}]"


def plot_scale(unit: str) -> float:
    """Return how many of the reader's units one of ours is: what a plot's numbers are times it."""
    return shop_amount(1.0, unit)[0]


def colour(name: str) -> str:
    """Return the light tone of ``name``; the style sheet exchanges it in the dark."""
    return PALETTE[name][0]


def plain_text(text: str) -> str:
    """Return ``text`` so that a plot shows it as it is; plots read some HTML themselves."""
    return html.escape(text, quote=False)


# Traces


def keep_peaks(values: Array, limit: int = MAX_POINTS) -> Index:
    """Return at most ``limit`` rows of ``values`` (n,): first, last, and each bucket's extremes.

    Min-max decimation: a peak of one sample stays. A bucket without a number keeps one row, so
    that a line still breaks there.
    """
    n = len(values)
    if n <= limit:
        return np.arange(n)
    buckets = limit // 2 - 1
    width = math.ceil(n / buckets)
    padded = np.full(width * buckets, np.nan)
    padded[:n] = values
    rows = padded.reshape(buckets, width)
    start = np.arange(buckets) * width
    lowest = start + np.argmin(np.where(np.isnan(rows), np.inf, rows), axis=1)
    highest = start + np.argmax(np.where(np.isnan(rows), -np.inf, rows), axis=1)
    kept = np.unique(np.concatenate([[0, n - 1], lowest, highest]))
    return kept[kept < n]


def thinned(values: Array) -> Index:
    """Return at most ``SCATTER_POINTS`` rows: every so many, and the peaks between them.

    Peaks alone would draw a cloud of noise as two clouds with nothing between.
    """
    if len(values) <= SCATTER_POINTS:
        return np.arange(len(values))
    half = SCATTER_POINTS // 2
    evenly = np.linspace(0, len(values) - 1, half).astype(np.intp)
    return np.union1d(evenly, keep_peaks(values, half))


def line_trace(x: Array, y: Array, *, tone: str, name: str, **more: Any) -> go.Scatter:
    """Return a line; peaks are kept where it has more than ``MAX_POINTS``."""
    kept = keep_peaks(y)
    style = {"color": colour(tone), "width": 1.5, **more.pop("line", {})}
    more = {"mode": "lines", "hoverinfo": "x+y+name", **more}
    return go.Scatter(x=x[kept], y=y[kept], name=name, line=style, **more)


def broken_line(x: Array, y: Array, gaps: Index, *, tone: str, name: str) -> go.Scatter:
    """Return a line as ``line_trace`` does, broken behind each row of ``gaps``."""
    kept = keep_peaks(y)
    behind = np.searchsorted(kept, gaps, side="right")
    made = line_trace(x, y, tone=tone, name=name)
    made.x = np.insert(x[kept], behind, x[gaps])
    made.y = np.insert(y[kept], behind, np.nan)
    return made


def points(x: Array, y: Array, *, tone: str, name: str, **more: Any) -> go.Scatter:
    """Return a cloud of marks, thinned to ``SCATTER_POINTS``: half evenly, half its peaks."""
    kept = thinned(y)
    marker = {"color": colour(tone), "size": 6, "opacity": 0.8, **more.pop("marker", {})}
    more = {"hoverinfo": "x+y+name", **more}
    return go.Scatter(x=x[kept], y=y[kept], name=name, mode="markers", marker=marker, **more)


# Figures


def figure(
    titles: Sequence[str], *, x_title: str, shares: Sequence[float] = (1.0,), gap: float = 0.12
) -> go.Figure:
    """Return empty plots one above the other over one x axis; a title above each names y.

    ``gap``: what is left between two, a share of the whole.
    """
    rows = len(titles)
    return make_subplots(
        rows=rows,
        cols=1,
        shared_xaxes=True,
        vertical_spacing=gap,
        row_heights=list(shares),
        figure=go.Figure(layout=_layout(titles, x_title, [{}] * rows, [{}] * rows)),
    )


def lone_figure(title: str, *, x_title: str, y_axis: Mapping[str, Any]) -> go.Figure:
    """Return one empty plot, like a ``figure`` of one title in a fifth of its time: without rows.

    ``y_axis``: how its y axis differs.
    """
    whole = {"domain": [0.0, 1.0]}
    x, y = {**whole, "anchor": "y"}, {**whole, "anchor": "x", **y_axis}
    return go.Figure(layout=_layout([title], x_title, [x], [y]))


def _layout(
    titles: Sequence[str],
    x_title: str,
    x_axes: Sequence[Mapping[str, Any]],
    y_axes: Sequence[Mapping[str, Any]],
) -> dict[str, Any]:
    """Return the layout of plots, all at once: an update takes as long as making it.

    ``x_axes``, ``y_axes``: how the axes of each differ.
    """
    rule = {"gridcolor": colour("rule"), "linecolor": colour("rule")}
    ticks = {"ticks": "outside", "tickcolor": "#8e999f", "automargin": True}
    along = {**rule, **ticks, "showgrid": False, "zeroline": False}
    up = {**rule, "zeroline": True, "zerolinecolor": colour("muted"), "zerolinewidth": 1}
    axes = {f"xaxis{row}": {**along, **own} for row, own in enumerate(x_axes, start=1)}
    axes[f"xaxis{len(titles)}"]["title"] = {"text": _lines(x_title), "font": {"size": 13}}
    axes |= {f"yaxis{row}": {**up, **own} for row, own in enumerate(y_axes, start=1)}
    return {
        "template": "none",
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "font": {"family": FONT, "size": 13, "color": colour("muted")},
        "margin": {"l": 58, "r": 14, "t": 30, "b": 46},
        "showlegend": False,
        "hovermode": "closest",
        "hoverlabel": {
            "bgcolor": colour("ink"),
            "bordercolor": colour("ink"),
            "font": {"family": FONT, "color": colour("card")},
        },
        "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "#8e999f", "activecolor": "#c0701d"},
        "annotations": [_title_above(row, title) for row, title in enumerate(titles, start=1)],
        **axes,
    }


def _lines(text: str) -> str:
    """Break a long title, so that it fits under a plot on a telephone."""
    return "<br>".join(plain_text(part) for part in textwrap.wrap(text, 40))


def _title_above(row: int, title: str) -> dict[str, Any]:
    axis = "" if row == 1 else str(row)
    return {
        "text": plain_text(title),
        "x": 0,
        "xref": "paper",
        "xanchor": "left",
        "y": 1,
        "yref": f"y{axis} domain",
        "yanchor": "bottom",
        "yshift": 6,
        "showarrow": False,
        "font": {"color": colour("ink"), "size": 13},
    }


def shade(made: go.Figure, ranges: Iterable[tuple[float, float]]) -> None:
    """Shade stretches of the x axis in every plot of ``made``."""
    for low, high in ranges:
        made.add_vrect(
            x0=low,
            x1=high,
            fillcolor=colour("shade"),
            opacity=0.22,
            line_width=0,
            layer="below",
            row="all",
            col=1,
            exclude_empty_subplots=False,
        )


def as_html(made: go.Figure, name: str, *, height_px: int, label: str) -> Markup:
    """Return the figure as a div that fills its place; ``name`` is its id, once a page.

    It is data: the page's script draws it when the page is whole. Earlier, a plot beside others
    would be drawn as wide as the place it has while it is alone.
    """
    tall = height_px >= TALL_PX
    if tall:
        made.update_layout(margin_t=made.layout.margin.t + BUTTONS_PX)
    made.for_each_trace(_in_few_bytes)
    bar = {"displayModeBar": "hover" if tall else False}
    config = json.dumps({**CONFIG, **bar, **locale_config()})
    data = f'{{"figure": {made.to_json(validate=False)}, "config": {config}}}'
    frame = Markup(
        '<div class="plot" role="{role}" aria-label="{label}" style="height:{height}px">'
        '<div id="{name}" class="plotly-graph-div" style="height:{height}px; width:100%">'
        '<script type="application/json">{data}</script></div></div>'
    )
    inert = Markup(data.replace("<", r"\u003c"))
    return frame.format(
        role="group" if tall else "img", label=label, height=height_px, name=name, data=inert
    )


def _in_few_bytes(trace: Any) -> None:
    """Have a trace keep its numbers in four bytes each where that is not seen."""
    for name in ("x", "y", "z"):
        values = getattr(trace, name, None)
        if isinstance(values, np.ndarray) and values.dtype == np.float64 and values.size:
            known = values[np.isfinite(values)]
            off = np.abs(known.astype(np.float32) - known)
            if known.size and off.max() <= DRAWN_SHARE * np.ptp(known):
                trace[name] = values.astype(np.float32)


# Pages


@cache
def _templates() -> Environment:
    env = Environment(
        loader=PackageLoader("autodb.reports", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    env.filters.update(number=number)
    env.globals.update(
        _=said_in_pages.page_sentence, _n=said_in_pages.page_sentences, told=said_in_pages.told,
        say=phrase, code=said_in_pages.code, link=said_in_pages.link_to,
        sign_in_link=said_in_pages.sign_in_link, amount=amount_words, day=day, localized=localized,
        quantity=quantity, span=span, suffix=suffix,
    )  # fmt: skip
    return env


def compile_templates() -> None:
    """Compile every template, which each is otherwise when it is first asked for."""
    env = _templates()
    for name in env.list_templates():
        env.get_template(name)


def _exchanges() -> Markup:
    """Style rules that exchange each light tone in a plot for its dark one."""
    rules = []
    for light, dark in PALETTE.values():
        rgb = ", ".join(str(int(light[i : i + 2], 16)) for i in (1, 3, 5))
        rules += [
            f'.plot [style*="{what}: rgb({rgb})"] {{ {what}: {dark} !important }}'
            for what in ("stroke", "fill")
        ]
    return Markup("\n".join(rules))


def fragment(template: str, **context: Any) -> Markup:
    """Return a piece of a page from a template; every text in ``context`` is escaped."""
    language = presentation().language
    made = _templates().get_template(template).render(language=language, **context)
    return Markup(made)


def whole_page(template: str, **context: Any) -> str:
    """Return a whole page from a template, which loads the script of its plots from beside it."""
    shell = {"library": Markup(library_tag()), "draw": fragment("plots.js")}
    return str(style(template, **shell, **context))


def style(template: str, **context: Any) -> Markup:
    """Return a piece that names colours and fonts, from a template."""
    tones = {"palette": PALETTE, "exchanges": _exchanges(), "font": Markup(FONT)}
    return fragment(template, **tones, **context)
