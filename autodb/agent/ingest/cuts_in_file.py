"""The cuts that a file holds: of a table, of raw phase currents, or stated of a recording."""

from collections.abc import Callable
from typing import Any

import numpy as np
from sqlalchemy.orm import Session

from autodb.agent.rows.catalogue import pair_id
from autodb.agent.rows.content import of_cut
from autodb.errors import UnusableInput
from autodb.files.channels import JOB, JOB_BLOCK, JOB_CUT, LOT, axis_of
from autodb.files.side import SideFile
from autodb.pairs.engaged import BY_NAME, DIRECTION
from autodb.records.source import RecordingSource
from autodb.records.tables import EDGE, CutTable, Recording
from autodb.sensing.ranges import faults
from autodb.sensing.ranges.feeding import feeds_outward
from autodb.sensing.ranges.points import COMPONENT_OF_AXIS
from autodb.sensing.ranges.recorded import raw
from autodb.store import models
from autodb.wording import phrase

_CONDITION_PREFIXES = (
    "cutting.",
    "work.",
    "pocket.",
    "spindle.speed",
    "tool.",
    "chip.",
    "cut.",
    "z.position",
)
CHIP = "chip.thickness"
"""A condition of a cut that is measured all the same."""


def cuts_in(
    source: RecordingSource, progress: Callable[[str], None] | None
) -> tuple[CutTable | None, tuple[str, ...]]:
    """Return the cuts of a file: its table of cuts, or the cut that its phase currents hold.

    With what was left out of that cut's averages. Raises SetAside.
    """
    holding = [
        base
        for base in source.usable()
        if base.holds_cuts or raw.has_phase_currents(base.conversion.specs)
    ]
    if len(holding) > 1:
        names = ", ".join(f"'{base.name}'" for base in holding)
        raise UnusableInput(
            phrase(
                "{file}: cuts in several time bases ({names}); use one time base",
                file=source.path,
                names=names,
            )
        )
    if not holding:
        return _said_cut(source), ()
    table = holding[0].read()
    cuts, notes = (table, ()) if isinstance(table, CutTable) else _raw_cut(table, progress)
    _refuse_unmeasured(cuts)
    faults.refuse(source.path, faults.checks_of_units(cuts, tuple(COMPONENT_OF_AXIS)))
    faults.refuse(source.path, faults.checks_of_signs(cuts))
    return cuts, notes


def _said_cut(source: RecordingSource) -> CutTable | None:
    """Return the cut that a side file states of a recording over time: nothing of it was averaged.

    None where it says too little for its forces to be worked out: pair, operation, conditions.
    """
    side, known = source.side, raw.stated_by(source.side)
    operation = BY_NAME.get(side.cut.operation or "")
    named = side.recording.work is not None and side.tool.name is not None
    if operation is None or not named or operation.lacking(known):
        return None
    return raw.table_of_cut(source.path, side, {"cut": 1.0} | known)


def _raw_cut(
    recording: Recording, progress: Callable[[str], None] | None
) -> tuple[CutTable, tuple[str, ...]]:
    cut = raw.cut_of_recording(recording, progress=progress)
    return cut.table, cut.notes


def _pair_names(table: CutTable, row: int) -> tuple[str, str]:
    """Return material and tool of a cut; empty where it is not known."""
    texts = {name: column[row] for name, column in table.texts.items()}
    material = texts.get("work.material") or table.side.recording.work or ""
    return material, texts.get("tool") or table.side.tool.name or ""


def _refuse_unmeasured(table: CutTable) -> None:
    """Raise UnusableInput where a table says how was cut, and nothing that was sensed."""
    said = ("cut", JOB_BLOCK)
    sensed = [name for name in table.channels if name not in said and not _is_condition(name)]
    if not sensed and CHIP not in table:
        raise UnusableInput(
            phrase(
                "{file}: nothing was measured in its cuts; add a column like y.current.range, "
                "force.z or {chip}{near}",
                file=table.path,
                chip=CHIP,
                near=table.near("force.z"),
            )
        )


def _is_condition(name: str) -> bool:
    return name.startswith(_CONDITION_PREFIXES) or name == "t"


def _named(table: CutTable, row: int) -> dict[str, str | float] | None:
    """Return what a cut is called in its job, as far as it is stated; None: not at all."""
    said, block = table.side.recording, table.get(JOB_BLOCK)
    known: dict[str, str | float | None] = {
        "job": table.texts[JOB][row] if JOB in table.texts else said.job,
        "program": said.program,
        "cut": table.texts[JOB_CUT][row] if JOB_CUT in table.texts else None,
        "block": None if block is None or not np.isfinite(block[row]) else float(block[row]),
    }
    return {name: value for name, value in known.items() if value} or None


def _cut_row(table: CutTable, row: int, signs: dict[str, int], *, outward: bool) -> models.Cut:
    """Return a row of a table as a cut; ``outward``: it faces away from the axis."""
    row_of = {name: float(channel[row]) for name, channel in table.channels.items()}
    values = {name: value for name, value in row_of.items() if np.isfinite(value)}
    texts = {name: column[row] for name, column in table.texts.items() if column[row]}
    conditions: dict[str, float | str] = {
        name: value for name, value in values.items() if _is_condition(name)
    }
    if EDGE in texts:
        conditions[EDGE] = texts[EDGE]
    if outward:
        conditions[DIRECTION] = -90.0
    measured = {
        name: value * (signs.get(axis_of(name), 1) if name.endswith(".current") else 1)
        for name, value in values.items()
        if name not in conditions and name not in ("cut", JOB_BLOCK)
    }
    return models.Cut(
        number=values["cut"],
        operation=texts.get("operation"),
        conditions=conditions,
        measured=measured,
        lot=texts.get(LOT) or table.side.recording.lot,
        named=_named(table, row),
    )


def _pair_id(session: Session, material: str, tool: str, side: SideFile) -> int | None:
    if not material or not tool:
        return None
    stated = _geometry_of(side) if side.tool.name in (None, tool) else {}
    return pair_id(session, material, tool, stated)


def _geometry_of(side: SideFile) -> dict[str, Any]:
    """Return the geometry that a side file states of its tool."""
    every = {name: getattr(side.tool, name) for name in _GEOMETRY}
    return {name: value for name, value in every.items() if value is not None}


_GEOMETRY = (
    *("kind", "diameter_mm", "teeth", "helix_deg", "corner_radius_mm", "point_angle_deg"),
    *("nose_radius_mm", "kappa_deg", "rake_deg", "inclination_deg", "included_deg"),
)


def made_cuts(session: Session, owner: models.Machine, cuts: CutTable) -> list[models.Cut]:
    """Return the cuts of a table as rows, not yet of a recording."""
    signs = {axis.name: axis.current_sign for axis in owner.axes}
    pairs: dict[tuple[str, str], int | None] = {}
    rows, outward = [], feeds_outward(cuts)
    for row in range(len(cuts)):
        named = _pair_names(cuts, row)
        if named not in pairs:
            pairs[named] = _pair_id(session, *named, cuts.side)
        made = _cut_row(cuts, row, signs, outward=bool(outward[row]))
        made.pair_id, made.content = pairs[named], of_cut(made, *named)
        rows.append(made)
    return rows
