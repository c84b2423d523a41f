"""Dates and times of day as text: ISO 8601 and what controls print instead."""

from collections.abc import Callable
from datetime import UTC, datetime, timedelta, timezone

from autodb.proofs.cases.stamps.axis_rows import AxisDraw
from autodb.proofs.cases.stamps.stamped import Rng, StampedRows, StampKind, Texts, Write, even_rows

SPRING = datetime(2026, 3, 29, 1, 0, 0, tzinfo=UTC)
AUTUMN = datetime(2026, 10, 25, 1, 0, 0, tzinfo=UTC)
"""When summer time begins and ends in the European Union."""
Print = Callable[[datetime, str], str]
"""A moment and the digits of its second, as text."""


def _iso(moment: datetime, digits: str) -> str:
    return f"{moment:%Y-%m-%dT%H:%M:%S}{digits}"


def _iso_utc(moment: datetime, digits: str) -> str:
    return f"{_iso(moment, digits)}Z"


def _iso_offset(moment: datetime, digits: str) -> str:
    zone = f"{moment:%z}"
    return f"{_iso(moment, digits)}{zone[:3]}:{zone[3:]}"


def _iso_space(moment: datetime, digits: str) -> str:
    return f"{moment:%Y-%m-%d %H:%M:%S}{digits}"


def _iso_comma(moment: datetime, digits: str) -> str:
    return f'"{moment:%Y-%m-%d %H:%M:%S}{digits.replace(".", ",")}"'


def _german(moment: datetime, digits: str) -> str:
    return f"{moment:%d.%m.%Y %H:%M:%S}{digits}"


def _american(moment: datetime, digits: str) -> str:
    hour = moment.hour % 12 or 12
    half = "AM" if moment.hour < 12 else "PM"
    return f"{moment.month}/{moment.day}/{moment.year} {hour}:{moment:%M:%S}{digits} {half}"


def _time_of_day(moment: datetime, digits: str) -> str:
    return f"{moment:%H:%M:%S}{digits}"


def _colon_ms(moment: datetime, digits: str) -> str:
    return f"{moment:%H:%M:%S}:{digits[1:4]}"


def _whole_seconds(moment: datetime, digits: str) -> str:
    del digits
    return f"{moment:%Y-%m-%dT%H:%M:%S}"


def dated_as(show: Print, *, hours: float = 0.0, digits: int = 0) -> Write:
    """Return what writes moments of some day as ``show`` prints them; ``digits`` 0: drawn."""

    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        zone = timezone(timedelta(hours=hours)) if hours else UTC
        start = datetime(2026, 5, 1, tzinfo=zone) + timedelta(seconds=int(rng.integers(0, 80_000)))
        shown = digits or int(rng.choice([4, 6]))
        return StampedRows(even_rows(draw), _texts(draw, start, show, shown), "", {"digits": shown})

    return write


def _texts(draw: AxisDraw, start: datetime, show: Print, digits: int) -> Texts:
    """Return a text for each row; the second is printed with ``digits``, rounded."""
    unit = 10**digits
    texts = []
    for since_s in draw.grid_s.tolist():
        whole, part = divmod(round(since_s * unit), unit)
        texts.append(show(start + timedelta(seconds=whole), f".{part:0{digits}d}"))
    return texts


def _over_the_change(show: Print) -> Write:
    """Return what writes local times of Berlin over a change of summer time."""

    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        change, (before, after) = (SPRING, (1, 2)) if rng.random() < 0.5 else (AUTUMN, (2, 1))
        start = change - timedelta(seconds=int(rng.uniform(0.2, 0.8) * draw.programme.seconds))

        def local(moment: datetime, digits: str) -> str:
            hours = before if moment < change else after
            return show(moment.astimezone(timezone(timedelta(hours=hours))), digits)

        since_s = (change - start).total_seconds()
        return StampedRows(even_rows(draw), _texts(draw, start, local, 4), "", {"after": since_s})

    return write


DATES = (
    StampKind("ISO 8601", "2026-05-01T13:59:50.1234, no zone.", "ISO 8601.", dated_as(_iso)),
    StampKind("ISO 8601 Z", "2026-05-01T13:59:50.1234Z.",
              "MTConnect timestamps; OPC UA exports.", dated_as(_iso_utc)),
    StampKind("ISO 8601 +02:00", "2026-05-01T13:59:50.1234+02:00.", "ISO 8601 with an offset.",
              dated_as(_iso_offset, hours=2.0)),
    StampKind("ISO, space", "2026-05-01 13:59:50.1234.", "pandas, SQL exports.",
              dated_as(_iso_space)),
    StampKind("ISO, comma", "2026-05-01 13:59:50,1234 in quotes.",
              "Python's logging, comma locales.", dated_as(_iso_comma)),
    StampKind("German date", "01.05.2026 13:59:50.1234.", "Controls with a German surface.",
              dated_as(_german)),
    StampKind("American date", "5/1/2026 1:59:50.1234 PM.", "Excel and LabVIEW, US locale.",
              dated_as(_american)),
    StampKind("time of day", "13:59:50.1234.", "TIME_OF_DAY of a PLC as text.",
              dated_as(_time_of_day)),
    StampKind("time, colon ms", "13:59:50:123, milliseconds cut off.", "Traces of PLCs.",
              dated_as(_colon_ms, digits=6)),
    StampKind("ISO, whole seconds", "2026-05-01T13:59:50: hundreds of rows share a stamp.",
              "Formats without a fraction.", dated_as(_whole_seconds, digits=6)),
    StampKind("summer time, offset", "Local time with its offset, over a change of summer time.",
              "2026-03-29 and 2026-10-25 in Europe.", _over_the_change(_iso_offset)),
    StampKind("summer time, bare", "Local time without offset, over a change of summer time.",
              "2026-03-29 and 2026-10-25 in Europe.", _over_the_change(_iso)),
)  # fmt: skip
