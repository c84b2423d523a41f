"""Predicted cuts as one picture: each quantity of every cut with its interval, and the limits."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup
from numpy.typing import NDArray

from autodb import __version__
from autodb.agent.answer.predicting import JobAnswer, Predicted
from autodb.files.job_words import job_in_words
from autodb.files.machine import AxisLimits
from autodb.forward.bending import bending_in_words
from autodb.forward.cut_figures import CutFigures, JobTotals
from autodb.forward.limits import QUANTITIES, PredictedQuantity, standings_in_words
from autodb.forward.prediction import Interval
from autodb.reports import amounts, figures
from autodb.wording import amount_words, listed, msgid, phrase, shop_amount

Array = NDArray[np.float64]

PLOT_PX = 190
"""Height of one quantity."""
NAMED = 24
"""Cuts up to which the axis says their names. Chosen: more do not fit beside each other."""
FAR = 3.0
"""A limit this many times beyond what is predicted would press it flat: only the title says it.
Chosen."""
UNKNOWN = msgid("not known: no length is stated")
GAP = 0.06
"""What is left between two quantities, a share of the picture."""
PLACES = {"start": -0.24, "mean": -0.08, "peak": 0.08, "end": 0.24}
"""Where what is known of a cut stands beside its number, in cuts."""
SYMBOLS = {"start": "triangle-right-open", "peak": "diamond-open", "end": "triangle-left-open"}


def render_prediction(answer: Predicted, limits: Mapping[str, AxisLimits]) -> str:
    """Return the page: a page that loads nothing from outside."""
    job = answer.job
    return figures.whole_page(
        "predicted.html.j2",
        title=phrase("{job}: predicted forces", job=job.name),
        name=job.name,
        pair=f"{job.material} / {job.tool}",
        asked=list(job_in_words(job)),
        limits=list(standings_in_words(answer.limits)),
        columns=[
            figures.quantity_title(one.channel, [cut.operation for cut in answer.cuts])
            for one in QUANTITIES
        ],
        taken=list(taken_rows(answer)),
        figures=[
            (cut.name or phrase("cut {number}", number=f"{k}"), figure_rows(its))
            for k, (cut, its) in enumerate(zip(answer.cuts, answer.figures, strict=True), start=1)
        ],
        totals=total_rows(answer.totals),
        bending=list(bending_in_words(answer.cuts, answer.bending)),
        machine_says=[
            phrase(
                "cut {number} {name}: {said}",
                number=f"{one.cut}",
                name=answer.cuts[one.cut - 1].name,
                said=one.statement,
            )
            for one in answer.exceeds
        ],
        notes=answer.notes,
        passive=any(cut.passive for cut in answer.cuts),
        marks=_marks_words(answer),
        plot=plot(answer, limits),
        prediction=answer.prediction_id,
        version=__version__,
    )


def render_look_up(answer: JobAnswer, limits: Mapping[str, AxisLimits]) -> str:
    """Return the page of an answer that is not kept: a page that loads nothing from outside."""
    pair = f"{answer.job.material} / {answer.job.tool}"
    return figures.whole_page(
        "looked_up.html.j2",
        title=pair,
        plot=plot(answer, limits),
        said=[*(one.statement for one in answer.exceeds), *answer.notes],
        version=__version__,
    )


def taken_rows(answer: JobAnswer) -> Iterator[tuple[str, list[str]]]:
    """Yield what a cut is, or its start, its end or its largest, and each quantity of it."""
    for number, cut in enumerate(answer.cuts, start=1):
        name = cut.name or phrase("cut {number}", number=f"{number}")
        others = [(f"{name}, {phrase(what)}", some) for what, some in cut.statistics]
        for called, some in [(name, cut), *others]:
            each = ((one, one.of(some)) for one in QUANTITIES)
            yield called, ["" if of is None else _in_interval(of, one.unit) for one, of in each]


def _marks_words(answer: JobAnswer) -> str:
    """Return what the marks of the picture are."""
    peaks = dict.fromkeys(cut.of_what for cut in answer.cuts if cut.peaks)
    if not peaks:
        return phrase("Bars are 95 % intervals.")
    of = listed(phrase(one) for one in peaks)
    if any(cut.changes for cut in answer.cuts):
        return phrase(
            "Bars are 95 % intervals; circles are means in time, triangles start and end, diamonds "
            "peaks {along}.",
            along=of,
        )
    return phrase("Bars are 95 % intervals; circles are means, diamonds peaks {along}.", along=of)


def figure_rows(its: CutFigures) -> list[tuple[str, str]]:
    """Return what a planner counts of a cut: what it is, and how much."""
    return [
        (phrase("Time"), _amount(its.time_s, "s")),
        (phrase("Removal rate"), _amount(its.removal_cm3_min, "cm³/min")),
        (phrase("Specific force"), _reach(its.specific_N_mm2, "N/mm²")),
        (phrase("Energy"), _reach(its.energy_kJ, "kJ")),
    ]


def total_rows(its: JobTotals) -> list[tuple[str, str]]:
    """Return what a planner counts of a job: what it is, and how much."""
    return [
        (phrase("Time"), _amount(its.time_s, "s")),
        (phrase("Removed"), _amount(its.removed_cm3, "cm³")),
        (phrase("Energy"), _reach(its.energy_kJ, "kJ")),
    ]


def _amount(value: float | None, unit: str) -> str:
    return phrase(UNKNOWN) if value is None else amounts.quantity(value, unit)


def _reach(one: Interval | None, unit: str) -> str:
    if one is None:
        return phrase(UNKNOWN)
    return _in_interval(one, unit)


def _in_interval(one: Interval, unit: str) -> str:
    """Return a value and its interval, and then their unit."""
    value, name = shop_amount(one.value, unit)
    after = amounts.suffix(name)
    ends = amounts.span(one.low, one.high, unit).removesuffix(after)
    return f"{amounts.number(value)} ({ends}){after}"


def plot(answer: JobAnswer, limits: Mapping[str, AxisLimits]) -> Markup:
    """Return the picture of an answer, with the limits of the machine's axes by name."""
    operations = [cut.operation for cut in answer.cuts]
    given = {one: [one.limit(limits, cut) for cut in answer.cuts] for one in QUANTITIES}
    titles = [_title(one, operations, given[one]) for one in QUANTITIES]
    made = figures.figure(titles, x_title=phrase("Cut"), shares=[1.0] * len(titles), gap=GAP)
    for row, one in enumerate(QUANTITIES, start=1):
        traces = _traces(one, answer)
        for trace in traces:
            made.add_trace(trace, row=row, col=1)
        _draw_limit(made, row, one, answer, given[one])
    numbers = list(range(1, len(answer.cuts) + 1))
    if len(numbers) <= NAMED:
        names = [
            figures.plain_text(cut.name) or str(k) for k, cut in enumerate(answer.cuts, start=1)
        ]
        made.update_xaxes(tickmode="array", tickvals=numbers, ticktext=names)
    made.update_yaxes(rangemode="tozero")
    made.update_xaxes(range=[0.5, len(numbers) + 0.5])
    label = phrase(
        "predicted force, torque and power of {count} cuts with 95 % intervals", count=len(numbers)
    )
    return figures.as_html(made, "predicted", height_px=PLOT_PX * len(titles), label=label)


