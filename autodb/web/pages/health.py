"""A machine's health: what is due, and how its axes went over the weeks."""

from fastapi import APIRouter, Request, Response

from autodb.agent.answer.shown.axis_courses import AxisCourse, machine_course
from autodb.agent.answer.shown.due_lines import DueLine, due_on
from autodb.reports.axis_course import plot_of_axis
from autodb.web.html import path, piece, service_page
from autodb.web.pages.reading import read_state
from autodb.web.service import Reads
from autodb.wording import phrase

router = APIRouter()


@router.get("/machines/{machine:path}/health")
def health_page(request: Request, _access: Reads, machine: str) -> Response:
    """Show what is due on a machine."""
    due = read_state(request, lambda session: due_on(session, machine))
    return service_page(
        request,
        "health.html.j2",
        title=phrase("{machine}: health", machine=machine),
        machine=machine,
        here="health",
        due=[(one.words, _place(machine, one)) for one in due],
    )


@router.get("/machines/{machine:path}/health/axes")
def axes_piece(request: Request, _access: Reads, machine: str) -> Response:
    """Answer with the piece of the page that shows how axes went: it takes a while."""
    found = read_state(request, lambda session: machine_course(session, machine))
    return piece(
        "_axes.html.j2",
        machine=path("machines", machine),
        axes=[(one, plot_of_axis(one), _rows(machine, one)) for one in found.axes],
    )


def _place(machine: str, one: DueLine) -> str:
    """Return the address of what something that is due is about."""
    if one.kind == "mismatch":
        return path("mismatches", str(one.number))
    if one.kind == "recording":
        return path("machines", machine, "recordings")
    return f"{path('machines', machine)}#calibrations"


def _rows(machine: str, course: AxisCourse) -> list[tuple[str, str, str]]:
    """Return what was done on an axis and what it rests on: when, in words, and its address."""
    done = [
        (one.at, one.words, _place(machine, DueLine(one.kind, one.number, one.words)))
        for one in course.marks
    ]
    recordings = path("machines", machine, "recordings")
    shown = {one.evidence: one.at for one in (*course.air, *course.residual)}
    read: list[tuple[str, str, str]] = [
        (at, phrase("recording {number}", number=number), f"{recordings}/{number}")
        for number, at in shown.items()
    ]
    return sorted(done + read, reverse=True)
