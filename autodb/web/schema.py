"""Units in the service's document: read off the names, which end in them."""

from collections.abc import Iterator
from typing import Any

from fastapi import FastAPI

UNITS = {
    "_N_m": "N·m", "_mm_rev": "mm/rev", "_mm_tooth": "mm/tooth", "_mm_min": "mm/min",
    "_m_min": "m/min", "_N": "N", "_mm": "mm", "_rpm": "rpm", "_deg": "°", "_s": "s", "_W": "W",
}  # fmt: skip
"""Unit by how a name ends, the longer ends first."""


def unit_of_name(name: str) -> str | None:
    """Return the unit that a name ends in; None where it has none.

    >>> unit_of("torque_N_m"), unit_of("feed_mm_rev"), unit_of("notes")
    ('N·m', 'mm/rev', None)
    """
    return next((unit for end, unit in UNITS.items() if name.endswith(end)), None)


def with_units(app: FastAPI) -> None:
    """Have an app's document say the unit of every quantity, as ``x-unit``."""
    made = app.openapi

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            document = made()
            for name, shape in _named(document):
                unit = unit_of_name(name)
                if unit is not None:
                    shape["x-unit"] = unit
        return made()

    app.openapi = openapi  # type: ignore[method-assign]  # FastAPI's way


def _named(document: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Give every property and parameter by its name."""
    for schema in document["components"]["schemas"].values():
        yield from schema.get("properties", {}).items()
    for path in document["paths"].values():
        for operation in path.values():
            for one in operation.get("parameters", ()):
                yield one["name"], one
