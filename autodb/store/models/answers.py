"""What was answered: predictions, and mismatches found in recordings."""

from collections.abc import Collection
from typing import Any

from sqlalchemy import CheckConstraint, ColumnElement, ForeignKey, Index, UniqueConstraint, or_
from sqlalchemy.orm import Mapped, mapped_column, relationship

from autodb.store.models._base import Base, link, now, one_of
from autodb.store.models.learning import (
    ChannelModel,
    CuttingParameters,
    FleetPrior,
    channel_model_mismatch,
    cutting_parameters_mismatch,
)
from autodb.store.models.recording import Cut, StoredRecording
from autodb.store.models.sensing import CalibrationVersion
from autodb.store.models.work import Pair

mismatch_recording = link("mismatch_recording", "mismatch", "recording")
"""Further recordings that a mismatch was found in, together with its first."""
mismatch_pair = link("mismatch_pair", "mismatch", "pair")
"""The pairs in whose cuts a mismatch was found; none: in all that its recording holds."""
calibration_mismatch = link("calibration_mismatch", "calibration", "mismatch")
"""The mismatches that a calibration's correction came from."""
prediction_parameters = link("prediction_parameters", "prediction", "cutting_parameters")
BY_NAME, BY_CONDITIONS, BY_STATEMENT = MATCHES = ("name", "conditions", "stated")
"""By what a cut is known to be the one that was predicted."""


class Prediction(Base):
    """One predicted job: the job as it was asked, the answer as it was given.

    ``started_from``: what stood in for a pair that the machine had not learnt; ``prior``: which,
    where that is what other machines know. ``width``: what past predictions made of the intervals
    (``autodb.forward.scored.Width``); NULL: they are as wide as the posterior says.
    """

    __tablename__ = "prediction"
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    job: Mapped[dict[str, Any]]
    cuts: Mapped[list[Any]]
    started_from: Mapped[str | None]
    created_at: Mapped[str] = mapped_column(default=now)
    prior_id: Mapped[int | None] = mapped_column(
        ForeignKey("fleet_prior.id", name="fk_prediction_prior")
    )
    width: Mapped[dict[str, Any] | None]
    parameters: Mapped[list[CuttingParameters]] = relationship(secondary=prediction_parameters)
    prior: Mapped[FleetPrior | None] = relationship()
    made: Mapped[list["PredictedCutMade"]] = relationship(
        order_by="PredictedCutMade.id", back_populates="prediction"
    )


