"""What a machine knows, as tables. Every derived row points to what it came from.

Unknown is NULL. Forces N, lengths mm, speeds as their names say; JSON holds only what is never
searched by.
"""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import JSON, CheckConstraint, Column, ForeignKey, Table, UniqueConstraint
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column, relationship


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


class Base(DeclarativeBase):
    """All tables."""

    type_annotation_map = {dict[str, Any]: JSON, list[Any]: JSON}  # noqa: RUF012 - SQLAlchemy's way


def _link(name: str, left: str, right: str) -> Table:
    """Return an association table: rows of ``left`` came from rows of ``right``."""
    return Table(
        name,
        Base.metadata,
        Column(f"{left}_id", ForeignKey(f"{left}.id", ondelete="CASCADE"), primary_key=True),
        Column(f"{right}_id", ForeignKey(f"{right}.id"), primary_key=True, index=True),
    )


calibration_recording = _link("calibration_recording", "calibration", "recording")
channel_model_recording = _link("channel_model_recording", "channel_model", "recording")
cutting_parameters_force = _link("cutting_parameters_force", "cutting_parameters", "sensed_force")
prediction_parameters = _link("prediction_parameters", "prediction", "cutting_parameters")


class Machine(Base):
    """One machine."""

    __tablename__ = "machine"
    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(unique=True)
    created_at: Mapped[str] = mapped_column(default=_now)
    axes: Mapped[list["Axis"]] = relationship(back_populates="machine", order_by="Axis.id")


