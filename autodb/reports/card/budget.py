"""The uncertainty budget of a force on a calibration card, at the middle of the current's range."""

from collections.abc import Iterator

import numpy as np

from autodb.fitting.uncertainty import BudgetEntry, UncertaintyBudget
from autodb.reports.card.axis_figures import AxisCard
from autodb.sensing.dynamometer import PARTS, WHOLE

PROCESS = "process"
TINY = 1e-12
"""Share below which references have no error."""


def budget_of_axis(axis: AxisCard) -> UncertaintyBudget:
    """Return the budget of what one cut at the middle is sensed as."""
    middle, found = axis.middle, axis.calibration
    contributions = [*_sensing(axis), *_references(axis)]
    said = "not in it: the force of the very cut is sensed"
    contributions.append(BudgetEntry(PROCESS, None, "A", said))
    return UncertaintyBudget(
        f"force.{found.component}", middle.value, found.unit, tuple(contributions)
    )


def _sensing(axis: AxisCard) -> Iterator[BudgetEntry]:
    """Yield what the current and the fit add."""
    middle, found = axis.middle, axis.calibration
    freedom = float(max(1, found.scores.n - len(found.coefficients)))
    cuts = f"{found.scores.n} cuts, by groups left out"
    yield BudgetEntry("sensing, one cut's own", middle.own, "A", cuts, freedom)
    fitted = f"coefficients fitted to {found.scores.n} cuts"
    yield BudgetEntry("sensing, calibration", middle.coefficients, "A", fitted, freedom)
    day = "sensing, drift from day to day"
    if middle.gain:
        yield BudgetEntry(day, middle.gain, "B", "gain on another day, published or seen here")
    else:
        yield BudgetEntry(day, None, "B", "none seen in these cuts")
    if middle.group:
        groups = f"{found.scores.groups} groups differ so ({found.scores.grouped_by})"
        few = float(max(1, found.scores.groups - 1))
        yield BudgetEntry("sensing, tool, material or day", middle.group, "A", groups, few)


def _references(axis: AxisCard) -> Iterator[BudgetEntry]:
    """Yield what the forces that it was calibrated on add: a protocol's, or a dynamometer's."""
    middle, found = axis.middle, axis.calibration
    transfer = "transfer from the reference cut"
    if not found.reference_errors:
        share = found.errors.reference_share
        said = "intervals of the protocol's reference forces"
        stated = middle.references if share else None
        yield BudgetEntry(transfer, stated, "B", said if share else "not stated")
    whole = max(float(np.linalg.norm([one.share for one in found.reference_errors])), TINY)
    for one in found.reference_errors:
        standard = middle.references * abs(one.share) / whole
        yield BudgetEntry(one.name, standard, one.evaluation, one.source)
    names = [one.name for one in found.reference_errors]
    for name in PARTS:
        if not any(one.startswith(name) for one in names):
            in_whole = any(one.startswith(WHOLE) for one in names)
            yield BudgetEntry(name, None, "B", f"in the {WHOLE}" if in_whole else "not stated")
    if found.reference_errors:
        yield BudgetEntry(transfer, None, "B", "none: forces were measured in each cut")
