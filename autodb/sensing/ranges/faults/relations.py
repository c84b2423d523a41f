"""What the channels of a table of cuts state together, and where it lies on any machine.

Every relation holds in any cut on metal, within wide bounds; bounds without a source are chosen.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import speed_m_min, torque_N_m
from autodb.files.machine import SPINDLE, MachineFile
from autodb.files.units import RAW
from autodb.records.tables import CutTable
from autodb.sensing.ranges.feeding import moving, torque_arm_mm, turned_cuts
from autodb.sensing.ranges.points import COMPONENT_OF_AXIS, current_signal
from autodb.standard import CutProtocol, rows_of_cut
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

SPECIFIC_N_MM2, USUAL_N_MM2 = (20.0, 12000.0), (120.0, 12000.0)
"""Force.y over feed · depth: 485.78 N at 0.2 mm and 2 mm are 1214 N/mm² (P1 table 2); usual is a
tenth to ten times of that, plastics have less."""
SPEED_RATIO = (0.7, 1.4)
"""π D n over the cutting speed in turning; D may be the machined, the mean or the outer one."""
ALIKE = 1.2
SPEED_M_MIN = (3.0, 6000.0)
DEPTH_A_FEED, USUAL_DEPTH = (0.05, 2000.0), (0.5, 100.0)
"""Depth over feed in turning; P1's are 2.5 to 25, finishing with a wiper has less than one."""
COMPONENT_SHARE = {"force.x": (0.005, 3.0), "force.z": (0.02, 3.0)}
"""Radial and axial force over the tangential one; a radial force can be nearly nothing."""
N_A, N_M_A = (10.0, 5e4), (0.02, 300.0)
"""Force per ampere of a feed drive, torque per ampere of a spindle: P1's lathe has 200 N/A and
about 1 N·m/A; a direct drive has less, a fine screw that hardly senses the cut more."""
AIR_SHARE = (0.02, 50.0)
OVERLOAD = 5.0
"""No drive carries more than this times its rated current."""
OVERSPEED = 1.2
REFERENCE_RATIO = (0.6, 1.6)
"""Measured over reference force of a standard cut: lathes differ by some per cent, lots of a
material by more; the factor between lbf and daN, 2.25, is distinguished."""


@dataclass(frozen=True)
class KnownOfCuts:
    """What else is known of a table's cuts: the protocol they follow, the machine they ran on.

    ``signs``: channels of which a side file states that their sign is right.
    """

    protocol: CutProtocol | None = None
    machine: MachineFile | None = None
    signs: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Relation:
    """What channels state together: a median over cuts, and where it lies on any machine.

    ``usual`` bounds are narrower: outside them nothing is wrong, but of two units that mend a table
    the one that makes it usual is meant. ``by_unit``: broken, it is a fault only where another unit
    mends it.
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    usual: tuple[float, float] | None = None
    by_unit: bool = False

    @property
    def holds(self) -> bool:
        """Whether the value lies within the bounds, or no cut states it."""
        return bool(np.isnan(self.value) or self.low <= self.value <= self.high)

    @property
    def is_usual(self) -> bool:
        """Whether it holds within the usual bounds."""
        if self.usual is None or np.isnan(self.value):
            return self.holds
        return bool(self.usual[0] <= self.value <= self.usual[1])

    def __str__(self) -> str:
        digits = ".0f" if self.value >= 1000.0 else ".3g"
        number = f"{localized(f'{self.value:{digits}}')} {self.unit}".strip()
        if self.value < self.low:
            low = localized(f"{self.low:g}")
            return phrase("{name} is {number}, below {low}", name=self.name, number=number, low=low)
        high = localized(f"{self.high:g}")
        return phrase("{name} is {number}, above {high}", name=self.name, number=number, high=high)


def relations(
    table: CutTable, axes: Sequence[str], heard: Sequence[str], known: KnownOfCuts
) -> list[Relation]:
    """Return every relation; ``heard`` are the axes whose current responds to the load.

    Where no force was measured, a protocol's references stand in.
    """
    measured, table = table, _with_references(table, known.protocol)
    with np.errstate(divide="ignore", invalid="ignore"):  # a cut may state zero
        return [
            *_conditions(table),
            *_forces(table),
            *_drives(table, heard),
            *_plates(table, axes, known.machine),
            *_standards(measured, known.protocol),
        ]


def _with_references(table: CutTable, protocol: CutProtocol | None) -> CutTable:
    """Return the table with a protocol's reference forces for the components not measured."""
    if protocol is None or not _states_conditions(table):
        return table
    added: dict[str, Array] = {}
    for cut in protocol.cut:
        rows = rows_of_cut(table, cut)
        for component, reference in cut.reference.items():
            if f"force.{component}" not in table:
                force = added.setdefault(f"force.{component}", np.full(len(table), np.nan))
                force[rows] = reference.value
    return replace(table, channels={**table.channels, **added})


def _states_conditions(table: CutTable) -> bool:
    return all(n in table for n in ("spindle.speed", "cutting.feed", "cutting.depth"))


def channels_stated(table: CutTable, *names: str) -> list[Array] | None:
    """Return channels (n,) in the cuts that state all of them; None where one is missing."""
    if any(name not in table for name in names):
        return None
    return [table[name] for name in names]


def _median(values: Array) -> float:
    known = np.abs(values[np.isfinite(values)])
    return float(np.median(known)) if known.size else np.nan


def _constant(ratios: Array) -> float:
    """Return the median of ratios that are the same in nine cuts of ten, else NaN.

    A unit is the same factor in every cut; a spindle at its highest speed cuts slower than stated,
    each diameter by another factor.
    """
    middle = _median(ratios)
    known = ratios[np.isfinite(ratios) & (ratios > 0)]
    alike = np.abs(np.log(known / middle)) < np.log(ALIKE)
    return middle if known.size and np.mean(alike) >= 0.9 else np.nan


