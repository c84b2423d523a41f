"""What cuts and what is cut: tools, materials, their pairs, and handbook values."""

from sqlalchemy import CheckConstraint, ForeignKey, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column, relationship

from autodb.store.models._base import Base, ReferenceColumns, now, one_of

TOOL_KINDS = ("turning_insert", "end_mill", "drill")


class Tool(Base):
    """One tool, by name, with the geometry that is known.

    ``kappa_deg``: entering angle κ_r; ``rake_deg``: normal rake in the holder; ``included_deg``:
    angle between an insert's two edges. ``runout_mm``: offset of the tool's axis from the
    spindle's, ``runout_sd_mm`` its standard deviation, towards ``runout_deg`` from tooth 0 to tooth
    1, as it is clamped; NULL: not known, taken as none.
    """

    __tablename__ = "tool"
    __table_args__ = (
        one_of("kind", TOOL_KINDS, name="ck_tool_kind"),
        CheckConstraint("teeth > 0", name="ck_tool_teeth"),
        CheckConstraint("diameter_mm > 0", name="ck_tool_diameter"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(unique=True)
    kind: Mapped[str | None] = mapped_column(index=True)
    diameter_mm: Mapped[float | None]
    teeth: Mapped[int | None]
    helix_deg: Mapped[float | None]
    corner_radius_mm: Mapped[float | None]
    point_angle_deg: Mapped[float | None]
    nose_radius_mm: Mapped[float | None]
    kappa_deg: Mapped[float | None]
    rake_deg: Mapped[float | None]
    inclination_deg: Mapped[float | None]
    included_deg: Mapped[float | None]
    runout_mm: Mapped[float | None]
    runout_deg: Mapped[float | None]
    runout_sd_mm: Mapped[float | None]
    properties: Mapped[list["ToolProperty"]] = relationship(order_by="ToolProperty.code")


class ToolProperty(Base, ReferenceColumns):
    """One property of a tool under its ISO 13399 code."""

    __tablename__ = "tool_property"
    __table_args__ = (UniqueConstraint("tool_id", "code", name="uq_tool_property_tool_code"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    tool_id: Mapped[int] = mapped_column(ForeignKey("tool.id"), index=True)
    code: Mapped[str]
    value: Mapped[float]
    unit: Mapped[str]


class Material(Base):
    """One work material, by name."""

    __tablename__ = "material"
    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(unique=True)


class ConventionalParameter(Base, ReferenceColumns):
    """One handbook value of a material: a cutting parameter that no machine of ours has learnt."""

    __tablename__ = "conventional_parameter"
    __table_args__ = (
        UniqueConstraint(
            "material_id", "operation", "component", "name", "source",
            name="uq_conventional_parameter_key",
        ),
        one_of("component", ("x", "y", "z"), name="ck_conventional_parameter_component"),
        CheckConstraint(
            "lower <= value AND value <= upper", name="ck_conventional_parameter_bounds"
        ),
    )  # fmt: skip
    id: Mapped[int] = mapped_column(primary_key=True)
    material_id: Mapped[int] = mapped_column(ForeignKey("material.id"), index=True)
    operation: Mapped[str]
    component: Mapped[str]
    name: Mapped[str]
    unit: Mapped[str]
    value: Mapped[float]


class Pair(Base):
    """One work-tool pair: what cutting parameters belong to."""

    __tablename__ = "pair"
    __table_args__ = (UniqueConstraint("material_id", "tool_id"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    material_id: Mapped[int] = mapped_column(ForeignKey("material.id"))
    tool_id: Mapped[int] = mapped_column(ForeignKey("tool.id"))
    material: Mapped[Material] = relationship()
    tool: Mapped[Tool] = relationship()


class PairState(Base):
    """Where a pair stands on one machine; ``version`` lets two agents that write it notice it."""

    __tablename__ = "pair_state"
    __table_args__ = (
        UniqueConstraint("machine_id", "pair_id", "operation", name="uq_pair_state_key"),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    pair_id: Mapped[int] = mapped_column(ForeignKey("pair.id"), index=True)
    operation: Mapped[str]
    refresh_pass_id: Mapped[int | None] = mapped_column(ForeignKey("refresh_pass.id"), index=True)
    version: Mapped[int] = mapped_column(server_default="1")
    updated_at: Mapped[str] = mapped_column(default=now, onupdate=now)
    __mapper_args__ = {"version_id_col": version}  # noqa: RUF012 - SQLAlchemy's way
