"""Stamps written as dates and times: seconds since 1970, or since midnight."""

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MONTHS = 12
_DAY_FIRST = re.compile(r"^(\d{1,2})\.(\d{1,2})\.(\d{4})[ T]+")
_SLASHES = re.compile(r"^(\d{1,2})/(\d{1,2})/(\d{4})[ T]+")
_HOUR = re.compile(r"^(\d{1,2}):")
_COLON_MS = re.compile(r"(\d:\d\d:\d\d):(\d{1,9})$")
_HALF_DAY = re.compile(r"(\d{1,2})(:\d\d:\d\d\S*)\s*([AaPp])\.?[Mm]\.?$")
_ONE_DIGIT_HOUR = re.compile(r"[T ](\d):")


def is_date(text: str) -> bool:
    """Say whether a text is a moment as loggers write it."""
    return ":" in text and any(c.isdigit() for c in text)


def seconds_of(texts: Sequence[str]) -> Array | None:
    """Return moments as seconds since 1970, or since midnight where there is no date, (n,).

    NaN where a text is empty; without a zone as in UTC. None where a text is no moment.
    """
    import pandas as pd

    plain = _as_iso([text.strip().replace(",", ".") for text in texts])
    written = pd.Series(plain, dtype="str")
    given = (written != "").to_numpy()
    try:
        moments = pd.to_datetime(written[given], format="ISO8601", utc=True)
    except ValueError:
        return None
    found = np.full(len(plain), np.nan)
    since = moments - pd.Timestamp("1970-01-01", tz="UTC")
    found[given] = (since / pd.Timedelta(1, "s")).to_numpy(dtype=np.float64)
    return found


def _as_iso(texts: Sequence[str]) -> list[str]:
    """Return moments of other ways of writing in that of ISO 8601.

    Hours before or after noon are of 24, a colon before a fraction is a point. Between slashes the
    month comes first, unless it would be a thirteenth.
    """
    slashes = [found for text in texts if (found := _SLASHES.match(text))]
    day_first = any(int(found[1]) > MONTHS for found in slashes)

    def from_slashes(found: re.Match[str]) -> str:
        month, day = (found[2], found[1]) if day_first else (found[1], found[2])
        return f"{found[3]}-{int(month):02}-{int(day):02}T"

    made = []
    for text in texts:
        one = _HALF_DAY.sub(_of_whole_day, _COLON_MS.sub(r"\1.\2", text))
        one = _DAY_FIRST.sub(lambda m: f"{m[3]}-{int(m[2]):02}-{int(m[1]):02}T", one)
        one = _SLASHES.sub(from_slashes, one)
        one = _HOUR.sub(lambda m: f"1970-01-01T{int(m[1]):02}:", one)
        made.append(_ONE_DIGIT_HOUR.sub(lambda m: f"T0{m[1]}:", one))
    return made


def _of_whole_day(found: re.Match[str]) -> str:
    """Return a time before or after noon as one of 24 hours."""
    hour = int(found[1]) % 12 + (12 if found[3] in "Pp" else 0)
    return f"{hour:02}{found[2]}"
