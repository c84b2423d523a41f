"""How what is known of a pair tightened: a usual cut's forces, as each kept version had them."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.posteriors import LAW, as_posterior, law_from_json
from autodb.agent.rows.sensed_forces import QUANTITY
from autodb.cutting.turning import PASSIVE_AXIS
from autodb.files.job_cut import JobCut
from autodb.forward.prediction import ToolOf
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.forecast import forecast
from autodb.store import models

Array = NDArray[np.float64]

SHOWN = 30
"""Versions that are shown: the first and the newest ones. Chosen."""


@dataclass(frozen=True)
class LearningCurve:
    """The posterior of one component of one cut's force, N, after n cuts: n, mean, sd (m,)."""

    component: str
    cut: str
    n: Array
    mean: Array
    sd: Array
    operation: str = ""


def precision_history(
    session: Session, machine_id: int, material: str, tool: ToolOf, cut: JobCut
) -> tuple[LearningCurve, ...]:
    """Return what a pair began with and its versions expect of a cut, a curve each component.

    The standard deviation is what is open of the law's numbers: without what each cut has of its
    own, which no cut would tighten.
    """
    rows = _versions(session, machine_id, material, tool.name)
    known = [as_posterior(row) for row in rows]
    if rows and rows[0].start is not None:
        known.insert(0, replace(known[0], state=law_from_json(rows[0].start), shared=(), cuts=0))
    stated = [cut.conditions(tool.diameter_mm)]
    asked = BY_NAME[cut.operation].cuts(tool.numbers, stated, called=tool.name)
    expected = [forecast(one, asked) for one in known]
    return tuple(
        LearningCurve(
            component=component,
            cut=cut.name,
            operation=cut.operation,
            n=np.array([one.cuts for one in known], dtype=np.float64),
            mean=np.array([one.mean[0, k] for one in expected]),
            sd=np.array([np.sqrt(max(one.sd[0, k] ** 2 - one.own[0, k], 0.0)) for one in expected]),
        )
        for component, k in QUANTITY.items()
        if component != PASSIVE_AXIS.get(cut.operation) and known
    )


def _versions(
    session: Session, machine_id: int, material: str, tool: str
) -> list[models.CuttingParameters]:
    """Return the first and the newest versions of a pair in its usual state, oldest first."""
    table = models.CuttingParameters
    query = (
        select(table)
        .join(models.Pair, models.Pair.id == table.pair_id)
        .join(models.Material, models.Material.id == models.Pair.material_id)
        .join(models.Tool, models.Tool.id == models.Pair.tool_id)
        .where(
            table.machine_id == machine_id,
            table.law == LAW,
            table.state.is_(None),
            table.undone_at.is_(None),
            models.Material.name == material,
            models.Tool.name == tool,
        )
    )
    newest = session.scalars(query.order_by(table.version.desc()).limit(SHOWN - 1)).all()
    first = session.scalars(query.order_by(table.version).limit(1)).all()
    rows = {row.version: row for row in (*first, *newest)}
    return [rows[version] for version in sorted(rows)]
