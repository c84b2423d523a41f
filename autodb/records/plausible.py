"""Is it what it says it is? Wrong units and clipped sensors, seen from a file's summary.

A unit that the side file states is believed, within what a machine can do; a unit that is only
assumed from the channel's name is doubted sooner.
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import get_args

import numpy as np

from autodb.errors import together
from autodb.files.channels import DURATION, LINEAR_AXES, largest_of, unit_of
from autodb.files.operation_words import suggested_operation
from autodb.files.side import Operation, SideFile
from autodb.files.units import RAW
from autodb.records.channel_summary import LEVELS, ChannelSummary
from autodb.records.mistaken import SPEEDS, Mistake
from autodb.records.source import RecordingSource
from autodb.records.stamps import doubt_of_rate
from autodb.records.summary import BaseSummary
from autodb.wording import listed, localized, phrase, significant

LEAST_TRAVEL_MM = 1.0
"""A recording in which axes move, but none by this much, is taken for one in metres,"""
LONGEST_MACHINE_M = 10.0
"""unless a coordinate is beyond this: no slide stands 10 m and more from its zero."""
LEAST_MOTION_MM = 0.05
"""Less is no motion: an axis that is held yields and trembles by some hundredths."""
WIDEST_FACTOR = 3.0
"""Quantities that state the same thing may differ by this: a diameter is a factor of 2, the units
that are mixed up (mm/min, m, rev/s) are factors of 60 and 1000."""
OUTLYING_SHARE = 0.1
"""Share of cuts whose speeds may be odd, before the table is."""
SAME_SPEED = 0.2
"""Logarithm of a ratio of speeds that may be one: diameters differ by the depth of cut."""
CLIPPED_SAMPLES = 20
ROUGH = 1e-4
"""A channel is clipped where 20 samples lie in plateaus at its limit that it has run into, more
than in plateaus elsewhere, and where else it is rough as a measurement is, not smooth."""
FAR = 0.5
"""A limit lies far from zero: at this share of the largest number at least. A plateau nearer to it
is a floor, such as the current of an idle spindle. Chosen."""
_MAY_CLIP = re.compile(r".*\.current(\.[uvw])?|force\..|torque\.spindle|.\.drive_(force|torque)")


def refuse_implausible(source: RecordingSource, bases: Iterable[BaseSummary]) -> None:
    """Raise UnusableInput for all things in a file that cannot be what they say they are."""
    found = [doubt for base in bases for doubt in doubts(base, source.side)]
    if found:
        raise together(source.path, found)


def refuse_doubtful(path: Path, base: BaseSummary, side: SideFile) -> None:
    """Raise UnusableInput for all things in a table that cannot be what they say they are."""
    found = list(doubts(base, side))
    if found:
        raise together(path, found)


def doubts(base: BaseSummary, side: SideFile) -> Iterator[str]:
    """Yield what is implausible in a time base, each with the remedy."""
    for channel in base.channels.values():
        yield from _too_large(channel, side)
        yield from _too_cold(channel, side)
        yield from _below_none(channel, side)
    yield from _speeds_apart(base)
    if base.holds_cuts:
        yield from _operations(base, side)
        yield from _cuts_apart(base)
    else:
        yield from _rate(base, side)
        yield from _in_metres(base, side)
        for channel in base.channels.values():
            yield from _clipped(channel, side)


def _rate(base: BaseSummary, side: SideFile) -> Iterator[str]:
    if base.timing is not None:
        doubt = doubt_of_rate(base.timing, base.stamps.sharpest, side)
        if doubt:
            yield f"column 't': {doubt}"


def _too_large(channel: ChannelSummary, side: SideFile) -> Iterator[str]:
    largest = max(abs(channel.minimum), abs(channel.maximum)) if channel.finite else 0.0
    if channel.unit != RAW and largest > largest_of(channel.name):
        yield (
            phrase(
                "column '{channel}': {largest} {channel_2} as {channel_3} is beyond any "
                'machine; state its unit in the side file: "{channel_3}" = {{column = …, unit '
                "= …}}",
                channel=_column(channel.name, side),
                largest=localized(f"{largest:g}"),
                channel_2=unit_of(channel.name),
                channel_3=channel.name,
            )
        )


def _too_cold(channel: ChannelSummary, side: SideFile) -> Iterator[str]:
    if channel.unit == "°C" and channel.finite and channel.minimum < -273.15:
        yield (
            phrase(
                "column '{channel}': {minimum} °C as {channel_2} is below absolute zero; state "
                "its unit in the side file",
                channel=_column(channel.name, side),
                minimum=localized(f"{channel.minimum:g}"),
                channel_2=channel.name,
            )
        )


def _below_none(channel: ChannelSummary, side: SideFile) -> Iterator[str]:
    if channel.name in ("tool.cutting_time", DURATION) and channel.finite and channel.minimum < 0.0:
        yield (
            phrase(
                "column '{channel}': {minimum} s as {channel_2} is less than none; correct it, "
                "or leave the cell empty",
                channel=_column(channel.name, side),
                minimum=localized(f"{channel.minimum:g}"),
                channel_2=channel.name,
            )
        )


def _speeds_apart(base: BaseSummary) -> Iterator[str]:
    for axis, rates in base.rates.items():
        factor = rates.factor
        if factor is not None and factor < 0:
            yield (
                phrase(
                    "{axis}.velocity runs against the slope of {axis}.position over t; set sign = "
                    "-1 for one of them in the side file",
                    axis=axis,
                )
            )
        elif factor is not None and not 1 / WIDEST_FACTOR < factor < WIDEST_FACTOR:
            yield (
                phrase(
                    "{axis}.velocity is {factor} times the slope of {axis}.position over t: one of "
                    "the three is in another unit (mm/min is 60, m is 1000); state its unit in the "
                    "side file",
                    axis=axis,
                    factor=localized(f"{factor:.3g}"),
                )
            )


def _in_metres(base: BaseSummary, side: SideFile) -> Iterator[str]:
    positions = [
        c for axis in LINEAR_AXES if (c := base.channels.get(f"{axis}.position")) and c.finite
    ]
    travels = {c.name: c.maximum - c.minimum for c in positions}
    moving = {name: travel for name, travel in travels.items() if travel > LEAST_MOTION_MM}
    far = max((max(abs(c.minimum), abs(c.maximum)) for c in positions), default=0.0)
    if not moving or max(travels.values()) >= LEAST_TRAVEL_MM or far > LONGEST_MACHINE_M:
        return
    name = max(moving, key=lambda n: moving[n])
    if not base.channels[name].stated:
        yield (
            phrase(
                "column '{name}': {name_2} travels {moving} mm in all, as if logged in metres; "
                'state "{name_2}" = {{column = "{name}", unit = "m"}} in the side file, or '
                'unit = "mm" if it is in mm',
                name=_column(name, side),
                name_2=name,
                moving=significant(moving[name]),
            )
        )


def _unknown(base: BaseSummary) -> list[str]:
    return [text for text in base.operations if text and text not in get_args(Operation)]


def left_out_operations(base: BaseSummary) -> tuple[str, ...]:
    """Return a sentence on operations that are none of ours and mean none; or nothing."""
    odd = _unknown(base)
    if not odd:
        return ()
    listed = ", ".join(f"'{text}'" for text in odd)
    return (
        phrase("no operation of ours: {listed}; nothing is learnt of these cuts", listed=listed),
    )


def _operations(base: BaseSummary, side: SideFile) -> Iterator[str]:
    """Yield one line for all texts that are no operation, where one of them may mean one."""
    known, odd = get_args(Operation), _unknown(base)
    if not any(map(suggested_operation, odd)):
        return
    row, column = base.operations[odd[0]], _column("operation", side)
    means = ", ".join(f'"{text}" = "{suggested_operation(text) or "…"}"' for text in odd)
    yield (
        phrase(
            "column '{column}', row {row}: '{odd}' is no operation; say what it means "
            "under [values] in the side file: operation = {{{means}}} (of {names})",
            column=column,
            row=row,
            odd=odd[0],
            means=means,
            names=", ".join(known),
        )
    )


def _cuts_apart(base: BaseSummary) -> Iterator[str]:
    ratios = np.concatenate([np.zeros(0), *base.speed_ratios])
    odd = (ratios > WIDEST_FACTOR) | (ratios < 1 / WIDEST_FACTOR)
    if odd.sum() > OUTLYING_SHARE * len(ratios):
        ratio = float(np.median(ratios[odd]))
        mends = [mistake for mistake in SPEEDS if _mends(mistake, ratio)]
        what = (
            phrase("as if {names}", names=listed(map(str, mends), phrase(" or ")))
            if mends
            else phrase("one of them in another unit")
        )
        remedy = mends[0].remedy if len(mends) == 1 else phrase("state its unit in the side file")
        yield (
            phrase(
                "π · work.diameter · spindle.speed is {ratio} times cutting.speed in {sum} of "
                "{n} cuts, {what}; {remedy}",
                ratio=localized(f"{ratio:.3g}"),
                sum=int(odd.sum()),
                n=len(ratios),
                what=what,
                remedy=remedy,
            )
        )


def _mends(mistake: Mistake, ratio: float) -> bool:
    """Say whether a mistake alone explains a ratio of π D n to the cutting speed."""
    power = -1.0 if mistake.channels == ("cutting.speed",) else 1.0
    return bool(abs(np.log(ratio * mistake.factor**power)) < SAME_SPEED)


def _clipped(channel: ChannelSummary, side: SideFile) -> Iterator[str]:
    spec = side.channels.get(channel.name)
    if not _MAY_CLIP.fullmatch(channel.name) or (spec is not None and spec.clips):
        return
    if channel.roughness <= ROUGH or channel.levels < LEVELS:
        return
    largest = max(abs(channel.minimum), abs(channel.maximum))
    for plateau in (channel.low, channel.high):
        far = abs(plateau.value) >= FAR * largest
        if far and plateau.value != 0 and plateau.held >= max(CLIPPED_SAMPLES, channel.elsewhere):
            yield (
                phrase(
                    "column '{channel}': {channel_2} is clipped at {value} {unit} ({held} "
                    "samples); use a wider sensor range, or set clips = true in the side file if "
                    "the drive itself limits the current",
                    channel=_column(channel.name, side),
                    channel_2=channel.name,
                    value=localized(f"{plateau.value:.6g}"),
                    unit=channel.unit,
                    held=plateau.held,
                )
            )
            return


def _column(name: str, side: SideFile) -> str:
    spec = side.channels.get(name)
    return (spec.column if spec else None) or name