def _title(
    one: PredictedQuantity, operations: Sequence[str], limits: Sequence[float | None]
) -> str:
    name = figures.bracketed(figures.quantity_title(one.channel, operations), one.unit)
    stated = sorted({limit for limit in limits if limit is not None})
    if not stated:
        return name
    least = amount_words(stated[0], one.unit, ".4g")
    if len(stated) == 1:
        return phrase("{quantity}, limit ± {limit}", quantity=name, limit=least)
    return phrase("{quantity}, limit at least ± {limit}", quantity=name, limit=least)


def _traces(one: PredictedQuantity, answer: JobAnswer) -> list[go.Scatter]:
    """Return means, and starts, ends and peaks beside them; warned of where a limit may go."""
    warned = {(each.cut, each.axis) for each in answer.exceeds if each.unit == one.unit}
    marks: dict[tuple[str, str], list[tuple[float, Interval, str]]] = {}
    for number, cut in enumerate(answer.cuts, start=1):
        tone = "warn" if (number, one.axis) in warned else "corrected"
        others = {name: one.of(some) for name, some in cut.statistics}
        for name, found in {"mean" if others else "predicted": one.of(cut), **others}.items():
            if found is not None:
                at = number + (PLACES[name.split(" ", maxsplit=1)[0]] if others else 0.0)
                marks.setdefault((name, tone), []).append((at, found, cut.name))
    return [_marked(some, name, tone, one.unit) for (name, tone), some in marks.items()]


def _marked(
    some: Sequence[tuple[float, Interval, str]], name: str, tone: str, unit: str
) -> go.Scatter:
    x = np.array([at for at, _, _ in some])
    scale = figures.plot_scale(unit)
    value, low, high = (scale * np.array([getattr(i, end) for _, i, _ in some])
                        for end in ("value", "low", "high"))  # fmt: skip
    hover = [
        f"{figures.plain_text(cut)}, {phrase(name)}<br>{_in_interval(i, unit)}"
        for _, i, cut in some
    ]
    bars = {
        "type": "data", "symmetric": False, "array": high - value, "arrayminus": value - low,
        "color": figures.colour(tone), "thickness": 1.6, "width": 4,
    }  # fmt: skip
    symbol = SYMBOLS.get(name.split(" ", maxsplit=1)[0], "circle")
    return go.Scatter(
        x=x,
        y=value,
        mode="markers",
        name=phrase(name),
        marker={"color": figures.colour(tone), "size": 8, "symbol": symbol},
        error_y=bars,
        text=hover,
        hoverinfo="text",
    )


def _draw_limit(
    made: go.Figure,
    row: int,
    one: PredictedQuantity,
    answer: JobAnswer,
    limits: Sequence[float | None],
) -> None:
    """Draw a limit on the sides of zero where forces are, unless it is FAR beyond them."""
    level = np.array([np.nan if limit is None else limit for limit in limits])
    if np.isnan(level).all():
        return
    level = np.append(level, level[-1])
    across = np.append(np.arange(len(limits)), len(limits)) + 0.5
    ends = [
        end
        for cut in answer.cuts
        for found in (one.of(cut), one.of(cut.peaks))
        if found is not None
        for end in (found.low, found.high)
    ]
    for reach, side in ((max(ends), 1.0), (-min(ends), -1.0)):
        if reach * FAR >= np.nanmin(level):
            line = {"dash": "dash", "width": 1.5, "shape": "hv"}
            shown = side * figures.plot_scale(one.unit) * level
            made.add_trace(
                figures.line_trace(across, shown, tone="warn", name=phrase("limit"), line=line),
                row=row,
                col=1,
            )
