"""Rows written on change: what of an axis' motion and effort they still show."""

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.files.channels import axis_of, effort_channels, place_channel
from autodb.records.tables import Recording
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

DEAD_BAND, USUAL = 0.12, 0.9
"""Share of its way in a row at top speed by which a place may change over rows not written, nine
times in ten: a dead band, or twice that. With bands of 0.1 a known axis' coefficients were within
0.6 %, with 0.14 friction was up to 3.3 % off."""
SEEN, REACH_S, MOVES = 0.5, 0.01, 0.01
"""Share of the rows in motion, beyond MOVES of the top speed, that must lie REACH_S, a period of
the default cutoff, from rows that were not written. Chosen: with 0.6 and more a known axis'
coefficients were within 0.6 %, with 0.4 it was no longer seen to creep."""
HELD_BAND = 0.01
"""Share of its way in a row at top speed by which a place may have to change until it is written,
where an effort is written so too: up to here a known axis' coefficients were within 2 %, at 0.015
up to 4.6 % off."""
EFFORT_BAND = 0.06
"""Share of its standard deviation by which an effort may have to change until it is written: of a
known axis inertia was within 2 %, at 0.07 within 3, at 0.11 up to 6 % off: it lags behind."""
REPEATED = 0.4
"""Share of the rows written on change that repeat an effort, from which on it is held. Chosen: 0.7
or more do of one that is held, 0.01 of one that is not."""
SMALLER = 0.5
"""Share of a dead band that no change is smaller than, where rows are written for it alone."""


def is_on_change(recording: Recording) -> bool:
    """Say whether rows were written when something had changed."""
    return "on change" in recording.timing.kinds


def refuse_dead_bands(recording: Recording, axis: str, *, derived: bool) -> None:
    """Refuse what is written on change by too much: an effort, and a place, where speeds are
    ``derived`` from it: slower than a dead band a step nobody knows when it moved.
    """
    if not is_on_change(recording):
        return
    efforts = [n for n in effort_channels([*recording.channels]) if axis_of(n) == axis]
    held = [name for name in efforts if _repeats(recording.written[name])]
    for name in held:
        band, sd = _least_change(recording.written[name]), float(np.std(recording[name]))
        if band > EFFORT_BAND * sd:
            raise UnusableInput(
                phrase(
                    "{file}: {name} is written when it has changed by {band}, {sd} % of its "
                    "standard deviation: too coarse to tell inertia from friction; record it on "
                    "every row",
                    file=recording.path,
                    name=name,
                    band=localized(f"{band:.2g}"),
                    sd=localized(f"{100.0 * band / sd:.2g}"),
                )
            )
    if derived:
        _refuse_dead_band(recording, axis, held=bool(held))


def _refuse_dead_band(recording: Recording, axis: str, *, held: bool) -> None:
    """Refuse a place of whose motion too little is seen; ``held``: an effort is written on change
    too, so that the place of a row may be that of an earlier one.
    """
    name = place_channel(axis)
    ways = np.abs(np.diff(recording[name]))
    band = _least_change(recording.written[name]) if held else _change_over_spans(recording, name)
    top = float(np.quantile(ways, 0.99))
    known = recording.timing.known_within(REACH_S)
    moving = ways > MOVES * top
    if known is None or not moving.any():
        return
    seen, coarse = float(np.mean(known[1:][moving])), ""
    if band > (HELD_BAND if held else DEAD_BAND) * top:
        coarse = phrase(
            "when it has changed by {band}, {top} % of its way in a row at top speed",
            band=localized(f"{band:.2g}"),
            top=localized(f"{100.0 * band / top:.2g}"),
        )
    elif seen < SEEN:
        coarse = f"on change, and {100.0 * (1.0 - seen):.0f} % of its motion is next to rows that "
        coarse += phrase("were not written")
    if coarse:
        raise UnusableInput(
            phrase(
                "{file}: {name} is written {coarse}: too coarse to derive velocity and "
                "acceleration; record it on every row, or {axis}.velocity besides",
                file=recording.path,
                name=name,
                coarse=coarse,
                axis=axis,
            )
        )


def refuse_unknown_rests(recording: Recording, axis: str) -> None:
    """Refuse rows that are written as a place changes, and for nothing else: what the effort was
    while the axis rested nobody knows.
    """
    name = place_channel(axis)
    if not is_on_change(recording) or name not in recording:
        return
    steps = np.abs(np.diff(recording.written[name]))
    if steps.min() > SMALLER * _least_change(recording.written[name]):
        raise UnusableInput(
            phrase(
                "{file}: rows are written as {name} changes only: its effort at rest is not "
                "known, and causes cannot be told; record every row, or as the effort changes "
                "too",
                file=recording.path,
                name=name,
            )
        )


def _repeats(written: Array) -> bool:
    """Say whether a channel (n,) repeats its last value on most of the rows that are written."""
    return bool(np.mean(np.diff(written) == 0) > REPEATED)


def _change_over_spans(recording: Recording, name: str) -> float:
    """Return by how much a place changes over rows that were not written: its dead band, where it
    is what they waited for.
    """
    measured = recording.timing.measured
    if measured is None:
        return 0.0
    rows = np.flatnonzero(measured)
    changes = np.abs(np.diff(recording[name][rows]))[np.diff(rows) > 1]
    return float(np.quantile(changes[changes > 0], USUAL)) if np.any(changes > 0) else 0.0


def _least_change(written: Array) -> float:
    """Return the dead band of a channel (n,): the least that it changes by, glitches aside."""
    steps = np.abs(np.diff(written))
    return float(np.quantile(steps[steps > 0], 0.01)) if np.any(steps > 0) else 0.0
