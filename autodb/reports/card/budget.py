"""The uncertainty budget of a force on a calibration card, at the middle of the current's range."""

from collections.abc import Iterator

import numpy as np

from autodb.fitting.uncertainty import BudgetEntry, UncertaintyBudget
from autodb.reports.card.axis_figures import AxisCard
from autodb.sensing.dynamometer import PARTS, WHOLE
from autodb.wording import msgid, phrase
from autodb.wording.kept import said_again

PROCESS = msgid("process")
TINY = 1e-12
"""Share below which references have no error."""


def budget_of_axis(axis: AxisCard) -> UncertaintyBudget:
    """Return the budget of what one cut at the middle is sensed as."""
    middle, found = axis.middle, axis.calibration
    contributions = [*_sensing(axis), *_references(axis)]
    said = phrase("not in it: the force of the very cut is sensed")
    contributions.append(BudgetEntry(phrase(PROCESS), None, "A", said))
    return UncertaintyBudget(
        f"force.{found.component}", middle.value, found.unit, tuple(contributions)
    )


def _sensing(axis: AxisCard) -> Iterator[BudgetEntry]:
    """Yield what the current and the fit add."""
    middle, found = axis.middle, axis.calibration
    freedom = float(max(1, found.scores.n - len(found.coefficients)))
    cuts = phrase("{count} cuts, by groups left out", count=found.scores.n)
    yield BudgetEntry(phrase("sensing, one cut's own"), middle.own, "A", cuts, freedom)
    fitted = phrase("coefficients fitted to {count} cuts", count=found.scores.n)
    yield BudgetEntry(phrase("sensing, calibration"), middle.coefficients, "A", fitted, freedom)
    day = phrase("sensing, drift from day to day")
    if middle.gain:
        said = phrase("gain on another day, published or seen here")
        yield BudgetEntry(day, middle.gain, "B", said)
    else:
        yield BudgetEntry(day, None, "B", phrase("none seen in these cuts"))
    if middle.group:
        groups = phrase(
            "{count} groups differ so ({group})",
            count=found.scores.groups,
            group=said_again(found.scores.grouped_by),
        )
        few = float(max(1, found.scores.groups - 1))
        name = phrase("sensing, tool, material or day")
        yield BudgetEntry(name, middle.group, "A", groups, few)


def _references(axis: AxisCard) -> Iterator[BudgetEntry]:
    """Yield what the forces that it was calibrated on add: a protocol's, or a dynamometer's."""
    middle, found = axis.middle, axis.calibration
    transfer = phrase("transfer from the reference cut")
    if not found.reference_errors:
        share = found.errors.reference_share
        said = phrase("intervals of the protocol's reference forces")
        stated = middle.references if share else None
        yield BudgetEntry(transfer, stated, "B", said if share else phrase("not stated"))
    whole = max(float(np.linalg.norm([one.share for one in found.reference_errors])), TINY)
    for one in found.reference_errors:
        standard = middle.references * abs(one.share) / whole
        yield BudgetEntry(one.name, standard, one.evaluation, one.source)
    names = [one.name for one in found.reference_errors]
    for name in PARTS:
        if not any(one.startswith(name) for one in names):
            in_whole = any(one.startswith(WHOLE) for one in names)
            yield BudgetEntry(name, None, "B", _lacking(in_whole))
    if found.reference_errors:
        yield BudgetEntry(transfer, None, "B", phrase("none: forces were measured in each cut"))


def _lacking(in_whole: bool) -> str:
    """Return why a contribution has no number."""
    return phrase("in the uncertainty as stated") if in_whole else phrase("not stated")
