"""Recordings written as loggers do, drawn: stamps, separators, marks, encodings; look reads them.

`AUTODB_MUTATIONS=50` draws fifty times as many.
"""

import gzip
import os
from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from autodb.readers import open_bases
from autodb.records import source as records
from autodb.records.proposed.columns import propose_channels
from autodb.records.proposed.written import side_file_of
from autodb.records.tables import Recording

TIMES = int(os.environ.get("AUTODB_MUTATIONS", "1"))
ROWS = 260
Moment = Callable[[datetime, float], str]
"""A stamp of a moment, which is so many seconds after the first."""


def _dated(form: str, *, digits: int = 3, end: str = "", mark: str = ".") -> Moment:
    def stamp(at: datetime, _: float) -> str:
        fraction = f"{at.microsecond:06d}"[:digits]
        return f"{at.strftime(form)}{mark}{fraction}{at.strftime(end)}"

    return stamp


def _lasting(at: datetime, since_s: float) -> str:
    del at
    ms = round(1000.0 * (since_s + 86_395.0))
    return f"{ms // 3_600_000}:{ms // 60_000 % 60:02d}:{ms // 1000 % 60:02d}.{ms % 1000:03d}"


def _number(scale: float, digits: int, offset: float = 0.0) -> Moment:
    return lambda _, since_s: f"{offset + scale * since_s:.{digits}f}"


def _epoch(ticks: int) -> Moment:
    return lambda _, since_s: str(1_795_000_000 * ticks + round(since_s * ticks))


STAMPS: dict[str, Moment] = {
    "ISO": _dated("%Y-%m-%dT%H:%M:%S"),
    "ISO, UTC": _dated("%Y-%m-%d %H:%M:%S", digits=6, end="Z"),
    "ISO, comma": _dated("%Y-%m-%d %H:%M:%S", mark=","),
    "compact": _dated("%Y%m%dT%H%M%S"),
    "German": _dated("%d.%m.%Y %H:%M:%S", mark=","),
    "German, short year": _dated("%d.%m.%y %H:%M:%S", mark=","),
    "American": _dated("%m/%d/%Y %I:%M:%S", end=" %p"),
    "MATLAB": _dated("%d-%b-%Y %H:%M:%S"),
    "colon before the fraction": _dated("%Y/%m/%d %H:%M:%S", mark=":"),
    "time of day": _dated("%H:%M:%S", digits=6),
    "half a day": _dated("%I:%M:%S", end="%p"),
    "duration beyond a day": _lasting,
    "seconds": _number(1.0, 3),
    "seconds from somewhere": _number(1.0, 3, offset=731.25),
    "milliseconds": _number(1e3, 1),
    "days of a spreadsheet": _number(1.0 / 86_400.0, 10, offset=46_353.5),
    "epoch, s": _number(1.0, 3, offset=1_795_000_000.0),
    "epoch, ms": _epoch(10**3),
    "epoch, µs": _epoch(10**6),
    "epoch, ns": _epoch(10**9),
}
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "cp1252")
STARTS = st.datetimes(datetime(2020, 1, 1), datetime(2030, 12, 31))


def _channels(rate_hz: float) -> dict[str, np.ndarray]:
    t = np.arange(ROWS) / rate_hz
    place = 30.0 * np.sin(2.0 * np.pi * t / (ROWS / rate_hz / 3.0))
    slope = np.gradient(place, t)
    return {"t": t, "Lage X [mm]": place, "Ströme X [A]": np.tanh(slope / np.abs(slope).max() * 20)}


@pytest.mark.parametrize("stamp", STAMPS)
def test_what_a_logger_writes_is_read(stamp: str, tmp_path: Path) -> None:
    @settings(
        max_examples=3 * TIMES,
        deadline=None,
        database=None,
        derandomize=TIMES == 1,
        suppress_health_check=list(HealthCheck),
    )
    @given(
        start=STARTS,
        rate_hz=st.sampled_from([20.0, 50.0, 100.0, 250.0]),
        separator=st.sampled_from([",", ";", "\t", "|"]),
        comma=st.booleans(),
        encoding=st.sampled_from(ENCODINGS),
        ending=st.sampled_from(["\n", "\r\n"]),
        above=st.sampled_from([(), ("Maschine 4, Halle 2", ""), ("# Größe;Ort", "# von Hand")]),
        packed=st.booleans(),
    )
    def check(
        *,
        start: datetime,
        rate_hz: float,
        separator: str,
        comma: bool,
        encoding: str,
        ending: str,
        above: tuple[str, ...],
        packed: bool,
    ) -> None:
        channels = _channels(rate_hz)
        mark = "," if comma and separator != "," else "."
        lines = [*above, separator.join(["Zeit", *list(channels)[1:]])]
        for row, since_s in enumerate(channels["t"].tolist()):
            moment = STAMPS[stamp](start + timedelta(seconds=since_s), since_s)
            plain = moment if ":" in moment else moment.replace(".", mark)
            cells = [f"{values[row]:.6f}".replace(".", mark) for values in channels.values()]
            first = f'"{plain}"' if separator in plain else plain
            lines.append(separator.join([first, *cells[1:]]))
        text = ending.join([*lines, ""]).encode(encoding)
        path = tmp_path / ("a.csv.gz" if packed else "a.csv")
        path.write_bytes(gzip.compress(text) if packed else text)
        _read_and_compare(path, channels)

    check()


def _read_and_compare(path: Path, channels: dict[str, np.ndarray]) -> None:
    side = path.with_suffix(".toml")
    side.unlink(missing_ok=True)
    side.write_text(side_file_of([propose_channels(base) for base in open_bases(path)], path.name))
    table = records.read(path)
    assert isinstance(table, Recording)
    assert_allclose(table["t"] - table["t"][0], channels["t"], atol=6e-4)
    assert_allclose(table["x.position"], channels["Lage X [mm]"], atol=1e-6)
    assert_allclose(table["x.current"], channels["Ströme X [A]"], atol=1e-6)
