"""Pairs of a work material and a tool: what is known of them, and how that tightened."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from sqlalchemy.orm import Session

from autodb.agent.answer.bounds.largest import WHAT, Largest, largest_value
from autodb.agent.answer.coefficients import machine_coefficients
from autodb.agent.answer.force_map import force_map
from autodb.agent.answer.looking_up import PairReader
from autodb.agent.answer.prediction_basis import PredictionBasis
from autodb.agent.learn.precision_history import precision_history
from autodb.agent.learn.usual_cut import usual_cut
from autodb.agent.rows.machines import owner_named
from autodb.errors import UnusableInput
from autodb.files.coefficients import BoundedValue
from autodb.files.cut_words import cut_in_words
from autodb.files.job_cut import JobCut
from autodb.forward.limits import standings_in_words
from autodb.reports.amounts import number, quantity
from autodb.reports.figures import force_title
from autodb.reports.page import learning_plot, learnt_words
from autodb.reports.pair import force_map_plots
from autodb.reports.planned.predicted import figure_rows
from autodb.web.html import service_page
from autodb.web.pages.cuts import form_of_cuts, prediction_spans, read_cuts, stated_rows
from autodb.web.pages.reading import read_state
from autodb.web.pages.typed import Typed, as_typed, typed_as, written_cut
from autodb.web.service import Reads, service_of
from autodb.wording import localized, msgid, phrase, shop_amount

UNITS = {"N/mm^2": "N/mm²"}
"""How units of coefficients are printed."""

router = APIRouter()


@router.get("/machines/{machine:path}/pairs")
def pairs_page(request: Request, _access: Reads, machine: str) -> Response:
    """Show the pairs that a machine has learnt."""
    listed = read_state(request, lambda session: PairReader(session, machine).pairs())
    return service_page(
        request,
        "pairs.html.j2",
        title=phrase("{machine}: pairs", machine=machine),
        machine=machine,
        here="pairs",
        pairs=listed,
    )


@router.get("/machines/{machine:path}/pair")
def pair(
    request: Request,
    _access: Reads,
    machine: str,
    material: Annotated[str, Query(max_length=200)],
    tool: Annotated[str, Query(max_length=200)],
    *,
    largest: Annotated[str, Query(max_length=20)] = "",
    share: Annotated[str, Query(max_length=20)] = "80",
    sure: Annotated[str, Query(max_length=20)] = "95",
    typed: Annotated[str, Query(max_length=20)] = "",
) -> Response:
    """Show what a pair takes: of one cut, over feed and depth, and how well that is known.

    ``largest``: what the largest is asked of, that keeps a share of each limit.
    """
    basis = service_of(request).lookup_cache.basis(machine, material, tool).basis
    how = typed_as(typed)
    stated = read_cuts(stated_rows(request.query_params), how)
    asked = stated[0] if stated else _usual(request, machine, material, tool)
    found, said = _largest(basis, asked, largest, _Kept(share, sure, how))
    asked = asked if found is None else found.cut
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
        said=said,
        answered=found is not None,
        whats=WHAT,
        share=_again(share, how),
        sure=_again(sure, how),
        spans=prediction_spans(known.cut),
        figures=figure_rows(known.figures),
        limits=list(standings_in_words(known.limits)),
        **form_of_cuts([written_cut(asked)]),
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


@dataclass(frozen=True)
class _Kept:
    """What share of limits is kept and how surely, per cent as it was typed."""

    share: str
    sure: str
    typed: Typed


def _largest(
    basis: PredictionBasis, cut: JobCut, what: str, kept: _Kept
) -> tuple[Largest | None, object]:
    """Return the largest that is asked for, if anything is, and what is said of it."""
    if not what:
        return None, ""
    try:
        found = largest_value(
            basis,
            cut,
            what,
            share=_per_cent(msgid("share"), kept.typed.number("share", kept.share), 1.0, 100.0),
            sure=_per_cent(msgid("sure"), kept.typed.number("sure", kept.sure), 50.0, 99.9),
        )
    except UnusableInput as error:
        return None, error
    return found, found.statement


def _per_cent(name: str, value: float, low: float, high: float) -> float:
    """Return a share that was typed in per cent; raises UnusableInput outside of its ends."""
    if not low <= value <= high:
        raise UnusableInput(
            phrase(
                "{name}: {value} % is not from {low} to {high}; type another",
                name=phrase(name),
                value=localized(f"{value:g}"),
                low=f"{low:g}",
                high=localized(f"{high:g}"),
            )
        )
    return value / 100.0


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
        (name, quantity(one.value, UNITS.get(one.unit, one.unit)),
         _ends(one, UNITS.get(one.unit, one.unit)))
        for name, one in named.items()
    ]  # fmt: skip


def _ends(one: BoundedValue, unit: str) -> str:
    """Return the 95 % interval of a coefficient, with the decimals of its value."""
    value, low, high = (shop_amount(end, unit)[0] for end in (one.value, one.lower, one.upper))
    return phrase("{low} to {high}", low=number(low, like=value), high=number(high, like=value))


def _again(text: str, how: Typed) -> str:
    """Return a share as it was typed, where it was not a number; else as the reader writes it."""
    try:
        return as_typed(how.number("", text), "1")
    except UnusableInput:
        return text
