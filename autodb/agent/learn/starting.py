"""Where a pair starts that a machine has not cut."""

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.learn.shared_priors import from_others
from autodb.agent.rows.imported_cards import imported_card
from autodb.agent.rows.posteriors import Start, as_posterior, begins, latest, pair_name
from autodb.errors import UnusableInput
from autodb.pairs import conventional
from autodb.pairs.posterior import P1_SCATTER, PairPosterior
from autodb.pairs.prior import any_metal, of_card, of_relative
from autodb.store import models


def start_of(session: Session, machine_id: int, material: str, tool: str) -> Start:
    """Return where a pair starts that a machine has not cut.

    From what other machines know of the material, where there are some; else from the same material
    with another tool on this machine, where there is such a pair that did not begin from a relative
    itself (two would begin from each other, and each take its own cuts for the other's); else from
    the material's card that was imported last; else from what it is by itself.
    """
    others = from_others(session, machine_id, material, tool)
    if others is not None:
        start = PairPosterior(others.law, (), P1_SCATTER, 0)
        return begins(start, others.words, prior=others.prior)
    related = _related(session, machine_id, material, tool)
    if related is not None:
        said = f"{pair_name(related.pair)}, the same material with another tool"
        return begins(
            of_relative(as_posterior(related)), f"{said} ({related.n_cuts} cuts)", related
        )
    card = imported_card(session, machine_id, material)
    if card is not None:
        return begins(of_card(card.card), f"imported card of {card.material} ({card.source})")
    return of_material(material)


def of_material(material: str) -> Start:
    """Return what a material starts from that no machine has cut.

    Conventional values of the material that ship; else what any metal may have.
    """
    try:
        handbook = conventional.material_named(material)
    except UnusableInput:
        said = f"what any metal may have: no conventional values of '{material}'"
        return begins(any_metal(), said)
    return begins(
        conventional.posterior_of_values(handbook), f"conventional values of {handbook.name}"
    )


def _related(
    session: Session, machine_id: int, material: str, tool: str
) -> models.CuttingParameters | None:
    """Return the newest parameters of the most-cut pair of a material and another tool."""
    pairs = session.scalars(
        select(models.Pair)
        .join(models.Material)
        .join(models.Tool)
        .where(models.Material.name == material, models.Tool.name != tool)
    )
    found = [latest(session, machine_id, pair.id) for pair in pairs]
    own = [row for row in found if row is not None and row.relative_id is None]
    return max(own, key=lambda row: row.n_cuts, default=None)
