"""Files of harder work, found while a pair is learnt: one mismatch each, that waits for a person.

They are excluded from what the pair learns until a person rejects it, or says of which lot of the
material they are.
"""

from collections.abc import Collection
from pathlib import Path
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.learn.states import HarderCuts
from autodb.agent.rows.mismatches import IN_HARDER, around, mismatch_line
from autodb.agent.rows.posteriors import pair_name
from autodb.agent.rows.recorded_edges import edge_label
from autodb.agent.rows.sensed_forces import PairForces
from autodb.fitting.gaussian import NORMAL_95
from autodb.store import models
from autodb.terms.chip import HARD_SPOT
from autodb.wording import stored_msgid

HARDER = stored_msgid(
    "{pair}: cuts {first} to {last} of {file} take {share} % ({low} to {high}) more force than "
    "cuts before, in all components alike: harder work; they are excluded until this is decided"
)


def open_harder_work(session: Session, found: PairForces, harder: list[HarderCuts]) -> list[str]:
    """Open a mismatch for each file of harder cuts of a pair; return what to say.

    None that is known already is opened again.
    """
    said, known = [], inferred_harder_cuts(session, found.pair.id)
    for one in harder:
        if {cut.id for cut in one.cuts} & known:
            continue
        columns = _columns(one, found)
        row = models.Mismatch(recording=one.cuts[0].recording, pairs=[found.pair], **columns)
        session.add(row)
        session.flush()
        said.append(mismatch_line(row, again=False, said=row.statement))
    return said


def inferred_harder_cuts(session: Session, pair_id: int) -> set[int]:
    """Return the cuts of a pair, by id, found to be harder, which nobody has rejected."""
    rows = session.scalars(
        select(models.Mismatch.found_in).where(
            models.Mismatch.pairs.any(models.Pair.id == pair_id),
            models.Mismatch.status != "rejected",
            models.Mismatch.found_in.is_not(None),
        )
    )
    return {int(cut) for one in rows if one is not None for cut in one.get(IN_HARDER, ())}


def _columns(one: HarderCuts, found: PairForces) -> dict[str, Any]:
    work, half = one.work, NORMAL_95 * one.work.sd
    numbers = [cut.number for cut in one.cuts]
    component, size_N = _largest(found, {cut.id for cut in one.cuts})
    beside = size_N / (1.0 + work.share)
    ends = {"first": min(numbers), "last": max(numbers)}
    return {
        "channel": f"force.{component}",
        "term": HARD_SPOT.name,
        "kind": "missing",
        "confidence": 1.0 - work.chance,
        "parameters": {
            "size": around(work.share * beside, half * beside, "N"),
            "factor": around(1.0 + work.share, half, "1"),
            **{name: around(number, 0.0, "1") for name, number in ends.items()},
        },
        "statement": HARDER.format(
            pair=pair_name(found.pair),
            file=Path(one.cuts[0].recording.path).name,
            share=f"{100.0 * work.share:.0f}",
            low=f"{100.0 * (work.share - half):.0f}",
            high=f"{100.0 * (work.share + half):.0f}",
            **{name: f"{number:g}" for name, number in ends.items()},
        ),
        "alternatives": [],
        "variables": ["cut"],
        "intervals": [[ends["first"], ends["last"]]],
        "regime": [],
        "to_tell_apart": None,
        "status": "open",
        "found_in": {
            "cuts": len(one.cuts),
            "excluded": len(one.cuts),
            "edges": sorted({label for cut in one.cuts if (label := edge_label(cut))}),
            IN_HARDER: [cut.id for cut in one.cuts],
        },
    }


def _largest(found: PairForces, cuts: Collection[int]) -> tuple[str, float]:
    """Return the component of the largest force of some cuts, and that force, N."""
    own = [force for force in found.forces if force.cut_id in cuts]
    most = max(own, key=lambda force: abs(force.value_N or 0.0))
    return most.component, abs(most.value_N or 0.0)
