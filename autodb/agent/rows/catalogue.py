"""What all machines share: materials, tools and their pairs, added once whoever is first."""

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.errors import UnusableInput
from autodb.files.tool_sources.designations import geometry_of_code
from autodb.store import lock_catalogue, models
from autodb.wording import localized, phrase

Named = TypeVar("Named", models.Material, models.Tool)
GEOMETRY = (
    *("diameter_mm", "teeth", "helix_deg", "corner_radius_mm", "point_angle_deg"),
    *("nose_radius_mm", "kappa_deg", "rake_deg", "inclination_deg", "included_deg"),
    *("runout_mm", "runout_deg", "runout_sd_mm"),
)
"""Columns of a tool that are its geometry, as it is clamped."""


def find_or_add(session: Session, table: type[Named], name: str) -> Named:
    """Return the material or the tool of a name, new where there is none."""
    row = _called(session, table, name)
    if row is None:
        lock_catalogue(session)
        row = _called(session, table, name)  # another agent may have been faster
    if row is None:
        row = table(name=name)
        session.add(row)
        session.flush()
    return row


def pair_id(session: Session, material: str, tool: str, stated: Mapping[str, Any]) -> int:
    """Return a work-tool pair, by id, new where there is none.

    Of its tool's geometry, what is ``stated`` and nobody stated before is kept, by column.
    """
    pair = session.scalar(
        select(models.Pair)
        .join(models.Material)
        .join(models.Tool)
        .where(models.Material.name == material, models.Tool.name == tool)
    )
    if pair is not None and not _new_of(pair.tool, stated):
        return pair.id
    lock_catalogue(session)
    of_material = find_or_add(session, models.Material, material)
    of_tool = find_or_add(session, models.Tool, tool)
    session.refresh(of_tool)
    for name, value in _new_of(of_tool, stated).items():
        setattr(of_tool, name, value)
    keys = {"material_id": of_material.id, "tool_id": of_tool.id}
    pair = session.scalar(select(models.Pair).filter_by(**keys))
    if pair is None:
        pair = models.Pair(**keys)
        session.add(pair)
    session.flush()
    return pair.id


def numbers_of(tool: models.Tool) -> dict[str, float]:
    """Return what is known of a tool's geometry, by name."""
    return geometry_known(tool.name, [getattr(tool, name) for name in GEOMETRY])


def geometry_known(tool: str, stated: Sequence[float | None] = ()) -> dict[str, float]:
    """Return what is known of a tool's geometry, by name: stated, by GEOMETRY, or by its code."""
    named = zip(GEOMETRY, stated, strict=False)
    return geometry_of_code(tool) | {name: value for name, value in named if value is not None}


def refuse_other_geometry(
    tool: str, known: Mapping[str, float], stated: Mapping[str, float]
) -> None:
    """Raise UnusableInput where something else is known of a tool than is stated."""
    for name, value in stated.items():
        if name in known and known[name] != value:
            raise UnusableInput(
                phrase(
                    "tool '{tool}': {name} is {known} here and {value} in the file; give another "
                    "tool another name",
                    tool=tool,
                    name=name,
                    known=localized(f"{known[name]:g}"),
                    value=localized(f"{value:g}"),
                )
            )


def _called(session: Session, table: type[Named], name: str) -> Named | None:
    return session.scalar(select(table).where(table.name == name))


def _new_of(tool: models.Tool, stated: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is stated of a tool's geometry and nobody stated before."""
    return {name: value for name, value in stated.items() if getattr(tool, name) is None}
