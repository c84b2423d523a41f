"""Cuts as a form states them, and as a page says them."""

from collections.abc import Mapping, Sequence

from starlette.datastructures import QueryParams

from autodb.errors import UnusableInput
from autodb.files.cut_words import FIELDS
from autodb.files.job import ANY_CUT, KEYS, OPERATIONS, JobCut
from autodb.forward.predictedfile import QUANTITIES
from autodb.forward.prediction import Interval, PredictedCut
from autodb.reports.figures import force_title, number, span
from autodb.web.routes.asked import as_cut

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
        raise UnusableInput(f"{len(operations)} cuts are too many; send {MOST}, or a program")
    columns = {name: query.getlist(name) for name in ("name", *(one.key for one in FIELDS))}
    return [
        {"operation": operation}
        | {name: some[k] for name, some in columns.items() if k < len(some) and some[k].strip()}
        for k, operation in enumerate(operations)
    ]


def read_cuts(rows: Sequence[Mapping[str, str]]) -> list[JobCut]:
    """Return the cuts that rows of a form state; raises UnusableInput naming cut and key."""
    found = []
    for k, row in enumerate(rows, start=1):
        try:
            found.append(as_cut(row))
        except UnusableInput as error:
            raise UnusableInput(f"cut {k}: {error}") from None
    return found


def cut_rows(cuts: Sequence[JobCut]) -> list[dict[str, str]]:
    """Return what a form shows of cuts: texts by key."""
    return [
        {
            key: f"{value:g}" if isinstance(value, float) else str(value)
            for key, value in cut.model_dump(exclude_none=True).items()
        }
        for cut in cuts
    ]


def prediction_spans(
    cut: PredictedCut, beside: Sequence[PredictedCut] = ()
) -> list[tuple[str, str, str, list[tuple[str, str]]]]:
    """Return what a cut takes: quantity, mean, 95 % interval, and start, end and peak by name.

    ``beside``: cuts that share its column titles.
    """
    operations = [one.operation for one in (cut, *beside)]
    titles = [*(force_title(name, operations) for name in "xyz"), "Spindle torque", "Cutting power"]
    rows = zip(titles, QUANTITIES, strict=True)
    return [
        (
            what,
            *_in_words(quantity.of(cut), quantity.unit),
            [
                (name, "{} ({})".format(*_in_words(quantity.of(some), quantity.unit)))
                for name, some in cut.statistics
            ],
        )
        for what, quantity in rows
    ]


def _in_words(one: Interval | None, unit: str) -> tuple[str, str]:
    assert one is not None
    return f"{number(one.value)} {unit}", span(one.low, one.high, unit)
