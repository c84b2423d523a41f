"""Edge changes that nobody recorded: found in a pair's forces, and kept for a person to reject.

Each is a mismatch of the pair: wear that fell back to its beginning. From then on its cuts count as
made with a new edge (``autodb.agent.rows.edges_in_use``), whether it is confirmed or not yet.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.catalogue import numbers_of
from autodb.agent.rows.edges_in_use import conditions_in_use
from autodb.agent.rows.mismatches import NEW_EDGE, around, mismatch_line
from autodb.agent.rows.posteriors import as_posterior, latest, pair_name
from autodb.agent.rows.recorded_edges import cut_before_s, edge_label
from autodb.agent.rows.sensed_forces import (
    QUANTITY,
    Calibrations,
    PairForces,
    forces_of_pair,
    operation_of,
)
from autodb.cutting.turning import PASSIVE_AXIS
from autodb.errors import UnusableInput
from autodb.fitting.gaussian import NORMAL_95
from autodb.pairs.changes.edge_changes import AROUND, EdgeChange, EdgeCuts, edge_changes, wears
from autodb.pairs.engaged import BY_NAME, CUTTING_TIME, EDGE
from autodb.pairs.forecast import expected_means
from autodb.pairs.posterior import WEAR
from autodb.store import models
from autodb.wording import stored_msgid

NEWEST = 200
"""Cuts of a pair that are looked at."""
POWER = 1.0
"""How wear grows with time, where a pair's posterior has none."""
NEAR = AROUND
"""Cuts within which a change is the one that a person rejected."""
IN_USE = stored_msgid("in use")
EDGE_CHANGED = stored_msgid(
    "{pair}: the wear of edge {edge} fell back to its beginning before cut {cut} of {file} "
    "({shares}) and stayed there: inferred, the edge was changed after {time}, and nobody recorded "
    "it; its cuts from then on count as a new edge's"
)


@dataclass(frozen=True)
class NewestCuts:
    """A pair's newest cuts that say how long their edge has cut, oldest first, and their forces.

    ``learnt``: the version of its posterior that ``read`` takes a fresh edge's forces from.
    """

    learnt: models.CuttingParameters
    cuts: list[models.Cut]
    found: PairForces
    read: EdgeCuts

    @property
    def show_wear(self) -> bool:
        """Whether forces grow with what edges have cut, and the posterior has no wear in it."""
        return as_posterior(self.learnt).wear is None and wears(self.read)


def newest_forces(
    session: Session,
    machine_id: int,
    pair: models.Pair,
    calibrations: Sequence[Calibrations],
    *,
    upto: int,
) -> PairForces:
    """Return the forces of a pair's newest cuts.

    ``calibrations`` as in ``forces_of_pair``; ``upto``: the last cut that counts, by id.
    """
    after = _newest_after(session, machine_id, pair.id, upto)
    return forces_of_pair(session, machine_id, pair, calibrations, cuts=(after, upto))


def newest_cuts(session: Session, machine_id: int, found: PairForces) -> NewestCuts | None:
    """Return a pair's newest cuts; None: too few of them, or nothing is learnt of it.

    ``found``: their forces.
    """
    usual = latest(session, machine_id, found.pair.id)
    if usual is None:
        return None
    cuts = list({force.cut_id: force.cut for force in found.forces}.values())
    cuts = [cut for cut in cuts if cut_before_s(cut) is not None]
    if len(cuts) <= 2 * AROUND:
        return None
    try:
        return NewestCuts(usual, cuts, found, _read(usual, found, cuts))
    except UnusableInput:
        return None


def infer_edge_changes(session: Session, newest: NewestCuts) -> list[str]:
    """Open a mismatch for each edge change that a pair's newest cuts show; return what to say."""
    cuts, pair = newest.cuts, newest.found.pair
    rejected = _rejected(session, pair.id)
    said = []
    for change in edge_changes(newest.read):
        cut = cuts[change.cut]
        near = {one.id for one in cuts[max(change.cut - NEAR, 0) : change.cut + NEAR + 1]}
        if near & rejected:
            continue
        row = models.Mismatch(
            recording=cut.recording,
            pairs=[pair],
            **_columns(change, cuts, newest.read, newest.found),
        )
        session.add(row)
        session.flush()
        said.append(mismatch_line(row, again=False, said=row.statement))
    return said


def _newest_after(session: Session, machine_id: int, pair_id: int, upto: int) -> int:
    """Return the id before that of a pair's newest cuts."""
    numbers = session.scalars(
        select(models.Cut.id)
        .where(
            models.Cut.recording.has(machine_id=machine_id),
            models.Cut.pair_id == pair_id,
            models.Cut.id <= upto,
            models.counting_cut(models.Cut.superseded_at),
        )
        .order_by(models.Cut.id.desc())
        .limit(NEWEST)
    ).all()
    return min(numbers, default=1) - 1


