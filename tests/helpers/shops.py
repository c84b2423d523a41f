"""Machines of a virtual fleet as a database keeps them: cuts with forces sensed, nothing learnt."""

from collections.abc import Mapping, Sequence

import numpy as np
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.rows.catalogue import pair_id
from autodb.agent.rows.machines import add_machine, find_machine
from autodb.files.machine import LATHE
from autodb.proofs.machines.lathe.power_pairs import GAIN, PowerPair, TurnedCut
from autodb.proofs.runs.pairs.pair_cuts import TURN, draw_read_cuts, sensing
from autodb.store import Store, models

DIAMETER_MM = 50.0
SENSED = {"y": 1, "z": 2}
"""Components that a lathe's currents sense in turning, by place in a cut's forces."""


def add(
    store: Store,
    name: str,
    pairs: Mapping[tuple[str, str], PowerPair],
    *,
    cuts: int,
    rng: np.random.Generator,
) -> None:
    """Add a machine, if it is not there, and what it sensed of cuts of pairs."""
    add_machine(store, name, LATHE)
    with store.writing(name) as session:
        owner = find_machine(session, name)
        number = 0
        sensors = _sensors(session, owner.id)
        before = select(func.count(models.StoredRecording.id)).where(
            models.StoredRecording.machine_id == owner.id
        )
        called = f"{name} {(session.scalar(before) or 0) + 1}"
        recording = models.StoredRecording(
            machine_id=owner.id, sha256=called, path=f"{called}.csv",
            kind="cuts", rows=cuts, units={}, side={},
        )  # fmt: skip
        session.add(recording)
        for (material, tool), pair in pairs.items():
            row = _pair(session, material, tool, pair)
            sensed = draw_read_cuts(rng, pair, TURN, cuts)
            for cut, read in zip(sensed.cuts, sensed.read, strict=True):
                number += 1
                assert isinstance(cut, TurnedCut)
                made = models.Cut(
                    recording=recording, number=number, operation="turn", pair_id=row.id,
                    conditions=conditions(cut), measured={},
                )  # fmt: skip
                session.add(made)
                session.flush()
                for (c, place), value in zip(SENSED.items(), read, strict=True):
                    session.add(
                        models.SensedForce(
                            cut_id=made.id, component=c, estimator="drive",
                            estimator_id=sensors[c].id, value_N=float(value),
                            sd_N=float(sensing(pair)[place]), common=[GAIN],
                        )
                    )  # fmt: skip


def _sensors(session: Session, machine_id: int) -> dict[str, models.Estimator]:
    """Return what senses a machine's forces, new where there is nothing yet."""
    rows = session.scalars(select(models.Estimator).filter_by(machine_id=machine_id))
    found = {row.component: row for row in rows}
    for c in SENSED.keys() - found.keys():
        found[c] = models.Estimator(
            machine_id=machine_id, kind="drive", component=c, version=1, model={}, scores={}
        )
    session.add_all(found.values())
    session.flush()
    return found


def conditions(cut: TurnedCut) -> dict[str, float]:
    """Return a cut as a table of cuts states it."""
    return {
        "cutting.speed": cut.speed_m_min,
        "cutting.feed": cut.feed_mm,
        "cutting.depth": cut.depth_mm,
        "work.diameter": DIAMETER_MM,
        "spindle.speed": cut.speed_m_min * 1000.0 / (np.pi * DIAMETER_MM),
    }


def _pair(session: Session, material: str, tool: str, pair: PowerPair) -> models.Pair:
    geometry = {
        "kind": "turning_insert", "nose_radius_mm": pair.nose_mm, "kappa_deg": pair.kappa_deg,
        "rake_deg": 0.0, "inclination_deg": 0.0, "included_deg": 80.0,
    }  # fmt: skip
    return session.get_one(models.Pair, pair_id(session, material, tool, geometry))


def names(count: int) -> Sequence[str]:
    """Return names of machines."""
    return [f"lathe-{number}" for number in range(count)]
