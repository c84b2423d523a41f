"""Which process state a cut that is asked for is in: the one that its speed and wear imply.

A state's cuts span a range of cutting speed, time on the edge and flank wear. A cut that states one
of them inside a state's range and outside the usual state's is taken to be in that state.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from sqlalchemy import Select, bindparam, select
from sqlalchemy.orm import Session, aliased

from autodb import forward
from autodb.agent.beliefs import as_belief
from autodb.agent.learnt_from import LearntFrom, learnt_from
from autodb.forward import PredictedCut, ToolOf
from autodb.jobs import JobCut
from autodb.pairs.belief import Belief
from autodb.pairs.engaged import CUTTING_TIME, FLANK_WEAR, SPEED
from autodb.store import models

IMPLIES = (SPEED, CUTTING_TIME, FLANK_WEAR)


def predict(
    session: Session, parameters: int | None, belief: Belief, tool: ToolOf, cuts: Sequence[JobCut]
) -> tuple[tuple[PredictedCut, ...], list[models.CuttingParameters]]:
    """Predict cuts, each in the state that it implies; return them, and the states' parameters.

    ``belief`` and ``parameters``: the pair's usual state; None: the machine has not learnt it.
    """
    states = [] if parameters is None else _others(session, parameters)
    if not states or parameters is None:
        return forward.predict(belief, tool, cuts), []
    usual = learnt_from(session, parameters)
    made = {row.id: learnt_from(session, row.id) for row in states}
    found = list(forward.predict(belief, tool, cuts))
    used = []
    for k, cut in enumerate(cuts):
        stated = cut.conditions(tool.diameter_mm)
        row = next((r for r in states if _implied(stated, made[r.id], usual)), None)
        if row is not None:
            (other,) = forward.predict(as_belief(row), tool, [cut])
            found[k] = replace(other, state=row.state)
            used += [row] if row not in used else []
    return tuple(found), used


def _implied(stated: Mapping[str, float], state: LearntFrom, usual: LearntFrom) -> bool:
    return any(
        name in stated
        and name in state.ranges
        and _inside(stated[name], state.ranges[name])
        and name in usual.ranges
        and not _inside(stated[name], usual.ranges[name])
        for name in IMPLIES
    )


def _inside(value: float, ends: tuple[float, float]) -> bool:
    return ends[0] <= value <= ends[1]


def _others(session: Session, parameters: int) -> list[models.CuttingParameters]:
    """Return the newest version of each state of a pair but the usual one, the most cut first."""
    numbers = session.connection().execute(_OF_OTHER_STATES, {"usual": parameters}).scalars().all()
    rows = [session.get_one(models.CuttingParameters, number) for number in numbers]
    newest = {row.state: row for row in rows}
    return sorted(newest.values(), key=lambda row: -row.n_cuts)


def _of_other_states() -> Select[int]:
    """Return the query of a pair's versions in other states than the usual one, oldest first."""
    usual, other = (aliased(models.CuttingParameters) for _ in range(2))
    same_pair = (usual.machine_id == other.machine_id) & (usual.pair_id == other.pair_id)
    return (
        select(other.id)
        .join(usual, same_pair)
        .where(usual.id == bindparam("usual"), other.state.is_not(None), other.undone_at.is_(None))
        .order_by(other.version)
    )


_OF_OTHER_STATES = _of_other_states()
"""Made once: a look-up asks it each time."""
