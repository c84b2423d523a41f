"""One report page of a machine: calibration, parameters, predictions, and one mismatch."""

from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from autodb.agent.learn.precision_history import LearningCurve
from autodb.reports import amounts, figures
from autodb.reports.against import PredictedMade, plot_against
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

NOT_SENSED = "not sensed"
FEW = 4


@dataclass(frozen=True)
class CalibrationPlot:
    """Scatter of one axis: estimate and target (n,) in ``unit``, the equation, and the verdict."""

    axis: str
    component: str
    estimate: Array
    target: Array
    equation: str
    unit: str
    rmse: float
    offered: bool
    verdict: str


@dataclass(frozen=True)
class PredictedSensed:
    """Forces of cuts predicted before they were made (95 % interval) against what was sensed."""

    component: str
    label: list[str]
    predicted_N: Array
    low_N: Array
    high_N: Array
    sensed_N: Array
    sensed_sd_N: Array


@dataclass(frozen=True)
class JobRow:
    """One predicted cut of a job as text: value and interval per quantity."""

    name: str
    cells: tuple[str, ...]


@dataclass(frozen=True)
class Page:
    """Everything a machine's report shows.

    ``headline``: (what, value) · ``drive_terms``: (part, size, meaning) · ``job_columns``: a name
    for each cell, or one more for the cut's name · a cell that is empty reads "not sensed".
    """

    machine: str
    pair: str
    headline: tuple[tuple[str, str], ...]
    calibrations: tuple[CalibrationPlot, ...]
    drive_terms: tuple[tuple[str, str, str], ...]
    learning: tuple[LearningCurve, ...]
    checks: tuple[PredictedSensed, ...]
    job_name: str
    job_columns: tuple[str, ...]
    job_rows: tuple[JobRow, ...]
    trace_text: str


def render_page(page: Page, mismatch_html: str | None) -> str:
    """Return the machine's report: a page that loads nothing from outside.

    ``mismatch_html`` is shown as it is: the content that explaining one recording gives.
    """
    return figures.whole_page(
        "page.html.j2",
        title=page.machine,
        page=page,
        mismatch=None if mismatch_html is None else Markup(mismatch_html),
        calibration_plots=[calibration_plot(n, plot) for n, plot in enumerate(page.calibrations)],
        learning_plots=[learning_plot(n, curve) for n, curve in enumerate(page.learning)],
        check_plots=[_check(n, check) for n, check in enumerate(page.checks)],
        NOT_SENSED=NOT_SENSED,
        equation_words=equation_words,
        force_title=figures.force_title,
        learnt_words=learnt_words,
        check_words=check_words,
    )


# Words


def equation_words(plot: CalibrationPlot) -> str:
    """Return the equation, with its scatter."""
    scatter = amounts.quantity(plot.rmse, plot.unit)
    return phrase(
        "{equation}; scatter {scatter} rms. I: current range above air cutting.",
        equation=localized(plot.equation),
        scatter=scatter,
    )


def learnt_words(curve: LearningCurve) -> str:
    """Return the force after the last cut, ± 2 sd."""
    return amounts.plus_minus(float(curve.mean[-1]), 2.0 * float(curve.sd[-1]), "N")


def check_words(check: PredictedSensed) -> str:
    """Return how many sensed forces lie in their predicted interval; how many were not sensed."""
    sensed = np.isfinite(check.sensed_N)
    inside = f"{np.sum(_inside(check))} of {np.sum(sensed)} measured forces"
    blind = int(np.sum(~sensed))
    return f"{inside} lie in the predicted interval" + (
        f"; {blind} {NOT_SENSED}." if blind else "."
    )


def _inside(check: PredictedSensed) -> NDArray[np.bool_]:
    return np.asarray((check.sensed_N >= check.low_N) & (check.sensed_N <= check.high_N))


# Plots


