"""Cuts that were looked up, as a page: each quantity with its interval, and the limits."""

from collections.abc import Mapping

from autodb import __version__
from autodb.agent.answer.predicting import JobAnswer
from autodb.files.machine import AxisLimits
from autodb.reports import figures
from autodb.reports.planned.predicted import plot


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
