"""Were the predictions right: what was predicted of cuts, and what they then took."""

from fastapi import APIRouter, Request, Response

from autodb.agent.matching.scoring import PredictionScores, scores_in
from autodb.forward.limits import QUANTITIES
from autodb.reports.amounts import quantity, span
from autodb.reports.scored import SHOWN, plot_of_scores, plots_against
from autodb.web.html import service_page
from autodb.web.pages.reading import read_state
from autodb.web.service import Reads
from autodb.wording import phrase

router = APIRouter()
LISTED = 60
"""Cuts that are listed. Chosen."""


@router.get("/machines/{machine:path}/scores")
def scores_page(request: Request, _access: Reads, machine: str) -> Response:
    """Show how far off a machine's past predictions were, and how sure they were of it."""
    found = read_state(request, lambda session: scores_in(session, machine))
    return service_page(
        request,
        "scores.html.j2",
        title=phrase("{machine}: predictions and cuts", machine=machine),
        machine=machine,
        here="scores",
        made=len(found.cuts),
        scored=found.scored,
        by_basis=found.by_basis,
        plot=plot_of_scores(found),
        against=plots_against(found),
        rows=_rows(found),
        most=SHOWN,
    )


def _rows(found: PredictionScores) -> list[tuple[object, ...]]:
    """Return what is listed of the newest cuts, newest first: a row for each quantity of a cut."""
    units = {one.channel: one.unit for one in QUANTITIES}
    return [
        (
            cut.job,
            cut.name,
            one.quantity,
            quantity(one.predicted.value, units[one.quantity]),
            span(one.predicted.low, one.predicted.high, units[one.quantity]),
            quantity(one.made, units[one.quantity]),
            one.held,
            cut.recording,
        )
        for cut in reversed(found.cuts[-LISTED:])
        for one in cut.scored
    ]
