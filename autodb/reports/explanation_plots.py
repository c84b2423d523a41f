"""Plots of an explanation: traces over time, where the mismatch sits, close-ups, signals."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup

from autodb.explain.answer import Array, ChannelAnswer, ChannelTrace
from autodb.files.channels import unit_of
from autodb.reports import figures

AROUND = 0.2
"""Share of a located stretch that is drawn on each side of it."""
GAP_STEPS = 5.0
"""Steps of a recording's clock from which on a line breaks: no row was recorded there."""


def channel_words(name: str) -> str:
    """Return a channel's name in shop words.

    >>> channel_words("x.drive_force"), channel_words("force.y"), channel_words("spindle.power")
    ('X axis drive force', 'Force Y', 'Spindle power')
    """
    first, *rest = name.replace("_", " ").split(".")
    if len(first) == 1:
        first = f"{first.upper()} axis"
    return " ".join(
        [first[:1].upper() + first[1:], *(r.upper() if len(r) == 1 else r for r in rest)]
    )


def drawn_words(rows: int) -> str | None:
    """Say that a plot of so many rows is thinned, where it is."""
    if rows <= figures.MAX_POINTS:
        return None
    return f"Drawn from {rows} samples; every peak is kept."


def traces_over_time(channel: dict[str, str], answer: ChannelAnswer, trace: ChannelTrace) -> Markup:
    """Draw recording, simulation and corrected, and under it what each leaves."""
    words, unit = channel["words"], answer.unit
    left_words = "Residual, before and after" if answer.mismatch else "Residual"
    made = figures.figure(
        [f"{words} [{unit}]", f"{left_words} [{unit}]"],
        x_title=_x_title(trace),
        shares=(0.62, 0.38),
    )
    figures.shade(made, _stretches(answer, trace))
    for name, values, left in _curves(answer, trace):
        made.add_trace(_curve(trace, values, name), row=1, col=1)
        if left is not None:
            made.add_trace(_curve(trace, left, name), row=2, col=1)
    return figures.as_html(
        made,
        f"{channel['id']}-over-{trace.x_name}",
        height_px=580,
        label=f"{words}: recording, simulation and residual",
    )


def _x_title(trace: ChannelTrace) -> str:
    return "Time [s]" if trace.x_name == "t" else "Cut number"


def _stretches(answer: ChannelAnswer, trace: ChannelTrace) -> list[tuple[float, float]]:
    """Return the located stretches along x; a cut reaches half a number to both sides."""
    half = 0.0 if trace.x_name == "t" else 0.5
    return [(low - half, high + half) for low, high in answer.where.intervals]


def located(
    channel: dict[str, str], answer: ChannelAnswer, trace: ChannelTrace
) -> list[tuple[Markup, str | None]]:
    """Draw each located stretch, ``AROUND`` of its length to both sides, at every sample.

    Each with what ``drawn_words`` says where it has more samples than are drawn.
    """
    found = []
    for number, (low, high) in enumerate(_stretches(answer, trace), start=1):
        around = AROUND * (high - low)
        near = part(trace, low - around, high + around)
        label = f"{channel['words']}: the stretch where the mismatch sits"
        name = f"located-{number}"
        plot = _near(channel, answer, near, name, label=label, shaded=[(low, high)])
        found.append((plot, drawn_words(len(near.x))))
    return found


def close_up(
    channel: dict[str, str], answer: ChannelAnswer, trace: ChannelTrace
) -> list[tuple[Markup, str | None]]:
    """Draw the turns of a waveform that are shown enlarged, with what ``drawn_words`` says."""
    if trace.close_up is None:
        return []
    near = part(trace, *trace.close_up)
    label = f"{channel['words']}: some turns of the spindle"
    return [(_near(channel, answer, near, "turns", label=label), drawn_words(len(near.x)))]


def part(trace: ChannelTrace, low: float, high: float) -> ChannelTrace:
    """Return the rows of a trace from ``low`` to ``high`` of its x."""
    rows = (trace.x >= low) & (trace.x <= high)
    return replace(
        trace,
        x=trace.x[rows],
        recording=trace.recording[rows],
        simulation=trace.simulation[rows],
        corrected=trace.corrected[rows],
        regime_signals={},
    )


def _near(
    channel: dict[str, str],
    answer: ChannelAnswer,
    near: ChannelTrace,
    name: str,
    *,
    label: str,
    shaded: Sequence[tuple[float, float]] = (),
) -> Markup:
    made = figures.figure([f"{channel['words']} [{answer.unit}]"], x_title=_x_title(near))
    figures.shade(made, shaded)
    for tone, values, _ in _curves(answer, near):
        made.add_trace(_curve(near, values, tone))
    return figures.as_html(made, f"{channel['id']}-{name}", height_px=340, label=label)


def _curves(answer: ChannelAnswer, trace: ChannelTrace) -> list[tuple[str, Array, Array | None]]:
    """Name, values, and what they leave; without a mismatch nothing was corrected."""
    rows: list[tuple[str, Array, Array | None]] = [("recording", trace.recording, None)]
    rows.append(("simulation", trace.simulation, trace.recording - trace.simulation))
    if answer.mismatch:
        rows.append(("corrected", trace.corrected, trace.recording - trace.corrected))
    return rows


def _curve(trace: ChannelTrace, values: Array, name: str) -> go.Scatter:
    if trace.x_name == "cut":
        style = {"mode": "lines+markers", "marker": {"size": 7}, "line": {"width": 1}}
        return figures.line_trace(trace.x, values, tone=name, name=name, **style)
    steps = np.diff(trace.x)
    gaps = np.flatnonzero(steps > GAP_STEPS * np.median(steps)) if steps.size else None
    if gaps is None or not gaps.size:
        return figures.line_trace(trace.x, values, tone=name, name=name)
    return figures.broken_line(trace.x, values, gaps, tone=name, name=name)


def against_signals(
    channel: dict[str, str], answer: ChannelAnswer, trace: ChannelTrace
) -> list[Markup]:
    """Draw what is left before and after against every regime signal, its regimes shaded."""
    return [
        _against(channel, answer, trace, signal, number)
        for number, signal in enumerate(trace.regime_signals, start=1)
    ]


def _against(
    channel: dict[str, str], answer: ChannelAnswer, trace: ChannelTrace, signal: str, number: int
) -> Markup:
    unit = unit_of(signal)
    made = figures.figure(
        [f"Residual [{answer.unit}]"],
        x_title=channel_words(signal) + (f" [{unit}]" if unit else ""),
    )
    figures.shade(made, [(r.low, r.high) for r in answer.where.regime if r.signal == signal])
    x = trace.regime_signals[signal]
    for name, _, left in _curves(answer, trace):
        if left is not None:
            mark = {"size": 5, "opacity": 0.45}
            made.add_trace(figures.points(x, left, tone=name, name=name, marker=mark))
    label = f"Residual against {channel_words(signal)}"
    return figures.as_html(made, f"{channel['id']}-against-{number}", height_px=300, label=label)
