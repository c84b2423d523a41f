"""What machines know together, to be shown."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from sqlalchemy.orm import Session

from autodb.agent.fleet.named import DisagreeingMachine, as_named
from autodb.agent.learn.together import known_materials, newest_prior
from autodb.cutting import shear
from autodb.errors import UnusableInput
from autodb.fitting import NORMAL_95
from autodb.store import models


@dataclass(frozen=True)
class OfMaterial:
    """What machines know together of a material, to be shown: how far tools and machines are
    apart, shares of what metals are; ``numbers`` of the law with 95 % intervals.
    """

    material: str
    machines: int
    tools: int
    tools_apart: float
    machines_apart: float
    numbers: tuple[str, ...]


@dataclass(frozen=True)
class SharedKnowledge:
    """What machines know together, by material, and the machines that disagree."""

    materials: list[OfMaterial]
    named: list[DisagreeingMachine]


SHOWN = ("shear_stress", "friction_angle", "K_te")


def shared_knowledge(session: Session) -> SharedKnowledge:
    """Return what machines know together now; raises UnusableInput where that is nothing."""
    materials: list[OfMaterial] = []
    named: dict[str, DisagreeingMachine] = {}
    for number in known_materials(session):
        prior = newest_prior(session, number)
        if prior is None or prior.known is None:
            continue
        named |= {one["machine"]: as_named(one) for one in prior.known["named"]}
        materials.append(_shown(prior, prior.known))
    if not materials:
        raise UnusableInput("machines know nothing together yet; 'autodb fleet learn' would")
    ordered = sorted(materials, key=lambda one: one.material)
    return SharedKnowledge(ordered, [named[name] for name in sorted(named)])


def _shown(prior: models.FleetPrior, known: Mapping[str, Any]) -> OfMaterial:
    mean, sd = np.array(prior.mean), np.sqrt(np.diag(np.array(prior.covariance)))
    low, high = (shear.law_values(mean + side * NORMAL_95 * sd) for side in (-1.0, 1.0))
    middle = shear.law_values(mean)
    return OfMaterial(
        material=prior.material.name,
        machines=prior.machines,
        tools=len(known["tools"]),
        tools_apart=known["shares"]["tools"],
        machines_apart=known["shares"]["machines"],
        numbers=tuple(f"{middle[n]:.3g} ({low[n]:.3g} to {high[n]:.3g})" for n in SHOWN),
    )