def _conditions(table: CutTable) -> list[Relation]:
    """Return what the conditions of the cuts state together."""
    found = []
    turns = np.array([o == "turn" for o in table.texts.get("operation", [""] * len(table))])
    around = channels_stated(table, "work.diameter", "spindle.speed")
    stated = table.get("cutting.speed")
    if around is not None:
        v_m_min = speed_m_min(*around)
        found.append(
            Relation("π · work.diameter · spindle.speed", "m/min", _median(v_m_min), *SPEED_M_MIN)
        )
        if stated is not None:
            ratio = _constant((v_m_min / stated)[turns])
            name = "π · work.diameter · spindle.speed / cutting.speed"
            found.append(Relation(name, "", ratio, *SPEED_RATIO))
    if stated is not None:
        found.append(Relation("cutting.speed", "m/min", _median(stated), *SPEED_M_MIN))
    both = channels_stated(table, "cutting.depth", "cutting.feed")
    if both is not None:
        ratio = _median((both[0] / both[1])[turned_cuts(table)])
        found.append(
            Relation("cutting.depth / cutting.feed", "", ratio, *DEPTH_A_FEED, USUAL_DEPTH)
        )
    return found


def _forces(table: CutTable) -> list[Relation]:
    """Return the specific cutting force, and the force's components to each other."""
    found, turned = [], turned_cuts(table)
    chip = channels_stated(table, "force.y", "cutting.feed", "cutting.depth")
    if chip is not None:
        specific = _median((chip[0] / (chip[1] * chip[2]))[turned])
        name = "force.y / (cutting.feed · cutting.depth)"
        found.append(Relation(name, "N/mm²", specific, *SPECIFIC_N_MM2, USUAL_N_MM2))
    for other, bounds in COMPONENT_SHARE.items():
        pair = channels_stated(table, other, "force.y")
        if pair is not None:
            share = _median((pair[0] / pair[1])[turned])
            found.append(Relation(f"{other} / force.y", "", share, *bounds))
    return found


def _drives(table: CutTable, axes: Sequence[str]) -> list[Relation]:
    """Return force or torque per ampere over air, and the air's share of the range, of each axis.

    A current without its air value holds friction too, which no bound on newtons per ampere covers.
    """
    found = []
    for axis in axes:
        air = channels_stated(table, f"{axis}.current.air", f"{axis}.current.range")
        if air is None or table.unit(f"{axis}.current.range") == RAW:
            continue
        name = f"{axis}.current.air / {axis}.current.range"
        found.append(Relation(name, "", _median(air[0] / air[1]), *AIR_SHARE))
        force = table.get(f"force.{COMPONENT_OF_AXIS[axis]}")
        if force is not None:
            found.append(_per_ampere(table, axis, force, air[1] - air[0]))
    return found


def _per_ampere(table: CutTable, axis: str, force: Array, rise: Array) -> Relation:
    """Return the force, or the torque where the arm is known, per ampere of rise."""
    rows = moving(table, axis) & turned_cuts(table) & (rise != 0)
    arm = torque_arm_mm(table) if axis == SPINDLE else None
    name = f"force.{COMPONENT_OF_AXIS[axis]} / {axis}.current"
    if arm is None:
        return Relation(name, "N/A", _median(force[rows] / rise[rows]), *N_A)
    torque = torque_N_m(force, arm)
    return Relation(f"torque of {name}", "N·m/A", _median(torque[rows] / rise[rows]), *N_M_A)


def _plates(table: CutTable, axes: Sequence[str], machine: MachineFile | None) -> list[Relation]:
    """Return currents over the rated ones, and spindle speed over its highest."""
    if machine is None:
        return []
    found = []
    for axis in axes:
        rated_A = machine.axes[axis].rated_A if axis in machine.axes else None
        range_A, signal = table.get(f"{axis}.current.range"), current_signal(table, axis)
        if rated_A is None or signal is None or table.unit(signal[0].split(" ", 1)[0]) == RAW:
            continue
        amplitude_A = signal[1] if range_A is None else 0.5 * range_A
        share = _median(amplitude_A) / (np.sqrt(2.0) * rated_A)
        found.append(Relation(f"{axis}.current over its rated current", "", share, 0.0, OVERLOAD))
    highest, speed = machine.spindle.max_speed_rpm, table.get("spindle.speed")
    if highest is not None and speed is not None:
        share = _median(speed) / highest
        found.append(Relation("spindle.speed over its highest", "", share, 0.0, OVERSPEED))
    return found


def _standards(table: CutTable, protocol: CutProtocol | None) -> list[Relation]:
    """Return the share of cuts that are a protocol's, and measured over reference forces."""
    if protocol is None or not _states_conditions(table):
        return []
    matched = [(cut, rows_of_cut(table, cut)) for cut in protocol.cut]
    share = float(np.mean(np.any([rows for _, rows in matched], axis=0)))
    name = f"share of cuts that are one of '{protocol.name}'"
    found = [Relation(name, "", share, 0.5 / len(table), 1.0, by_unit=True)]
    ratios: dict[str, list[Array]] = {}
    for cut, rows in matched:
        for component, reference in cut.reference.items():
            measured = table.get(f"force.{component}")
            if measured is not None:
                ratios.setdefault(component, []).append(measured[rows] / reference.value)
    for component, parts in ratios.items():
        ratio = _median(np.concatenate(parts))
        found.append(Relation(f"force.{component} over its reference", "", ratio, *REFERENCE_RATIO))
    return found
