"""Plots of an explanation (traces over time, close-ups, signals), and where it sits in words."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup

from autodb.explain.answer import Array, ChannelAnswer, ChannelTrace, Regime
from autodb.files.channels import unit_of
from autodb.reports import amounts, figures
from autodb.wording import listed_stretches, msgid, phrase
from autodb.wording.sentences import MOST_LISTED

AROUND = 0.2
"""Share of a located stretch that is drawn on each side of it."""
GAP_STEPS = 5.0
"""Steps of a recording's clock from which on a line breaks: no row was recorded there."""


CHANNELS = (
    (r"force\..", msgid("Force {axis}"), 1),
    (r".\.position", msgid("{axis} axis position"), 0),
    (r".\.velocity", msgid("{axis} axis velocity"), 0),
    (r".\.acceleration", msgid("{axis} axis acceleration"), 0),
    (r".\.current", msgid("{axis} axis current"), 0),
    (r".\.drive_force", msgid("{axis} axis drive force"), 0),
    (r".\.drive_torque", msgid("{axis} axis drive torque"), 0),
    (r".\.direction", msgid("{axis} axis direction"), 0),
    (r".\.temperature", msgid("{axis} axis temperature"), 0),
    (r"spindle\.speed", msgid("Spindle speed"), 0),
    (r"spindle\.current", msgid("Spindle current"), 0),
    (r"spindle\.power", msgid("Spindle power"), 0),
    (r"spindle\.angle", msgid("Spindle angle"), 0),
    (r"torque\.spindle", msgid("Torque spindle"), 0),
    (r"cutting\.feed", msgid("Cutting feed"), 0),
    (r"cutting\.depth", msgid("Cutting depth"), 0),
    (r"cutting\.speed", msgid("Cutting speed"), 0),
    (r"cutting\.width", msgid("Cutting width"), 0),
    (r"tool\.cutting_time", msgid("Tool cutting time"), 0),
)
"""Channels that have a name in other languages, and which part of it is the axis."""


def channel_words(name: str) -> str:
    """Return a channel's name in shop words.

    >>> channel_words("x.drive_force"), channel_words("force.y"), channel_words("spindle.power")
    ('X axis drive force', 'Force Y', 'Spindle power')
    """
    first, *rest = name.replace("_", " ").split(".")
    if len(first) == 1:
        first = f"{first.upper()} axis"
    said = " ".join(
        [first[:1].upper() + first[1:], *(r.upper() if len(r) == 1 else r for r in rest)]
    )
    known = next((one for one in CHANNELS if re.fullmatch(one[0], name)), None)
    return phrase(known[1], axis=name.split(".")[known[2]].upper()) if known else said


def drawn_words(rows: int) -> str | None:
    """Say that a plot of so many rows is thinned, where it is."""
    if rows <= figures.MAX_POINTS:
        return None
    return phrase("Drawn from {count} samples; every peak is kept.", count=rows)


def traces_over_time(channel: dict[str, str], answer: ChannelAnswer, trace: ChannelTrace) -> Markup:
    """Draw recording, simulation and corrected, and under it what each leaves."""
    words, unit = channel["words"], answer.unit
    left_words = phrase("Residual, before and after") if answer.mismatch else phrase("Residual")
    made = figures.figure(
        [figures.bracketed(words, unit), figures.bracketed(left_words, unit)],
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
        label=phrase("{channel}: recording, simulation and residual", channel=words),
    )


def _x_title(trace: ChannelTrace) -> str:
    return phrase("Time [s]") if trace.x_name == "t" else phrase("Cut number")


def _stretches(answer: ChannelAnswer, trace: ChannelTrace) -> list[tuple[float, float]]:
    """Return the located stretches along x; a cut reaches half a number to both sides."""
    half = 0.0 if trace.x_name == "t" else 0.5
    return [(low - half, high + half) for low, high in answer.where.intervals]


def located(
    channel: dict[str, str], answer: ChannelAnswer, trace: ChannelTrace
) -> list[tuple[Markup, str | None]]:
    """Draw each located stretch, ``AROUND`` of its length to both sides, at every sample; of more
    than are listed, the longest.

    Each with what ``drawn_words`` says where it has more samples than are drawn.
    """
    found = []
    shown = _stretches(answer, trace)
    if len(shown) > MOST_LISTED:
        shown = [max(shown, key=lambda one: one[1] - one[0])]
    for number, (low, high) in enumerate(shown, start=1):
        around = AROUND * (high - low)
        near = part(trace, low - around, high + around)
        label = phrase("{channel}: the stretch where the mismatch sits", channel=channel["words"])
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
    label = phrase("{channel}: some turns of the spindle", channel=channel["words"])
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
    made = figures.figure(
        [figures.bracketed(channel["words"], answer.unit)], x_title=_x_title(near)
    )
    figures.shade(made, shaded)
    for tone, values, _ in _curves(answer, near):
        made.add_trace(_curve(near, values, tone))
    return figures.as_html(made, f"{channel['id']}-{name}", height_px=340, label=label)


