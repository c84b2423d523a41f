"""Which rows of a cut table are which standard cut, and the reference force that they then have."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.records.tables import CutTable
from autodb.standard.protocol import CutProtocol, StandardCut
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

MATCH = 0.03
"""Relative difference of speed, feed and depth up to which a cut counts as a standard cut."""


@dataclass(frozen=True)
class References:
    """Reference force of each row (NaN: none) and the relative sd that all of them share."""

    force_N: Array
    share: float


def reference_forces(table: CutTable, protocol: CutProtocol, component: str) -> References:
    """Return the reference force of every row that is a standard cut of the protocol.

    Raises UnusableInput when no row is one, none of those has a reference, or a row is two of them.
    """
    force = np.full(len(table), np.nan)
    shares: list[float] = []
    matched = 0
    for cut in protocol.cut:
        rows = rows_of_cut(table, cut)
        matched += int(rows.sum())
        reference = cut.reference.get(component)
        if reference is not None and rows.any():
            _refuse_two_in_one(table, cut, rows & np.isfinite(force))
            force[rows] = reference.value
            shares.append((reference.upper - reference.lower) / 3.92 / abs(reference.value))
    if not matched:
        raise UnusableInput(
            phrase(
                "{file}: no row is a standard cut of '{protocol}'",
                file=table.path,
                protocol=protocol.name,
            )
        )
    if not shares:
        raise UnusableInput(
            phrase(
                "protocol '{protocol}': no reference for force.{component} yet; measure its "
                "cuts once with a dynamometer",
                protocol=protocol.name,
                component=component,
            )
        )
    return References(force, float(np.mean(shares)))


def _refuse_two_in_one(table: CutTable, cut: StandardCut, twice: NDArray[np.bool_]) -> None:
    if twice.any():
        number = table.cut[np.flatnonzero(twice)[0]]
        raise UnusableInput(
            phrase(
                "{file}: cut {number} is '{cut}' and another standard cut; a table does not "
                "state the direction of feed; use a protocol with one direction for each "
                "speed, feed and depth",
                file=table.path,
                number=localized(f"{number:g}"),
                cut=cut.name,
            )
        )


def rows_of_cut(table: CutTable, cut: StandardCut) -> NDArray[np.bool_]:
    """Return which rows of a table have a cut's operation, speed, feed and depth, shape (n,)."""
    operations = table.texts.get("operation", [cut.operation] * len(table))
    same = np.array([operation == cut.operation for operation in operations])
    wanted = {"spindle.speed": cut.speed_rpm, "cutting.feed": cut.feed_mm}
    if cut.depth_mm is not None:
        wanted["cutting.depth"] = cut.depth_mm
    for channel, value in wanted.items():
        same &= np.abs(table[channel] / value - 1.0) < MATCH
    return same
