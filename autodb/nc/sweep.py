"""The NC program of an axis' moves in air: one axis moves, the others are parked, the spindle off.

After a rapid in machine coordinates every move is an increment, so that no work offset and no tool
offset counts. X counts in diameters where the control takes it so.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, floor

from autodb.errors import UnusableInput, near_words
from autodb.files.machine import AxisFile, Body, Clamping, MachineFile
from autodb.nc.dialects import DIALECTS
from autodb.nc.steps import DECIMALS
from autodb.nc.words import Words
from autodb.wording import localized, phrase

MARGIN_MM = 1.0
"""How far a sweep stays from the ends of a travel. Chosen: soft limits trip at the last micron."""
ROUNDING = 1e-6
"""Thousandths of a millimetre that binary fractions are off."""


@dataclass(frozen=True)
class SweepWay:
    """There and back between two places, mm of the axis' travel, with a rest at each."""

    start_mm: float
    end_mm: float
    feed_mm_min: float
    rest_s: float


@dataclass(frozen=True)
class SweepStretch:
    """Where an axis may sweep, mm of its travel, and its highest feed."""

    axis: str
    low_mm: float
    high_mm: float
    fastest_mm_min: float


def sweep_stretch(
    machine: MachineFile,
    axis: str,
    *,
    source: str,
    safe_mm: float | None = None,
    between_mm: tuple[float, float] | None = None,
) -> SweepStretch:
    """Return where an axis may sweep: its travel, or a part of it; never below its safe height.

    ``safe_mm`` is the lowest height of an axis that bears weight, as a place of its travel. Raises
    UnusableInput naming the key that is missing, or the limit that is not kept.
    """
    own = machine.axes.get(axis)
    if own is None:
        raise UnusableInput(
            phrase(
                "{source}: no axis '{axis}'{hint}",
                source=source,
                axis=axis,
                hint=near_words(axis, list(machine.axes)),
            )
        )
    limits = own.limits
    low, high = limits.travel_low_mm, limits.travel_high_mm
    if low is None or high is None:
        raise UnusableInput(
            phrase(
                "{source}: axes.{axis}.limits: travel_low_mm or travel_high_mm is missing; state "
                "both",
                source=source,
                axis=axis,
            )
        )
    if limits.speed_mm_min is None:
        raise UnusableInput(
            phrase(
                "{source}: axes.{axis}.limits.speed_mm_min is missing; state it",
                source=source,
                axis=axis,
            )
        )
    low, high = low + MARGIN_MM, high - MARGIN_MM
    if own.vertical is not None:
        if safe_mm is None:
            raise UnusableInput(
                phrase(
                    "{source}: axis {axis} bears weight; state its lowest safe place with --safe "
                    "MM",
                    source=source,
                    axis=axis,
                )
            )
        low, high = _above(own, axis, (low, high), safe_mm)
    if between_mm is not None:
        _refuse_beyond(axis, between_mm, low, high, source)
        low, high = between_mm
    return SweepStretch(axis, _inward(low, 1), _inward(high, -1), limits.speed_mm_min)


def _inward(mm: float, side: int) -> float:
    """Return a place with the digits of a program, rounded up (1) or down (−1)."""
    units = mm * 10**DECIMALS
    whole: int = ceil(units - ROUNDING) if side > 0 else floor(units + ROUNDING)
    return float(whole / 10**DECIMALS)


def _above(
    own: AxisFile, axis: str, travel_mm: tuple[float, float], safe_mm: float
) -> tuple[float, float]:
    """Return the part of the travel at a safe height."""
    low, high = travel_mm
    if not low <= safe_mm <= high:
        raise UnusableInput(
            phrase(
                "--safe: {safe_mm} mm is not between {low} and {high} mm, the travel of {axis}",
                safe_mm=localized(f"{safe_mm:g}"),
                low=localized(f"{low:g}"),
                high=localized(f"{high:g}"),
                axis=axis,
            )
        )
    return (safe_mm, high) if own.vertical == "up" else (low, safe_mm)