def _rejected(session: Session, pair_id: int) -> set[int]:
    """Return the first cuts, by id, of changes that a person said there were not."""
    rows = session.scalars(
        select(models.Mismatch.found_in).where(
            models.Mismatch.pairs.any(models.Pair.id == pair_id),
            models.Mismatch.status == "rejected",
            models.Mismatch.found_in.is_not(None),
        )
    )
    return {int(one[NEW_EDGE]) for one in rows if one is not None and NEW_EDGE in one}


def _read(usual: models.CuttingParameters, found: PairForces, cuts: list[models.Cut]) -> EdgeCuts:
    """Return cuts, in the order of time, with what each force is of a fresh edge's."""
    posterior = as_posterior(usual)
    in_use = conditions_in_use(cuts)
    place = {cut.id: k for k, cut in enumerate(cuts)}
    fresh = np.full((len(cuts), len(QUANTITY)), np.nan)
    for name in dict.fromkeys(operation_of(cut) for cut in cuts):
        rows = [k for k, cut in enumerate(cuts) if operation_of(cut) == name]
        stated = [{n: v for n, v in in_use[k].items() if n != CUTTING_TIME} for k in rows]
        made = BY_NAME[name].cuts(numbers_of(found.pair.tool), stated, called=found.pair.tool.name)
        fresh[rows] = expected_means(posterior, made)[:, :3]
    q = np.full_like(fresh, np.nan)
    for force in found.forces:
        k, column = place.get(force.cut_id), QUANTITY[force.component]
        passive = PASSIVE_AXIS.get(operation_of(force.cut)) == force.component
        if k is not None and not passive and (force.value_N or 0.0) / fresh[k, column] > 0.0:
            q[k, column] = np.log((force.value_N or 0.0) / fresh[k, column])
    q[:, np.sum(np.isfinite(q), axis=0) <= 2 * AROUND] = np.nan
    used_s = np.array([float(one[CUTTING_TIME]) for one in in_use])
    labels = [str(one.get(EDGE)) for one in in_use]
    power = POWER if posterior.wear is None else posterior.wear.power
    return EdgeCuts(q, _runs(labels, used_s.tolist()), used_s, power)


def _runs(labels: list[str], used_s: list[float]) -> Any:
    """Return the place of each cut's edge: a label whose time begins anew is another one."""
    runs: dict[str, tuple[int, float]] = {}
    count, found = 0, []
    for label, used in zip(labels, used_s, strict=True):
        place, before = runs.get(label, (-1, np.inf))
        if used < before:
            place, count = count, count + 1
        runs[label] = place, used
        found.append(place)
    return np.array(found, dtype=np.intp)


def _columns(
    change: EdgeChange, cuts: list[models.Cut], read: EdgeCuts, found: PairForces
) -> dict[str, Any]:
    cut, before = cuts[change.cut], cuts[change.cut - 1]
    fell = {name: change.fell[k] for name, k in QUANTITY.items() if np.isfinite(change.fell[k])}
    channel = max(fell, key=lambda name: fell[name])
    forces = {f.component: abs(f.value_N or 0.0) for f in found.forces if f.cut_id == cut.id}
    size = fell[channel] * forces[channel]
    half = NORMAL_95 * size / sqrt(2.0 * change.evidence)
    shares = ", ".join(f"force.{name} {-100 * share:.0f} %" for name, share in fell.items())
    label, used_s = edge_label(cut), cut_before_s(cut)
    after = int(np.sum(read.edge[change.cut :] == read.edge[change.cut]))
    return {
        "channel": f"force.{channel}",
        "term": WEAR,
        "kind": "mistuned",
        "confidence": 1.0 / (1.0 + len(cuts) * exp(-change.evidence)),
        "parameters": {"size": around(size, half, "N")},
        "statement": EDGE_CHANGED.format(
            pair=pair_name(found.pair),
            edge=label or IN_USE,
            cut=f"{cut.number:g}",
            file=Path(cut.recording.path).name,
            shares=shares,
            time=f"{used_s:.0f} s",
        ),
        "alternatives": [],
        "variables": [CUTTING_TIME],
        "intervals": [[before.number, cut.number]] if before.number < cut.number else [],
        "regime": [],
        "to_tell_apart": None,
        "status": "open",
        "found_in": {
            "cuts": after,
            "excluded": 0,
            "edges": [] if label is None else [label],
            NEW_EDGE: cut.id,
        },
    }
