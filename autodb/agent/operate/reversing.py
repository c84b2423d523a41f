"""What a decision on a mismatch changed is taken back: what was so before holds again.

Versions of models, calibrations and pairs that hold a confirmed cause are withdrawn, as those are
that rest on them; a pair that holds other confirmed causes is learnt anew with these. Nothing is
deleted. A rejected cause has its cuts learnt: versions that learnt them since are withdrawn.
"""

from collections.abc import Iterable, Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.learn.lots import forget_lot
from autodb.agent.operate.clamping import forget_runout
from autodb.agent.operate.refreshing import learn_confirmed
from autodb.agent.rows.counted_edges import count_edges
from autodb.agent.rows.posteriors import pair_name, resting_on, taken_back_words
from autodb.store import models
from autodb.wording import phrase

_Parameters = models.CuttingParameters


def take_back(session: Session, row: models.Mismatch) -> list[str]:
    """Take back what a decided mismatch changed, and have it open; return it in words."""
    said, others = list[str](), dict[int, models.Mismatch]()
    versions = _of_rejected(session, row) if row.status == "rejected" else _of_confirmed(row)
    for model in [] if row.status == "rejected" else _models(session, row):
        model.undone_at = models.now()
        said.append(
            phrase(
                "{channel} version {version} is taken back",
                channel=model.channel,
                version=model.version,
            )
        )
    corrected = [one.id for one in row.calibrations if one.undone_at is None]
    by = _Parameters.forces.any(models.SensedForce.calibration_id.in_(corrected))
    versions += resting_on(session, row.recording.machine_id, by)
    ids = [one.id for one in versions]
    for version in resting_on(session, row.recording.machine_id, _Parameters.id.in_(ids)):
        version.undone_at = models.now()
        said.append(taken_back_words(version))
        others |= {one.id: one for one in version.mismatches if one is not row}
    said += forgotten(session, row)
    said += _rest_again(session, row)
    row.status, row.confirmed_term, row.decided_at, row.applied = "open", None, None, None
    session.flush()
    for other in others.values():
        if other.status == "confirmed":
            said += _learnt_again(session, other)
    return said


def forgotten(session: Session, row: models.Mismatch) -> list[str]:
    """Take back corrections, lots and run-out of a confirmed mismatch; return it in words."""
    said = []
    for one in row.calibrations:
        if one.undone_at is None:
            one.undone_at = models.now()
            said.append(
                phrase(
                    "calibration of {axis} version {version} is taken back",
                    axis=one.axis,
                    version=one.version,
                )
            )
    forget_lot(session, row)
    return [*said, *forget_runout(session, row)]


def _of_confirmed(row: models.Mismatch) -> list[_Parameters]:
    """Return the versions of pairs that hold a cause."""
    return [one for one in row.parameters_of_pairs if one.undone_at is None]


def _of_rejected(session: Session, row: models.Mismatch) -> list[_Parameters]:
    """Return the versions that learnt cuts of a rejected cause since it was rejected."""
    if not row.channel.startswith("force."):
        return []
    recordings = [one.id for one in row.recordings]
    its = models.SensedForce.cut.has(models.Cut.recording_id.in_(recordings))
    last = (row.applied or {}).get("after")
    known = last is not None
    since = _Parameters.id > last if known else _Parameters.created_at > str(row.decided_at)
    query = select(_Parameters).where(
        since, _Parameters.undone_at.is_(None), _Parameters.forces.any(its)
    )
    return list(session.scalars(query))


def _models(session: Session, row: models.Mismatch) -> list[models.ChannelModel]:
    """Return the models that confirming a cause made, and the later ones that have its term.

    One that another confirmed cause has found there already stays, as made by that one.
    """
    kept = None if row.applied is None else row.applied.get("models", [])
    there = [one for one in row.models if one.undone_at is None]
    found = list[models.ChannelModel]()
    for model in [one for one in there if kept is None or one.id in kept]:
        heir = _other_holder(session, row, model)
        if heir is not None:
            of_heir = (heir.applied or {}).get("models", [])
            heir.applied = {**(heir.applied or {}), "models": [*of_heir, model.id]}
            continue
        later = select(models.ChannelModel).where(
            models.ChannelModel.machine_id == model.machine_id,
            models.ChannelModel.channel == model.channel,
            models.ChannelModel.version > model.version,
            models.ChannelModel.undone_at.is_(None),
        )
        found += [model, *_with_term(session.scalars(later), str(row.confirmed_term))]
    return found


def _with_term(rows: Iterable[models.ChannelModel], term: str) -> Sequence[models.ChannelModel]:
    return [row for row in rows if term in {one["term"] for one in row.terms}]


def _other_holder(
    session: Session, row: models.Mismatch, model: models.ChannelModel
) -> models.Mismatch | None:
    """Return another confirmed mismatch of the same term that a model holds."""
    query = select(models.Mismatch).where(
        models.Mismatch.models.any(models.ChannelModel.id == model.id),
        models.Mismatch.id != row.id,
        models.Mismatch.status == "confirmed",
        models.Mismatch.confirmed_term == row.confirmed_term,
    )
    return session.scalar(query.order_by(models.Mismatch.id).limit(1))


def _rest_again(session: Session, row: models.Mismatch) -> list[str]:
    """Have recordings count no more that count only because the cause was confirmed."""
    said = list[str]()
    for number in (row.applied or {}).get("recordings", ()):
        recording = session.get_one(models.StoredRecording, number)
        also = models.Mismatch.found_in_any([number]), models.Mismatch.status == "confirmed"
        others = select(models.Mismatch.id).where(*also, models.Mismatch.id != row.id)
        if recording.looked_at is not None or session.scalar(others.limit(1)) is not None:
            continue
        recording.looked_at = models.now()
        cuts = [cut for cut in recording.cuts if cut.superseded_at is None]
        for cut in cuts:
            cut.superseded_at = recording.looked_at
        count_edges(session, recording.machine_id, cuts)
        said.append(
            phrase(
                "recording {number} came in to be explained, and its cuts count no more",
                number=number,
            )
        )
    return said


def _learnt_again(session: Session, row: models.Mismatch) -> list[str]:
    """Learn the pairs of another cause that stays confirmed; return it in words."""
    made, _ = learn_confirmed(session, row, lambda _: None)
    return [
        phrase(
            "{pair} version {version} holds mismatch {number} still",
            pair=pair_name(one.pair),
            version=one.version,
            number=row.id,
        )
        for one in made
    ]