def _refuse_beyond(
    axis: str, between_mm: tuple[float, float], low: float, high: float, source: str
) -> None:
    if not low <= between_mm[0] < between_mm[1] <= high:
        raise UnusableInput(
            phrase(
                "--between: {start} to {end} mm is no stretch of axis {axis} between {low} and "
                "{high} mm ({source})",
                start=localized(f"{between_mm[0]:g}"),
                end=localized(f"{between_mm[1]:g}"),
                axis=axis,
                low=localized(f"{low:g}"),
                high=localized(f"{high:g}"),
                source=source,
            )
        )


def sweep_program(
    ways: Sequence[SweepWay],
    on: SweepStretch,
    machine: MachineFile,
    *,
    dialect: str,
    parked_mm: Mapping[str, float],
    source: str,
    name: str,
) -> str:
    """Return the program; ``parked_mm``: where each other linear axis is brought first.

    Raises UnusableInput naming the dialects there are, the axis without a place to park, the place
    outside its travel, or the jaws or the tailstock that a lathe's tool would come to.
    """
    if dialect not in DIALECTS:
        raise UnusableInput(
            phrase(
                "no NC program for dialect '{dialect}'{hint}",
                dialect=dialect,
                hint=near_words(dialect, DIALECTS),
            )
        )
    lathe, mill = DIALECTS[dialect]
    turns = machine.axes.get("spindle")
    is_lathe = turns is not None and turns.carries == "work"
    if is_lathe and machine.diameter is None:
        raise UnusableInput(
            phrase("{source}: diameter is missing; state whether X is one", source=source)
        )
    words = lathe if is_lathe else mill
    _refuse_unparked(machine, on.axis, parked_mm, source)
    for way in ways:
        _refuse_outside(way, on)
    if is_lathe and machine.setup is not None:
        _refuse_what_it_would_hit(on, machine.setup, parked_mm, source)
    factor = 2.0 if is_lathe and machine.diameter else 1.0
    clear = _clear_words(machine.setup, is_lathe=is_lathe)
    text = _text(ways, on, words, parked_mm, name=name, factor=factor, clear=clear)
    return "".join(f"{line}\n" for line in text)


def _refuse_unparked(
    machine: MachineFile, axis: str, parked_mm: Mapping[str, float], source: str
) -> None:
    for other in (name for name in "xyz" if name in machine.axes and name != axis):
        if other not in parked_mm:
            raise UnusableInput(
                phrase(
                    "{source}: axis {other} is not parked; use --park {other}=MM, clear of all",
                    source=source,
                    other=other,
                )
            )
        limits = machine.axes[other].limits
        low, high = limits.travel_low_mm, limits.travel_high_mm
        if low is None or high is None or not low <= parked_mm[other] <= high:
            raise UnusableInput(
                phrase(
                    "--park: {other} = {place} mm is not known to lie in its travel ({source}: "
                    "axes.{other}.limits)",
                    other=other,
                    place=localized(f"{parked_mm[other]:g}"),
                    source=source,
                )
            )
    for other in parked_mm:
        if other not in machine.axes or other == axis:
            raise UnusableInput(
                phrase("--park: {other} is no other axis of {source}", other=other, source=source)
            )


def _refuse_outside(way: SweepWay, on: SweepStretch) -> None:
    for place in (way.start_mm, way.end_mm):
        if not on.low_mm - 1e-9 <= place <= on.high_mm + 1e-9:
            raise UnusableInput(
                phrase(
                    "a pass to {place} mm is outside {low_mm} to {high_mm} mm",
                    place=localized(f"{place:g}"),
                    low_mm=localized(f"{on.low_mm:g}"),
                    high_mm=localized(f"{on.high_mm:g}"),
                )
            )
    if way.feed_mm_min > on.fastest_mm_min:
        raise UnusableInput(
            phrase(
                "a pass at {feed_mm_min} mm/min is above axis {axis}'s {fastest_mm_min} mm/min",
                feed_mm_min=localized(f"{way.feed_mm_min:g}"),
                axis=on.axis,
                fastest_mm_min=localized(f"{on.fastest_mm_min:g}"),
            )
        )


