"""An axis over the weeks as a plot: gain, friction and force, with what was done marked in all."""

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from autodb.agent.answer.shown.axis_courses import AxisCourse, CoursePoint
from autodb.reports import figures

PANEL_PX, BELOW_PX, BETWEEN_PX = 110, 80, 36
TONES = {"calibration": "simulation", "mismatch": "warn"}


def plot_of_axis(course: AxisCourse) -> Markup | None:
    """Return the plot of an axis; None where nothing is known of it."""
    panels = [
        (title, points)
        for title, points in (
            (f"Gain of calibration [{course.gain_unit}]", course.gain),
            ("Current in air [A]", course.air),
            (f"Dry friction [{course.friction_unit}]", course.friction),
            (f"Force {course.component.upper()} above expectation [%]", course.residual),
        )
        if points
    ]
    if not panels:
        return None
    height = BELOW_PX + PANEL_PX * len(panels)
    titles = [title for title, _ in panels]
    shares = [1.0] * len(panels)
    made = figures.figure(titles, x_title="", shares=shares, gap=BETWEEN_PX / height)
    for row, (_, some) in enumerate(panels, start=1):
        made.add_trace(_trace(some), row=row, col=1)
        made.update_yaxes(zeroline=False, rangemode="normal", row=row, col=1)
    for mark in course.marks:
        tone = figures.colour(TONES[mark.kind])
        line = {"color": tone, "width": 1.5, "dash": "dot" if mark.kind == "mismatch" else "solid"}
        made.add_vline(x=mark.at, line=line, row="all", col=1, exclude_empty_subplots=False)
    made.update_xaxes(type="date", hoverformat="%Y-%m-%d %H:%M")
    label = f"{course.axis}: {', '.join(titles)} over time"
    return figures.as_html(made, f"course-{course.axis}", height_px=height, label=label)


def _trace(some: Sequence[CoursePoint]) -> object:
    """Return values over time, with intervals where they are known."""
    value = np.array([one.value for one in some])
    half = np.array([0.0 if one.high is None else one.high - one.value for one in some])
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