def calibration_plot(n: int, plot: CalibrationPlot) -> Markup:
    """Return the plot of a calibration, the n-th of a page."""
    tone = "corrected" if plot.offered else "recording"
    what = _sensed_as(plot)
    made = figures.figure(
        [figures.bracketed(phrase("{quantity} from a reference", quantity=what), plot.unit)],
        x_title=figures.bracketed(phrase("{quantity} from the current", quantity=what), plot.unit),
    )
    scale = figures.plot_scale(plot.unit)
    sensed = np.isfinite(plot.estimate) & np.isfinite(plot.target)
    made.add_trace(
        figures.points(
            scale * plot.estimate[sensed],
            scale * plot.target[sensed],
            tone=tone,
            name=phrase("standard cut"),
        )
    )
    if np.any(sensed):
        ends = scale * np.array([np.min(plot.estimate[sensed]), np.max(plot.estimate[sensed])])
        dash = {"dash": "solid" if plot.offered else "dot", "width": 2}
        made.add_trace(
            figures.line_trace(ends, ends, tone="simulation", name=phrase("the same"), line=dash)
        )
    label = phrase(
        "{axis}: {quantity} from a reference against that from the current",
        axis=plot.axis,
        quantity=what,
    )
    return figures.as_html(made, f"calibration-{n}", height_px=320, label=label)


def _sensed_as(plot: CalibrationPlot) -> str:
    return phrase("Torque") if plot.unit == "N·m" else figures.force_of(plot.component)


def learning_plot(n: int, curve: LearningCurve) -> Markup:
    """Return the plot of a curve, the n-th of a page."""
    scale = figures.plot_scale("N")
    mean, sd = scale * curve.mean, scale * curve.sd
    made = figures.lone_figure(
        figures.bracketed("", "N").strip(),
        x_title=phrase("Cuts in the fit"),
        y_axis={"range": tightening_range(mean, sd), "zeroline": False},
    )
    low, high = mean - 2.0 * sd, mean + 2.0 * sd
    for edge, fill in ((low, None), (high, "tonexty")):
        band = {"fill": fill, "fillcolor": translucent("corrected"), "line": {"width": 0}}
        made.add_trace(
            figures.line_trace(curve.n, edge, tone="corrected", name=phrase("± 2 sd"), **band)
        )
    mark = {"mode": "lines+markers", "marker": {"size": 5}, "line": {"width": 2}}
    made.add_trace(figures.line_trace(curve.n, mean, tone="corrected", name=phrase("mean"), **mark))
    force = figures.force_title(curve.component, [curve.operation])
    label = phrase(
        "{force} of {cut}: {value}", force=force, cut=curve.cut, value=learnt_words(curve)
    )
    return figures.as_html(made, f"learning-{n}", height_px=260, label=label)


def tightening_range(mean: Array, sd: Array) -> list[float]:
    """Return the y range that shows a band tighten: wide first bands run off the plot.

    The range holds every mean after the first and the band after the third; of fewer than four
    everything.
    """
    if len(mean) < FEW:
        return [float(np.min(mean - 2.4 * sd)), float(np.max(mean + 2.4 * sd))]
    third = min(2, len(mean) - 1)
    late = slice(min(1, third), None)
    reach = 2.4 * float(np.max(sd[third:]))
    low, high = float(np.min(mean[late])), float(np.max(mean[late]))
    return [min(low, float(mean[-1]) - reach), max(high, float(mean[-1]) + reach)]


def translucent(tone: str) -> str:
    """Return a tone of the palette that lets through what is behind it."""
    light = figures.colour(tone)
    red, green, blue = (int(light[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({red},{green},{blue},0.2)"


def _check(n: int, check: PredictedSensed) -> Markup:
    made = PredictedMade(
        title=f"Force {check.component.upper()}",
        unit="N",
        label=check.label,
        predicted=check.predicted_N,
        low=check.low_N,
        high=check.high_N,
        made=check.sensed_N,
        made_sd=check.sensed_sd_N,
        held=_inside(check),
    )
    return plot_against(f"check-{n}", made, words=check_words(check))
