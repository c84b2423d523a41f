"""Material cards of a machine's posteriors: Kienzle's view of its pairs, for a CAM system."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from sqlalchemy.orm import Session

from autodb.agent.answer.looking_up import Listed, PairReader
from autodb.agent.learn.known import KnownPair
from autodb.agent.learn.learnt_from import learnt_from
from autodb.agent.rows.imported_cards import made_by
from autodb.cutting import tools
from autodb.cutting.kienzle import ViewRange
from autodb.errors import UnusableInput
from autodb.pairs.card import KienzleCard, kienzle_card
from autodb.pairs.engaged import BY_NAME
from autodb.wording import listed, phrase

RAKE = "rake_deg"


@dataclass(frozen=True)
class MadeCards:
    """A card a material; ``left_out`` says of which pairs there is none, and why."""

    cards: tuple[KienzleCard, ...]
    left_out: tuple[str, ...]


def made_cards(
    session: Session, machine: str, material: str | None = None, tool: str | None = None
) -> MadeCards:
    """Return cards of the pairs that a machine has learnt: of each material, its most-cut pair.

    Raises UnusableInput where the machine, or the material or tool, is not known, it has learnt no
    pair, or no pair makes a card.
    """
    pair_reader = PairReader(session, machine)
    chosen, left_out = _most_cut(pair_reader.pairs(material, tool))
    cards = []
    for pair in chosen:
        try:
            cards.append(_card(session, pair_reader, machine, pair))
        except UnusableInput as error:
            left_out.append(error.line)
    if not cards:
        why = listed(left_out, "; ") or phrase("run 'autodb refresh'")
        raise UnusableInput(
            phrase(
                "machine '{machine}' has no pair to make a card of; {why}", machine=machine, why=why
            )
        )
    return MadeCards(tuple(cards), tuple(left_out))


def _most_cut(pairs: Sequence[Listed]) -> tuple[list[Listed], list[str]]:
    """Return the pair of each material with most cuts, and a line for each other one."""
    chosen: dict[str, Listed] = {}
    for pair in sorted(pairs, key=lambda one: -one.cuts):
        chosen.setdefault(pair.material, pair)
    left_out = [
        f"{pair.material} / {pair.tool} ({pair.cuts} cuts): the card is of "
        f"{chosen[pair.material].tool} ({chosen[pair.material].cuts} cuts); choose with --tool"
        for pair in pairs
        if chosen[pair.material] is not pair
    ]
    return [pair for pair in pairs if chosen[pair.material] is pair], left_out


def _card(session: Session, pair_reader: PairReader, machine: str, pair: Listed) -> KienzleCard:
    known = pair_reader.known(pair.material, pair.tool)
    source = (
        f"{made_by(machine)}{pair.tool}, {pair.cuts} cuts, version {pair.version}, "
        f"{pair.learnt_at[:10]}"
    )
    at = ViewRange(rake_rad=float(np.radians(rake_deg(session, known))))
    return kienzle_card(pair.material, known.posterior.law, at, source=source)


def rake_deg(session: Session, known: KnownPair) -> float:
    """Return the rake of a pair's tool; where nobody stated it, what its cuts took it for."""
    made = learnt_from(session, known.behind.parameters or 0).operations
    kinds = sorted({BY_NAME[operation].kind for operation in made})
    usual = [one for kind in kinds for one in tools.assumed_of(kind, known.tool.numbers)]
    taken = [one.value for one in usual if one.name == RAKE]
    return known.tool.numbers.get(RAKE, taken[0] if taken else 0.0)
