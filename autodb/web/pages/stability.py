"""Stability: to what depth cuts are stable with a tool point whose modes or receptance is given."""

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response
from pydantic import ValidationError
from starlette.datastructures import QueryParams

from autodb.agent.answer.bounds.stable import StableCut
from autodb.agent.answer.looking_up import PairReader
from autodb.errors import UnusableInput
from autodb.files.job import Job
from autodb.files.job_cut import JobCut
from autodb.files.job_words import job_in_words
from autodb.forward.stability.dynamics import AXES, SHARE, ModeSection, modes_in_words
from autodb.reports.planned.lobes import shown_lobes
from autodb.web.html import piece, service_page
from autodb.web.http.problems import first_of
from autodb.web.pages.cuts import form_of_cuts, read_cuts, rewritten, stated_rows
from autodb.web.pages.planner import NAME, first_cut
from autodb.web.pages.reading import read_state
from autodb.web.pages.typed import Typed, as_typed, typed_as, typed_now, written_cut
from autodb.web.receive.apart import JobStability
from autodb.web.routes.stability import DYNAMICS, named_file, received_dynamics, stable_apart
from autodb.web.service import Reads
from autodb.wording import msgid, phrase, shop_amount

router = APIRouter()
MODES_MOST = 20
"""Modes of a form. Chosen: more come as a file."""
PER_MM = 1000.0
MODE_FIELDS = (
    ("frequency_Hz", msgid("Frequency"), "Hz", 1.0),
    ("damping_ratio", msgid("Damping ratio"), "1", 1.0),
    ("stiffness_N_m", msgid("Stiffness"), "N/mm", PER_MM),
    ("share", msgid("Compliance known to ±"), "%", 0.01),
)
"""Numbers of a mode in a form: key, what it is called, its unit, and how many of ours that is."""
OF_MODES = "axis"


@router.get("/machines/{machine:path}/stability")
async def stability_page(
    request: Request,
    _access: Reads,
    machine: str,
    material: Annotated[str, Query(max_length=200)] = "",
    tool: Annotated[str, Query(max_length=200)] = "",
    *,
    typed: Annotated[str, Query(max_length=20)] = "",
) -> Response:
    """Show the form of cuts and modes, and the lobes once they are stated."""
    known = read_state(request, lambda session: PairReader(session, machine).pairs())
    said: object = ""
    rows: list[Mapping[str, str]] = []
    modes: list[Mapping[str, str]] = []
    answer: dict[str, Any] | None = None
    try:
        modes.extend(_mode_rows(request.query_params))
        rows.extend(stated_rows(request.query_params))
        cuts = read_cuts(rows, typed_as(typed))
        rows = rewritten(rows, cuts, typed_as(typed))
        if modes:
            stated = _modes(modes, typed_as(typed))
            modes = _rewritten_modes(modes, stated, typed_as(typed))
            job = _job(material, tool, cuts)
            task = JobStability(machine, job, Path(str(phrase("the modes"))), stated)
            found = await stable_apart(request, task)
            answer = _answered(job, list(modes_in_words(stated)), found)
    except UnusableInput as error:
        said = error
    if not rows:
        rows = [
            written_cut(
                read_state(request, lambda one: first_cut(one, machine, known, material, tool))
            )
        ]
    return service_page(
        request,
        "stability.html.j2",
        title=phrase("{machine}: stability", machine=machine),
        machine=machine,
        here="stability",
        materials=sorted({one.material for one in known}),
        tools=sorted({one.tool for one in known}),
        material=material or (known[0].material if known else ""),
        tool=tool or (known[0].tool if known else ""),
        **form_of_cuts(rows),
        mode_fields=[
            (key, phrase(called), shop_amount(1.0, unit)[1] if unit != "1" else "")
            for key, called, unit, _ in MODE_FIELDS
        ],
        modes=modes or [{OF_MODES: AXES[0], "share": as_typed(100.0 * SHARE, "%")}],
        axes=AXES,
        said=said,
        answer=answer,
    )