def _curves(answer: ChannelAnswer, trace: ChannelTrace) -> list[tuple[str, Array, Array | None]]:
    """Name, values, and what they leave, in the reader's unit; without a mismatch nothing was
    corrected.
    """
    scale = figures.plot_scale(answer.unit)
    recording, simulation = scale * trace.recording, scale * trace.simulation
    rows: list[tuple[str, Array, Array | None]] = [(msgid("recording"), recording, None)]
    rows.append((msgid("simulation"), simulation, recording - simulation))
    if answer.mismatch:
        corrected = scale * trace.corrected
        rows.append((msgid("corrected"), corrected, recording - corrected))
    return rows


def _curve(trace: ChannelTrace, values: Array, name: str) -> go.Scatter:
    if trace.x_name == "cut":
        style = {"mode": "lines+markers", "marker": {"size": 7}, "line": {"width": 1}}
        return figures.line_trace(trace.x, values, tone=name, name=phrase(name), **style)
    steps = np.diff(trace.x)
    gaps = np.flatnonzero(steps > GAP_STEPS * np.median(steps)) if steps.size else None
    if gaps is None or not gaps.size:
        return figures.line_trace(trace.x, values, tone=name, name=phrase(name))
    return figures.broken_line(trace.x, values, gaps, tone=name, name=phrase(name))


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
        [figures.bracketed(phrase("Residual"), answer.unit)],
        x_title=figures.bracketed(channel_words(signal), unit or ""),
    )
    scale, regimes = figures.plot_scale(unit or ""), answer.where.regime
    figures.shade(made, [(scale * r.low, scale * r.high) for r in regimes if r.signal == signal])
    x = scale * trace.regime_signals[signal]
    for name, _, left in _curves(answer, trace):
        if left is not None:
            mark = {"size": 5, "opacity": 0.45}
            made.add_trace(figures.points(x, left, tone=name, name=phrase(name), marker=mark))
    label = phrase("Residual against {signal}", signal=channel_words(signal))
    return figures.as_html(made, f"{channel['id']}-against-{number}", height_px=300, label=label)


def where_words(answer: ChannelAnswer, trace: ChannelTrace | None) -> list[str]:
    """Return where the mismatch sits, one line a stretch or a regime."""
    in_cuts = trace is not None and trace.x_name == "cut"
    lines = []
    for low, high, count in listed_stretches(answer.where.intervals):
        place = (
            phrase("Cuts {low} to {high}", low=f"{low:g}", high=f"{high:g}")
            if in_cuts
            else phrase("From {low} to {high} s", low=_second(low), high=_second(high))
        )
        if count > 1:
            place = phrase("{place}, in {count} stretches", place=place, count=count)
        if not _is_confined(answer):
            place = phrase("{place}: one of the causes; the others act all along", place=place)
        lines.append(place)
    return lines + [regime_words(regime) for regime in answer.where.regime]


def _is_confined(answer: ChannelAnswer) -> bool:
    """Whether every cause has a stretch of its own."""
    return len(answer.missing) <= len(listed_stretches(answer.where.intervals))


def stretch_words(answer: ChannelAnswer) -> str:
    """Return what a shaded stretch is."""
    if _is_confined(answer):
        return phrase("where the mismatch sits")
    return phrase("where one of the causes acts")


def regime_words(regime: Regime) -> str:
    """Return a regime as a line: its signal, its range, what it holds of the squared error."""
    share = f"{100.0 * regime.share:.0f}"
    holds = phrase("{share} % of the mismatch", share=share)
    if regime.rows is not None:
        rows = f"{100.0 * regime.rows:.0f}"
        holds = phrase(
            "{share} % of the squared error in {rows} % of the rows", share=share, rows=rows
        )
    unit, where = unit_of(regime.signal) or "", ""
    if regime.signal.endswith(".direction"):
        where = phrase("forwards") if regime.high > 0.0 else phrase("backwards")
    elif regime.low == regime.high:
        where = amounts.quantity(regime.low, unit)
    else:
        where = amounts.span(regime.low, regime.high, unit)
    signal = channel_words(regime.signal)
    return phrase("{signal} {where}: {holds}", signal=signal, where=where, holds=holds)


def _second(t_s: float) -> str:
    """A time is never rounded beyond a second."""
    return amounts.number(t_s) if abs(t_s) < 1000.0 else f"{t_s:.0f}"
