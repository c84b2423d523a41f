"""Channels of several rates brought onto one time base, where the user asks for it."""

import numpy as np

from autodb.errors import UnusableInput
from autodb.records.source import FEWEST_ROWS, RecordingSource
from autodb.records.tables import Array, CutTable, Recording
from autodb.wording import localized, phrase

PASS_BAND = 0.4
"""Low-pass corner as a share of the new rate: below its Nyquist frequency (0.5)."""


def common_times_s(source: RecordingSource, rate_hz: float) -> Array:
    """Return times at ``rate_hz`` over the span that all time bases of a file share, s.

    Raises UnusableInput where they share too little, or one is a table of cuts.
    """
    if not rate_hz > 0:
        raise UnusableInput(
            phrase("--resample {rate}: give a rate in Hz above 0", rate=localized(f"{rate_hz:g}"))
        )
    spans = [(r.t_s[0], r.t_s[-1]) for r in _recordings(source)]
    start_s, end_s = max(start for start, _ in spans), min(end for _, end in spans)
    t_s = start_s + np.arange(int(max(end_s - start_s, 0.0) * rate_hz) + 1) / rate_hz
    if len(t_s) < FEWEST_ROWS:
        raise UnusableInput(
            phrase(
                "{file}: its time bases share {start} s: too little for {rate} Hz; read one of "
                "them with --group NAME",
                file=source.path,
                start=localized(f"{max(end_s - start_s, 0.0):.3g}"),
                rate=localized(f"{rate_hz:g}"),
            )
        )
    return np.asarray(t_s, dtype=np.float64)


def read_at(source: RecordingSource, t_s: Array) -> Recording:
    """Read all time bases of a file at the times ``t_s`` (n,), evenly spaced.

    Channels that were faster pass a 4th-order Butterworth low-pass at 0.4 of the new rate, forwards
    and backwards; then all are interpolated linearly. Raises UnusableInput where a time base does
    not span ``t_s`` or a channel stands in two of them.
    """
    channels = {"t": t_s}
    recordings = _recordings(source)
    for recording in recordings:
        if recording.t_s[0] > t_s[0] or recording.t_s[-1] < t_s[-1]:
            raise UnusableInput(
                phrase(
                    "{file}: from {t} to {t_2} s only; {t_3} to {t_4} s are needed",
                    file=source.path,
                    t=localized(f"{recording.t_s[0]:g}"),
                    t_2=localized(f"{recording.t_s[-1]:g}"),
                    t_3=localized(f"{t_s[0]:g}"),
                    t_4=localized(f"{t_s[-1]:g}"),
                )
            )
        for name in recording.channels:
            if name in channels and name != "t":
                raise UnusableInput(
                    phrase("{file}: '{name}' stands in two time bases", file=source.path, name=name)
                )
            if name != "t":
                channels[name] = _onto(t_s, recording, name)
    return Recording(
        source.path,
        channels,
        units={name: unit for r in recordings for name, unit in r.units.items()},
        side=source.side,
        unusable={name: line for r in recordings for name, line in r.unusable.items()},
        ignored=tuple(name for r in recordings for name in r.ignored),
    )


def one_base(
    source: RecordingSource,
    *,
    group: str | None = None,
    resample_hz: float | None = None,
    like: Recording | CutTable | None = None,
) -> Recording | CutTable:
    """Read one time base of a file, or all of them at one rate, or at the times of ``like``.

    Where its stamps are those of ``like``, its rows are laid out alike.
    """
    if group is not None and resample_hz is not None:
        raise UnusableInput(
            phrase("give either --group or --resample: one reads a part, the other all")
        )
    if resample_hz is None:
        only = len(source.bases) == 1 and like is not None
        base = source.choose(None if only else group)
        return base.read(like=like if isinstance(like, Recording) else None)
    if isinstance(like, Recording):
        return read_at(source, like.t_s)
    return read_at(source, common_times_s(source, resample_hz))


def only_over_time(found: Recording | CutTable) -> Recording:
    """Return a recording over time; raises UnusableInput where it is a table of cuts."""
    if isinstance(found, CutTable):
        raise UnusableInput(
            phrase("{file}: is a table of cuts; use a recording over time", file=found.path)
        )
    return found


def _recordings(source: RecordingSource) -> list[Recording]:
    tables = [base.read() for base in source.usable()]
    series = [table for table in tables if isinstance(table, Recording)]
    if len(series) < len(tables):
        raise UnusableInput(
            phrase("{file}: holds a table of cuts; --resample is for recordings", file=source.path)
        )
    return series


def _onto(t_s: Array, recording: Recording, name: str) -> Array:
    from scipy import signal

    values, rate_hz = recording[name], 1.0 / float(t_s[1] - t_s[0])
    if recording.rate_hz > rate_hz:
        sos = signal.butter(4, PASS_BAND * rate_hz, fs=recording.rate_hz, output="sos")
        values = signal.sosfiltfilt(sos, values, padlen=min(len(values) - 1, 30))
    return np.asarray(np.interp(t_s, recording.t_s, values), dtype=np.float64)
