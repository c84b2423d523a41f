"""A machine's posterior of a work-tool pair, learnt or prior, and on what that rests."""

from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.catalogue import geometry_known, numbers_of
from autodb.agent.rows.machines import Owner
from autodb.agent.rows.posteriors import LAW, as_posterior, latest
from autodb.errors import UnusableInput
from autodb.forward.prediction import ToolOf
from autodb.pairs.posterior import PairPosterior
from autodb.store import models
from autodb.wording import phrase


@dataclass(frozen=True)
class Behind:
    """What a prediction rests on.

    ``parameters``, ``version`` and ``cuts`` of the pair's own posterior; None and 0 where the
    machine has not cut it, and then it rests on what ``started_from`` says.
    """

    parameters: int | None
    version: int | None
    cuts: int
    started_from: str | None


@dataclass(frozen=True)
class KnownPair:
    """A machine's pair: its posterior, its tool, the rows that these are from.

    ``row``: the pair's newest parameters, or a related pair's; None: no machine's. ``prior``: what
    other machines know, where the posterior is from that.
    """

    posterior: PairPosterior
    tool: ToolOf
    behind: Behind
    row: models.CuttingParameters | None
    prior: models.FleetPrior | None = None

    @property
    def own(self) -> bool:
        """Whether the machine has learnt this pair."""
        return self.behind.parameters is not None


def known_of(session: Session, owner: Owner, material: str, tool: str) -> KnownPair:
    """Return a machine's posterior of a pair, learnt or prior.

    Raises UnusableInput where the pair was learnt under an earlier law only.
    """
    its_tool = session.scalar(select(models.Tool).where(models.Tool.name == tool))
    called = ToolOf(tool, geometry_known(tool) if its_tool is None else numbers_of(its_tool))
    pair = _pair(session, material, tool)
    row = latest(session, owner.id, pair.id) if pair is not None else None
    if row is not None:
        behind = Behind(row.id, row.version, row.n_cuts, row.started_from)
        return KnownPair(as_posterior(row), called, behind, row)
    from autodb.agent.learn.starting import start_of

    _refuse_earlier_law(session, owner, pair)
    start = start_of(session, owner.id, material, tool)
    behind = Behind(None, None, 0, start.said)
    return KnownPair(start.posterior, called, behind, start.row, start.prior)


def _refuse_earlier_law(session: Session, owner: Owner, pair: models.Pair | None) -> None:
    """Raise UnusableInput where a pair's parameters are all of an earlier law."""
    earlier = pair is not None and session.scalar(
        select(models.CuttingParameters.law)
        .where(
            models.CuttingParameters.machine_id == owner.id,
            models.CuttingParameters.pair_id == pair.id,
            models.CuttingParameters.law != LAW,
        )
        .limit(1)
    )
    if earlier:
        raise UnusableInput(
            phrase(
                "machine '{owner}': its parameters of the pair belong to an earlier autodb's "
                "law; run 'autodb refresh --machine {owner}' to fit them again to the same cuts",
                owner=owner.name,
            )
        )


def _pair(session: Session, material: str, tool: str) -> models.Pair | None:
    return session.scalar(
        select(models.Pair)
        .join(models.Material)
        .join(models.Tool)
        .where(models.Material.name == material, models.Tool.name == tool)
    )
