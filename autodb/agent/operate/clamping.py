"""Run-out that a person confirmed, kept with its tool for as long as that stays clamped."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.fitting.gaussian import NORMAL_95
from autodb.store import models
from autodb.wording import localized, phrase

OFFSET, TOOTH = "offset", "tooth "
"""Parameters of a run-out: how far the axis is off, and how far each tooth stands out, mm."""
COLUMNS = ("runout_mm", "runout_deg", "runout_sd_mm")


def keep_runout(session: Session, row: models.Mismatch) -> str | None:
    """Keep a confirmed run-out with the tool of its recording; return it in words.

    None where the recording names no tool, or the mismatch does not say how teeth stand out.
    """
    name = (row.recording.side.get("tool") or {}).get("name")
    tool = session.scalar(select(models.Tool).where(models.Tool.name == name))
    found = _off_axis(row.parameters)
    if tool is None or found is None:
        return None
    before = {column: getattr(tool, column) for column in COLUMNS}
    row.applied = {**(row.applied or {}), "tool": tool.id, "before": before}
    tool.runout_mm, tool.runout_deg, tool.runout_sd_mm = found
    session.flush()
    return phrase(
        "tool {tool}: run-out {size} ± {half} mm towards {angle}° from tooth 0, as it is clamped",
        tool=tool.name,
        size=localized(f"{found[0]:.4f}"),
        half=localized(f"{NORMAL_95 * found[2]:.4f}"),
        angle=localized(f"{found[1]:.0f}"),
    )


def forget_runout(session: Session, row: models.Mismatch) -> list[str]:
    """Have a tool run out as before a decision; return it in words."""
    applied = row.applied or {}
    tool = session.get(models.Tool, applied["tool"]) if "tool" in applied else None
    if tool is None:
        return []
    for column, value in applied["before"].items():
        setattr(tool, column, value)
    return [phrase("the run-out of tool {tool} is taken back", tool=tool.name)]


def _off_axis(parameters: Mapping[str, Any]) -> tuple[float, float, float] | None:
    """Return offset of the axis, mm, its direction, deg, and standard deviation, mm.

    What teeth stand out by beyond an axis that is off is in the standard deviation.
    """
    teeth = [one["value"] for name, one in parameters.items() if name.startswith(TOOTH)]
    offset = parameters.get(OFFSET)
    if len(teeth) < 2 or offset is None:
        return None
    lag = 2.0 * np.pi * np.arange(len(teeth)) / len(teeth)
    columns = np.column_stack([np.cos(lag), np.sin(lag)])
    along = np.linalg.lstsq(columns, np.array(teeth), rcond=1e-9)[0]
    left = float(np.sqrt(np.mean((np.array(teeth) - columns @ along) ** 2)))
    sd = float(np.hypot((offset["high"] - offset["low"]) / (2.0 * NORMAL_95), left))
    direction = float(np.degrees(np.arctan2(along[1], along[0])))
    return float(np.hypot(*along)), direction, sd
