"""The score of a machine's past predictions: how far off they were, and how sure of it."""

from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy.orm import Session

from autodb.agent.matching.past_predictions import HISTORY, PastCut, past_cuts
from autodb.agent.rows.machines import find_machine
from autodb.forward.limits import QUANTITIES
from autodb.forward.scored import Score, Width, score_of, width_of
from autodb.store import Store
from autodb.wording import msgid

LEARNT, NOT_LEARNT = msgid("learnt pair"), msgid("card, relative or metal")
"""What a prediction was made from."""


@dataclass(frozen=True)
class ScoreOf:
    """The scores of predictions made from one basis, a row a quantity; the next machine's width."""

    basis: str
    scores: tuple[Score, ...]
    width: Width


@dataclass(frozen=True)
class PredictionScores:
    """What became of a machine's predictions.

    ``cuts``: those that were predicted and made, oldest first; ``scored``: those with a force or
    torque that was sensed or measured.
    """

    machine: str
    scored: int
    by_basis: tuple[ScoreOf, ...]
    cuts: tuple[PastCut, ...]


def scores_of_machine(store: Store, machine: str) -> PredictionScores:
    """Return the scores of all predictions of a machine whose cuts were made.

    Raises NotThere for an unknown machine.
    """
    with store.reading() as session:
        return scores_in(session, machine)


def scores_in(session: Session, machine: str) -> PredictionScores:
    """Return them from one state of the database; raises NotThere for an unknown machine."""
    past = past_cuts(session, find_machine(session, machine).id)
    every = ((LEARNT, True), (NOT_LEARNT, False))
    by_basis = (_scored(name, [one for one in past if one.learnt == own]) for name, own in every)
    return PredictionScores(
        machine=machine,
        scored=sum(bool(one.scored) for one in past),
        by_basis=tuple(one for one in by_basis if one.scores),
        cuts=tuple(past),
    )


def _scored(basis: str, past: Sequence[PastCut]) -> ScoreOf:
    every = [one for cut in past for one in cut.scored]
    scores = []
    for quantity in QUANTITIES:
        some = [one for one in every if one.quantity == quantity.channel]
        if some:
            scores.append(score_of(quantity.channel, some))
    newest = [one for cut in past[-HISTORY:] for one in cut.scored]
    return ScoreOf(basis, tuple(scores), width_of([], newest, upto=None))
