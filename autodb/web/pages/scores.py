"""Were the predictions right: what was predicted of cuts, and what they then took."""

from fastapi import APIRouter, Request, Response

from autodb.agent.matching.scoring import scores_in
from autodb.reports.scored import SHOWN, plot_of_scores
from autodb.web.html import service_page
from autodb.web.pages.reading import read_state
from autodb.web.service import Reads

router = APIRouter()


@router.get("/machines/{machine:path}/scores")
def scores_page(request: Request, _access: Reads, machine: str) -> Response:
    """Show how far off a machine's past predictions were, and how sure they were of it."""
    found = read_state(request, lambda session: scores_in(session, machine))
    return service_page(
        request,
        "scores.html.j2",
        title=f"{machine}: predictions and cuts",
        machine=machine,
        here="scores",
        made=len(found.cuts),
        scored=found.scored,
        by_basis=found.by_basis,
        plot=plot_of_scores(found),
        most=SHOWN,
    )
