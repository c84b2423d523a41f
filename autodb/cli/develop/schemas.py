"""Writes the JSON Schemas of the file formats: `python -m autodb.cli.develop.schemas DIR`.

They are generated from the models that read the files, so they cannot say anything else. Units come
from the suffix of each name.
"""

import json
import sys
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel

from autodb.explain.answer import Explanation
from autodb.files.coefficients import Coefficients
from autodb.files.job import Job
from autodb.files.machine import MachineFile
from autodb.files.part import PartFile
from autodb.files.side import SideFile
from autodb.files.tool import ToolFile
from autodb.live.agentfile import AgentFile
from autodb.pairs.handbook.stated import StatedMaterial
from autodb.standard.protocol import CutProtocol

DIALECT = "https://json-schema.org/draft/2020-12/schema"
Mode = Literal["validation", "serialization"]
FORMATS: tuple[tuple[str, str, type[BaseModel], Mode], ...] = (
    ("job", "Job file", Job, "validation"),
    ("machine", "Machine file", MachineFile, "validation"),
    ("tool", "Tool file", ToolFile, "validation"),
    ("standard_cuts", "Standard cuts (protocol)", CutProtocol, "validation"),
    ("conventional", "Conventional values of a work material", StatedMaterial, "validation"),
    ("part", "Part file", PartFile, "validation"),
    ("agent", "Agent file", AgentFile, "validation"),
    ("side_file", "Side file of a recording", SideFile, "validation"),
    ("explanation", "explanation.json", Explanation, "serialization"),
    ("coefficients", "Fitted coefficients", Coefficients, "serialization"),
)
"""Name, title, model, and whether the model reads the file or writes it."""

UNITS = (
    ("_N_m_A", "N·m/A"),
    ("_N_m", "N·m"),
    ("_mm_min", "mm/min"),
    ("_mm_rev", "mm/rev"),
    ("_mm_tooth", "mm/tooth"),
    ("_m_min", "m/min"),
    ("_mm", "mm"),
    ("_deg", "degrees"),
    ("_rpm", "rpm"),
    ("_kg", "kg"),
    ("_N", "N"),
    ("_A", "A"),
    ("_s", "s"),
)
"""Endings of names and their units, longer endings first."""


def unit_of_key(name: str) -> str | None:
    """Return the unit that a key's ending names, or None.

    >>> unit_of_key("speed_mm_min")
    'mm/min'
    """
    return next((unit for ending, unit in UNITS if name.endswith(ending)), None)


def format_schema(name: str, title: str, model: type[BaseModel], mode: Mode) -> dict[str, Any]:
    """Return the JSON Schema of one format, with `$id`, title, and units in the descriptions."""
    made = model.model_json_schema(mode=mode)
    for part in (made, *made.get("$defs", {}).values()):
        _describe(part)
    made.pop("title")
    return {"$schema": DIALECT, "$id": f"urn:autodb:{name}", "title": title, **made}


def _describe(part: dict[str, Any]) -> None:
    """Write descriptions in plain text, and the unit of every property that has one."""
    if "description" in part:
        part["description"] = " ".join(part["description"].replace("``", "`").split())
    for name, value in part.get("properties", {}).items():
        value.pop("title", None)
        unit = unit_of_key(name)
        if unit is not None:
            value["description"] = unit


def texts() -> dict[str, str]:
    """Return the text of every schema by file name."""
    return {
        f"{name}.schema.json": json.dumps(
            format_schema(name, title, model, mode), indent=1, ensure_ascii=False
        )
        + "\n"
        for name, title, model, mode in FORMATS
    }


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m autodb.cli.develop.schemas DIR")
    for file, content in texts().items():
        (Path(sys.argv[1]) / file).write_text(content, encoding="utf-8")
