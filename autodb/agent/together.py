"""What machines know together of a material, as the database keeps it.

Only what a machine's parameters say is read: what its own cuts told (autodb.pairs.hierarchy), never
a cut, a force or a recording. A prior holds sums, so that a machine's next version is added at the
cost of that version; the pairs in it are linked to it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.beliefs import LAW, OF_CALIBRATIONS, as_belief, kept_law, law_of
from autodb.fitting import Gaussian
from autodb.pairs.hierarchy import ACTIVE, STEPS, Known, OfTool, Told, told
from autodb.store import models
from autodb.store.models.learning import EVERY

Array = NDArray[np.float64]

NOTHING, RECORDINGS = "nothing", "recordings"
"""What a machine's file may say that it shares: less, and more, than its parameters."""
OTHERS = 2
"""Machines beside one's own from which on a pair starts from what they know. Chosen."""
UPPER = np.triu_indices(len(ACTIVE))


@dataclass(frozen=True)
class OwnCuts:
    """What a pair's own cuts told: with the errors of its machine's calibrations, and without.

    ``row``: the version that holds it.
    """

    row: models.CuttingParameters
    as_stated: Told
    as_felt: Told


def own_cuts(row: models.CuttingParameters) -> OwnCuts:
    """Return what a version's own cuts told; the version must say what it began with."""
    assert row.start is not None
    belief, start = as_belief(row), law_of(row.start)
    given = law_of(row.start["given"]) if "given" in row.start else start
    return OwnCuts(row, told(belief.law, start), told(belief.given(OF_CALIBRATIONS), given))


def sharing(session: Session) -> dict[int, list[models.CuttingParameters]]:
    """Return the newest versions of all pairs that machines share, by material.

    A version that does not say what it began with tells nothing that could be told apart.
    """
    parameters = models.CuttingParameters
    usual = (
        parameters.law == LAW,
        parameters.operation == EVERY,
        parameters.component == EVERY,
        parameters.state.is_(None),
        parameters.undone_at.is_(None),
    )
    newest = (
        select(parameters.machine_id, parameters.pair_id, func.max(parameters.version).label("v"))
        .where(*usual)
        .group_by(parameters.machine_id, parameters.pair_id)
        .subquery()
    )
    query = (
        select(parameters)
        .join(
            newest,
            (parameters.machine_id == newest.c.machine_id)
            & (parameters.pair_id == newest.c.pair_id)
            & (parameters.version == newest.c.v),
        )
        .join(models.Machine, models.Machine.id == parameters.machine_id)
        .where(
            *usual,
            parameters.start.is_not(None),
            models.Machine.shares.is_(None) | (models.Machine.shares != NOTHING),
        )
        .order_by(parameters.id)
    )
    found: dict[int, list[models.CuttingParameters]] = {}
    for row in session.scalars(query):
        found.setdefault(row.pair.material_id, []).append(row)
    return found


def newest_prior(session: Session, material_id: int) -> models.FleetPrior | None:
    """Return what machines know together of a material now; None: nothing yet."""
    prior = models.FleetPrior
    return session.scalar(
        select(prior)
        .where(
            prior.material_id == material_id,
            prior.operation == EVERY,
            prior.component == EVERY,
            prior.law == LAW,
        )
        .order_by(prior.version.desc())
        .limit(1)
    )


@dataclass(frozen=True)
class FromOthers:
    """What other machines than one's own know of a pair.

    ``machines``: how many of them cut the material; ``with_tool``: with the pair's tool.
    """

    prior: models.FleetPrior
    law: Gaussian
    machines: int
    with_tool: int

    @property
    def words(self) -> str:
        """How it is said what a pair started from."""
        tool = f"{self.with_tool} of them with this tool" if self.with_tool else "with other tools"
        return f"{self.machines} other machines that cut the material, {tool}"


def from_others(session: Session, machine_id: int, material: str, tool: str) -> FromOthers | None:
    """Return what others know of a pair; None where fewer than OTHERS do.

    Of the machine's own pairs, this one is taken out; its others, of other tools, stay in.
    """
    row = session.scalar(select(models.Material).where(models.Material.name == material))
    prior = None if row is None else newest_prior(session, row.id)
    if prior is None or prior.known is None:
        return None
    known = known_from(prior.known)
    machines, with_tool = set(), set()
    for own in prior.parameters:
        name = own.pair.tool.name
        if own.machine_id != machine_id:
            machines.add(own.machine_id)
            with_tool |= {own.machine_id} if name == tool else set()
        elif name == tool:
            known = known.without(tool, own_cuts(own).as_stated)
    if len(machines) < OTHERS:
        return None
    return FromOthers(prior, known.pair(tool), len(machines), len(with_tool))


def as_kept(known: Known) -> dict[str, Any]:
    """Return what is known of a material as JSON."""
    a, b = known.shares
    return {
        "start": kept_law(known.start),
        "shares": {"tools": a, "machines": b},
        "tools": {
            name: {
                "precision": [one[UPPER].tolist() for one in tool.told.precision],
                "weighted": tool.told.weighted.tolist(),
                "log": tool.log.tolist(),
                "machines": tool.machines,
            }
            for name, tool in known.tools.items()
        },
    }


def known_from(kept: Mapping[str, Any]) -> Known:
    """Return what is known of a material from JSON."""
    return Known(
        law_of(kept["start"]), {name: _of_tool(one) for name, one in kept["tools"].items()}
    )


def _of_tool(kept: Mapping[str, Any]) -> OfTool:
    size = len(ACTIVE)
    precision = np.zeros((len(STEPS), size, size))
    precision[:, *UPPER] = kept["precision"]
    precision[:, *UPPER[::-1]] = kept["precision"]
    return OfTool(
        Told(precision, np.array(kept["weighted"])), np.array(kept["log"]), kept["machines"]
    )


def machines_of(rows: Iterable[models.CuttingParameters]) -> int:
    """Return how many machines versions are of."""
    return len({row.machine_id for row in rows})


def names_of(session: Session, machine_ids: Sequence[int]) -> dict[int, str]:
    """Return the names of machines by id."""
    query = select(models.Machine.id, models.Machine.name)
    found = session.execute(query.where(models.Machine.id.in_(machine_ids)))
    return {row[0]: row[1] for row in found}
