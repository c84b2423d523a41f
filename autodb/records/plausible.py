"""Is it what it says it is? Wrong units and clipped sensors, seen from a file's summary.

A unit that the side file states is believed, within what a machine can do; a unit that is only
assumed from the channel's name is doubted sooner.
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from autodb.channels import LINEAR_AXES
from autodb.errors import UnusableInput
from autodb.records.source import Source
from autodb.records.summary import BaseSummary, ChannelSummary
from autodb.sidefile import SideFile
from autodb.units import RAW

LARGEST: tuple[tuple[str, float, str], ...] = (
    (r"spindle\.speed", 5e5, "rpm"),
    (r".\.position", 2e5, "mm"),
    (r".\.velocity", 1e5, "mm/s"),
    (r".*\.current(\..+)?", 1e5, "A"),
    (r"(force\..|.\.drive_force)", 1e7, "N"),
    (r"(torque\.spindle|.\.drive_torque)", 1e6, "N·m"),
    (r"spindle\.power", 1e8, "W"),
    (r".*\.temperature", 3e3, "°C"),
    (r"cutting\.speed", 1e5, "m/min"),
    (r"cutting\.(feed|depth|width)|tool\.flank_wear|chip\.thickness", 1e3, "mm"),
    (r"work\.diameter", 1e5, "mm"),
)
"""Beyond what machine tools do by a factor: the fastest air-bearing spindles reach some 350 000 rpm
and the longest portal mills some 100 m; the others are ten times and more over what is built."""
LEAST_TRAVEL_MM = 1.0
"""A recording in which axes move, but none by this much, is taken for one in metres."""
LEAST_MOTION_MM = 0.02
"""Less is no motion: an axis that is held yields by some micrometres."""
WIDEST_FACTOR = 3.0
"""Quantities that state the same thing may differ by this: a diameter is a factor of 2, the units
that are mixed up (mm/min, m, rev/s) are factors of 60 and 1000."""
CLIPPED_SAMPLES = 20
CLIPPED_SHARE = 0.5
ROUGH = 1e-4
"""A channel is clipped where at least 20 samples lie in plateaus at its limit, they are at least
half of all plateaus, and elsewhere it is rough as a measurement is, not smooth as a calculation."""
_MAY_CLIP = re.compile(r".*\.current(\.[uvw])?|force\..|torque\.spindle|.\.drive_(force|torque)")


def refuse_implausible(source: Source, bases: Iterable[BaseSummary]) -> None:
    """Raise UnusableInput for the first thing in a file that cannot be what it says it is."""
    for base in bases:
        refuse_doubtful(source.path, base, source.side)


def refuse_doubtful(path: Path, base: BaseSummary, side: SideFile) -> None:
    """Raise UnusableInput for the first thing in a table that cannot be what it says it is."""
    for doubt in doubts(base, side):
        raise UnusableInput(f"{path}: {doubt}")


def doubts(base: BaseSummary, side: SideFile) -> Iterator[str]:
    """Yield what is implausible in a time base, each with what would work."""
    for channel in base.channels.values():
        yield from _too_large(channel, side)
    yield from _speeds_apart(base)
    if base.holds_cuts:
        yield from _cuts_apart(base)
    else:
        yield from _in_metres(base, side)
        for channel in base.channels.values():
            yield from _clipped(channel, side)


def _too_large(channel: ChannelSummary, side: SideFile) -> Iterator[str]:
    largest = max(abs(channel.minimum), abs(channel.maximum)) if channel.finite else 0.0
    for pattern, limit, unit in LARGEST:
        if channel.unit != RAW and re.fullmatch(pattern, channel.name) and largest > limit:
            yield (
                f"column '{_column(channel.name, side)}': {largest:g} {unit} as {channel.name} is "
                "beyond any machine; its own unit in the side file would work "
                f'("{channel.name}" = {{column = …, unit = …}})'
            )


def _speeds_apart(base: BaseSummary) -> Iterator[str]:
    for axis, rates in base.rates.items():
        factor = rates.factor
        if factor is not None and not 1 / WIDEST_FACTOR < abs(factor) < WIDEST_FACTOR:
            yield (
                f"{axis}.velocity is {factor:.3g} times the slope of {axis}.position over t: "
                "one of the three is in another unit (mm/min is 60, m is 1000); its unit in the "
                "side file would work"
            )


def _in_metres(base: BaseSummary, side: SideFile) -> Iterator[str]:
    travels = {
        c.name: c.maximum - c.minimum
        for axis in LINEAR_AXES
        if (c := base.channels.get(f"{axis}.position")) and c.finite
    }
    moving = {name: travel for name, travel in travels.items() if travel > LEAST_MOTION_MM}
    if not moving or max(travels.values()) >= LEAST_TRAVEL_MM:
        return
    name = max(moving, key=lambda n: moving[n])
    if side.channels.get(name) is None or side.channels[name].unit is None:
        yield (
            f"column '{_column(name, side)}': {name} travels {moving[name]:.3g} mm in all, as if "
            f'logged in metres; "{name}" = {{column = "{_column(name, side)}", unit = "m"}} in the '
            'side file would work, or unit = "mm" where it is meant so'
        )


def _cuts_apart(base: BaseSummary) -> Iterator[str]:
    means = {name: channel.mean for name, channel in base.channels.items() if channel.finite}
    try:
        diameter, rpm = means["work.diameter"], means["spindle.speed"]
        speed = means["cutting.speed"]
    except KeyError:
        return
    expected = 3.14159265 * diameter * rpm / 1000.0
    if speed == 0 or not 1 / WIDEST_FACTOR < expected / speed < WIDEST_FACTOR:
        yield (
            f"work.diameter {diameter:.3g} mm at spindle.speed {rpm:.3g} rpm gives "
            f"{expected:.3g} m/min, cutting.speed says {speed:.3g}: one of them is in another "
            "unit; its unit in the side file would work"
        )


def _clipped(channel: ChannelSummary, side: SideFile) -> Iterator[str]:
    spec = side.channels.get(channel.name)
    if not _MAY_CLIP.fullmatch(channel.name) or (spec is not None and spec.clips):
        return
    for value, held in (
        (channel.minimum, channel.plateau_low),
        (channel.maximum, channel.plateau_high),
    ):
        at_limits = channel.plateau_low + channel.plateau_high
        if (
            value != 0
            and held >= CLIPPED_SAMPLES
            and at_limits > CLIPPED_SHARE * channel.plateau
            and channel.roughness > ROUGH
        ):
            yield (
                f"column '{_column(channel.name, side)}': {channel.name} is clipped at {value:.6g} "
                f"{channel.unit} ({held} samples); a wider sensor range would work, or "
                f"clips = true in the side file where the drive itself limits there"
            )
            return


def _column(name: str, side: SideFile) -> str:
    spec = side.channels.get(name)
    return (spec.column if spec else None) or name