@router.post("/machines/{machine:path}/stability")
async def stability_of_file(
    request: Request,
    _access: Reads,
    machine: str,
    material: Annotated[str, Query(max_length=200)] = "",
    tool: Annotated[str, Query(max_length=200)] = "",
    *,
    typed: Annotated[str, Query(max_length=20)] = "",
) -> Response:
    """Answer with the piece of the page that has the lobes of cuts with a tool point's file."""
    job = _job(material, tool, read_cuts(stated_rows(request.query_params), typed_as(typed)))
    with tempfile.TemporaryDirectory(prefix="autodb-") as name:
        parts = await received_dynamics(request, machine, Path(name), (DYNAMICS,))
        path = named_file(parts[DYNAMICS])
        found = await stable_apart(request, JobStability(machine, job, path))
    point = phrase("tool point of {file}", file=path.name)
    return piece("_stable.html.j2", answer=_answered(job, [point], found))


def _answered(job: Job, point: list[str], found: Sequence[StableCut]) -> dict[str, Any]:
    """Return what the template shows of an answer, with its question."""
    asked = [f"{job.material} / {job.tool}", *job_in_words(job), *point]
    return {"asked": asked, **shown_lobes(found)}


def _job(material: str, tool: str, cuts: Sequence[JobCut]) -> Job:
    """Return the job that is asked of; raises UnusableInput where something is missing."""
    if not material or not tool or not cuts:
        raise UnusableInput(phrase("state material, tool and a cut; then ask again"))
    named = tuple(
        cut.model_copy(update={"name": cut.name or str(phrase("cut {number}", number=k))})
        for k, cut in enumerate(cuts, start=1)
    )
    return Job(name=NAME, material=material, tool=tool, cut=named)


def _mode_rows(query: QueryParams) -> list[dict[str, str]]:
    """Return what a form states of modes; raises UnusableInput for more than it may have."""
    axes = query.getlist(OF_MODES)
    if len(axes) > MODES_MOST:
        raise UnusableInput(
            phrase("{count} modes are too many; send {most}, or a file", count=len(axes),
                   most=MODES_MOST)
        )  # fmt: skip
    columns = {key: query.getlist(key) for key, *_ in MODE_FIELDS}
    return [
        {OF_MODES: axis}
        | {key: some[k] for key, some in columns.items() if k < len(some) and some[k].strip()}
        for k, axis in enumerate(axes)
    ]


def _modes(rows: Sequence[Mapping[str, str]], typed: Typed) -> tuple[ModeSection, ...]:
    """Return the modes that rows of a form state; raises UnusableInput naming mode and key."""
    found = []
    for number, row in enumerate(rows, start=1):
        try:
            stated: dict[str, object] = {OF_MODES: row[OF_MODES]}
            for key, _, unit, ours in MODE_FIELDS:
                if key in row:
                    stated[key] = ours * typed.number(key, row[key], unit)
            found.append(ModeSection.model_validate(stated))
        except UnusableInput as error:
            raise UnusableInput(
                phrase("mode {number}: {problem}", number=number, problem=error)
            ) from None
        except ValidationError as error:
            problem = first_of(error.errors())
            raise UnusableInput(
                phrase("mode {number}: {problem}", number=number, problem=problem)
            ) from None
    return tuple(found)


def _rewritten_modes(
    rows: Sequence[Mapping[str, str]], modes: Sequence[ModeSection], typed: Typed
) -> list[Mapping[str, str]]:
    """Return rows as they were typed, or, where the reader writes numbers otherwise now, anew."""
    if typed == typed_now():
        return list(rows)
    return [
        {OF_MODES: mode.axis}
        | {key: as_typed(getattr(mode, key) / ours, unit) for key, _, unit, ours in MODE_FIELDS}
        for mode in modes
    ]
