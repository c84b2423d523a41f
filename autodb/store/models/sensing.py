"""From current to force: calibrations, estimators, and the forces they sensed."""

from typing import Any

from sqlalchemy import CheckConstraint, ForeignKey, Index, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column, relationship

from autodb.store.models._base import COMPONENTS, Base, link, now, one_of
from autodb.store.models.recording import Cut, StoredRecording

CALIBRATION_KINDS = (
    "line", "line-of-speed", "power", "power-of-speed", "line-warmed", "power-warmed",
    "power-of-speed-warmed", "anfis", "magnetised", "magnetised-of-speed",
)  # fmt: skip
ESTIMATOR_KINDS = ("range", "drive", "lstm", "table", "inspection", "fusion")
SCALE_KINDS = ("added-mass", "force", "standard-cut")
SPINDLE_STATES = ("cold", "warm")
FEED_DIRECTIONS = ("+", "-")

calibration_recording = link("calibration_recording", "calibration", "recording")
calibration_repeat = link("calibration_repeat", "calibration", "cut")
estimator_recording = link("estimator_recording", "estimator", "recording")
estimator_source = link("estimator_source", "estimator", "calibration")


class CalibrationVersion(Base):
    """One version of an axis' model from current to force or torque, with its scores.

    It holds for a gear range, coolant, spindle state and feed direction; NULL: for any.
    ``repeats``: the cuts repeated to check it. ``cut_sd``: one cut's own error, in ``unit``; the
    shares are relative and common to all cuts, as is by how much a new tool, material or day
    differs, ``group_covariance`` (2, 2) of an offset and a share of gain; NULL: all of it is in
    scores and covariance. ``current_sd``: rms error of the currents, which ``cut_sd`` lacks.
    ``domain``: what its cuts were, and laws nearly as good; NULL: not kept before.
    ``reference_errors``: what moves all forces that it was made on, as in SensedForce.errors.
    ``corrections``: each the `factor` by which it reads too high, its standard deviation `sd`, and
    since when: `recording`, by id, and in that the time `t_s` of a cut; NULL: none.
    """

    __tablename__ = "calibration"
    __table_args__ = (
        UniqueConstraint("machine_id", "axis", "version"),
        one_of("kind", CALIBRATION_KINDS, name="ck_calibration_kind"),
        one_of("spindle_state", SPINDLE_STATES, name="ck_calibration_spindle_state"),
        one_of("feed_direction", FEED_DIRECTIONS, name="ck_calibration_feed_direction"),
        Index(
            "ix_calibration_key",
            "machine_id", "axis", "gear_range", "coolant", "spindle_state", "feed_direction",
        ),
    )  # fmt: skip
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
    created_at: Mapped[str] = mapped_column(default=now)
    kind: Mapped[str] = mapped_column(server_default="line")
    parameters: Mapped[dict[str, Any] | None]
    gear_range: Mapped[str | None]
    coolant: Mapped[str | None]
    spindle_state: Mapped[str | None]
    feed_direction: Mapped[str | None]
    protocol: Mapped[str | None]
    outliers: Mapped[list[Any] | None]
    trials: Mapped[dict[str, Any] | None]
    cut_sd: Mapped[float | None]
    gain_share: Mapped[float | None]
    reference_share: Mapped[float | None]
    current_sd: Mapped[float | None]
    group_covariance: Mapped[list[Any] | None]
    domain: Mapped[dict[str, Any] | None]
    reference_errors: Mapped[list[Any] | None]
    corrections: Mapped[list[Any] | None]
    undone_at: Mapped[str | None]
    recordings: Mapped[list[StoredRecording]] = relationship(secondary=calibration_recording)
    repeats: Mapped[list[Cut]] = relationship(secondary=calibration_repeat)


