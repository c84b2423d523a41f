"""What was predicted of cuts and what they then took: read for scores, and for the next widths."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Select, bindparam, func, select
from sqlalchemy.orm import Session

from autodb.agent.rows.mismatches import NEW_EDGE, SINCE
from autodb.forward.prediction import Interval
from autodb.forward.scored import Scored, Width, width_of
from autodb.store import models

HISTORY = 200
"""Cuts that the next width is from, the newest ones. Chosen: they tell it to some 5 %, in 30 ms."""


@dataclass(frozen=True)
class PastCut:
    """A cut that was predicted and then made: its job, its name there, and what is scored of it.

    ``learnt``: it was predicted from the pair's own parameters. ``number`` of the link.
    """

    number: int
    prediction: int
    job: str
    pair: tuple[str, str]
    name: str
    learnt: bool
    matched_by: str
    recording: int
    cut: float
    scored: tuple[Scored, ...]


def past_cuts(
    session: Session, machine_id: int, *, newest: bool = False, upto: int | None = None
) -> list[PastCut]:
    """Return a machine's cuts that count and were predicted before, oldest first.

    ``newest``: at most HISTORY, the newest; ``upto``: none whose link has a larger number.
    """
    query = _NEWEST if newest else _PAST
    if upto is not None:
        query = query.where(models.table_of(models.PredictedCutMade).c.id <= upto)
    found = session.connection().execute(query, {"machine": machine_id})
    return [_past_cut(dict(row)) for row in reversed(found.mappings().all())]


def width_of_next(
    session: Session, machine_id: int, pair: tuple[str, str], *, learnt: bool
) -> Width:
    """Return by what the next intervals of a pair, material and tool, are wider.

    Predictions from parameters that were ``learnt`` say nothing of others, nor others of them; nor
    do outlying cuts whose cause is open, which widen by what they showed, and cuts predicted before
    their cause was confirmed.
    """
    past = past_cuts(session, machine_id, newest=True)
    known = _known_why(session, machine_id, past)
    alike = [one for one in past if one.learnt == learnt and one.number not in known]
    own = [each for one in alike if one.pair == pair for each in one.scored]
    others = [each for one in alike if one.pair != pair for each in one.scored]
    return width_of(own, others, upto=max((one.number for one in past), default=None))


@dataclass(frozen=True)
class KnownCause:
    """A recording that an open or confirmed mismatch in forces was found in, and of whose cuts.

    ``pair``: material and tool; None: of all of its cuts. ``decided_at``: None: it is open.
    """

    recording: int
    pair: tuple[str, str] | None
    decided_at: str | None

    def holds(self, one: PastCut) -> bool:
        """Say whether it was found in the recording of a cut, among cuts of its pair."""
        return one.recording == self.recording and self.pair in (None, one.pair)


def _known_why(session: Session, machine_id: int, past: Sequence[PastCut]) -> set[int]:
    """Return the links, by number, of cuts of which a mismatch says why they were off.

    Where it is open those that no version has learnt; where it is confirmed, those that were
    predicted before.
    """
    causes = known_causes(session, machine_id) if past else []
    waiting = [one for one in past if any(c.decided_at is None and c.holds(one) for c in causes)]
    found = _outlying(session, waiting)
    decided = [cause for cause in causes if cause.decided_at is not None]
    at = _predicted_at(session, past) if decided else {}
    return found | {
        one.number
        for one in past
        for cause in decided
        if cause.holds(one) and at[one.prediction] <= (cause.decided_at or "")
    }


def _outlying(session: Session, cuts: Sequence[PastCut]) -> set[int]:
    """Return the links, by number, of cuts that no version has learnt from."""
    numbers = {one.number: one.scored[0].cut for one in cuts if one.scored}
    if not numbers:
        return set()
    seen = models.cutting_parameters_force.c
    query = (
        select(models.SensedForce.cut_id)
        .join(models.cutting_parameters_force, seen.sensed_force_id == models.SensedForce.id)
        .where(models.SensedForce.cut_id.in_(set(numbers.values())))
    )
    learnt = set(session.scalars(query))
    return {number for number, cut in numbers.items() if cut not in learnt}


def _predicted_at(session: Session, cuts: Sequence[PastCut]) -> dict[int, str]:
    """Return when the predictions of cuts were made, by id."""
    row = models.Prediction
    rows = session.execute(
        select(row.id, row.created_at).where(row.id.in_({one.prediction for one in cuts}))
    )
    return {row.id: row.created_at for row in rows}


def known_causes(session: Session, machine_id: int) -> list[KnownCause]:
    """Return the recordings of a machine of which a mismatch says why forces were off."""
    rows = session.connection().execute(_CAUSES, {"machine": machine_id}).all()
    return [
        KnownCause(recording, None if tool is None else (material, tool), decided_at)
        for first, further, decided_at, found_in, material, tool in rows
        if not {SINCE, NEW_EDGE} & (found_in or {}).keys()
        for recording in {first, further} - {None}
    ]


def _causes() -> Select[Any]:
    mismatch, recording, pair, material, tool = map(
        models.table_of,
        (models.Mismatch, models.StoredRecording, models.Pair, models.Material, models.Tool),
    )
    row, further, of_pair = mismatch.c, models.mismatch_recording.c, models.mismatch_pair.c
    return (
        select(
            row.recording_id,
            further.recording_id,
            row.decided_at,
            row.found_in,
            material.c.name,
            tool.c.name,
        )
        .select_from(mismatch)
        .join(recording, recording.c.id == row.recording_id)
        .outerjoin(models.mismatch_recording, further.mismatch_id == row.id)
        .outerjoin(models.mismatch_pair, of_pair.mismatch_id == row.id)
        .outerjoin(pair, pair.c.id == of_pair.pair_id)
        .outerjoin(material, material.c.id == pair.c.material_id)
        .outerjoin(tool, tool.c.id == pair.c.tool_id)
        .where(
            recording.c.machine_id == bindparam("machine"),
            row.status != "rejected",
            row.channel.startswith("force."),
        )
    )


_CAUSES = _causes()


def _past() -> Select[Any]:
    """Return the query of a machine's cuts that were predicted, the newest first."""
    predicted, prediction, made, recorded = map(
        models.table_of,
        (models.PredictedCutMade, models.Prediction, models.Cut, models.StoredRecording),
    )
    link, asked, cut, recording = predicted.c, prediction.c, made.c, recorded.c
    return (
        select(
            link.id,
            link.prediction_id,
            link.name,
            link.cut_id,
            link.matched_by,
            link.expected,
            link.made,
            *(asked.job[key].as_string().label(key) for key in ("material", "tool")),
            asked.job["name"].as_string().label("job"),
            asked.started_from,
            asked.width,
            cut.number.label("cut"),
            recording.id.label("recording"),
            func.coalesce(recording.continues_id, recording.id).label("first"),
        )
        .select_from(predicted)
        .join(prediction, asked.id == link.prediction_id)
        .join(made, cut.id == link.cut_id)
        .join(recorded, recording.id == cut.recording_id)
        .where(asked.machine_id == bindparam("machine"), models.counting_cut(cut.superseded_at))
        .order_by(link.id.desc())
    )


_PAST = _past()
_NEWEST = _PAST.limit(HISTORY)
"""Made once: a look-up asks it each time."""


def _past_cut(row: Mapping[str, Any]) -> PastCut:
    return PastCut(
        number=row["id"],
        prediction=row["prediction_id"],
        job=row["job"],
        pair=(row["material"], row["tool"]),
        name=row["name"],
        learnt=row["started_from"] is None,
        matched_by=row["matched_by"],
        recording=row["recording"],
        cut=row["cut"],
        scored=tuple(_scored(row)),
    )


def _scored(row: Mapping[str, Any]) -> list[Scored]:
    expected, made = row["expected"], row["made"] or {}
    return [
        Scored(
            quantity=quantity,
            cut=row["cut_id"],
            recording=row["first"],
            predicted=Interval(*expected[quantity]),
            made=value,
            sd=sd,
            widened=1.0 if row["width"] is None else row["width"]["factor"],
        )
        for quantity, (value, sd, _) in made.items()
        if quantity in expected and value
    ]
