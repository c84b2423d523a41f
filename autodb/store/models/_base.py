"""What all tables share: the base class, links between rows, and the columns of reference data."""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import JSON, BigInteger, CheckConstraint, Column, ForeignKey, Integer, Table
from sqlalchemy.orm import DeclarativeBase, Mapped

COMPONENTS = ("x", "y", "z")


def now() -> str:
    """Return the time, ISO 8601 in UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


class Base(DeclarativeBase):
    """All tables."""

    type_annotation_map = {  # noqa: RUF012 - SQLAlchemy's way
        dict[str, Any]: JSON(none_as_null=True),
        list[Any]: JSON(none_as_null=True),
        int: BigInteger().with_variant(Integer, "sqlite"),
    }


class ReferenceColumns:
    """Columns of a reference value: where it is from, how sure, and since when; NULL is unknown."""

    lower: Mapped[float | None]
    upper: Mapped[float | None]
    source: Mapped[str | None]
    status: Mapped[str | None]
    date: Mapped[str | None]


def table_of(model: type[Base]) -> Table:
    """Return the table of a model.

    A query of tables alone needs no mappers: to set them up takes a command that asks but a few
    things 0.05 s.
    """
    table = model.__table__
    assert isinstance(table, Table)
    return table


def link(name: str, left: str, right: str) -> Table:
    """Return an association table: rows of ``left`` came from rows of ``right``."""
    return Table(
        name,
        Base.metadata,
        Column(f"{left}_id", ForeignKey(f"{left}.id", ondelete="CASCADE"), primary_key=True),
        Column(f"{right}_id", ForeignKey(f"{right}.id"), primary_key=True, index=True),
    )


def one_of(column: str, values: tuple[str, ...], *, name: str) -> CheckConstraint:
    """Return a named check that ``column`` is NULL or one of ``values``."""
    listed = ", ".join(f"'{value}'" for value in values)
    return CheckConstraint(f"{column} IN ({listed})", name=name)
