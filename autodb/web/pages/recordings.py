"""Recordings: which there are, and of each its plot, its quality, what rests on it; withdrawing."""

from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Form, HTTPException, Query, Request, Response
from fastapi.responses import RedirectResponse
from markupsafe import Markup
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.answer.shown.recorded import course_of
from autodb.agent.answer.shown.recordings import (
    WITHDRAWN,
    RecordedChannel,
    RecordingSaid,
    RecordingSeen,
    recording_said,
    recordings_seen,
    stored_recording,
)
from autodb.agent.operate.access import Role, noting
from autodb.agent.operate.withdrawing import take_again, withdraw
from autodb.errors import UnusableInput
from autodb.reports.amounts import number as said_number
from autodb.reports.recorded import plot_of_course
from autodb.store import models
from autodb.web.html import path, piece, service_page
from autodb.web.pages.reading import read_state
from autodb.web.receive.apart import RecordingToShow
from autodb.web.routes.kept_recordings import NOTED
from autodb.web.routes.machines import MOST_ID, Number
from autodb.web.service import Reads, allowed, made_apart, service_of
from autodb.wording import listed, phrase, phrase_many, shop_amount

router = APIRouter()
SEE_OTHER = 303
A_PAGE, CUTS = 50, 300
"""Recordings of a page, and cuts that are listed of one. Chosen."""


@router.get("/machines/{machine:path}/recordings")
def recordings_page(
    request: Request,
    _access: Reads,
    machine: str,
    before: Annotated[int | None, Query(ge=1, le=MOST_ID)] = None,
) -> Response:
    """Show a machine's recordings, the newest first."""
    found = read_state(
        request, lambda session: recordings_seen(session, machine, most=A_PAGE, before=before)
    )
    return service_page(
        request,
        "recordings.html.j2",
        title=phrase("{machine}: recordings", machine=machine),
        machine=machine,
        here="recordings",
        recordings=[(one, _began(one), length_words(one)) for one in found],
        older=found[-1].id if len(found) == A_PAGE else None,
        WITHDRAWN=WITHDRAWN,
    )


@router.get("/machines/{machine:path}/recordings/{number}")
def recording_page(request: Request, _access: Reads, machine: str, number: Number) -> Response:
    """Show one recording."""
    return _shown(request, machine, number)


@router.get("/machines/{machine:path}/recordings/{number}/plot")
async def recording_plot(
    request: Request, _access: Reads, machine: str, number: Number
) -> Response:
    """Answer with the piece of the page that draws a recording over time, read apart."""
    service = service_of(request)
    with service.store.reading() as session:
        place = stored_recording(session, machine, number).path
    task = RecordingToShow(machine, number, Path(place))
    made = await made_apart(service, task, str, service.settings.limits.predicting)
    return piece("_report.html.j2", report=Markup(made))


@router.post("/machines/{machine:path}/recordings/{number}")
def withdraw_page(
    request: Request,
    machine: str,
    number: Number,
    *,
    word: Annotated[str, Form()],
    csrf: Annotated[str, Form()] = "",
    sure: Annotated[str, Form()] = "",
    why: Annotated[str, Form(max_length=1000)] = "",
) -> Response:
    """Withdraw a recording, or take it again."""
    access = allowed(request, Role.OPERATE, csrf, changes=True)
    store = service_of(request).store
    if word not in NOTED:
        raise HTTPException(
            422, phrase("word: '{word}'; use {words}", word=word, words=listed(NOTED))
        )
    also = noting(access, NOTED[word], "recording", why=why or None)
    try:
        if word != "withdraw":
            take_again(store, machine, number, also=also)
        elif not why.strip() or not sure:
            raise UnusableInput(phrase("say why, and that you are sure; then it is withdrawn"))
        else:
            withdraw(store, machine, number, why=why.strip(), also=also)
    except UnusableInput as error:
        return _shown(request, machine, number, said=error, status=422)
    return RedirectResponse(path("machines", machine, "recordings", str(number)), SEE_OTHER)


def _shown(
    request: Request, machine: str, number: int, *, said: object = "", status: int = 200
) -> Response:
    def asked(session: Session) -> tuple[RecordingSaid, Markup | None, list[tuple[str, ...]]]:
        row = stored_recording(session, machine, number)
        drawn = plot_of_course(course_of(row)) if row.kind == "cuts" else None
        cut = models.Cut
        some = select(cut).where(cut.recording_id == number).order_by(cut.number).limit(CUTS)
        cuts = [_cut_row(one) for one in session.scalars(some)]
        return recording_said(session, machine, number), drawn, cuts

    found, plot, cuts = read_state(request, asked)
    return service_page(
        request,
        "recording.html.j2",
        title=phrase("{machine}: recording {number}", machine=machine, number=number),
        status=status,
        machine=machine,
        here="recordings",
        found=found,
        plot=plot,
        cuts=cuts,
        length=length_words(found.seen),
        channels=[(one.name, shop_amount(1.0, one.unit)[1], _range(one)) for one in found.channels],
        said=said,
        WITHDRAWN=WITHDRAWN,
    )


def _cut_row(one: models.Cut) -> tuple[str, ...]:
    """Return what is listed of a cut: number, operation, material, tool, whether it counts."""
    pair = ("", "") if one.pair is None else (one.pair.material.name, one.pair.tool.name)
    operation = phrase(one.operation) if one.operation else ""
    return f"{one.number:g}", operation, *pair, phrase("no") if one.superseded_at else phrase("yes")


def _began(one: RecordingSeen) -> str:
    """Return when a recording began, or came in where nobody stated that."""
    return one.began_at or one.imported_at


def length_words(one: RecordingSeen) -> str:
    """Return how long a recording is: its time, or its cuts where it is a table of them."""
    if one.kind == "cuts" or one.length_s is None:
        return phrase_many("{count} row", "{count} rows", one.rows)
    minutes, seconds = divmod(one.length_s, 60.0)
    return f"{minutes:.0f} min {seconds:.0f} s" if minutes else f"{said_number(seconds)} s"


def _range(one: RecordedChannel) -> list[str]:
    """Return what is known of a channel's values: smallest, largest, mean, standard deviation."""
    every = (one.minimum, one.maximum, one.mean, one.sd)
    return [
        phrase("not known") if value is None else said_number(shop_amount(value, one.unit)[0])
        for value in every
    ]
