"""What the library of plots writes itself, in the reader's language: marks, months and buttons."""

from functools import cache
from typing import Any

from autodb.wording import phrase, presentation
from autodb.wording.amounts import NARROW, decimal_mark

DAY_MS = 86_400_000


def locale_config() -> dict[str, Any]:
    """Return what a plot is told of the reader's language; nothing in English, which it writes."""
    language = presentation().language
    if language == "en":
        return {}
    words = {"dictionary": _buttons(), "format": _marks(language)}
    return {"locale": language, "locales": {language: words}}


def date_ticks() -> dict[str, Any]:
    """Return how an axis of time writes its times; in English its ticks as the library does."""
    if presentation().language == "en":
        return {"hoverformat": "%Y-%m-%d %H:%M"}
    ticks = (
        {"dtickrange": [None, DAY_MS], "value": "%H:%M:%S\n%d.%m.%Y"},
        {"dtickrange": [DAY_MS, "M1"], "value": "%d.%m.\n%Y"},
        {"dtickrange": ["M1", None], "value": "%m.%Y"},
    )
    return {"hoverformat": "%d.%m.%Y %H:%M", "tickformatstops": ticks}


def _buttons() -> dict[str, str]:
    """Return the titles of a plot's buttons by those that the library has in English."""
    return {
        "Download plot as a PNG": phrase("Download plot as a PNG"),
        "Download plot": phrase("Download plot"),
        "Zoom": phrase("Zoom"),
        "Pan": phrase("Pan"),
        "Zoom in": phrase("Zoom in"),
        "Zoom out": phrase("Zoom out"),
        "Autoscale": phrase("Autoscale"),
        "Reset axes": phrase("Reset axes"),
    }


@cache
def _marks(language: str) -> dict[str, Any]:
    """Return marks and names of days and months (Unicode CLDR), as D3 takes them."""
    from babel.dates import get_day_names, get_month_names

    months, days = range(1, 13), (6, *range(6))
    return {
        "decimal": decimal_mark(language),
        "thousands": NARROW,
        "grouping": [3],
        "dateTime": "%d.%m.%Y %H:%M:%S",
        "date": "%d.%m.%Y",
        "time": "%H:%M:%S",
        "months": [get_month_names("wide", locale=language)[one] for one in months],
        "shortMonths": [get_month_names("abbreviated", locale=language)[one] for one in months],
        "days": [get_day_names("wide", locale=language)[one] for one in days],
        "shortDays": [get_day_names("abbreviated", locale=language)[one] for one in days],
    }
