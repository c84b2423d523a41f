"""Where a force came from: its calibration or sensor, the causes that corrected it, recordings."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.answer.budgets import budget_of_force
from autodb.agent.ingest.importing import time_sentences
from autodb.agent.rows.calibration_records import as_calibration
from autodb.agent.rows.mismatches import decided_words
from autodb.agent.rows.recordings import cuts_as_table
from autodb.agent.sense.measured import statement_of
from autodb.sensing.ranges.forms import stored_form
from autodb.sensing.ranges.sensed_force import left_domain
from autodb.store import models
from autodb.terms.vocabulary import statement_parts
from autodb.wording import (
    ENGLISH,
    amount_words,
    day,
    listed,
    localized,
    msgid,
    phrase,
    presentation,
)
from autodb.wording.kept import said_again

SENSED = msgid("sensed force {number}: force.{component} of cut {cut}: {what}")
MEASURED = msgid("measured force {number}: force.{component} of cut {cut}: {what}")


KINDS_OF_SENSOR = {
    "inspection": msgid("inspection"), "lstm": msgid("lstm"), "table": msgid("table"),
    "fusion": msgid("fusion"),
}  # fmt: skip
"""What senses forces beside a calibrated current."""


@dataclass
class Node:
    """One step of a trace: a sentence and what it came from."""

    text: str
    sources: list["Node"] = field(default_factory=list)


def recording_node(_session: Session, row: models.StoredRecording) -> Node:
    """Return a recording, and whether it counts."""
    path = Path(row.path)
    said = [
        phrase("time: {what}", what=said_again(one)) for one in time_sentences(row, but_even=True)
    ]
    said += [] if path.exists() else [phrase("the file is no longer there")]
    if row.withdrawn_at is not None:
        when = stored_day(row.withdrawn_at)
        said.append(phrase("withdrawn {day}: {why}", day=when, why=row.withdrawn_why))
    if row.looked_at is not None:
        said.append(phrase("only explained"))
    text = phrase(
        "recording {number}: {file}, {rows} rows, sha256 {sha256}",
        number=row.id, file=path.name, rows=row.rows, sha256=row.sha256[:12],
    )  # fmt: skip
    return Node(phrase("{what} ({more})", what=text, more=listed(said, "; ")) if said else text)


def stored_day(at: str) -> str:
    """Return a stored time for the reader; as it is stored for programs."""
    return at if presentation() == ENGLISH else day(at)


def calibration_node(session: Session, row: models.CalibrationVersion) -> Node:
    """Return a calibration with the recordings that it was made on."""
    form, coefficients = stored_form(row.kind, row.parameters), np.array(row.coefficients)
    text = phrase(
        "calibration {number}: axis {axis} version {version}: {equation}, I = {channel}; {verdict}",
        number=row.id, axis=as_calibration(row).called_words, version=row.version,
        equation=form.equation(coefficients, row.unit, row.current_unit), channel=row.channel,
        verdict=said_again(row.verdict),
    )  # fmt: skip
    node = Node(text, [recording_node(session, r) for r in row.recordings])
    causes = select(models.Mismatch).where(
        models.Mismatch.calibrations.any(models.CalibrationVersion.id == row.id)
    )
    for one in row.corrections or ():
        said = phrase(
            "divided by {factor} from recording {number} on",
            factor=localized(f"{one['factor']:.4g}"), number=one["recording"],
        )  # fmt: skip
        node.sources.append(Node(said, [cause_node(session, c) for c in session.scalars(causes)]))
    return node


def cause_node(session: Session, row: models.Mismatch) -> Node:
    """Return a mismatch with the recordings that it was found in."""
    other = row.confirmed_term if row.confirmed_term != row.term else None
    status = decided_words(row.status, other, row.decided_by)
    if row.decided_at:
        status = phrase("{decided} on {day}", decided=status, day=stored_day(row.decided_at))
    text = phrase(
        "mismatch {number}: {channel}: {term} ({kind}, {status}): {statement}",
        number=row.id, channel=row.channel, term=row.term, kind=phrase(row.kind), status=status,
        statement=_statement(row.statement),
    )  # fmt: skip
    return Node(text, [recording_node(session, one) for one in row.recordings])


def _statement(text: str) -> str:
    """Return what was stated of a cause: what its effect does, and how large it is."""
    does, *rest = statement_parts(text)
    return listed([*([phrase(does)] if does else []), *map(said_again, rest)], " ")


def force_node(session: Session, row: models.SensedForce) -> Node:
    """Return a sensed or measured force, its uncertainty budget and what sensed it."""
    what: str = said_again(str(row.reason))
    if row.value_N is not None:
        value, sd = newtons_words(row.value_N).partition(" ")[0], newtons_words(row.sd_N or 0.0)
        what = f"{value} ± {sd}"
    known = SENSED if row.errors is None else MEASURED
    text: str = phrase(
        known, number=row.id, component=row.component,
        cut=localized(f"{row.cut.number:g}"), what=what,
    )  # fmt: skip
    sources = [recording_node(session, row.cut.recording)]
    if row.errors is not None:
        sources.append(Node(origin_words(session, row)))
    if row.value_N is not None:
        budget = budget_of_force(session, row)
        sources.append(Node(budget.total(), [Node(line) for line in budget.lines()]))
    if row.calibration is not None:
        sources.append(calibration_node(session, row.calibration))
        text = _beyond(text, row, row.calibration)
    if row.sensor is not None:
        sources.append(sensor_node(session, row.sensor))
    return Node(text, sources)


def newtons_words(value_N: float) -> str:
    """Return newtons with one digit behind the mark, as programs have them; a shop's with three."""
    own = presentation().units.get("N")
    return amount_words(value_N, "N", ".1f" if own is None else ".3g")


def _beyond(text: str, row: models.SensedForce, by: models.CalibrationVersion) -> str:
    """Return a force with what of its cut its calibration was not made with, and what that adds."""
    if by.domain is None or not row.common or not row.common[-1]:
        return text
    table = cuts_as_table([row.cut], path=Path(row.cut.recording.path))
    _, said = left_domain(table, as_calibration(by))
    added = newtons_words(row.common[-1])
    return phrase("{force}, and ± {added} {why}", force=text, added=added, why=said_again(said))


def origin_words(session: Session, row: models.SensedForce) -> str:
    """Return where a measured force is from."""
    recording = row.cut.recording
    owner = session.get_one(models.Machine, recording.machine_id)
    words = statement_of(owner, recording).words
    return phrase("measured by or taken from: {words}", words=said_again(words))


def sensor_node(session: Session, row: models.Estimator) -> Node:
    """Return a sensor of forces that is no calibrated current, with its recordings."""
    kind = phrase(KINDS_OF_SENSOR.get(row.kind, row.kind))
    text = phrase(
        "sensor {number}: {kind} of force.{component}, version {version}",
        number=row.id, kind=kind, component=row.component, version=row.version,
    )  # fmt: skip
    return Node(text, [recording_node(session, r) for r in row.recordings])
