"""An axis over the weeks as a plot: gain, friction and force, with what was done marked in all."""

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from autodb.agent.answer.shown.axis_courses import AxisCourse, CoursePoint
from autodb.files.channels import axis_words
from autodb.reports import figures
from autodb.reports.plot_words import date_ticks
from autodb.wording import listed, phrase

PANEL_PX, BELOW_PX, BETWEEN_PX = 110, 80, 36
TONES = {"calibration": "simulation", "mismatch": "warn"}


def plot_of_axis(course: AxisCourse) -> Markup | None:
    """Return the plot of an axis; None where nothing is known of it."""
    above = phrase("Force {axis} above expectation", axis=course.component.upper())
    panels = [
        (title, unit, points)
        for title, unit, points in (
            (phrase("Gain of calibration"), course.gain_unit, course.gain),
            (phrase("Current in air"), "A", course.air),
            (phrase("Dry friction"), course.friction_unit, course.friction),
            (above, "%", course.residual),
        )
        if points
    ]
    if not panels:
        return None
    height = BELOW_PX + PANEL_PX * len(panels)
    titles = [figures.bracketed(title, unit) for title, unit, _ in panels]
    shares = [1.0] * len(panels)
    made = figures.figure(titles, x_title="", shares=shares, gap=BETWEEN_PX / height)
    for row, (_, unit, some) in enumerate(panels, start=1):
        made.add_trace(_trace(some, figures.plot_scale(unit)), row=row, col=1)
        made.update_yaxes(zeroline=False, rangemode="normal", row=row, col=1)
    for mark in course.marks:
        tone = figures.colour(TONES[mark.kind])
        line = {"color": tone, "width": 1.5, "dash": "dot" if mark.kind == "mismatch" else "solid"}
        made.add_vline(x=mark.at, line=line, row="all", col=1, exclude_empty_subplots=False)
    made.update_xaxes(type="date", **date_ticks())
    label = phrase(
        "{axis}: {quantities} over time",
        axis=axis_words(course.axis),
        quantities=listed(titles),
    )
    return figures.as_html(made, f"course-{course.axis}", height_px=height, label=label)


def _trace(some: Sequence[CoursePoint], scale: float) -> object:
    """Return values times a scale over time, with intervals where they are known."""
    value = scale * np.array([one.value for one in some])
    half = scale * np.array([0.0 if one.high is None else one.high - one.value for one in some])
    bars = {"type": "data", "array": half, "color": figures.colour("corrected"), "thickness": 1.4}
    return figures.line_trace(
        np.array([one.at for one in some]),
        value,
        tone="corrected",
        name="",
        mode="lines+markers",
        line={"width": 1},
        marker={"size": 6},
        error_y=bars if half.any() else None,
        hoverinfo="x+y",
    )
