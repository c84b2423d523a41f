"""A machine as answers about it need it: read by one query."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Select, bindparam, select
from sqlalchemy.orm import Session

from autodb.agent.rows.machines import LIMITS, find_machine, limits_of, with_fastest
from autodb.files.machine import AxisLimits
from autodb.store import models


@dataclass(frozen=True)
class Owner:
    """A machine: its row's number, its name, and what its axes may carry, by their names."""

    id: int
    name: str
    limits: Mapping[str, AxisLimits]


def owner_of(machine: models.Machine) -> Owner:
    """Return a machine that was read already."""
    return Owner(machine.id, machine.name, limits_of(machine))


def owner_named(session: Session, name: str) -> Owner:
    """Read the machine called ``name``; raises NotThere naming near ones."""
    rows = session.connection().execute(_NAMED, {"name": name}).all()
    if not rows:
        return owner_of(find_machine(session, name))
    limits = {axis: _limits(own) for _, _, axis, *own in rows if axis}
    return Owner(rows[0].id, name, with_fastest(limits, rows[0].max_speed_rpm))


def _limits(columns: list[Any]) -> AxisLimits:
    return AxisLimits(**dict(zip(LIMITS, columns, strict=True)))


def _named() -> Select[Any]:
    machine, axis = models.table_of(models.Machine), models.table_of(models.Axis)
    columns = (axis.c[column] for column in LIMITS.values())
    return (
        select(machine.c.id, machine.c.max_speed_rpm, axis.c.name, *columns)
        .select_from(machine)
        .outerjoin(axis, axis.c.machine_id == machine.c.id)
        .where(machine.c.name == bindparam("name"))
        .order_by(axis.c.id)
    )


_NAMED = _named()
