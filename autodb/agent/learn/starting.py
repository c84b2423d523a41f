"""Where a pair starts that a machine has not cut."""

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.learn.shared_priors import from_others, own_cuts
from autodb.agent.rows.imported_cards import imported_card
from autodb.agent.rows.posteriors import (
    OF_CALIBRATIONS,
    Start,
    as_posterior,
    begins,
    latest,
    law_from_json,
    pair_name,
)
from autodb.errors import UnusableInput
from autodb.pairs.handbook import conventional
from autodb.pairs.hierarchy import of_relatives
from autodb.pairs.posterior import USUAL_SCATTER, PairPosterior
from autodb.pairs.prior import any_metal, of_card, of_relative
from autodb.store import models
from autodb.wording import stored_msgid

ANY_METAL = stored_msgid("what any metal may have: no conventional values of '{material}'")
LIKE_ANOTHER = stored_msgid(
    "what any metal may have: no conventional values of '{material}' (did you mean {names}?)"
)
OTHER_TOOL = stored_msgid("{pair}, the same material with another tool ({count} cuts)")
OTHER_TOOLS = stored_msgid(
    "{pair}, the same material with another tool ({count} cuts), and with {tools}"
)
FROM_HANDBOOK = stored_msgid("conventional values of {material}")
FROM_GROUP = stored_msgid("conventional values of {material} (VDI 3323 group {number})")
"""As the first where the handbook knows a material by its group alone: its name says so."""
FROM_CARD = stored_msgid("imported card of {material} ({source})")


def start_of(session: Session, machine_id: int, material: str, tool: str) -> Start:
    """Return where a pair starts that a machine has not cut.

    From what other machines know of the material, where there are some; else from the same material
    with other tools on this machine (``_of_other_tools``); else from the material's card that was
    imported last; else from what it is by itself.
    """
    others = from_others(session, machine_id, material, tool)
    if others is not None:
        start = PairPosterior(others.law, (), USUAL_SCATTER, 0)
        return begins(start, others.words, prior=others.prior)
    related = _of_other_tools(session, machine_id, material, tool)
    if related is not None:
        return related
    card = imported_card(session, machine_id, material)
    if card is not None:
        return begins(
            of_card(card.card), FROM_CARD.format(material=card.material, source=card.source)
        )
    return of_material(material)


def of_material(material: str) -> Start:
    """Return what a material starts from that no machine has cut.

    Conventional values of the material that ship; else what any metal may have.
    """
    try:
        handbook = conventional.material_named(material)
    except UnusableInput:
        alike = conventional.alike_named(material)
        said = ANY_METAL.format(material=material)
        if alike:
            said = LIKE_ANOTHER.format(material=material, names=", ".join(alike))
        return begins(any_metal(), said)
    return begins(
        conventional.posterior_of_values(handbook), FROM_HANDBOOK.format(material=handbook.name)
    )


def _of_other_tools(session: Session, machine_id: int, material: str, tool: str) -> Start | None:
    """Return what pairs of a material and other tools say of it; None where there is none.

    The first is the most-cut one that did not begin from another itself (two would begin from each
    other, and each take its own cuts for the other's); of others counts what their own cuts say,
    where the calibrations that sensed them are among the first's.
    """
    every = _newest_of(session, machine_id, material, tool)
    own = [row for row in every if row.relative_id is None]
    first = max(own, key=lambda row: row.n_cuts, default=None)
    if first is None:
        return None
    posterior, said = as_posterior(first), pair_name(first.pair)
    sensing = _calibrations(posterior)
    more = [
        row
        for row in every
        if row is not first and row.start and _calibrations(as_posterior(row)) <= sensing
    ]
    if not more or first.start is None:
        words = OTHER_TOOL.format(pair=said, count=first.n_cuts)
        return begins(of_relative(posterior), words, first)
    said_of = {row.pair.tool.name: own_cuts(session, row.id).as_sensed for row in (first, *more)}
    law = of_relatives(posterior, law_from_json(first.start), said_of, tool)
    named = ", ".join(f"{row.pair.tool.name} ({row.n_cuts} cuts)" for row in more)
    words = OTHER_TOOLS.format(pair=said, count=first.n_cuts, tools=named)
    return begins(law, words, first, others=[row.id for row in more])


def _calibrations(posterior: PairPosterior) -> set[str]:
    return {one.key for one in posterior.shared if one.key.startswith(OF_CALIBRATIONS)}


def _newest_of(
    session: Session, machine_id: int, material: str, tool: str
) -> list[models.CuttingParameters]:
    """Return the newest parameters of pairs of a material and other tools, one each."""
    pairs = session.scalars(
        select(models.Pair)
        .join(models.Material)
        .join(models.Tool)
        .where(models.Material.name == material, models.Tool.name != tool)
    )
    found = [latest(session, machine_id, pair.id) for pair in pairs]
    return [row for row in found if row is not None]
