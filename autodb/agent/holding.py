"""What a calibration holds for: the gear range that its spindle turned in, and the coolant."""

from collections.abc import Sequence
from pathlib import Path

from autodb.errors import UnusableInput
from autodb.store import models

GEARED = "spindle"
"""The axis that changes gear; coolant counts for all."""


def gear_range_of(recording: models.Recording) -> str | None:
    """Return the gear range that a recording's side file states."""
    return _stated(recording, "gear_range")


def coolant_of(recording: models.Recording) -> str | None:
    """Return the coolant that a recording's side file states."""
    return _stated(recording, "coolant")


def _stated(recording: models.Recording, key: str) -> str | None:
    value = recording.side.get("recording", {}).get(key)
    return None if value is None else str(value)


def refuse_mixed(recordings: Sequence[models.Recording]) -> None:
    """Raise UnusableInput where recordings state different gear ranges, or coolants.

    One that states nothing goes with any.
    """
    for what, of in (("gear range", gear_range_of), ("coolant", coolant_of)):
        first: dict[str, str] = {}
        for recording in recordings:
            value = of(recording)
            if value is not None:
                first.setdefault(value, Path(recording.path).name)
        if len(first) > 1:
            said = ", ".join(f"'{value}' ({name})" for value, name in first.items())
            raise UnusableInput(
                f"cuts with {what} {said}: one calibration holds for one {what}; "
                "'calibrate FILES --machine' with the files of one would work"
            )


def holds_for(axis: str, recordings: Sequence[models.Recording]) -> dict[str, str | None]:
    """Return gear range and coolant that a calibration on these recordings holds for."""
    geared, cooled = (
        next((value for value in map(of, recordings) if value is not None), None)
        for of in (gear_range_of, coolant_of)
    )
    return {"gear_range": geared if axis == GEARED else None, "coolant": cooled}


def why_not(calibration: models.Calibration, recording: models.Recording) -> str | None:
    """Return why a calibration does not hold for a recording's cuts, None where it does."""
    for what, holds, is_ in (
        ("gear range", calibration.gear_range, gear_range_of(recording)),
        ("coolant", calibration.coolant, coolant_of(recording)),
    ):
        if holds is not None and is_ is not None and holds != is_:
            return f"{calibration.axis} was calibrated with {what} '{holds}', not '{is_}'"
    return None
