"""What was answered: predictions, and mismatches found in recordings."""

from typing import Any

from sqlalchemy import CheckConstraint, ForeignKey, Index
from sqlalchemy.orm import Mapped, mapped_column, relationship

from autodb.store.models._base import Base, link, now
from autodb.store.models.learning import (
    ChannelModel,
    CuttingParameters,
    FleetPrior,
    channel_model_mismatch,
    cutting_parameters_mismatch,
)
from autodb.store.models.recording import StoredRecording

prediction_parameters = link("prediction_parameters", "prediction", "cutting_parameters")


class Prediction(Base):
    """One predicted job: the job as it was asked, the answer as it was given.

    ``started_from``: what stood in for a pair that the machine had not learnt; ``prior``: which,
    where that is what other machines know.
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
    parameters: Mapped[list[CuttingParameters]] = relationship(secondary=prediction_parameters)
    prior: Mapped[FleetPrior | None] = relationship()


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
