"""Cuts as a form states them, and as a page says them."""

from collections.abc import Mapping, Sequence
from typing import Any

from starlette.datastructures import QueryParams

from autodb.errors import UnusableInput
from autodb.files.cut_words import FIELDS, shown_fields
from autodb.files.job_cut import ANY_CUT, KEYS, OPERATIONS, JobCut
from autodb.forward.limits import QUANTITIES
from autodb.forward.prediction import Interval, PredictedCut
from autodb.reports.amounts import quantity, span
from autodb.reports.figures import quantity_title
from autodb.web.pages.typed import Typed, typed_now, written_cut
from autodb.wording import phrase

MOST = 50
"""Cuts of a form. Chosen: more come as a program or by the API."""


SHOWN = {
    operation: [*KEYS[operation].needs, *KEYS[operation].may, *ANY_CUT] for operation in OPERATIONS
}
"""Fields of a cut by its operation."""


def stated_rows(query: QueryParams) -> list[dict[str, str]]:
    """Return what a form states of cuts, texts by key; it sends every field of each cut.

    Raises UnusableInput for more cuts than it may have.
    """
    operations = query.getlist("operation")
    if len(operations) > MOST:
        raise UnusableInput(
            phrase(
                "{count} cuts are too many; send {most}, or a program",
                count=len(operations),
                most=MOST,
            )
        )
    columns = {name: query.getlist(name) for name in ("name", *(one.key for one in FIELDS))}
    return [
        {"operation": operation}
        | {name: some[k] for name, some in columns.items() if k < len(some) and some[k].strip()}
        for k, operation in enumerate(operations)
    ]


def read_cuts(rows: Sequence[Mapping[str, str]], typed: Typed) -> list[JobCut]:
    """Return the cuts that rows of a form state; raises UnusableInput naming cut and key."""
    found = []
    for k, row in enumerate(rows, start=1):
        try:
            found.append(typed.cut(row))
        except UnusableInput as error:
            raise UnusableInput(
                phrase("cut {number}: {problem}", number=k, problem=error)
            ) from None
    return found


def form_of_cuts(rows: Sequence[Mapping[str, str]]) -> dict[str, Any]:
    """Return what the template shows of a form of cuts: its rows, fields and operations."""
    return {
        "rows": rows,
        "fields": shown_fields(),
        "shown": SHOWN,
        "operations": [(one, phrase(one)) for one in OPERATIONS],
        "typed": typed_now(),
    }


def rewritten(
    rows: Sequence[Mapping[str, str]], cuts: Sequence[JobCut], typed: Typed
) -> list[Mapping[str, str]]:
    """Return rows as they were typed, or, where the reader writes numbers otherwise now, anew."""
    return list(rows) if typed == typed_now() else [written_cut(cut) for cut in cuts]


def prediction_spans(
    cut: PredictedCut, beside: Sequence[PredictedCut] = ()
) -> list[tuple[str, str, str, list[tuple[str, str]]]]:
    """Return what a cut takes: quantity, mean, 95 % interval, and start, end and peak by name.

    ``beside``: cuts that share its column titles.
    """
    operations = [one.operation for one in (cut, *beside)]
    return [
        (
            quantity_title(one.channel, operations),
            *_in_words(one.of(cut), one.unit),
            [
                (phrase(name), "{} ({})".format(*_in_words(one.of(some), one.unit)))
                for name, some in cut.statistics
            ],
        )
        for one in QUANTITIES
    ]


def _in_words(one: Interval | None, unit: str) -> tuple[str, str]:
    assert one is not None
    return quantity(one.value, unit), span(one.low, one.high, unit)
