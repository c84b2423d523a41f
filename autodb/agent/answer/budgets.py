"""The uncertainty budget of a force that is kept: what it enters its pair's posterior with.

Each contribution is a standard uncertainty (``autodb.fitting.uncertainty``), worked out by the
readings that the posterior learns from (``autodb.agent.sense.sensed``), so that the total is what
it uses. Where the force was learnt, at what its pair expects, with the scatter of its cuts; else at
what was read, and the process is left open.
"""

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.calibration_records import as_calibration
from autodb.agent.rows.force_errors import errors_of, shared_key
from autodb.agent.rows.posteriors import as_posterior
from autodb.agent.sense.sensed import Readings, as_observed
from autodb.fitting.uncertainty import BudgetEntry, UncertaintyBudget
from autodb.pairs.posterior import CALIBRATION, DAY, EDGE, GAIN, LOT, REFERENCES, WEAR
from autodb.pairs.updating import ReadingErrors, reading_errors
from autodb.sensing.dynamometer import PARTS, WHOLE, ForceError
from autodb.store import models
from autodb.wording import stored_msgid

TRANSFER, SENSING, PROCESS = (
    stored_msgid("transfer from the reference cut"), stored_msgid("sensing"),
    stored_msgid("process"),
)  # fmt: skip
ALONE = stored_msgid("sensing, this cut alone")
CALIBRATED = stored_msgid("sensing, calibration")
FROM_DAY_TO_DAY = stored_msgid("sensing, drift from day to day")
DRIFTED = stored_msgid("sensing, drifted gain")
GAIN_OF_SENSOR = stored_msgid("sensing, gain")
WORN = stored_msgid("process, wear of this edge")


def budget_of_force(session: Session, force: models.SensedForce) -> UncertaintyBudget:
    """Return the budget of a force that was measured or sensed."""
    version = _learnt_by(session, force)
    found = _errors(force, version)
    contributions = [*_own(force, float(found.own[0])), *_shared(force, found)]
    contributions += [*_of_none(force, contributions), _process(found, version)]
    return UncertaintyBudget(
        quantity=f"force.{force.component} of cut {force.cut.number:g}",
        value=float(force.value_N or 0.0),
        unit="N",
        contributions=tuple(contributions),
    )


def _learnt_by(session: Session, force: models.SensedForce) -> models.CuttingParameters | None:
    """Return the newest version that learnt a force; None: none that counts has."""
    made = models.CuttingParameters
    query = select(made).where(
        made.forces.any(models.SensedForce.id == force.id),
        made.undone_at.is_(None),
        made.shared.is_not(None),
    )
    return session.scalar(query.order_by(made.id.desc()).limit(1))


def _errors(force: models.SensedForce, version: models.CuttingParameters | None) -> ReadingErrors:
    if version is not None:
        posterior = as_posterior(version)
        return reading_errors(posterior, as_observed([force], terms=posterior.terms))
    readings = Readings([force])
    return ReadingErrors(readings.sd_N, np.full(1, np.nan), readings.moved_N())


def _own(force: models.SensedForce, sd_N: float) -> Iterator[BudgetEntry]:
    """Yield what is a force's own: of a measured one its noise, of a sensed one its sensing."""
    own = [one for one in errors_of(force) if one.of is None]
    for one in own:
        whole = float(force.value_N or 0.0)
        yield BudgetEntry(one.name, one.standard_N(whole), one.evaluation, one.source, one.freedom)
    if not own:
        said = stored_msgid("scatter of one cut's own, with the noise of its current")
        if force.calibration is None:
            yield BudgetEntry(ALONE, sd_N, "B", force.estimator)
            return
        freedom = _freedom(force.calibration)
        yield BudgetEntry(ALONE, sd_N, "A", said, freedom)


def _freedom(row: models.CalibrationVersion) -> float:
    return float(max(1, int(row.scores["n"]) - len(row.coefficients)))