class Axis(Base):
    """One driven axis of a machine."""

    __tablename__ = "axis"
    __table_args__ = (
        UniqueConstraint("machine_id", "name"),
        CheckConstraint("carries IN ('tool', 'work')"),
        CheckConstraint("current_sign IN (-1, 1)"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    name: Mapped[str]
    carries: Mapped[str]
    current_sign: Mapped[int]
    machine: Mapped[Machine] = relationship(back_populates="axes")


class Tool(Base):
    """One tool, by name, with the geometry that is known."""

    __tablename__ = "tool"
    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(unique=True)
    nose_radius_mm: Mapped[float | None]
    kappa_deg: Mapped[float | None]
    rake_deg: Mapped[float | None]
    inclination_deg: Mapped[float | None]


class Material(Base):
    """One work material, by name."""

    __tablename__ = "material"
    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(unique=True)


class Pair(Base):
    """One work-tool pair: what cutting parameters belong to."""

    __tablename__ = "pair"
    __table_args__ = (UniqueConstraint("material_id", "tool_id"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    material_id: Mapped[int] = mapped_column(ForeignKey("material.id"))
    tool_id: Mapped[int] = mapped_column(ForeignKey("tool.id"))
    material: Mapped[Material] = relationship()
    tool: Mapped[Tool] = relationship()


class Recording(Base):
    """One imported file, known by its checksum; the side file is kept as it was read."""

    __tablename__ = "recording"
    __table_args__ = (
        UniqueConstraint("machine_id", "sha256"),
        CheckConstraint("kind IN ('cuts', 'series')"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    sha256: Mapped[str]
    path: Mapped[str]
    kind: Mapped[str]
    rows: Mapped[int]
    units: Mapped[dict[str, Any]]
    side: Mapped[dict[str, Any]]
    imported_at: Mapped[str] = mapped_column(default=_now)
    cuts: Mapped[list["Cut"]] = relationship(back_populates="recording", order_by="Cut.number")


class Cut(Base):
    """One cut of a recording: its conditions, and its measured channels by name."""

    __tablename__ = "cut"
    __table_args__ = (UniqueConstraint("recording_id", "number"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    recording_id: Mapped[int] = mapped_column(ForeignKey("recording.id"), index=True)
    pair_id: Mapped[int | None] = mapped_column(ForeignKey("pair.id"), index=True)
    number: Mapped[float]
    operation: Mapped[str | None]
    conditions: Mapped[dict[str, Any]]
    measured: Mapped[dict[str, Any]]
    recording: Mapped[Recording] = relationship(back_populates="cuts")
    pair: Mapped[Pair | None] = relationship()


class Calibration(Base):
    """One version of an axis' line from current to force or torque, with its scores."""

    __tablename__ = "calibration"
    __table_args__ = (UniqueConstraint("machine_id", "axis", "version"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    axis: Mapped[str]
    version: Mapped[int]
    component: Mapped[str]
    channel: Mapped[str]
    current_unit: Mapped[str]
    unit: Mapped[str]
    coefficients: Mapped[list[Any]]
    covariance: Mapped[list[Any]]
    scores: Mapped[dict[str, Any]]
    scores_with_transients: Mapped[dict[str, Any]]
    transients: Mapped[list[Any]]
    current_low: Mapped[float]
    current_high: Mapped[float]
    offered: Mapped[bool]
    verdict: Mapped[str]
    created_at: Mapped[str] = mapped_column(default=_now)
    recordings: Mapped[list[Recording]] = relationship(secondary=calibration_recording)


class SensedForce(Base):
    """One force component of one cut as one estimator felt it, or why it did not.

    ``common`` is the derivative by the calibration's coefficients: the error shared by all cuts.
    """

    __tablename__ = "sensed_force"
    __table_args__ = (
        UniqueConstraint("cut_id", "component", "estimator", "calibration_id"),
        CheckConstraint("component IN ('x', 'y', 'z')"),
        CheckConstraint("(value_N IS NULL) = (sd_N IS NULL)"),
        CheckConstraint("(value_N IS NULL) = (reason IS NOT NULL)", name="not_sensed_says_why"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    cut_id: Mapped[int] = mapped_column(ForeignKey("cut.id"), index=True)
    component: Mapped[str]
    estimator: Mapped[str]
    calibration_id: Mapped[int | None] = mapped_column(ForeignKey("calibration.id"), index=True)
    value_N: Mapped[float | None]
    sd_N: Mapped[float | None]
    common: Mapped[list[Any] | None]
    reason: Mapped[str | None]
    cut: Mapped[Cut] = relationship()
    calibration: Mapped[Calibration | None] = relationship()


class ChannelModel(Base):
    """One version of an axis' identified drive model: terms, values, covariance, protocol."""

    __tablename__ = "channel_model"
    __table_args__ = (UniqueConstraint("machine_id", "channel", "version"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    axis: Mapped[str]
    channel: Mapped[str]
    version: Mapped[int]
    unit: Mapped[str]
    terms: Mapped[list[Any]]
    covariance: Mapped[list[Any]]
    relative_error: Mapped[float]
    protocol: Mapped[str]
    created_at: Mapped[str] = mapped_column(default=_now)
    recordings: Mapped[list[Recording]] = relationship(secondary=channel_model_recording)


class CuttingParameters(Base):
    """One version of a pair's cutting law for one force component on one machine.

    ``forces`` are the sensed forces this version added to ``previous``; without a previous version
    it starts from the prior.
    """

    __tablename__ = "cutting_parameters"
    __table_args__ = (UniqueConstraint("machine_id", "pair_id", "component", "version"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    pair_id: Mapped[int] = mapped_column(ForeignKey("pair.id"), index=True)
    component: Mapped[str]
    version: Mapped[int]
    mean: Mapped[list[Any]]
    covariance: Mapped[list[Any]]
    process_share: Mapped[float]
    misfit_N: Mapped[float]
    n_cuts: Mapped[int]
    previous_id: Mapped[int | None] = mapped_column(ForeignKey("cutting_parameters.id"))
    created_at: Mapped[str] = mapped_column(default=_now)
    pair: Mapped[Pair] = relationship()
    previous: Mapped["CuttingParameters | None"] = relationship(remote_side="CuttingParameters.id")
    forces: Mapped[list[SensedForce]] = relationship(secondary=cutting_parameters_force)


class Prediction(Base):
    """One predicted job: the job as it was asked, the answer as it was given."""

    __tablename__ = "prediction"
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    job: Mapped[dict[str, Any]]
    cuts: Mapped[list[Any]]
    created_at: Mapped[str] = mapped_column(default=_now)
    parameters: Mapped[list[CuttingParameters]] = relationship(secondary=prediction_parameters)


class Mismatch(Base):
    """One difference between a recording and its simulation, named or unknown."""

    __tablename__ = "mismatch"
    __table_args__ = (
        CheckConstraint("status IN ('open', 'confirmed', 'rejected')"),
        CheckConstraint("kind IN ('missing', 'mistuned')"),
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
    created_at: Mapped[str] = mapped_column(default=_now)
    recording: Mapped[Recording] = relationship()
