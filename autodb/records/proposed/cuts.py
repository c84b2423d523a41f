"""Units of a cut table that its numbers tell: what a chip takes, what a drive can carry."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from autodb.files.channels import FORCES
from autodb.records.proposed.motion import Array
from autodb.wording import listed, phrase

LEAST_N_MM2, MOST_N_MM2 = 200.0, 10_000.0
"""Specific cutting force of any metal at any chip: aluminium some 400 N/mm², hard steel in thin
chips some 8000; wide of both. Chosen."""
FORCES_IN = {"kN": 1000.0, "daN": 10.0}
MOST_A = 500.0
"""Amperes of no drive of a machine tool; milliamperes of many. Chosen."""


@dataclass(frozen=True)
class ChannelProposal:
    """A column may be a channel, in ``unit`` (empty: ours), for a reason; of time of counted rows
    the unit is the step in s.
    """

    column: str
    channel: str
    unit: str
    because: str


def with_told_units(
    found: Iterable[ChannelProposal], numbers: Mapping[str, Array]
) -> Iterator[ChannelProposal]:
    """Yield proposals with the units that their numbers tell, where nothing states them."""
    given = list(found)
    values = {one.channel: numbers[one.column] for one in given if one.column in numbers}
    unit, specific = _unit_of_forces(values)
    for one in given:
        if one.unit or one.channel not in values:
            yield one
        elif one.channel in FORCES and specific:
            said = phrase(
                "specific cutting force {specific} N/mm², in {unit}",
                specific=f"{specific:.0f}", unit=unit or "N",
            )  # fmt: skip
            yield replace(one, unit=unit, because=listed([one.because, said], "; "))
        elif ".current" in one.channel and _median(values[one.channel]) > MOST_A:
            said = phrase("too large for amperes")
            yield replace(one, unit="mA", because=listed([one.because, said], "; "))
        else:
            yield one


def _unit_of_forces(values: Mapping[str, Array]) -> tuple[str, float]:
    """Return the unit of cutting forces, empty for N, and the specific force; 0: not known."""
    needed = [values.get(c) for c in ("force.y", "cutting.feed", "cutting.depth")]
    if any(one is None for one in needed):
        return "", 0.0
    force, feed_mm, depth_mm = (np.asarray(one) for one in needed)
    with np.errstate(divide="ignore", invalid="ignore"):
        specific = _median(np.abs(force) / (feed_mm * depth_mm))
    for unit, newtons in {"": 1.0, **FORCES_IN}.items():
        if LEAST_N_MM2 <= specific * newtons <= MOST_N_MM2:
            return unit, specific * newtons
    return "", 0.0


def _median(values: Array) -> float:
    known = np.abs(values[np.isfinite(values)])
    return float(np.median(known)) if known.size else 0.0
