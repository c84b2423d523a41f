"""What was answered: predictions, and mismatches found in recordings."""

from typing import Any

from sqlalchemy import CheckConstraint, ForeignKey, Index, UniqueConstraint
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
    """One difference between a recording and its simulation, named or unknown.

    ``confirmed_term``: what it was confirmed as, its term or an alternative; ``models``: the model
    versions that confirming it made; ``parameters_of_pairs``: versions of pairs that hold it.
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
    recording: Mapped[StoredRecording] = relationship()
    models: Mapped[list[ChannelModel]] = relationship(secondary=channel_model_mismatch)
    parameters_of_pairs: Mapped[list[CuttingParameters]] = relationship(
        secondary=cutting_parameters_mismatch,
        order_by=CuttingParameters.id,
        back_populates="mismatches",
    )
