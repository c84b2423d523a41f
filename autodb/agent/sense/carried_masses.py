"""Masses of a machine's slides, where its axes carry each other and all of them are identified."""

import math

from sqlalchemy.orm import Session

from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.identifying import newest_model, stored_terms
from autodb.agent.sense.reconstructing import known_scale
from autodb.agent.sense.scaling import TONNE_KG
from autodb.files.channels import LINEAR_AXES
from autodb.sensing.drives.masses import Mass, own_masses
from autodb.store import Store, models

EFFORTS = ("drive_force", "current")
"""Channels that tell a mass: force, or current where newtons an ampere are known."""


def slide_masses(store: Store, machine: str) -> dict[str, Mass]:
    """Return the mass of each slide alone, kg; none unless linear axes carry each other and every
    one of them has a model whose inertia is known in newtons.
    """
    with store.reading() as session:
        owner = find_machine(session, machine)
        linear = [axis for axis in owner.axes if axis.name in LINEAR_AXES]
        carried_by = {axis.name: axis.carried_by for axis in linear}
        moved = {axis.name: _moved(session, owner.id, axis) for axis in linear}
    known = {name: mass for name, mass in moved.items() if mass is not None}
    if len(known) < len(linear) or not any(below in known for below in carried_by.values()):
        return {}
    return own_masses(known, carried_by)


def _moved(session: Session, machine_id: int, axis: models.Axis) -> Mass | None:
    """Return what an axis moves; None where no model of it tells."""
    for effort in EFFORTS:
        row = newest_model(session, machine_id, f"{axis.name}.{effort}")
        inertia = row and next(
            (t for t in stored_terms(row) if t.term == "inertia" and t.sd is not None), None
        )
        if row is None or not inertia or inertia.sd is None:
            continue
        if row.unit == "N":
            return Mass(TONNE_KG * inertia.value, TONNE_KG * inertia.sd)
        scale = known_scale(session, axis)
        if scale is not None and row.unit == "A":
            kg = TONNE_KG * inertia.value * scale.per_ampere
            return Mass(kg, kg * math.hypot(inertia.sd / inertia.value, scale.share))
    return None
