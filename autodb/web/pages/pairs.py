"""Pairs of a work material and a tool: what is known of them, and how that tightened."""

from collections.abc import Mapping
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from sqlalchemy.orm import Session

from autodb.agent.answer.coefficients import machine_coefficients
from autodb.agent.answer.force_map import force_map
from autodb.agent.answer.looking_up import PairReader
from autodb.agent.learn.precision_history import precision_history
from autodb.agent.learn.usual_cut import usual_cut
from autodb.agent.rows.owner import owner_named
from autodb.files.coefficients import BoundedValue
from autodb.files.job import JobCut
from autodb.reports.figures import force_title, number
from autodb.reports.page import learning_plot, learnt_words
from autodb.reports.pair import force_map_plots
from autodb.web.html import service_page
from autodb.web.pages.cuts import (
    FIELDS,
    SHOWN,
    cut_in_words,
    cut_rows,
    prediction_spans,
    read_cuts,
    stated_rows,
)
from autodb.web.pages.reading import day, read_state
from autodb.web.service import Reads, service_of

UNITS = {"1": "", "N/mm^2": "N/mm²"}
"""How units of coefficients are printed."""

router = APIRouter()


@router.get("/machines/{machine:path}/pairs")
def pairs_page(request: Request, _access: Reads, machine: str) -> Response:
    """Show the pairs that a machine has learnt."""
    listed = read_state(request, lambda session: PairReader(session, machine).pairs())
    return service_page(
        request,
        "pairs.html.j2",
        title=f"{machine}: pairs",
        machine=machine,
        here="pairs",
        pairs=[(one, day(one.learnt_at)) for one in listed],
    )


@router.get("/machines/{machine:path}/pair")
def pair(
    request: Request,
    _access: Reads,
    machine: str,
    material: Annotated[str, Query(max_length=200)],
    tool: Annotated[str, Query(max_length=200)],
) -> Response:
    """Show what a pair takes: of one cut, over feed and depth, and how well that is known."""
    basis = service_of(request).lookup_cache.basis(machine, material, tool).basis
    stated = read_cuts(stated_rows(request.query_params))
    asked = stated[0] if stated else _usual(request, machine, material, tool)
    known = basis.look_up(asked)
    drawn = force_map(basis, asked)
    curves = read_state(
        request,
        lambda session: precision_history(
            session, owner_named(session, machine).id, material, basis.known.tool, asked
        ),
    )
    return service_page(
        request,
        "pair.html.j2",
        title=f"{material} / {tool}",
        machine=machine,
        here="pairs",
        material=material,
        tool=tool,
        known=known,
        words=cut_in_words(asked),
        spans=prediction_spans(known.cut),
        fields=FIELDS,
        shown=SHOWN,
        rows=cut_rows([asked]),
        force_title=force_title,
        curves=[(one, learnt_words(one), learning_plot(n, one)) for n, one in enumerate(curves)],
        maps=force_map_plots(drawn),
        limited=any(layer.limit is not None for layer in drawn.layers),
        coefficients=read_state(
            request, lambda session: _coefficients(session, machine, material, tool)
        )
        if basis.known.own
        else [],
    )


def _usual(request: Request, machine: str, material: str, tool: str) -> JobCut:
    return read_state(
        request,
        lambda session: usual_cut(session, owner_named(session, machine).id, material, tool),
    )


def _coefficients(
    session: Session, machine: str, material: str, tool: str
) -> list[tuple[str, str, str]]:
    """Return the coefficients of an orthogonal edge: name, value, and its 95 % interval."""
    (found,) = machine_coefficients(session, machine, material, tool).pairs
    edge = found.orthogonal_edge
    named: Mapping[str, BoundedValue] = {**edge.kienzle, **edge.linear}
    return [
        (name, f"{number(one.value)} {UNITS.get(one.unit, one.unit)}".strip(),
         f"{number(one.lower, like=one.value)} to {number(one.upper, like=one.value)}")
        for name, one in named.items()
    ]  # fmt: skip