def _refuse_what_it_would_hit(
    on: SweepStretch, setup: Clamping, parked_mm: Mapping[str, float], source: str
) -> None:
    """Raise UnusableInput where the tip of the tool comes near what turns on a lathe."""
    spans = {axis: (mm, mm) for axis, mm in parked_mm.items()} | {on.axis: (on.low_mm, on.high_mm)}
    if not {"x", "z"} <= spans.keys():
        return
    (near_z, far_z), across = spans["z"], spans["x"]
    reaches = {"jaws": near_z < setup.jaws.z_mm + setup.clearance_mm}
    if setup.tailstock is not None:
        reaches["tailstock"] = far_z > setup.tailstock.z_mm - setup.clearance_mm
    for name in (one for one, reached in reaches.items() if reached):
        body: Body = getattr(setup, name)
        for key, stated in (
            (f"{name}.diameter_mm", body.diameter_mm), ("zero.x_mm", setup.zero.x_mm),
        ):  # fmt: skip
            if stated is None:
                raise UnusableInput(
                    phrase("{source}: setup.{key} is missing; state it", source=source, key=key)
                )
        inside = (across[0] - (setup.zero.x_mm or 0.0), across[1] - (setup.zero.x_mm or 0.0))
        least_mm = 0.0 if inside[0] <= 0.0 <= inside[1] else min(map(abs, inside))
        if least_mm < 0.5 * (body.diameter_mm or 0.0) + setup.clearance_mm:
            raise UnusableInput(
                phrase(
                    "{source}: the tool would come nearer than setup.clearance_mm = "
                    "{clearance_mm} to the {name} (setup.{name}), {least_mm} mm from the "
                    "spindle's axis; use --between, or --park farther away",
                    source=source,
                    clearance_mm=localized(f"{setup.clearance_mm:g}"),
                    name=name,
                    least_mm=localized(f"{least_mm:.3f}"),
                )
            )


def _clear_words(setup: Clamping | None, *, is_lathe: bool) -> str:
    """Return what was held against what is in the way, for the program's head."""
    if not is_lathe:
        return "travel alone was checked: take the work off the table"
    if setup is None:
        return "no setup is stated: jaws and tailstock were not checked"
    return "the tool of the setup was checked against jaws and tailstock: take longer ones out"


def _text(
    ways: Sequence[SweepWay],
    on: SweepStretch,
    words: Words,
    parked_mm: Mapping[str, float],
    *,
    name: str,
    factor: float,
    clear: str,
) -> Iterator[str]:
    """Yield the lines: header, modes, the others parked, the axis at its start, the passes."""
    plain = "".join(c if c.isascii() and c.isalnum() else "_" for c in name.upper())[:24]
    yield from (line.format(name=plain) for line in words.opening)
    yield words.said("not proven on your machine: check it, dry run it, keep a hand on feed hold")
    yield words.said(f"moves in air of axis {on.axis}: {len(ways)} passes there and back")
    yield words.said(f"travel {on.low_mm:.3f} to {on.high_mm:.3f}, spindle off, no tool needed")
    yield words.said(clear)
    yield words.said("record position and current of the axis from the first pass to the last")
    yield from words.sweep_modes
    for axis, mm in parked_mm.items():
        yield _home(words, axis, mm, factor)
    at = round(ways[0].start_mm, DECIMALS)
    yield _home(words, on.axis, at, factor)
    yield words.said("stop: are the others where nothing is in the way?")
    yield "M0"
    yield from words.increments
    scale = _x_factor(words, on.axis, factor)
    for way in ways:
        feed = f"F{way.feed_mm_min:.3f}"
        rest = words.dwell.format(seconds=f"{way.rest_s:.1f}", milliseconds=int(1e3 * way.rest_s))
        yield words.said(f"{way.feed_mm_min:g} mm/min")
        for to in (way.start_mm, way.end_mm, way.start_mm):
            step = round(round(to, DECIMALS) - at, DECIMALS)
            if step:
                at = round(to, DECIMALS)
                yield f"G1 {words.step[on.axis]}{scale * step:.3f} {feed}"
                yield rest
    yield from words.closing


def _home(words: Words, axis: str, mm: float, factor: float) -> str:
    value = f"{_x_factor(words, axis, factor) * mm:.3f}"
    return words.home.format(axis=axis.upper(), value=value)


def _x_factor(words: Words, axis: str, factor: float) -> float:
    """Return what a millimetre of an axis counts; DIAMOF makes X a radius where it is said."""
    return factor if axis == "x" and not words.home_in_radii else 1.0
