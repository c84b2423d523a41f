"""Which process state a cut that is asked for is in: the one that its speed and wear imply.

A state's cuts span a range of cutting speed, time on the edge and flank wear. A cut that states one
of them inside a state's range and outside the usual state's is taken to be in that state.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from sqlalchemy import Select, bindparam, select
from sqlalchemy.orm import Session

from autodb.agent.learn.learnt_from import LearntFrom, learnt_from
from autodb.agent.rows.posteriors import as_posterior
from autodb.files.job_cut import JobCut
from autodb.forward import job_cuts
from autodb.forward.prediction import PredictedCut, ToolOf
from autodb.pairs.engaged import CUTTING_TIME, FLANK_WEAR, SPEED
from autodb.pairs.posterior import PairPosterior
from autodb.store import models

IMPLIES = (SPEED, CUTTING_TIME, FLANK_WEAR)


@dataclass(frozen=True)
class OfState:
    """A learnt pair in another state than the usual: its newest version, and what its cuts were."""

    row: models.CuttingParameters
    posterior: PairPosterior
    made: LearntFrom


@dataclass(frozen=True)
class States:
    """What the cuts of a learnt pair were in its usual state, and its others, most cut first."""

    usual: LearntFrom
    others: tuple[OfState, ...]

    def implied(self, stated: Mapping[str, float]) -> OfState | None:
        """Return the state that a cut's conditions, by channel, imply; None: the usual one."""
        return next((one for one in self.others if _implied(stated, one.made, self.usual)), None)


def states_of_version(session: Session, parameters: int) -> States:
    """Return the states of the pair that a version of its usual one, by id, is of."""
    numbers = others_of(session, parameters)
    rows = [session.get_one(models.CuttingParameters, number) for number in numbers]
    others = [
        OfState(row, as_posterior(row), learnt_from(session, row.id))
        for row in sorted(rows, key=lambda row: (-row.n_cuts, row.id))
    ]
    return States(learnt_from(session, parameters), tuple(others))


def predict_in_states(
    posterior: PairPosterior, tool: ToolOf, states: States | None, cuts: Sequence[JobCut]
) -> tuple[tuple[PredictedCut, ...], list[models.CuttingParameters]]:
    """Predict cuts, each in the state that it implies; return them, and the states' parameters.

    ``posterior``: of the usual state; ``states``: None where the machine has not learnt the pair.
    """
    if states is None or not states.others:
        return job_cuts.predict(posterior, tool, cuts), []
    which = [states.implied(cut.conditions(tool.diameter_mm)) for cut in cuts]
    found: dict[int, PredictedCut] = {}
    used = list({id(one): one for one in which if one is not None}.values())
    for state in (None, *used):
        numbers = [k for k, one in enumerate(which) if one is state]
        its = posterior if state is None else state.posterior
        name = None if state is None else state.row.state
        made = job_cuts.predict(its, tool, [cuts[k] for k in numbers])
        found |= {k: replace(one, state=name) for k, one in zip(numbers, made, strict=True)}
    return tuple(found[k] for k in range(len(cuts))), [state.row for state in used]


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


def others_of(session: Session, parameters: int) -> frozenset[int]:
    """Return the newest versions, by id, of each state of a pair but the usual one, given by id."""
    rows = session.connection().execute(_OF_OTHER_STATES, {"usual": parameters}).all()
    return frozenset({state: number for number, state in rows}.values())


def _of_other_states() -> Select[Any]:
    """Return the query of a pair's versions in other states than the usual one, oldest first."""
    parameters = models.table_of(models.CuttingParameters)
    usual, other = parameters.alias(), parameters.alias()
    same_pair = (usual.c.machine_id == other.c.machine_id) & (usual.c.pair_id == other.c.pair_id)
    return (
        select(other.c.id, other.c.state)
        .select_from(other)
        .join(usual, same_pair)
        .where(
            usual.c.id == bindparam("usual"),
            other.c.state.is_not(None),
            other.c.undone_at.is_(None),
        )
        .order_by(other.c.version)
    )


_OF_OTHER_STATES = _of_other_states()
"""Made once: a look-up asks it each time."""
