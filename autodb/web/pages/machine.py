"""One machine: its axes and limits, what it can sense, its drives, and what moved and when."""

from fastapi import APIRouter, Request, Response
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.answer.overview import MachineSaid, machine_said
from autodb.agent.learn.passes import last_passes_of
from autodb.agent.operate.changed_edges import EdgeOfTool, EdgesOfMachine, edges_of_machine
from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.drive_maps import DriveMap, drive_map, modelled_channels
from autodb.agent.sense.sensors import Sensor, sensors_of
from autodb.files.channels import axis_words
from autodb.files.machine import AxisLimits
from autodb.reports import axis
from autodb.reports.amounts import quantity
from autodb.reports.machine_page import calibration_plots
from autodb.reports.page import CalibrationPlot, calibration_plot, equation_words
from autodb.store import models
from autodb.web.html import service_page
from autodb.web.pages.reading import read_state
from autodb.web.service import Reads, service_of
from autodb.wording import amount_words, day, listed, localized, phrase

PASSES = 20
"""Refreshes that are shown. Chosen."""
AGAIN_S = 5
"""After so long a browser without scripts asks again for a machine that learns. Chosen."""
LIMITS = (
    ("force_N", "N"), ("torque_N_m", "N·m"), ("power_W", "W"), ("speed_mm_min", "mm/min"),
    ("speed_rpm", "rpm"),
)  # fmt: skip

router = APIRouter()


@router.get("/machines/{machine:path}/moved")
def refreshes_page(request: Request, _access: Reads, machine: str) -> Response:
    """Show what refreshes found, the newest first."""

    def asked(session: Session) -> list[tuple[str, list[str]]]:
        number = find_machine(session, machine).id
        found = last_passes_of(session, number, most=PASSES)
        return [(day(one.finished_at), one.done.lines()) for one in found]

    return service_page(
        request,
        "moved.html.j2",
        title=phrase("{machine}: what moved", machine=machine),
        machine=machine,
        here="moved",
        passes=read_state(request, asked),
    )


@router.get("/machines/{machine:path}/drives/{channel}")
def drive(request: Request, _access: Reads, machine: str, channel: str) -> Response:
    """Show a drive's model: its terms, and its effort over place and velocity."""

    def asked(session: Session) -> DriveMap:
        return drive_map(session, machine, channel)

    found = read_state(request, asked)
    maps = [] if found.field is None else axis.field_plots(found.field, found.axis, found.unit)
    return service_page(
        request,
        "drive.html.j2",
        title=f"{machine}: {channel}",
        machine=machine,
        drive=found,
        error=f"{localized(f'{100.0 * found.relative_error:.2g}')} %",
        terms=[axis.term_row(one) for one in found.terms],
        maps=maps,
    )


@router.get("/machines/{machine:path}")
def machine_page_of(request: Request, _access: Reads, machine: str) -> Response:
    """Show one machine."""
    return show_machine(request, machine)


def show_machine(
    request: Request,
    machine: str,
    *,
    refused: str = "",
    edge_refused: str = "",
    status: int = 200,
) -> Response:
    """Return the page of a machine; ``refused``: why it does not begin to learn, and
    ``edge_refused``: why no edge change is recorded.
    """
    said, sensed, blind, plots, channels = read_state(
        request, lambda session: _of(session, machine)
    )
    edges = read_state(request, lambda session: edges_of_machine(session, machine))
    learning = service_of(request).learnings.said(machine)
    return service_page(
        request,
        "machine.html.j2",
        title=machine,
        status=status,
        machine=machine,
        here="machine",
        learning=learning,
        refused=refused,
        edges=_edge_rows(edges),
        tools=edges.tools,
        edge_refused=edge_refused,
        again_s=AGAIN_S if learning is not None and learning.state == "running" else None,
        said=said,
        limits={name: _limits(one) for name, one in said.limits.items()},
        sensors=[(one, _error(one)) for one in sensed],
        blind=[name.removeprefix("force.").upper() for name in blind],
        calibrations=[
            (one, calibration_plot(n, one), equation_words(one)) for n, one in enumerate(plots)
        ],
        channels=channels,
        axis_words=axis_words,
    )


def _of(
    session: Session, machine: str
) -> tuple[MachineSaid, list[Sensor], list[str], list[CalibrationPlot], list[str]]:
    said = machine_said(session, machine)
    owner = session.scalars(select(models.Machine).where(models.Machine.name == machine)).one()
    sensed, blind = sensors_of(session, machine)
    plots = calibration_plots(session, owner)
    return said, sensed, blind, plots, modelled_channels(session, owner.id)


def _edge_rows(found: EdgesOfMachine) -> list[tuple[str, EdgeOfTool | None, str]]:
    """Return each tool with the last change of its edge, and how long the edge has cut since."""
    last = {one.tool: one for one in found.edges}
    return [(tool, last.get(tool), _has_cut(last.get(tool))) for tool in found.tools]


def _has_cut(one: EdgeOfTool | None) -> str:
    if one is None:
        return ""
    if one.cut_s is None:
        return phrase("not known")
    return amount_words(one.cut_s / 60.0, "min", ".1f")


def _limits(one: AxisLimits) -> str:
    """Return what an axis may carry, in words; empty where nothing is stated."""
    stated = ((getattr(one, key), unit) for key, unit in LIMITS)
    said = [amount_words(value, unit) for value, unit in stated if value is not None]
    if one.travel_low_mm is not None and one.travel_high_mm is not None:
        low, high = amount_words(one.travel_low_mm, "mm"), amount_words(one.travel_high_mm, "mm")
        said.append(phrase("{low} to {high}", low=low, high=high))
    for curve, unit in ((one.torque_curve, "N·m"), (one.power_curve, "W")):
        for rpm, value in curve or ():
            at = amount_words(rpm, "rpm")
            said.append(phrase("{value} at {speed}", value=amount_words(value, unit), speed=at))
    if one.efficiency is not None:
        said.append(phrase("efficiency {share}", share=localized(f"{one.efficiency:g}")))
    return listed(said)


def _error(one: Sensor) -> str:
    if one.error is None:
        return ""
    return phrase("{error} on {what}", error=quantity(one.error, one.unit), what=phrase(one.of))