def _shared(force: models.SensedForce, found: ReadingErrors) -> Iterator[BudgetEntry]:
    """Yield what a force shares with others, by what it is the error of."""
    stated = _stated(force)
    for key, sd_N in found.shared.items():
        of = stated.get(key)
        if of is not None:
            yield BudgetEntry(of.name, float(sd_N[0]), of.evaluation, of.source, of.freedom)
        elif not key.startswith((WEAR, LOT)):  # of the law, not of what read the force
            begins = next(one for one in _SENSED if key.startswith(one))
            yield _SENSED[begins](force, float(sd_N[0]))


def _stated(force: models.SensedForce) -> Mapping[str, ForceError]:
    """Return the errors of the dynamometer behind a force, by key."""
    recording = force.cut.recording.first_id
    found = [one for one in errors_of(force) if one.of is not None]
    if force.calibration is not None:
        found += as_calibration(force.calibration).reference_errors
    return {shared_key(one, recording): one for one in found}


def _coefficients(force: models.SensedForce, sd_N: float) -> BudgetEntry:
    assert force.calibration is not None
    said = stored_msgid("coefficients of calibration {number}").format(number=force.calibration.id)
    return BudgetEntry(CALIBRATED, sd_N, "A", said, _freedom(force.calibration))


def _references(force: models.SensedForce, sd_N: float) -> BudgetEntry:
    assert force.calibration is not None
    said = stored_msgid("reference forces that calibration {number} was made with").format(
        number=force.calibration.id
    )
    return BudgetEntry(TRANSFER, sd_N, "B", said)


def _day(_force: models.SensedForce, sd_N: float) -> BudgetEntry:
    return BudgetEntry(FROM_DAY_TO_DAY, sd_N, "A", stored_msgid("groups of cuts differ so"))


def _gain(force: models.SensedForce, sd_N: float) -> BudgetEntry:
    if force.calibration is not None:
        return BudgetEntry(DRIFTED, sd_N, "A", stored_msgid("pairs read otherwise since then"))
    return BudgetEntry(
        GAIN_OF_SENSOR,
        sd_N,
        "B",
        stored_msgid("gain of sensor {number}").format(number=force.estimator_id),
    )


def _edge(_force: models.SensedForce, sd_N: float) -> BudgetEntry:
    return BudgetEntry(WORN, sd_N, "A", stored_msgid("edges differ so"))


_SENSED: dict[str, Callable[[models.SensedForce, float], BudgetEntry]] = {
    CALIBRATION: _coefficients, REFERENCES: _references, DAY: _day, GAIN: _gain, EDGE: _edge,
}  # fmt: skip
"""What a key of an error that forces share begins with, and its contribution."""


def _of_none(force: models.SensedForce, known: list[BudgetEntry]) -> Iterator[BudgetEntry]:
    """Yield what a budget names in any case and this one has not, and why it has not."""
    names = [one.name for one in known]
    for name in PARTS:
        if not any(one.startswith(name) for one in names):
            yield BudgetEntry(name, None, "B", _why_none(names))
    if force.errors is not None:
        for name in (TRANSFER, SENSING):
            yield BudgetEntry(name, None, "B", stored_msgid("none: measured in the cut itself"))


def _why_none(names: list[str]) -> str:
    if any(name.startswith(WHOLE) for name in names):
        return stored_msgid("in the {what}").format(what=WHOLE)
    if TRANSFER in names:
        return stored_msgid("not stated beside the intervals of the reference forces")
    return stored_msgid("not stated")


def _process(found: ReadingErrors, version: models.CuttingParameters | None) -> BudgetEntry:
    if version is None:
        return BudgetEntry(
            PROCESS, None, "A", stored_msgid("not known: no version of the pair learnt it")
        )
    freedom = float(np.mean(as_posterior(version).scatter.weight))
    said = stored_msgid("scatter of the pair's cuts, parameters {number}").format(number=version.id)
    return BudgetEntry(PROCESS, float(found.process[0]), "A", said, freedom)
