"""Mismatches: what simulations left out of recordings, and a person's word on them."""

from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Form, HTTPException, Query, Request, Response
from fastapi.responses import RedirectResponse
from markupsafe import Markup
from sqlalchemy.orm import Session

from autodb.agent.answer.overview import MismatchSaid, mismatch_said
from autodb.agent.operate.access import Role, noting
from autodb.agent.operate.deciding import confirm, mismatch, mismatches, reject, reopen
from autodb.agent.rows.mismatches import decided_words
from autodb.errors import UnusableInput
from autodb.reports.explanation import (
    certainty_words,
    move_words,
    parameter_words,
    term_words,
    told_statement,
)
from autodb.web.html import path, piece, service_page
from autodb.web.pages.reading import read_state
from autodb.web.receive.apart import MismatchToExplain
from autodb.web.routes.machines import Number
from autodb.web.service import Reads, allowed, made_apart, service_of
from autodb.wording import day, listed, listed_stretches, phrase

router = APIRouter()
SEE_OTHER = 303
CONFIRM = "confirm"
OTHERS = {"reject": reject, "reopen": reopen}
NOTED = {
    CONFIRM: "mismatch confirmed", "reject": "mismatch rejected", "reopen": "mismatch reopened",
}  # fmt: skip
"""What the audit log says of a decision, by its word."""


@router.get("/machines/{machine:path}/mismatches")
def of_machine(
    request: Request, _access: Reads, machine: str, decided: Annotated[bool, Query()] = False
) -> Response:
    """Show a machine's mismatches: those that wait, or all."""

    def asked(session: Session) -> list[MismatchSaid]:
        rows = mismatches(session, machine, decided=decided)
        return [mismatch_said(session, row) for row in rows]

    found = read_state(request, asked)
    return service_page(
        request,
        "mismatches.html.j2",
        title=phrase("{machine}: mismatches", machine=machine),
        machine=machine,
        here="mismatches",
        told_statement=told_statement,
        mismatches=[(one, term_words(one.term), day(one.created_at)) for one in reversed(found)],
        decided=decided,
    )


@router.get("/mismatches/{number}")
def one(request: Request, _access: Reads, number: Number) -> Response:
    """Show one mismatch."""
    return _shown(request, number)


@router.get("/mismatches/{number}/report")
async def report(request: Request, _access: Reads, number: Number) -> Response:
    """Answer with the piece of the page that explains the recording against what is known now."""
    service = service_of(request)
    with service.store.reading() as session:
        name = Path(mismatch(session, number).recording.path).name
    task = MismatchToExplain(number, Path(name))
    made = await made_apart(service, task, str, service.settings.limits.explaining)
    return piece("_report.html.j2", report=Markup(made))


@router.post("/mismatches/{number}")
def decide_page(
    request: Request,
    number: Number,
    *,
    word: Annotated[str, Form()],
    csrf: Annotated[str, Form()] = "",
    term: Annotated[str, Form()] = "",
    lot: Annotated[str, Form()] = "",
    why: Annotated[str, Form(max_length=1000)] = "",
) -> Response:
    """Confirm or reject a mismatch, or take its decision back."""
    access = allowed(request, Role.OPERATE, csrf, changes=True)
    service = service_of(request)
    try:
        also = noting(access, NOTED.get(word, word), "mismatch", **_said(term, why))
        who, reason = access.who, why or None
        if word == CONFIRM:
            confirm(
                service.store, number, term=term or None, lot=lot or None, by=who, why=reason,
                also=also,
            )  # fmt: skip
        elif word in OTHERS:
            OTHERS[word](service.store, number, by=who, why=reason, also=also)
        else:
            raise HTTPException(
                422, phrase("word: '{word}'; use {words}", word=word, words=listed(NOTED))
            )
    except UnusableInput as error:
        return _shown(request, number, said=error, status=422)
    return RedirectResponse(path("mismatches", str(number)), SEE_OTHER)


def _said(term: str, why: str) -> dict[str, str | None]:
    return {"term": term or None, "why": why or None}


def _shown(request: Request, number: int, *, said: object = "", status: int = 200) -> Response:
    def asked(session: Session) -> tuple[MismatchSaid, dict[str, object]]:
        row = mismatch(session, number)
        evidence: dict[str, object] = {
            "recordings": [(one.id, Path(one.path).name) for one in row.recordings],
            "intervals": listed_stretches(row.intervals or ()),
            "parameters": row.parameters,
        }
        return mismatch_said(session, row), evidence

    found, evidence = read_state(request, asked)
    return service_page(
        request,
        "mismatch.html.j2",
        title=f"{term_words(found.term)} ({found.channel})",
        parameter_words=parameter_words,
        told_statement=told_statement,
        decided=_decided(found),
        status=status,
        machine=found.machine,
        here="mismatches",
        mismatch=found,
        words=term_words,
        move=move_words(found.term, found.alternatives, found.to_tell_apart or "", term_words),
        sure=certainty_words(found.confidence),
        said=said,
        **evidence,
    )


def _decided(found: MismatchSaid) -> str:
    """Return what was decided of a mismatch whose decisions were not kept one by one."""
    term = found.confirmed_term and term_words(found.confirmed_term)
    said = decided_words(found.status, term, found.decided_by)
    if found.decided_at is None:
        return said
    return phrase("{decided}, {day} UTC.", decided=said, day=day(found.decided_at))
