"""A job planned by dropping its NC program: what its lines that cut will take."""

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from autodb.agent.rows.machines import owner_named
from autodb.files.job_words import job_in_words
from autodb.reports.planned import predicted
from autodb.web.html import piece
from autodb.web.pages.planner import limits_shown, shown_cuts
from autodb.web.pages.reading import read_state
from autodb.web.pages.typed import typed_as
from autodb.web.routes.programs import predicted_program
from autodb.web.service import Reads

SHOWN = 300
"""Lines of a program that are listed; beyond, those with the largest torque. Chosen."""

router = APIRouter()


@router.post("/machines/{machine:path}/plan/program")
async def of_program(
    request: Request,
    _access: Reads,
    machine: str,
    typed: Annotated[str, Query(max_length=20)] = "",
) -> Response:
    """Answer with the piece of the planner that says what a program will take."""
    answer = await predicted_program(request, machine, typed_as(typed).number)
    limits = read_state(request, lambda session: owner_named(session, machine).limits)
    heaviest = sorted(
        range(len(answer.cuts)),
        key=lambda k: -abs((answer.cuts[k].peaks or answer.cuts[k]).torque_N_m.value),
    )
    listed = sorted(heaviest[:SHOWN])
    return piece(
        "_answer.html.j2",
        answer=answer,
        asked=list(job_in_words(answer.job)),
        plot=predicted.plot(answer, limits),
        cuts=shown_cuts(answer, listed),
        left_out=len(answer.cuts) - len(listed),
        **limits_shown(answer),
    )