class PredictedCutMade(Base):
    """One cut that was made, and which of a prediction's cuts it is, by ``number`` from 1.

    ``name``: what the prediction calls it.

    ``expected``: by quantity the prediction as [value, low, high] at the conditions that the cut
    was made with; ``made``: by quantity what was sensed or measured then, its standard deviation
    (0: not known) and the row of the force; NULL: nothing yet.
    """

    __tablename__ = "predicted_cut"
    __table_args__ = (
        UniqueConstraint("cut_id", name="uq_predicted_cut_cut"),
        CheckConstraint("number > 0", name="ck_predicted_cut_number"),
        one_of("matched_by", MATCHES, name="ck_predicted_cut_matched_by"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    prediction_id: Mapped[int] = mapped_column(ForeignKey("prediction.id"), index=True)
    number: Mapped[int]
    name: Mapped[str]
    cut_id: Mapped[int] = mapped_column(ForeignKey("cut.id", ondelete="CASCADE"))
    matched_by: Mapped[str]
    expected: Mapped[dict[str, Any]]
    made: Mapped[dict[str, Any] | None]
    created_at: Mapped[str] = mapped_column(default=now)
    prediction: Mapped[Prediction] = relationship(back_populates="made")
    cut: Mapped[Cut] = relationship()


class Mismatch(Base):
    """One difference between recordings and their simulation, named or unknown.

    ``recording``: the first that it was found in, ``further``: others that were explained together
    with it; ``pairs``: those whose cuts were, none: all that the recording holds. ``found_in``:
    `cuts`, how many these were, `excluded`, how many of them their pair's normal cutting state
    excludes, and `edges`, which cut them; NULL: of the whole recording.
    ``confirmed_term``: what it was confirmed as, its term or an alternative. ``applied``: what that
    changed: the `models` it made, the `lot` of material that it is of, the `cuts` that were named
    so, the `recordings` that count since, the `tool` whose run-out it is and what that was
    `before`; rejected: the parameters `after` which it was, by id; NULL: nothing. ``models``,
    ``calibrations`` and ``parameters_of_pairs``: the versions that hold it; ``decisions``: all that
    were taken on it, oldest first.
    """

    __tablename__ = "mismatch"
    __table_args__ = (
        CheckConstraint("status IN ('open', 'confirmed', 'rejected')"),
        CheckConstraint("kind IN ('missing', 'mistuned')"),
        CheckConstraint("status <> 'open' OR decided_at IS NULL", name="ck_mismatch_decided"),
        Index("ix_mismatch_status", "status"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    recording_id: Mapped[int] = mapped_column(ForeignKey("recording.id"), index=True)
    channel: Mapped[str]
    term: Mapped[str]
    kind: Mapped[str]
    confidence: Mapped[float]
    parameters: Mapped[dict[str, Any]]
    statement: Mapped[str]
    status: Mapped[str] = mapped_column(default="open")
    created_at: Mapped[str] = mapped_column(default=now)
    alternatives: Mapped[list[Any] | None]
    variables: Mapped[list[Any] | None]
    intervals: Mapped[list[Any] | None]
    regime: Mapped[list[Any] | None]
    to_tell_apart: Mapped[str | None]
    decided_at: Mapped[str | None]
    decided_by: Mapped[str | None]
    confirmed_term: Mapped[str | None]
    found_in: Mapped[dict[str, Any] | None]
    applied: Mapped[dict[str, Any] | None]
    recording: Mapped[StoredRecording] = relationship()
    further: Mapped[list[StoredRecording]] = relationship(
        secondary=mismatch_recording, order_by=StoredRecording.id
    )
    pairs: Mapped[list[Pair]] = relationship(secondary=mismatch_pair)
    models: Mapped[list[ChannelModel]] = relationship(secondary=channel_model_mismatch)
    parameters_of_pairs: Mapped[list[CuttingParameters]] = relationship(
        secondary=cutting_parameters_mismatch,
        order_by=CuttingParameters.id,
        back_populates="mismatches",
    )
    calibrations: Mapped[list[CalibrationVersion]] = relationship(secondary=calibration_mismatch)
    decisions: Mapped[list["MismatchDecision"]] = relationship(order_by="MismatchDecision.id")

    @property
    def lot(self) -> str | None:
        """The lot of material that it was confirmed for."""
        return (self.applied or {}).get("lot")

    @property
    def recordings(self) -> list[StoredRecording]:
        """All recordings that it was found in."""
        return [self.recording, *self.further]

    @classmethod
    def found_in_any(cls, recordings: Collection[int]) -> ColumnElement[bool]:
        """Return what asks for mismatches that were found in one of some recordings, by id."""
        return or_(
            cls.recording_id.in_(recordings),
            cls.further.any(StoredRecording.id.in_(recordings)),
        )

    @classmethod
    def of_pair(cls, pair: int) -> ColumnElement[bool]:
        """Return what asks for mismatches that hold for the cuts of a pair, by id."""
        return or_(~cls.pairs.any(), cls.pairs.any(Pair.id == pair))


class MismatchDecision(Base):
    """One decision on a mismatch: what it became, `open` where a decision was taken back.

    ``term``: what it was confirmed as; ``why``: the reason that was given.
    """

    __tablename__ = "mismatch_decision"
    __table_args__ = (
        one_of("status", ("open", "confirmed", "rejected"), name="ck_mismatch_decision_status"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    mismatch_id: Mapped[int] = mapped_column(
        ForeignKey("mismatch.id", ondelete="CASCADE"), index=True
    )
    status: Mapped[str]
    term: Mapped[str | None]
    why: Mapped[str | None]
    decided_by: Mapped[str | None]
    decided_at: Mapped[str]
