"""Machines: their axes, what carries what, limits, motors and gears."""

from typing import Any

from sqlalchemy import CheckConstraint, ForeignKey, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column, relationship

from autodb.store.models._base import Base, now, one_of

DIALECTS = ("fanuc", "siemens", "heidenhain", "haas", "mazak", "okuma", "linuxcnc", "other")
UNITS = ("mm", "inch")
COUNTERWEIGHTS = ("none", "weight", "gas", "hydraulic", "spring")
VERTICALS = ("up", "down")


class Machine(Base):
    """One machine. ``version`` counts its changes, so that two writers notice each other.

    ``dynamometer``: what its file states of it. ``retired_at``: since when nothing more comes in of
    the machine; what it told stays.
    """

    __tablename__ = "machine"
    __table_args__ = (
        one_of("dialect", DIALECTS, name="ck_machine_dialect"),
        one_of("units", UNITS, name="ck_machine_units"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(unique=True)
    created_at: Mapped[str] = mapped_column(default=now)
    version: Mapped[int] = mapped_column(server_default="1")
    dialect: Mapped[str | None]
    units: Mapped[str | None]
    diameter: Mapped[bool | None]
    base_speed_rpm: Mapped[float | None]
    max_speed_rpm: Mapped[float | None]
    rotary_order: Mapped[list[Any] | None]
    shares: Mapped[str | None]
    compress_after_days: Mapped[float | None]
    drop_after_days: Mapped[float | None]
    retired_at: Mapped[str | None]
    dynamometer: Mapped[dict[str, Any] | None]
    axes: Mapped[list["Axis"]] = relationship(
        back_populates="machine", order_by="Axis.id", cascade="all, delete-orphan"
    )
    gears: Mapped[list["GearRange"]] = relationship(
        order_by="GearRange.id", cascade="all, delete-orphan"
    )
    __mapper_args__ = {"version_id_col": version}  # noqa: RUF012 - SQLAlchemy's way


class Axis(Base):
    """One driven axis of a machine. ``carried_by`` names the axis it rides on; NULL: the bed."""

    __tablename__ = "axis"
    __table_args__ = (
        UniqueConstraint("machine_id", "name"),
        CheckConstraint("carries IN ('tool', 'work')"),
        CheckConstraint("current_sign IN (-1, 1)"),
        one_of("counterweight", COUNTERWEIGHTS, name="ck_axis_counterweight"),
        one_of("vertical", VERTICALS, name="ck_axis_vertical"),
        CheckConstraint("travel_low_mm < travel_high_mm", name="ck_axis_travel"),
        CheckConstraint(
            '"torque_constant_lower" <= "torque_constant_N_m_A"'
            ' AND "torque_constant_N_m_A" <= "torque_constant_upper"',
            name="ck_axis_torque_constant",
        ),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    name: Mapped[str]
    carries: Mapped[str]
    current_sign: Mapped[int]
    carried_by: Mapped[str | None]
    moved_mass_kg: Mapped[float | None]
    vertical: Mapped[str | None]
    brake: Mapped[bool | None]
    counterweight: Mapped[str | None]
    counterweight_force_N: Mapped[float | None]
    rated_A: Mapped[float | None]
    screw_pitch_mm: Mapped[float | None]
    gear_ratio: Mapped[float | None]
    limit_force_N: Mapped[float | None]
    limit_torque_N_m: Mapped[float | None]
    limit_power_W: Mapped[float | None]
    limit_torque_curve: Mapped[list[Any] | None]
    limit_power_curve: Mapped[list[Any] | None]
    limit_efficiency: Mapped[float | None]
    limit_speed_mm_min: Mapped[float | None]
    limit_speed_rpm: Mapped[float | None]
    travel_low_mm: Mapped[float | None]
    travel_high_mm: Mapped[float | None]
    torque_constant_N_m_A: Mapped[float | None]
    torque_constant_lower: Mapped[float | None]
    torque_constant_upper: Mapped[float | None]
    torque_constant_source: Mapped[str | None]
    torque_constant_status: Mapped[str | None]
    torque_constant_date: Mapped[str | None]
    machine: Mapped[Machine] = relationship(back_populates="axes")


class GearRange(Base):
    """One gear range of a machine's spindle."""

    __tablename__ = "gear_range"
    __table_args__ = (
        UniqueConstraint("machine_id", "name", name="uq_gear_range_machine_name"),
        CheckConstraint("low_rpm < high_rpm", name="ck_gear_range_speeds"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    name: Mapped[str]
    low_rpm: Mapped[float]
    high_rpm: Mapped[float]
    base_speed_rpm: Mapped[float | None]
