"""A force, torque or power whose sign is turned round: it runs against what any cut does.

The work pushes the edge along its own velocity and against the feed, and the spindle gives power
(ISO 841 axes, force on the tool). A dynamometer that reports the force on the work has all of that
turned round, in every cut.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import CutTable
from autodb.sensing.ranges.faults.check import DataCheck
from autodb.sensing.ranges.feeding import (
    feeds_outward,
    mill_feed,
    oblique_cuts,
    operations_of,
    turned_cuts,
    z_runs_back,
)
from autodb.wording import listed, phrase

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]

LEAST_SHARE = 0.05
"""Share of the measured force, in the median cut, below which a component's sign says nothing.
Chosen."""
LEAST_PART = 0.1
"""Part of a feed along an axis below which that axis' force does not count. Chosen."""
AGAINST = ("slot", "ramp", "side-up")
"""Milling in which every tooth pushes the tool against the feed."""
ASIDE = ("slot", "ramp", "side-down", "pocket")
"""Milling in which it pushes the tool to the left of the feed."""


@dataclass(frozen=True)
class _Known:
    """A quantity that is above zero in every cut: values (n,), NaN where nothing is known of it.

    ``channels`` it is made of; ``said``: how it is called where it is not.
    """

    channels: tuple[str, ...]
    said: str
    values: Array


def signs(table: CutTable, stated: Collection[str] = ()) -> DataCheck:
    """Return whether what has one sign in any cut has it in one cut at least.

    ``stated``: channels of which a side file states that their sign is right.
    """
    size_N = _resultant_N(table)
    turned = [
        one
        for one in _known(table)
        if _turned_round(one, size_N) and not set(one.channels) <= set(stated)
    ]
    return DataCheck("signs", len(turned), "<=", 0, _sentence(turned) if turned else "")


def _sentence(turned: list[_Known]) -> str:
    channels = list(dict.fromkeys(name for one in turned for name in one.channels))
    names = _listed(channels)
    forces = any(name.startswith("force.") for name in channels)
    why = (
        phrase("the dynamometer reports the force on the work?")
        if forces
        else phrase("is its sign right?")
    )
    return phrase(
        "{value} in every cut: {why} set sign = -1 for {names} in the side file, or "
        "sign = 1 if it is right as it is",
        value=_listed([one.said for one in turned]),
        why=why,
        names=names,
    )


def _listed(names: list[str]) -> str:
    return listed(filter(None, [listed(names[:-1]), names[-1]]), phrase(" and "))


def _turned_round(one: _Known, size_N: Array) -> bool:
    known = np.isfinite(one.values)
    if not known.any() or np.any(one.values[known] >= 0.0):
        return False
    if not one.channels[0].startswith("force."):
        return True
    share = np.abs(one.values[known]) / size_N[known]
    return bool(np.median(share) >= LEAST_SHARE)


def _resultant_N(table: CutTable) -> Array:
    """Return the size of what was measured of each cut's force (n,)."""
    parts = [np.nan_to_num(table[f"force.{c}"]) for c in "xyz" if f"force.{c}" in table]
    return np.sqrt(np.sum(np.square(parts), axis=0)) if parts else np.ones(len(table))


def _known(table: CutTable) -> Iterator[_Known]:
    """Yield what is above zero in every cut, of what the table has."""
    turned, operations = turned_cuts(table), np.array(operations_of(table))
    yield from _force(table, "y", turned, phrase("force.y is negative"))
    straight, along = turned & ~oblique_cuts(table), np.where(z_runs_back(table), -1.0, 1.0)
    yield from _force(table, "z", straight, phrase("force.z runs with the feed"), along)
    across = np.where(feeds_outward(table), -1.0, 1.0)
    yield from _force(
        table, "x", operations == "face", phrase("force.x runs with the feed"), across
    )
    yield from _force(
        table, "z", operations == "drill", phrase("force.z pulls the drill into the work")
    )
    yield from _milled(table, operations)
    yield from _spindle(table)


def _force(
    table: CutTable, component: str, rows: Rows, said: str, sign: Array | float = 1.0
) -> Iterator[_Known]:
    name = f"force.{component}"
    if name in table:
        yield _Known((name,), said, np.where(rows, sign * table[name], np.nan))


def _milled(table: CutTable, operations: NDArray[np.str_]) -> Iterator[_Known]:
    """Yield the parts of a mill's mean force against its feed and to the left of it."""
    if "force.x" not in table or "force.y" not in table:
        return
    feed_x, feed_y = mill_feed(table)
    for of, said, x, y in (
        (AGAINST, phrase("the force in x and y runs with the feed"), -feed_x, -feed_y),
        (ASIDE, phrase("the force in x and y is to the right of the feed"), -feed_y, feed_x),
    ):
        rows = np.isin(operations, of) & np.isfinite(feed_x)
        parts = {"force.x": x, "force.y": y}
        channels = [n for n, part in parts.items() if np.any(np.abs(part[rows]) > LEAST_PART)]
        if channels:
            values = x * table["force.x"] + y * table["force.y"]
            yield _Known(tuple(channels), said, np.where(rows, values, np.nan))


def _spindle(table: CutTable) -> Iterator[_Known]:
    """Yield the power that the spindle gives, as recorded and as torque times speed."""
    power, torque, speed = (
        table.get(name) for name in ("spindle.power", "torque.spindle", "spindle.speed")
    )
    if power is not None:
        yield _Known(("spindle.power",), phrase("spindle.power is negative"), power)
    if torque is not None and speed is not None:
        said = phrase("torque.spindle times spindle.speed is negative")
        yield _Known(("torque.spindle",), said, torque * speed)
