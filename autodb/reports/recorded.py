"""A recording as a plot: a trace a channel, its cuts shaded."""

from markupsafe import Markup

from autodb.agent.answer.shown.recorded import RecordedCourse
from autodb.reports import figures
from autodb.wording import phrase

PANEL_PX = 124
"""Height of a channel's plot. Chosen: eight are a page."""
BELOW_PX, BETWEEN_PX = 90, 36
"""What an axis with its title takes, and a title between two plots."""


def plot_of_course(course: RecordedCourse) -> Markup:
    """Return the plot, and what it says below it."""
    if not course.channels:
        return Markup('<p class="said">{}</p>').format(phrase("No channel of it has a number."))
    names = list(course.channels)
    titles = [figures.bracketed(name, course.units[name]) for name in names]
    x_title = phrase("Time [s]") if course.over_time else phrase("Cut")
    shares = [1.0] * len(names)
    height = BELOW_PX + PANEL_PX * len(names)
    made = figures.figure(titles, x_title=x_title, shares=shares, gap=BETWEEN_PX / height)
    figures.shade(made, course.cuts)
    for row, name in enumerate(names, start=1):
        values = figures.plot_scale(course.units[name]) * course.channels[name]
        if course.over_time:
            trace = figures.line_trace(course.x, values, tone="corrected", name=name)
        else:
            trace = figures.points(course.x, values, tone="corrected", name=name)
        made.add_trace(trace, row=row, col=1)
    channels = ", ".join(names)
    label = (
        phrase("{channels} over time", channels=channels)
        if course.over_time
        else phrase("{channels} over cuts", channels=channels)
    )
    plot = figures.as_html(made, "recorded", height_px=height, label=label)
    return plot + figures.fragment("recorded.html.j2", course=course)
