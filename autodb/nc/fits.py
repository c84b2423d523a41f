"""Does a program fit a machine? Refused in one line: the cut, the axis, the limit.

Every position of every cut, in the material and lifted into the air, is held against the travel of
its axis, the jaws, the tailstock and the retract position, every speed against the spindle.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from autodb.errors import UnusableInput
from autodb.files.machine import AxisFile, Clamping, MachineFile
from autodb.nc.steps import CutPath, StraightMove


@dataclass(frozen=True)
class Mounted:
    """A machine as a program sees it: its file, axes, clamping, and where its file says so.

    ``zero_mm`` is the position of each axis at the program's zero, ``retract_mm`` the program's
    coordinates of the retract position, by axis.
    """

    source: str
    machine: MachineFile
    setup: Clamping
    limit_rpm: float
    zero_mm: dict[str, float]
    retract_mm: dict[str, float]

    def refusal(self, path: CutPath, what: str) -> UnusableInput:
        """Return the error that names the cut."""
        return UnusableInput(f"{self.source}: cut '{path.cut.name}': {what}")


def mounted(
    machine: MachineFile, *, axes: Sequence[str], retracted: Sequence[str], source: str
) -> Mounted:
    """Return a machine that states all that a program needs.

    ``axes`` move in it, ``retracted`` do so first. Raises UnusableInput naming the key that is
    missing.
    """
    setup = machine.setup
    if setup is None:
        raise UnusableInput(f"{source}: no [setup]; add [setup], which says what is clamped")
    for axis in axes:
        _refuse_unknown_travel(machine.axes.get(axis), axis, source)
    zero = {axis: _at(setup.zero.model_dump(), axis, "zero", source) for axis in axes}
    retract = {axis: _at(setup.retract.model_dump(), axis, "retract", source) for axis in retracted}
    return Mounted(
        source=source,
        machine=machine,
        setup=setup,
        limit_rpm=_limit_rpm(machine, setup, source),
        zero_mm=zero,
        retract_mm={axis: round(retract[axis] - zero[axis], 3) for axis in retracted},
    )


def _refuse_unknown_travel(axis: AxisFile | None, name: str, source: str) -> None:
    if axis is None:
        raise UnusableInput(f"{source}: no [axes.{name}]; the program moves it")
    for key in ("travel_low_mm", "travel_high_mm"):
        if getattr(axis.limits, key) is None:
            raise UnusableInput(f"{source}: axes.{name}.limits.{key} is missing; state it")


def _at(places: dict[str, float | None], axis: str, key: str, source: str) -> float:
    found = places[f"{axis}_mm"]
    if found is None:
        raise UnusableInput(f"{source}: setup.{key}.{axis}_mm is missing; state it")
    return found


def _limit_rpm(machine: MachineFile, setup: Clamping, source: str) -> float:
    spindle = machine.axes.get("spindle")
    stated = (
        machine.spindle.max_speed_rpm,
        setup.max_speed_rpm,
        None if spindle is None else spindle.limits.speed_rpm,
    )
    known = [limit for limit in stated if limit is not None]
    if not known:
        raise UnusableInput(f"{source}: spindle.max_speed_rpm is missing; state it")
    return float(int(min(known)))


def refuse_what_does_not_fit(paths: Sequence[CutPath], on: Mounted) -> None:
    """Raise UnusableInput naming the first cut that a machine cannot make, axis and limit."""
    for axis, mm in on.retract_mm.items():
        _refuse_beyond_travel(axis, mm, on, "retract position")
    for path in paths:
        if path.cut.speed_rpm > on.limit_rpm:
            raise on.refusal(
                path, f"{path.cut.speed_rpm:g} rpm is above the spindle's limit {on.limit_rpm:g}"
            )
        for axis, mm in _reached(path):
            _refuse_beyond_travel(axis, mm, on, f"cut '{path.cut.name}'")
            _refuse_behind_retract(path, axis, mm, on)
        _refuse_near_jaws(path, on)


def _reached(path: CutPath) -> Iterator[tuple[str, float]]:
    for move in (*path.moves, *path.lifted()):
        yield from move.to.items()


def _refuse_beyond_travel(axis: str, mm: float, on: Mounted, what: str) -> None:
    limits = on.machine.axes[axis].limits
    at_mm = mm + on.zero_mm[axis]
    for key, limit_mm, side in (
        ("travel_low_mm", limits.travel_low_mm, -1.0),
        ("travel_high_mm", limits.travel_high_mm, 1.0),
    ):
        assert limit_mm is not None  # mounted() refused
        if side * (at_mm - limit_mm) > 0:
            raise UnusableInput(
                f"{on.source}: {what}: axis {axis} would go to {at_mm:.3f} mm of its travel, "
                f"beyond {key} = {limit_mm:g}"
            )


def _refuse_behind_retract(path: CutPath, axis: str, mm: float, on: Mounted) -> None:
    if axis in on.retract_mm and mm > on.retract_mm[axis]:
        raise on.refusal(
            path,
            f"axis {axis} would go to {mm + on.zero_mm[axis]:.3f} mm of its travel, beyond "
            f"setup.retract.{axis}_mm = {on.retract_mm[axis] + on.zero_mm[axis]:g}",
        )


def _refuse_near_jaws(path: CutPath, on: Mounted) -> None:
    lowest_mm = min(move.to["z"] for move in path.moves if "z" in move.to)
    jaws_mm = on.setup.jaws.z_mm - on.zero_mm["z"]
    if lowest_mm < jaws_mm + on.setup.clearance_mm:
        raise on.refusal(
            path,
            f"axis z would go to {lowest_mm + on.zero_mm['z']:.3f} mm of its travel, nearer than "
            f"setup.clearance_mm = {on.setup.clearance_mm:g} to setup.jaws.z_mm = "
            f"{on.setup.jaws.z_mm:g}",
        )


def refuse_what_a_lathe_would_hit(
    paths: Sequence[CutPath], on: Mounted, *, bar_diameter_mm: float
) -> None:
    """Raise UnusableInput where the retract position or a cut is in the way of a turning body.

    The tool leaves first along x: its retract must lie outside the bar, the jaws and the tailstock.
    """
    bodies = {"bar.diameter_mm": bar_diameter_mm, "setup.jaws.diameter_mm": _wide(on, "jaws")}
    if on.setup.tailstock is not None:
        bodies["setup.tailstock.diameter_mm"] = _wide(on, "tailstock")
        _refuse_near_tailstock(paths, on, bodies["setup.tailstock.diameter_mm"])
    for key, diameter_mm in bodies.items():
        if on.retract_mm["x"] < diameter_mm / 2 + on.setup.clearance_mm:
            raise UnusableInput(
                f"{on.source}: retract position: axis x at {on.retract_mm['x']:g} mm from the "
                f"spindle's axis is nearer than setup.clearance_mm to {key} = {diameter_mm:g}"
            )


def _wide(on: Mounted, key: str) -> float:
    diameter_mm: float | None = getattr(on.setup, key).diameter_mm
    if diameter_mm is None:
        raise UnusableInput(f"{on.source}: setup.{key}.diameter_mm is missing; state it")
    return diameter_mm


def _refuse_near_tailstock(paths: Sequence[CutPath], on: Mounted, diameter_mm: float) -> None:
    assert on.setup.tailstock is not None
    z_mm = on.setup.tailstock.z_mm - on.zero_mm["z"] - on.setup.clearance_mm
    radius_mm = diameter_mm / 2 + on.setup.clearance_mm
    for path in paths:
        for moves in (path.moves, path.lifted()):
            if any(x < radius_mm and z > z_mm for x, z in _corners(moves, on)):
                raise on.refusal(
                    path,
                    "axis x would go nearer than setup.clearance_mm to setup.tailstock.diameter_mm "
                    f"= {diameter_mm:g} where z is beyond its face",
                )


def _corners(moves: Sequence[StraightMove], on: Mounted) -> Iterator[tuple[float, float]]:
    """Yield the inmost x and outmost z of every move, from the retract position on."""
    x, z = on.retract_mm["x"], on.retract_mm["z"]
    for move in moves:
        to_x, to_z = move.to.get("x", x), move.to.get("z", z)
        yield min(x, to_x), max(z, to_z)
        x, z = to_x, to_z