class DriveScale(Base):
    """One version of what an ampere of a feed axis' drive is, N, told by a known load.

    ``share``: its relative standard deviation, common to all loads that are sensed with it.
    ``recording``: of the load; ``source``: which it was.
    """

    __tablename__ = "drive_scale"
    __table_args__ = (
        UniqueConstraint("machine_id", "axis", "version", name="uq_drive_scale_key"),
        one_of("kind", SCALE_KINDS, name="ck_drive_scale_kind"),
        CheckConstraint("per_ampere > 0", name="ck_drive_scale_per_ampere"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    axis: Mapped[str]
    version: Mapped[int]
    kind: Mapped[str]
    per_ampere: Mapped[float]
    share: Mapped[float]
    source: Mapped[str]
    recording_id: Mapped[int] = mapped_column(ForeignKey("recording.id"))
    created_at: Mapped[str] = mapped_column(default=now)
    undone_at: Mapped[str | None]
    recording: Mapped[StoredRecording] = relationship()


class Estimator(Base):
    """One version of what senses a force component on a machine; its model is here or in a file."""

    __tablename__ = "estimator"
    __table_args__ = (
        UniqueConstraint("machine_id", "kind", "component", "version", name="uq_estimator_key"),
        one_of("kind", ESTIMATOR_KINDS, name="ck_estimator_kind"),
        one_of("component", COMPONENTS, name="ck_estimator_component"),
        CheckConstraint("(path IS NULL) = (sha256 IS NULL)", name="ck_estimator_file"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    kind: Mapped[str]
    component: Mapped[str]
    version: Mapped[int]
    model: Mapped[dict[str, Any] | None]
    path: Mapped[str | None]
    sha256: Mapped[str | None]
    normalisation: Mapped[dict[str, Any] | None]
    scores: Mapped[dict[str, Any]]
    since: Mapped[str] = mapped_column(default=now)
    undone_at: Mapped[str | None]
    recordings: Mapped[list[StoredRecording]] = relationship(secondary=estimator_recording)
    calibrations: Mapped[list[CalibrationVersion]] = relationship(secondary=estimator_source)


class SensedForce(Base):
    """One force component of one cut as one estimator sensed it, or why it did not.

    One that was measured has its errors in ``errors``, a row each (``autodb.sensing.dynamometer``).

    ``common`` is the derivative by the calibration's coefficients, and by an offset where it has
    ``group_covariance``: the error shared by all cuts. Of another estimator: the relative standard
    deviation of a gain that all that it sensed share.
    """

    __tablename__ = "sensed_force"
    __table_args__ = (
        UniqueConstraint("cut_id", "component", "estimator", "calibration_id"),
        UniqueConstraint("cut_id", "component", "estimator_id", name="uq_sensed_force_estimator"),
        CheckConstraint("component IN ('x', 'y', 'z')"),
        CheckConstraint('("value_N" IS NULL) = ("sd_N" IS NULL)'),
        CheckConstraint('("value_N" IS NULL) = (reason IS NOT NULL)', name="not_sensed_says_why"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    cut_id: Mapped[int] = mapped_column(ForeignKey("cut.id"), index=True)
    component: Mapped[str]
    estimator: Mapped[str]
    calibration_id: Mapped[int | None] = mapped_column(ForeignKey("calibration.id"), index=True)
    estimator_id: Mapped[int | None] = mapped_column(
        ForeignKey("estimator.id", name="fk_sensed_force_estimator"), index=True
    )
    value_N: Mapped[float | None]
    sd_N: Mapped[float | None]
    common: Mapped[list[Any] | None]
    errors: Mapped[list[Any] | None]
    reason: Mapped[str | None]
    cut: Mapped[Cut] = relationship()
    calibration: Mapped[CalibrationVersion | None] = relationship()
    sensor: Mapped[Estimator | None] = relationship()


class SensedWaveform(Base):
    """A force over time as an estimator sensed it: where its file lies; its sd at every row."""

    __tablename__ = "sensed_waveform"
    __table_args__ = (
        UniqueConstraint(
            "recording_id", "component", "estimator_id", name="uq_sensed_waveform_key"
        ),
        one_of("component", COMPONENTS, name="ck_sensed_waveform_component"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    recording_id: Mapped[int] = mapped_column(ForeignKey("recording.id"), index=True)
    estimator_id: Mapped[int] = mapped_column(ForeignKey("estimator.id"), index=True)
    component: Mapped[str]
    path: Mapped[str]
    sha256: Mapped[str]
    bytes: Mapped[int]
    rows: Mapped[int]
    rate_hz: Mapped[float | None]
    sd_N: Mapped[float | None]
    created_at: Mapped[str] = mapped_column(default=now)
