"""Tools by ISO 13399 property codes, and what a machine has learnt of pairs as coefficients."""

from typing import Annotated

from fastapi import APIRouter, Path, Query, Request, Response
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.answer.coefficients import machine_coefficients, tool_of
from autodb.errors import NotThere, near
from autodb.files.coefficients import Coefficients, ToolCoefficients
from autodb.store import models
from autodb.web.routes.machines import PAGE, MachineName, Most, answer_from_state, documented_answer
from autodb.web.service import Reads

router = APIRouter()


@router.get("/tools", summary="Tools", **documented_answer(list[ToolCoefficients]))
def tools(
    request: Request,
    _access: Reads,
    most: Most = PAGE,
    after: Annotated[str, Query(description="Only those behind this name.")] = "",
) -> Response:
    """List tools by name, with what is known of their geometry by ISO 13399 property code."""

    def some(session: Session) -> list[ToolCoefficients]:
        by_name = select(models.Tool).where(models.Tool.name > after).order_by(models.Tool.name)
        return [tool_of(row) for row in session.scalars(by_name.limit(most))]

    return answer_from_state(request, list[ToolCoefficients], some)


@router.get("/tools/{name:path}", summary="One tool", **documented_answer(ToolCoefficients))
def one_tool(
    request: Request,
    _access: Reads,
    name: Annotated[str, Path(description="Name of the tool.", examples=["CNMG 120408"])],
) -> Response:
    """Say what is known of a tool's geometry, by ISO 13399 property code where it has one."""

    def one(session: Session) -> ToolCoefficients:
        row = session.scalar(select(models.Tool).where(models.Tool.name == name))
        if row is None:
            every = list(session.scalars(select(models.Tool.name)))
            raise NotThere(f"no tool '{name}'{near(name, every) if every else ''}")
        return tool_of(row)

    return answer_from_state(request, ToolCoefficients, one)


@router.get(
    "/machines/{machine:path}/coefficients",
    summary="Coefficients of its pairs",
    **documented_answer(Coefficients),
)
def its_coefficients(
    request: Request,
    _access: Reads,
    machine: MachineName,
    material: Annotated[str | None, Query(examples=["C45"])] = None,
    tool: Annotated[str | None, Query(examples=["CNMG 120408"])] = None,
) -> Response:
    """Say what a machine has learnt of its pairs: the law's numbers, Kienzle's, and their bounds.

    As `autodb export --coefficients` writes it.
    """
    return answer_from_state(
        request,
        Coefficients,
        lambda session: machine_coefficients(session, machine, material, tool),
    )
