"""What the cuts behind a posterior were: their operations, and the ranges of what they state.

Wear that a pair's posterior holds, in words: how much, and what it is of a cut asked for.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from sqlalchemy import bindparam, func, literal_column, select
from sqlalchemy.orm import Session

from autodb.files.job_cut import JobCut
from autodb.fitting.gaussian import NORMAL_95
from autodb.forward.prediction import PredictedCut, ToolOf
from autodb.pairs.engaged import BY_NAME, CUTTING_TIME, DEPTH, FEED, FLANK_WEAR, SPEED, UNSAID
from autodb.pairs.forecast import worn
from autodb.pairs.posterior import WEAR, PairPosterior
from autodb.store import models
from autodb.store.models.learning import cutting_parameters_force
from autodb.wording import significant

CHANNELS = (DEPTH, FEED, SPEED, CUTTING_TIME, FLANK_WEAR)
"""What a cut's ranges are kept of."""


@dataclass(frozen=True)
class LearntFrom:
    """``operations`` that were cut; ``ranges``: lowest and highest of a channel, where stated."""

    operations: frozenset[str]
    ranges: Mapping[str, tuple[float, float]]


_PARAMETERS, _CUT, _FORCE = map(
    models.table_of, (models.CuttingParameters, models.Cut, models.SensedForce)
)
_versions = (
    select(_PARAMETERS.c.id, _PARAMETERS.c.previous_id)
    .where(_PARAMETERS.c.id == bindparam("newest"))
    .cte("versions", recursive=True)
)
_versions = _versions.union_all(
    select(_PARAMETERS.c.id, _PARAMETERS.c.previous_id).join(
        _versions, _PARAMETERS.c.id == _versions.c.previous_id
    )
)
_stated = [_CUT.c.conditions[name].as_float() for name in CHANNELS]
_operation = func.coalesce(_CUT.c.operation, literal_column(f"'{UNSAID}'"))
_used = cutting_parameters_force.c
_LEARNT_FROM = (
    select(
        _operation,
        *(end(one) for one in _stated for end in (func.min, func.max)),
    )
    .select_from(_versions)
    .join(cutting_parameters_force, _used.cutting_parameters_id == _versions.c.id)
    .join(_FORCE, _FORCE.c.id == _used.sensed_force_id)
    .join(_CUT, _CUT.c.id == _FORCE.c.cut_id)
    .group_by(_operation)
)
"""Of a version and those it was built on, one row an operation."""


def learnt_from(session: Session, parameters_id: int) -> LearntFrom:
    """Return what the cuts of a version and of those before it were."""
    rows = session.connection().execute(_LEARNT_FROM, {"newest": parameters_id}).all()
    ranges = {}
    for k, name in enumerate(CHANNELS):
        low = [row[2 * k + 1] for row in rows if row[2 * k + 1] is not None]
        high = [row[2 * k + 2] for row in rows if row[2 * k + 2] is not None]
        if low:
            ranges[name] = (min(low), max(high))
    return LearntFrom(frozenset(row[0] for row in rows), ranges)


def wear_words(posterior: PairPosterior) -> str:
    """Return how a posterior says that edges wear."""
    wear = posterior.wear
    assert wear is not None
    place = posterior.columns(WEAR)
    half = NORMAL_95 * np.sqrt(np.diag(posterior.state.covariance)[place])
    along, across = (
        f"{significant(value)} ({significant(value - one)} to {significant(value + one)})"
        for value, one in zip(posterior.state.mean[place], half, strict=True)
    )
    differ = f"edges differ by {100 * wear.between:.0f} %" if wear.between else "edges alike"
    return (
        f"{WEAR}: each mm of an edge takes {along} N more along the cutting speed and {across} N "
        f"across the edge after {wear.reference_s:.0f} s, as T^{wear.power:.2g}; {differ}"
    )


def said_of_wear(
    posterior: PairPosterior, tool: ToolOf, asked: Sequence[JobCut], found: Sequence[PredictedCut]
) -> Iterator[str]:
    """Say what wear is of the forces predicted, and which cuts count as made with a fresh edge.

    ``asked``: none for the lines of a program, which state nothing of their edge.
    """
    if posterior.wear is None:
        return
    fresh = [k for k, cut in enumerate(asked, start=1) if cut.cutting_time_s is None]
    if fresh or not asked:
        which = f"cut {', '.join(map(str, fresh))}" if fresh else "every line"
        yield (
            f"{which}: predicted for a fresh edge; the pair's edges wear, so state in "
            "cutting_time_s how long the edge has cut before"
        )
    for number, cut in enumerate(asked, start=1):
        if cut.cutting_time_s and found[number - 1].state is None:
            name = f" '{cut.name}'" if cut.name else ""
            yield f"cut {number}{name}: {_of_cut(posterior, tool, cut)}"


def _of_cut(posterior: PairPosterior, tool: ToolOf, cut: JobCut) -> str:
    """Return what wear is of each force of a cut, with 95 % intervals."""
    assert posterior.wear is not None
    assert cut.cutting_time_s is not None
    conditions = [cut.conditions(tool.diameter_mm)]
    added = worn(posterior, BY_NAME[cut.operation].cuts(tool.numbers, conditions, called=tool.name))
    place, by = posterior.columns(WEAR), added.slopes[0, :3]
    covariance = posterior.state.covariance[place, place]
    half = NORMAL_95 * np.sqrt(np.einsum("qi,ij,qj->q", by, covariance, by) + added.own[0, :3])
    forces = ", ".join(
        f"force.{component} {value:.0f} N ({value - one:.0f} to {value + one:.0f})"
        for component, value, one in zip("xyz", added.mean[0, :3], half, strict=True)
    )
    longest_s = posterior.wear.reference_s
    beyond = (
        f"; no edge was seen beyond {longest_s:.0f} s" if cut.cutting_time_s > longest_s else ""
    )
    return f"its edge has cut {cut.cutting_time_s:g} s before; {WEAR} is {forces} of it{beyond}"
