"""Stamps in another unit than seconds are doubted, the unit that fits named; dates are read."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.timing.dates import is_date, seconds_of
from autodb.timing.units import doubtful_rate, highest_acceleration
from tests.helpers.stamped import MOVE_S, WAY_MM, written_mm

T = np.arange(8000) / 400.0
SHARPEST = 6.0 * WAY_MM / MOVE_S**2
"""Of 3u² − 2u³: at both ends of a move."""


def test_the_highest_acceleration_is_that_of_the_moves() -> None:
    """Nearly: it is to tell units apart, by a thousand and more."""
    found = highest_acceleration(T, written_mm(T))
    assert found is not None
    assert_allclose(found, SHARPEST, rtol=0.4)


@pytest.mark.parametrize(
    ("unit", "seconds", "name"),
    [
        ("ms", 1e-3, "milliseconds"),
        ("us", 1e-6, "microseconds"),
        ("ns", 1e-9, "nanoseconds"),
        ("1e-7", 1e-7, "ticks of 100 ns"),
        ("min", 60.0, "minutes"),
        ("day", 86400.0, "days"),
    ],
)
@pytest.mark.parametrize("rate_hz", [50.0, 400.0, 2000.0])
def test_the_unit_that_fits_is_named(unit: str, seconds: float, name: str, rate_hz: float) -> None:
    """Also where the rate alone would pass: 2 kHz in milliseconds are 2 Hz."""
    t = np.arange(round(20.0 * rate_hz)) / rate_hz
    written = np.arange(len(t)) / (rate_hz * seconds)
    sharpest = highest_acceleration(written, written_mm(t))
    said = doubtful_rate(1.0 / rate_hz / seconds, sharpest)
    stated = f"scale = {unit}" if unit == "1e-7" else f'unit = "{unit}"'
    assert f"as {name} {rate_hz:g} Hz ({stated})" in said


@pytest.mark.parametrize("rate_hz", [2.5, 10.0, 50.0, 400.0, 8000.0])
def test_seconds_are_not_doubted(rate_hz: float) -> None:
    t = np.arange(round(20.0 * rate_hz)) / rate_hz
    assert not doubtful_rate(1.0 / rate_hz, highest_acceleration(t, written_mm(t)))


def test_a_map_at_creep_is_not_doubted() -> None:
    """2.5 rows a second, speeds that change from row to row: too few rows to tell accelerations."""
    rng = np.random.default_rng(1)
    place = np.cumsum(rng.exponential(0.003, size=3000))
    assert highest_acceleration(np.arange(3000) / 2.5, place) is None


@pytest.mark.parametrize(
    ("texts", "seconds"),
    [
        (["2026-03-29T00:59:58.5", "2026-03-29T00:59:59"], 0.5),
        (["2026-03-29T01:59:59.5+01:00", "2026-03-29T03:00:00.5+02:00"], 1.0),
        (["2026-03-29 00:59:58,5Z", "2026-03-29 01:00:00,75Z"], 2.25),
        (["29.03.2026 0:59:58", "29.03.2026 01:00:00.25"], 2.25),
        (["03/29/2026 10:00:00", "03/29/2026 10:00:00.125"], 0.125),
        (["29/03/2026 23:59:59", "30/03/2026 00:00:01"], 2.0),
        (["9:05:01.25", "10:05:01.25"], 3600.0),
        (["13:59:50:123", "13:59:50:623"], 0.5),
        (["5/1/2026 11:59:59.5 AM", "5/1/2026 12:00:00.5 PM"], 1.0),
        (["5/1/2026 11:59:59 pm", "5/2/2026 12:00:01 am"], 2.0),
        (["29.03.26 10:00:00,5", "29.03.26 10:00:01,5"], 1.0),
        (["29-03-2026 10:00:00", "29-03-2026 10:00:00.25"], 0.25),
        (["31-May-2026 23:59:59", "01-Jun-2026 00:00:01"], 2.0),
        (["30. Juin 2026 23:59:59", "1. Juillet 2026 00:00:01"], 2.0),
        (["Dez 31, 2025 23:59:59.5", "Jan 1, 2026 00:00:00"], 0.5),
        (["2026/03/29 10:00:00.5", "2026/03/29 10:00:00.75"], 0.25),
        (["20260329T100000.5", "20260329T100001.5"], 1.0),
        (["23:59:59.5", "24:00:00.5"], 1.0),
        (["0 days 23:59:59", "1 days 00:00:01"], 2.0),
        (["59:59.25", "60:00.75"], 1.5),
        (["10:00", "10:01"], 60.0),
    ],
)
def test_dates_are_read_as_loggers_write_them(texts: list[str], seconds: float) -> None:
    assert is_date(texts[0])
    found = seconds_of(texts)
    assert found is not None
    assert_allclose(np.diff(found), seconds, atol=1e-6)


def test_what_is_no_date_is_none() -> None:
    for text in ("noon", "12.5", ":", "inf:00:00", "29 Foo 2026 10:00:00", "10:00:00:00:00"):
        assert seconds_of([text]) is None
    assert not is_date("12.5")
    found = seconds_of(["10:00:00", ""])
    assert found is not None
    assert np.isnan(found[1])
