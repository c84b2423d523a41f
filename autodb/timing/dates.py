"""Stamps written as dates and times: seconds since 1970, or since midnight."""

import re
from collections.abc import Sequence

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import compute

Array = NDArray[np.float64]

_NAMED_MONTHS = (
    ("jan", "ene", "gen"),
    ("feb", "fev", "fév"),
    ("mar", "mär", "mrz"),
    ("apr", "avr", "abr"),
    ("may", "mai", "mag"),
    ("jun", "giu", "juin"),
    ("jul", "lug", "juil"),
    ("aug", "aoû", "ago"),
    ("sep", "set"),
    ("oct", "okt", "ott"),
    ("nov",),
    ("dec", "dez", "déc", "dic"),
)
"""Beginnings of the months' names in five languages; the longer ones tell June from July."""
_NUMBERED = r"^(\d{1,2})[./-](\d{1,2})[./-]"
_BEYOND_MONTHS = r"(1[3-9]|[23]\d)[./-]"
_YEARS = ((r"(\d{4})[ T]+", r"\3"), (r"(\d\d)[ T]+", r"20\3"))
"""Years of four digits, and of two, with what follows; and how they are written in full."""
_COMPACT = re.compile(r"\d{8}T\d{6}")
_DURATION = r"^((\d+ days? +)?\d{1,9}:)?\d{1,9}:\d+\.?\d*$"
_HALF_DAY = r"([0-9:.]+) *([AaPp])\.?[Mm]\.?$"


def is_date(text: str) -> bool:
    """Say whether a text is a moment as loggers write it.

    >>> is_date("27.11.2026 10:00:00"), is_date("20261127T100000"), is_date("12.5")
    (True, True, False)
    """
    return (":" in text and any(c.isdigit() for c in text)) or bool(_COMPACT.match(text))


def seconds_of(texts: Sequence[str]) -> Array | None:
    """Return moments as seconds since 1970, or since midnight or a start where there is no date.

    Shape (n,); NaN where a text is empty; without a zone as in UTC. None where a text is no moment.
    """
    written = compute.utf8_trim_whitespace(pa.array(texts, pa.string()))
    given = compute.not_equal(written, "").to_numpy(zero_copy_only=False)
    plain = compute.replace_substring(written.filter(pa.array(given)), ",", ".")
    plain = _replaced(plain, r"(\d:\d\d:\d\d):(\d{1,9})$", r"\1.\2")
    plain, later_s = _whole_days(plain)
    for read in (_moments, _durations, _rewritten):
        seconds = read(plain)
        if seconds is not None:
            found = np.full(len(written), np.nan)
            found[given] = seconds + later_s
            return found
    return None


def _replaced(texts: pa.Array, pattern: str, by: str) -> pa.Array:
    return compute.replace_substring_regex(texts, pattern, by)


def _any(texts: pa.Array, pattern: str) -> bool:
    return bool(compute.any(compute.match_substring_regex(texts, pattern)).as_py())


def _whole_days(texts: pa.Array) -> tuple[pa.Array, Array]:
    """Return times before or after noon without saying so, and what is to be added to each, s."""
    if not _any(texts, _HALF_DAY):
        return texts, np.zeros(len(texts))
    plain = _replaced(_replaced(texts, _HALF_DAY, r"\1"), r"(\d) *([AaPp])\.?[Mm]\.?$", r"\1")
    plain = _replaced(plain, r"(^|[ T])12:", r"\100:")
    after = compute.match_substring_regex(texts, r"[Pp]\.?[Mm]\.?$")
    return plain, 43_200.0 * after.to_numpy(zero_copy_only=False)


def _moments(texts: pa.Array) -> Array | None:
    """Return dates as ISO 8601 has them as seconds since 1970, (n,)."""
    import pandas as pd

    try:
        moments = pd.to_datetime(texts.to_pandas(), format="ISO8601", utc=True)
    except ValueError:
        return None
    since = moments - pd.Timestamp("1970-01-01", tz="UTC")
    return np.asarray(since / pd.Timedelta(1, "s"), dtype=np.float64)


def _durations(texts: pa.Array) -> Array | None:
    """Return times of day, and durations beyond one, in s, (n,).

    One colon stands between minutes and seconds where seconds have a fraction, else between hours
    and minutes.
    """
    if not compute.all(compute.match_substring_regex(texts, _DURATION)).as_py():
        return None
    parts = compute.split_pattern(_replaced(texts, r"^(\d+) days? +", r"\1:"), ":")
    counts = set(compute.unique(compute.list_value_length(parts)).to_pylist())
    if len(counts) != 1:
        return None
    (count,) = counts
    seconds = (86_400.0, 3600.0, 60.0, 1.0)[-count:]
    if count == 2 and not _any(texts, r"\."):
        seconds = (3600.0, 60.0)
    cells = [compute.list_element(parts, k).cast(pa.float64()) for k in range(count)]
    found = [size * cell.to_numpy() for size, cell in zip(seconds, cells, strict=True)]
    return np.asarray(sum(found), dtype=np.float64)


def _rewritten(texts: pa.Array) -> Array | None:
    """Return dates of other ways of writing as seconds since 1970, (n,).

    Between slashes the month comes first, between points and dashes the day, unless that would be
    a thirteenth month.
    """
    month_first = not _any(texts, r"^\d{1,2}[.-]")
    if _any(texts, rf"^{_BEYOND_MONTHS}" if month_first else rf"^\d{{1,2}}[./-]{_BEYOND_MONTHS}"):
        month_first = not month_first
    for year, full in _YEARS:
        order = rf"{full}-\1-\2T" if month_first else rf"{full}-\2-\1T"
        texts = _replaced(texts, _NUMBERED + year, order)
    if _any(texts, r"^[^T]*\pL{3}"):
        texts = _with_numbered_months(texts)
    texts = _replaced(texts, r"-(\d)-", r"-0\1-")
    return _moments(_replaced(_replaced(texts, r"-(\d)T", r"-0\1T"), r"[T ](\d):", r"T0\1:"))


def _with_numbered_months(texts: pa.Array) -> pa.Array:
    """Return dates whose months have names in the order of ISO 8601."""
    for number, names in reversed([*enumerate(_NAMED_MONTHS, start=1)]):
        month = rf"(?i:(?:{'|'.join(names)})\pL*)"
        for year, full in _YEARS:
            by = rf"{full.replace('3', '2')}-{number}-\1T"
            texts = _replaced(texts, rf"^(\d{{1,2}})[-. ]+{month}[-. ]+{year}", by)
            texts = _replaced(texts, rf"^{month}[-. ]+(\d{{1,2}})[-. ]+{year}", by)
    return texts
