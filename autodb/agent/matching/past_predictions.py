"""What was predicted of cuts and what they then took: read for scores, and for the next widths."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Select, bindparam, func, select
from sqlalchemy.orm import Session

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
    session: Session, machine_id: int, *, most: int | None = None, upto: int | None = None
) -> list[PastCut]:
    """Return a machine's cuts that count and were predicted before, oldest first.

    ``most``: at most so many, the newest; ``upto``: none whose link has a larger number.
    """
    query = _PAST if upto is None else _PAST.where(models.PredictedCutMade.id <= upto)
    found = session.connection().execute(query.limit(most), {"machine": machine_id})
    return [_past_cut(dict(row)) for row in reversed(found.mappings().all())]


def width_of_next(
    session: Session, machine_id: int, pair: tuple[str, str], *, learnt: bool
) -> Width:
    """Return by what the next intervals of a pair, material and tool, are wider.

    Predictions from parameters that were ``learnt`` say nothing of others, nor others of them.
    """
    past = past_cuts(session, machine_id, most=HISTORY)
    alike = [one for one in past if one.learnt == learnt]
    own = [each for one in alike if one.pair == pair for each in one.scored]
    others = [each for one in alike if one.pair != pair for each in one.scored]
    return width_of(own, others, upto=max((one.number for one in past), default=None))


def _past() -> Select[Any]:
    link, asked, cut, recording = (
        models.PredictedCutMade,
        models.Prediction,
        models.Cut,
        models.StoredRecording,
    )
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
        .join(asked, asked.id == link.prediction_id)
        .join(cut, cut.id == link.cut_id)
        .join(recording, recording.id == cut.recording_id)
        .where(asked.machine_id == bindparam("machine"), cut.superseded_at.is_(None))
        .order_by(link.id.desc())
    )


_PAST = _past()
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
