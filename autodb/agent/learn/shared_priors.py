"""What machines know together of a material, as the database keeps it.

Only what a machine's parameters say is read: the information of its own cuts
(autodb.pairs.hierarchy), never a cut, a force or a recording. A prior holds sums, so that a
machine's next version is added at the cost of that version; the pairs in it are linked to it.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.rows.posteriors import LAW, OF_CALIBRATIONS, kept_law, law_from_json, posterior_of
from autodb.fitting.gaussian import Gaussian
from autodb.pairs.hierarchy import (
    ACTIVE,
    STEPS,
    InformationOfCuts,
    KnownMaterial,
    OfTool,
    information_of_cuts,
)
from autodb.store import models
from autodb.store.models.learning import EVERY, fleet_prior_parameters

Array = NDArray[np.float64]

NOTHING, RECORDINGS = "nothing", "recordings"
"""What a machine's file may say that it shares: less, and more, than its parameters."""
OTHERS = 2
"""Machines beside one's own from which on a pair starts from what they know. Chosen."""
UPPER = np.triu_indices(len(ACTIVE))


@dataclass(frozen=True)
class PairVersion:
    """The newest version of a machine's pair, by its keys: its numbers are read where needed."""

    id: int
    machine_id: int
    pair_id: int
    material_id: int
    tool: str
    rake_deg: float | None


@dataclass(frozen=True)
class OwnCuts:
    """Information of a pair's own cuts: with the errors of its machine's calibrations, and
    without."""

    as_stated: InformationOfCuts
    as_sensed: InformationOfCuts


_P = models.CuttingParameters
_VERSION = (
    select(
        _P.id, _P.machine_id, _P.pair_id, models.Pair.material_id, models.Tool.name,
        models.Tool.rake_deg,
    )
    .join(models.Pair, models.Pair.id == _P.pair_id)
    .join(models.Tool, models.Tool.id == models.Pair.tool_id)
    .order_by(_P.id)
)  # fmt: skip
_USUAL = (
    _P.law == LAW,
    _P.operation == EVERY,
    _P.component == EVERY,
    _P.state.is_(None),
    _P.undone_at.is_(None),
)


def own_cuts(session: Session, version: int) -> OwnCuts:
    """Return the information of a version's own cuts; it must say what it began with."""
    columns = (_P.mean, _P.covariance, _P.shared, _P.scatter, _P.terms, _P.n_cuts, _P.start)
    *kept, cuts, start = session.execute(select(*columns).where(_P.id == version)).one()
    posterior, before = posterior_of(*kept, cuts=cuts), law_from_json(start)
    given = law_from_json(start["given"]) if "given" in start else before
    return OwnCuts(
        information_of_cuts(posterior.law, before),
        information_of_cuts(posterior.given(OF_CALIBRATIONS), given),
    )


def sharing(session: Session) -> dict[int, list[PairVersion]]:
    """Return the newest versions of all pairs that machines share, by material.

    A version that does not say what it began with gives no information of its own.
    """
    newest = (
        select(_P.machine_id, _P.pair_id, func.max(_P.version).label("version"))
        .where(*_USUAL)
        .group_by(_P.machine_id, _P.pair_id)
        .subquery()
    )
    same = (
        (_P.machine_id == newest.c.machine_id)
        & (_P.pair_id == newest.c.pair_id)
        & (_P.version == newest.c.version)
    )
    query = (
        _VERSION.join(newest, same)
        .join(models.Machine, models.Machine.id == _P.machine_id)
        .where(
            *_USUAL,
            _P.start.is_not(None),
            models.Machine.shares.is_(None) | (models.Machine.shares != NOTHING),
        )
    )
    found: dict[int, list[PairVersion]] = {}
    for row in session.execute(query):
        version = PairVersion(*row)
        found.setdefault(version.material_id, []).append(version)
    return found


def pairs_in(
    session: Session, prior: models.FleetPrior, *, machine_id: int | None = None
) -> list[PairVersion]:
    """Return the versions whose sums a prior holds, all or those of one machine."""
    link = fleet_prior_parameters.c
    query = _VERSION.join(fleet_prior_parameters, link.cutting_parameters_id == _P.id)
    query = query.where(link.fleet_prior_id == prior.id)
    if machine_id is not None:
        query = query.where(_P.machine_id == machine_id)
    return [PairVersion(*row) for row in session.execute(query)]


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


def known_materials(session: Session) -> set[int]:
    """Return the materials, by id, of which machines know something together now."""
    prior = models.FleetPrior
    return set(session.scalars(select(prior.material_id).where(prior.known.is_not(None))))


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
    own = pairs_in(session, prior, machine_id=machine_id)
    machines = prior.machines - bool(own)
    if machines < OTHERS:
        return None
    known = known_from(prior.known)
    for one in own:
        if one.tool == tool:
            known = known.without(tool, own_cuts(session, one.id).as_stated)
    with_tool = known.tools[tool].machines if tool in known.tools else 0
    return FromOthers(prior, known.pair(tool), machines, with_tool)


def as_kept(known: KnownMaterial) -> dict[str, Any]:
    """Return what is known of a material as JSON."""
    a, b = known.shares
    return {
        "start": kept_law(known.start),
        "shares": {"tools": a, "machines": b},
        "tools": {
            name: {
                "precision": [one[UPPER].tolist() for one in tool.information.precision],
                "weighted": tool.information.weighted.tolist(),
                "log": tool.log.tolist(),
                "machines": tool.machines,
            }
            for name, tool in known.tools.items()
        },
    }


def known_from(kept: Mapping[str, Any]) -> KnownMaterial:
    """Return what is known of a material from JSON."""
    return KnownMaterial(
        law_from_json(kept["start"]), {name: _of_tool(one) for name, one in kept["tools"].items()}
    )


def _of_tool(kept: Mapping[str, Any]) -> OfTool:
    size = len(ACTIVE)
    precision = np.zeros((len(STEPS), size, size))
    precision[:, *UPPER] = kept["precision"]
    precision[:, *UPPER[::-1]] = kept["precision"]
    return OfTool(
        InformationOfCuts(precision, np.array(kept["weighted"])),
        np.array(kept["log"]),
        kept["machines"],
    )


def machines_of(versions: Iterable[PairVersion]) -> int:
    """Return how many machines versions are of."""
    return len({one.machine_id for one in versions})


def machine_names(session: Session) -> dict[int, str]:
    """Return the names of all machines by id."""
    rows = session.execute(select(models.Machine.id, models.Machine.name))
    return {row[0]: row[1] for row in rows}
