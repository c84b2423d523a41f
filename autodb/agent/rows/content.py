"""What a recording holds, whatever bytes it came in: by that it is known again.

The same table with other line ends, one line more or as Parquet is the same cuts; the same rows
over time are the same recording. Numbers count to DIGITS: what a conversion of units rounds is not
another value.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from hashlib import blake2b

from autodb.store import models

DIGITS = 12
SHARE_DIGITS = 8
"""Of means and scatters, as shares of the largest value: they are summed in blocks of any size."""


def of_cut(cut: models.Cut, material: str, tool: str) -> str:
    """Return by what a cut of a table is known again: number, conditions, what was sensed."""
    return _digest(
        [
            *(_shown(cut.number), cut.operation, material, tool),
            *([] if cut.lot is None else [cut.lot]),
            _shown_all(cut.conditions),
            _shown_all(cut.measured),
        ]
    )


def of_series(channels: Iterable[models.RecordingChannel]) -> str:
    """Return by what a recording over time is known again: each channel's rows and their spread."""
    return _digest(sorted(_of_channel(channel) for channel in channels))


def _of_channel(channel: models.RecordingChannel) -> list[str]:
    ends = [channel.minimum, channel.maximum]
    largest = max((abs(end) for end in ends if end is not None), default=0.0) or 1.0
    spread = (channel.mean, channel.sd)
    shares = [None if one is None else round(one / largest, SHARE_DIGITS) + 0.0 for one in spread]
    return [channel.name, channel.unit, str(channel.rows), *map(_shown, ends), *map(_shown, shares)]


def _shown_all(values: Mapping[str, float | str]) -> list[list[str]]:
    return [[name, _shown(values[name])] for name in sorted(values)]


def _shown(value: float | str | None) -> str:
    return str(value) if value is None or isinstance(value, str) else f"{value + 0.0:.{DIGITS}g}"


def _digest(values: Sequence[object]) -> str:
    return blake2b(json.dumps(values).encode(), digest_size=16).hexdigest()
