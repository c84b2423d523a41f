"""What a calibration is fitted to: the current and the known force or torque of each cut."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import torque_N_m
from autodb.errors import UnusableInput, near_words
from autodb.records.tables import CutTable
from autodb.sensing.ranges.choosing import MIN_GROUPS, grouping
from autodb.sensing.ranges.feeding import moving, torque_arm_mm
from autodb.sensing.ranges.forms import MeasuredCuts
from autodb.wording import phrase

Array = NDArray[np.float64]

COMPONENT_OF_AXIS = {"x": "x", "z": "z", "spindle": "y"}
FEED_AXES = ("x", "z")


def current_signal(table: CutTable, axis: str) -> tuple[str, Array] | None:
    """Return name and values (n,) of the current that an axis senses force with, or None.

    The rise of the range over its air value where both are there, else the range, else the current.
    """
    cut, air = table.get(f"{axis}.current.range"), table.get(f"{axis}.current.air")
    if cut is not None and air is not None:
        return f"{axis}.current.range − {axis}.current.air", cut - air
    for name in (f"{axis}.current.range", f"{axis}.current"):
        if name in table:
            return name, table[name]
    return None


@dataclass(frozen=True)
class Points:
    """What a form is fitted to: rows (m,) in which the axis moves and the target is known."""

    channel: str
    unit: str
    cut: Array
    sensed: MeasuredCuts
    target: Array
    groups: NDArray[np.generic]
    grouped_by: str

    def at(self, rows: NDArray[np.bool_]) -> "Points":
        """Return some of the rows."""
        return replace(
            self,
            cut=self.cut[rows],
            sensed=self.sensed.at(rows),
            target=self.target[rows],
            groups=self.groups[rows],
        )


def calibration_points(
    table: CutTable,
    axis: str,
    *,
    force_N: Array | None = None,
    other_way: NDArray[np.bool_] | None = None,
) -> Points:
    """Return the current and the reference force or torque of the cuts in which an axis moves.

    ``force_N`` (n,) are the reference forces (NaN: none); default the table's own ``force.*``.
    ``other_way`` (n,): cuts of the axis' other direction, which come mirrored.

    Raises UnusableInput when the current, the force or enough independent groups are missing.
    """
    component = COMPONENT_OF_AXIS[axis]
    signal = current_signal(table, axis)
    if signal is None:
        raise UnusableInput(
            phrase(
                "{file}: no channel '{axis}.current' or '{axis}.current.range'{hint}",
                file=table.path,
                axis=axis,
                hint=near_words(f"{axis}.current.range", table.ignored) if table.ignored else "",
            )
        )
    force = table[f"force.{component}"] if force_N is None else force_N
    target, unit = _target(table, axis, force)
    used = moving(table, axis) & np.isfinite(target) & np.isfinite(signal[1])
    groups, grouped_by = grouping(table, used)
    if len(np.unique(groups)) < MIN_GROUPS:
        raise UnusableInput(
            phrase(
                "{file}: {axis}: {n} independent groups of cuts with force.{component}; use "
                "{min_groups} or more",
                file=table.path,
                axis=axis,
                n=len(np.unique(groups)),
                component=component,
                min_groups=MIN_GROUPS,
            )
        )
    points = Points(
        channel=signal[0],
        unit=unit,
        cut=table.cut[used],
        sensed=measured_cuts(table, axis, signal[1]).at(used),
        target=target[used],
        groups=groups,
        grouped_by=grouped_by,
    )
    return points if other_way is None else _mirrored(points, other_way[used])


def _mirrored(points: Points, other_way: NDArray[np.bool_]) -> Points:
    """Return points of which those of the axis' other direction are seen in a mirror.

    Their force changes its sign, and their current where it has one: where it goes with the force
    one way in both directions, as a signed current does and a range, which never falls, does not.
    """
    rising = [
        float(np.cov(points.sensed.current[rows], points.target[rows])[0, 1]) > 0.0
        for rows in (other_way, ~other_way)
    ]
    turned = np.where(other_way, -1.0, 1.0)
    sign = turned if rising[0] == rising[1] else np.ones_like(turned)
    current = sign * points.sensed.current
    sensed = replace(points.sensed, current=current, other_way=other_way.astype(np.float64))
    return replace(points, sensed=sensed, target=turned * points.target)


def measured_cuts(table: CutTable, axis: str, current: Array) -> MeasuredCuts:
    """Return what an axis measured in every row."""
    names = ("spindle.speed", "cutting.feed", "cutting.depth", "spindle.temperature")
    speed_rpm, feed_mm, depth_mm, temperature_C = (
        np.full(len(table), np.nan) if known is None else known for known in map(table.get, names)
    )
    feed_mm_s = feed_mm * speed_rpm / 60.0
    rises = f"{axis}.current.range" in table
    return MeasuredCuts(
        current,
        feed_mm_s,
        speed_rpm,
        feed_mm,
        depth_mm,
        temperature_C,
        current_sd(table, axis),
        air=table.get(f"{axis}.current.air") if rises else None,
    )


def current_sd(table: CutTable, axis: str) -> Array | None:
    """Return the standard error (n,) of what ``current_signal`` returns; None where none is known.

    Of a rise it is that of both means; NaN where a cut lacks one.
    """
    cut, air = (table.get(f"{axis}.current.{part}.sd") for part in ("range", "air"))
    if f"{axis}.current.range" in table and f"{axis}.current.air" in table:
        return None if cut is None or air is None else np.hypot(cut, air)
    return cut if f"{axis}.current.range" in table else None


def _target(table: CutTable, axis: str, force_N: Array) -> tuple[Array, str]:
    """Return what the line predicts: spindle torque where the torque arm is known, else force."""
    arm_mm = torque_arm_mm(table) if axis == "spindle" else None
    return (force_N, "N") if arm_mm is None else (torque_N_m(force_N, arm_mm), "N·m")
