"""A recording as it was read becomes one of even rows: stamps examined, places counted on."""

from dataclasses import replace

import numpy as np

from autodb.errors import UnusableInput
from autodb.records.stamps import TURNS_ON, doubt_of_rate
from autodb.records.tables import Array, Recording
from autodb.timing import StampFinding, Timing, examined
from autodb.timing.places import EFFORTS, PLACES, drawn_between, filled_between, unwrapped
from autodb.timing.units import highest_acceleration
from autodb.wording import phrase

SMOOTH = (*PLACES, ".velocity")
"""Ends of the names of channels that are smooth over time: resampled by splines."""


def on_even_rows(raw: Recording, *, like: Recording | None = None) -> Recording:
    """Return a recording as read, with stamps as written, as one of even rows.

    ``like``: one whose time was examined already, and counts for stamps that are the same (a
    simulation of it).

    Raises UnusableInput where its stamps cannot be used, or are in another unit than stated.
    """
    if like is not None and _same(raw.channels["t"], like.written["t"]):
        return _laid_out(raw, like.timing)
    raw, wraps = _counted_on(raw)
    others = {name: values for name, values in raw.channels.items() if name != "t"}
    timing = examined(raw.channels["t"], others, where=str(raw.path))
    if wraps:
        timing = replace(timing, findings=(*timing.findings, *wraps))
    made = _laid_out(raw, timing)
    _refuse_doubtful_unit(made)
    return made


def _same(one: Array, other: Array) -> bool:
    return len(one) == len(other) and np.array_equal(one, other, equal_nan=True)


def _counted_on(raw: Recording) -> tuple[Recording, list[StampFinding]]:
    """Return a recording with its angles and positions counted on over their wraps, and filled
    where they, or efforts, are refreshed on some rows only.
    """
    channels, unusable, wraps = dict(raw.channels), dict(raw.unusable), []
    for name in raw.channels:
        if name.endswith(PLACES):
            channels[name], wrap, why = unwrapped(name, raw.channels[name])
            channels[name], polled = filled_between(name, channels[name])
            wraps += [found for found in (wrap, polled) if found is not None]
            if why:
                unusable[name] = f"{raw.path}: {why}"
                del channels[name]
        elif name.endswith(EFFORTS):
            channels[name], polled = drawn_between(name, raw.channels[name])
            wraps += [] if polled is None else [polled]
    return replace(raw, channels=channels, unusable=unusable), wraps


def _laid_out(raw: Recording, timing: Timing) -> Recording:
    layout = timing.layout
    if layout is None:
        return replace(raw, examined_as=timing)
    channels = {
        name: layout.laid_out(values, smooth=name.endswith(SMOOTH))
        for name, values in raw.channels.items()
    }
    nearest = np.round(layout.laid_out(np.arange(layout.rows, dtype=np.float64))).astype(np.intp)
    texts = {name: [lines[row] for row in nearest] for name, lines in raw.texts.items()}
    return replace(
        raw,
        channels=channels | {"t": layout.t_s},
        texts=texts,
        examined_as=timing,
        as_written=raw.channels,
    )


def _refuse_doubtful_unit(made: Recording) -> None:
    longest = max(made.pieces, key=lambda piece: piece.stop - piece.start)
    places = [n for n in made.channels if n.endswith(PLACES) and n != TURNS_ON]
    found = [highest_acceleration(made.t_s[longest], made.channels[n][longest]) for n in places]
    sharpest = max((one for one in found if one is not None), default=None)
    doubt = doubt_of_rate(made.timing, sharpest, made.side)
    if doubt:
        raise UnusableInput(phrase("{file}: column 't': {doubt}", file=made.path, doubt=doubt))


def rows_of_file(recording: Recording, values: Array, otherwise: Array | None = None) -> Array:
    """Return values at the even rows (m,) at the rows of the file (N,).

    ``otherwise`` (N,): what stands at rows that are in no piece; None: what the nearest row has.
    """
    layout = recording.timing.layout
    if layout is None:
        return values
    found = layout.of_file(values)
    nowhere = np.flatnonzero(np.isnan(found))
    if not nowhere.size:
        return found
    if otherwise is not None:
        found[nowhere] = otherwise[nowhere]
    else:
        known = np.flatnonzero(~np.isnan(found))
        found[nowhere] = found[known[np.searchsorted(known, nowhere).clip(max=len(known) - 1)]]
    return found
