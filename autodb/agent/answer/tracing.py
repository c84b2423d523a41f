"""Trace: from a stored answer down to the recordings it came from."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.answer.budgets import budget_of_force
from autodb.agent.answer.notes import terms_words
from autodb.agent.ingest.importing import time_sentences
from autodb.agent.learn.shared_priors import RECORDINGS
from autodb.agent.matching.past_predictions import HISTORY, past_cuts
from autodb.agent.rows.calibration_records import as_calibration
from autodb.agent.rows.mismatches import decision_words
from autodb.agent.rows.posteriors import LAW, as_posterior, pair_name, version_chain
from autodb.agent.rows.recordings import cuts_as_table
from autodb.agent.sense.measured import statement_of
from autodb.cutting import shear
from autodb.errors import NotThere, near
from autodb.files.dynamometer import COMPONENTS
from autodb.fitting.gaussian import NORMAL_95
from autodb.forward.scored import Width
from autodb.sensing.ranges.forms import stored_form
from autodb.sensing.ranges.sensed_force import left_domain
from autodb.store import Store, models
from autodb.wording import significant

ARMAREGO = ("shear_stress", "friction_angle", "chip_ratio", "K_te", "K_re")
EARLIER_LAWS = {
    "linear_edge_nose": (("K_c", "N/mm²"), ("K_e", "N/mm"), ("K_n", "N")),
}


@dataclass
class Node:
    """One step of a trace: a sentence and what it came from."""

    text: str
    sources: list["Node"] = field(default_factory=list)


def trace(store: Store, kind: str, number: int) -> Node:
    """Return where row ``number`` of ``kind`` came from, down to recordings.

    Raises NotThere for an unknown kind or number.
    """
    if kind not in _KINDS:
        raise NotThere(f"nothing called '{kind}' is traced{near(kind, _KINDS)}")
    model, describe = _KINDS[kind]
    with store.reading() as session:
        row = session.get(model, number)
        if row is None:
            raise NotThere(f"there is no {kind} {number} in this database")
        return describe(session, row)


def _recording(_session: Session, row: models.StoredRecording) -> Node:
    path = Path(row.path)
    said = [f"time: {one}" for one in time_sentences(row, but_even=True)]
    said += [] if path.exists() else ["the file is no longer there"]
    if row.withdrawn_at is not None:
        said.append(f"withdrawn {row.withdrawn_at}: {row.withdrawn_why}")
    if row.looked_at is not None:
        said.append("only explained")
    more = f" ({'; '.join(said)})" if said else ""
    return Node(f"recording {row.id}: {path.name}, {row.rows} rows, sha256 {row.sha256[:12]}{more}")


def _calibration(session: Session, row: models.CalibrationVersion) -> Node:
    form, coefficients = stored_form(row.kind, row.parameters), np.array(row.coefficients)
    equation = form.equation(coefficients, row.unit, row.current_unit)
    said = f"{equation}, I = {row.channel}; {row.verdict}"
    text = f"calibration {row.id}: axis {as_calibration(row).called} version {row.version}: {said}"
    node = Node(text, [_recording(session, r) for r in row.recordings])
    causes = select(models.Mismatch).where(
        models.Mismatch.calibrations.any(models.CalibrationVersion.id == row.id)
    )
    for one in row.corrections or ():
        said = f"divided by {one['factor']:.4g} from recording {one['recording']} on"
        node.sources.append(Node(said, [_cause(session, c) for c in session.scalars(causes)]))
    return node


def _sensed(session: Session, row: models.SensedForce) -> Node:
    what = f"{row.value_N:.1f} ± {row.sd_N:.1f} N" if row.value_N is not None else str(row.reason)
    known = "sensed" if row.errors is None else "measured"
    text = f"{known} force {row.id}: force.{row.component} of cut {row.cut.number:g}: {what}"
    sources = [_recording(session, row.cut.recording)]
    if row.errors is not None:
        sources.append(Node(_origin(session, row)))
    if row.value_N is not None:
        budget = budget_of_force(session, row)
        sources.append(Node(budget.total(), [Node(line) for line in budget.lines()]))
    if row.calibration is not None:
        sources.append(_calibration(session, row.calibration))
        text += _beyond(row, row.calibration)
    if row.sensor is not None:
        sources.append(_sensor(session, row.sensor))
    return Node(text, sources)


def _beyond(row: models.SensedForce, by: models.CalibrationVersion) -> str:
    """Return what of a force's cut its calibration was not made with, and what that adds."""
    if by.domain is None or not row.common or not row.common[-1]:
        return ""
    table = cuts_as_table([row.cut], path=Path(row.cut.recording.path))
    _, said = left_domain(table, as_calibration(by))
    return f", and ± {row.common[-1]:.1f} N {said}"


def _origin(session: Session, row: models.SensedForce) -> str:
    """Return where a measured force is from."""
    recording = row.cut.recording
    owner = session.get_one(models.Machine, recording.machine_id)
    return f"measured by or taken from: {statement_of(owner, recording).words}"


def _budgets(session: Session, forces: list[models.SensedForce]) -> Iterator[Node]:
    """Yield the uncertainty of each component's median force, and where these forces are from."""
    for component in COMPONENTS:
        some = [force for force in forces if force.component == component]
        some.sort(key=lambda force: abs(force.value_N or 0.0))
        if some:
            middle = some[len(some) // 2]
            budget = budget_of_force(session, middle)
            yield Node(
                f"force.{component}: {budget.value:.1f} N, the median: {budget.total()}; 'autodb "
                f"trace force {middle.id}' lists the contributions"
            )
    measured = [force for force in forces if force.errors is not None]
    of_recording = {force.cut.recording_id: force for force in measured}
    for text in dict.fromkeys(_origin(session, one) for one in of_recording.values()):
        yield Node(text)


def _sensor(session: Session, row: models.Estimator) -> Node:
    text = f"sensor {row.id}: {row.kind} of force.{row.component}, version {row.version}"
    return Node(text, [_recording(session, r) for r in row.recordings])


def _parameters(session: Session, row: models.CuttingParameters) -> Node:
    node = Node(
        f"{_named(row)}, {row.n_cuts} cuts",
        [Node(_posterior(row) if row.law == LAW else _earlier_law(row))],
    )
    causes = [_cause(session, mismatch) for mismatch in row.mismatches]
    if row.state is not None:
        node.sources.append(Node(f"of the state '{row.state}'", causes))
    elif row.mismatches:
        held = [str(one.confirmed_term or one.term) for one in row.mismatches]
        said = "; ".join(terms_words(as_posterior(row), held))
        node.sources.append(Node(said or f"with {', '.join(held)}", causes))
    if row.started_from is not None:
        begun = [] if row.relative is None else [_parameters(session, row.relative)]
        begun += [
            Node(_named(session.get_one(models.CuttingParameters, number)))
            for number in (row.start or {}).get("others", ())
        ]
        begun += [] if row.prior is None else [_of_others(session, row.prior, row.machine_id)]
        node.sources.append(Node(f"began as: {row.started_from}", begun))
    forces = [force for version in version_chain(row) for force in version.forces]
    by_recording: dict[int, list[models.SensedForce]] = {}
    for force in forces:
        by_recording.setdefault(force.cut.recording_id, []).append(force)
    for some in by_recording.values():
        source = _recording(session, some[0].cut.recording)
        cuts = ", ".join(dict.fromkeys(f"{force.cut.number:g}" for force in some))
        source.sources.append(Node(f"cuts {cuts}"))
        node.sources.append(source)
    node.sources += _budgets(session, forces)
    sensed_by = {force.calibration.id: force.calibration for force in forces if force.calibration}
    node.sources += [_calibration(session, calibration) for calibration in sensed_by.values()]
    sensors = {force.sensor.id: force.sensor for force in forces if force.sensor}
    node.sources += [_sensor(session, sensor) for sensor in sensors.values()]
    return node


def _named(row: models.CuttingParameters) -> str:
    return f"parameters {row.id}: {pair_name(row.pair)}, version {row.version}"


def _posterior(row: models.CuttingParameters) -> str:
    """Return the five numbers of the law with their 95 % intervals."""
    law = as_posterior(row).law
    half = NORMAL_95 * np.sqrt(np.diag(law.covariance))
    low, middle, high = (shear.law_values(law.mean + step * half) for step in (-1.0, 0.0, 1.0))
    units = {one.name: one.unit for one in shear.PARAMETERS}
    return ", ".join(
        f"{name} {significant(middle[name])} ({significant(low[name])} to "
        f"{significant(high[name])}) {units[name]}".rstrip()
        for name in ARMAREGO
    )


def _earlier_law(row: models.CuttingParameters) -> str:
    """Return the numbers of a law that earlier versions kept for each operation and component."""
    sd = np.sqrt(np.diag(np.array(row.covariance)))
    values = ", ".join(
        f"{name} {mean:.1f} ± {one:.1f} {unit}"
        for (name, unit), mean, one in zip(EARLIER_LAWS[row.law], row.mean, sd, strict=True)
    )
    return f"{row.operation}, force.{row.component}: {values}"


def _prediction(session: Session, row: models.Prediction) -> Node:
    node = Node(f"prediction {row.id}: job '{row.job['name']}'")
    program = row.job.get("program")
    if program is not None:
        node.sources.append(Node(f"program {program['file']}, sha256 {program['sha256'][:12]}"))
    for cut in row.cuts:
        name = cut["name"] or f"{cut['speed_rpm']:.0f} rpm"
        for component in "xyz":
            force = cut[f"force_{component}_N"]
            if force is not None:
                interval = f"{force['value']:.0f} N ({force['low']:.0f} to {force['high']:.0f})"
                node.sources.append(Node(f"cut '{name}': force.{component} {interval}"))
    if row.started_from is not None:
        known = [] if row.prior is None else [_of_others(session, row.prior, row.machine_id)]
        node.sources.append(Node(f"the pair was not learnt: {row.started_from}", known))
    node.sources += [_parameters(session, p) for p in row.parameters]
    if row.width is not None:
        node.sources.append(_width(session, row))
    if row.made:
        node.sources.append(Node("then made", [_made(link) for link in row.made]))
    return node


def _width(session: Session, row: models.Prediction) -> Node:
    """The factor on a prediction's intervals comes from cuts that were predicted before it."""
    width = Width(**(row.width or {}))
    past = past_cuts(session, row.machine_id, most=HISTORY, upto=width.upto)
    alike = [one for one in past if one.learnt == (row.started_from is None) and one.scored]
    by_recording: dict[int, list[str]] = {}
    for one in alike:
        by_recording.setdefault(one.recording, []).append(f"{one.cut:g}")
    sources = []
    for number, cuts in by_recording.items():
        source = _recording(session, session.get_one(models.StoredRecording, number))
        source.sources.append(Node(f"cuts {', '.join(cuts)}"))
        sources.append(source)
    return Node(
        f"intervals × {width.factor:.2f}: {width.cuts} cuts of the pair and {width.others} of "
        "other pairs were off by more than predicted",
        sources,
    )


def _made(link: models.PredictedCutMade) -> Node:
    counts = "" if link.cut.superseded_at is None else ", which does not count any more"
    return Node(
        f"cut '{link.name}': cut {link.cut.number:g} of recording {link.cut.recording_id}, by "
        f"{link.matched_by}{counts}"
    )


def _of_others(session: Session, row: models.FleetPrior, machine_id: int) -> Node:
    """A prior comes from machines' parameters; of another than one's own no more is shown.

    But of one whose file shares its recordings.
    """
    node = Node(
        f"prior {row.id}: {row.material.name}, version {row.version}, {row.machines} machines"
    )
    for one in row.parameters:
        machine = session.get_one(models.Machine, one.machine_id)
        if one.machine_id == machine_id or machine.shares == RECORDINGS:
            node.sources.append(_parameters(session, one))
        else:
            node.sources.append(Node(f"machine '{machine.name}': {_named(one)}, {one.n_cuts} cuts"))
    return node


def _model(session: Session, row: models.ChannelModel) -> Node:
    """A version comes from its recordings, the mismatches confirmed, and the version before."""
    node = Node(
        f"{_version(row)}: {', '.join(_term(t) for t in row.terms)}",
        [_recording(session, r) for r in row.recordings],
    )
    confirmed = select(models.Mismatch).where(
        models.Mismatch.models.any(models.ChannelModel.id == row.id)
    )
    node.sources += [_cause(session, mismatch) for mismatch in session.scalars(confirmed)]
    if row.parent is not None:
        node.sources.append(_model(session, row.parent))
    return node


def _version(row: models.ChannelModel) -> str:
    return f"model {row.id}: {row.channel} version {row.version}"


def _term(t: dict[str, Any]) -> str:
    sure = "in the sum only" if t["sd"] is None else f"± {significant(t['sd'], 2)} {t['unit']}"
    return f"{t['term']} {t['value']:.4g} {sure}"


def _scale(session: Session, row: models.DriveScale) -> Node:
    percent = 100.0 * NORMAL_95 * row.share
    text = (
        f"scale {row.id}: {row.axis} version {row.version}: force constant {row.per_ampere:.4g} "
        f"N/A ± {percent:.2g} % (95 %), {row.source}"
    )
    return Node(text, [_recording(session, row.recording)])


def _cause(session: Session, row: models.Mismatch) -> Node:
    called = f" as {row.confirmed_term}" if row.confirmed_term not in (None, row.term) else ""
    by = f" by {row.decided_by}" if row.decided_by else ""
    when = f" on {row.decided_at}" if row.decided_at else ""
    status = f"{row.status}{called}{by}{when}"
    text = f"mismatch {row.id}: {row.channel}: {row.term} ({row.kind}, {status}): {row.statement}"
    return Node(text, [_recording(session, one) for one in row.recordings])


def _mismatch(session: Session, row: models.Mismatch) -> Node:
    """A mismatch leads to its recordings, to all decisions, and to the versions these made."""
    node = _cause(session, row)
    node.sources += [Node(decision_words(one)) for one in row.decisions]
    node.sources += [
        Node(f"confirmed, it made {_version(model)}{_back(model.undone_at)}")
        for model in row.models
    ]
    node.sources += [
        Node(f"confirmed, it corrected {_calibrated(one)}{_back(one.undone_at)}")
        for one in row.calibrations
    ]
    node.sources += [
        Node(f"confirmed, it is in {_named(one)}{_back(one.undone_at)}")
        for one in row.parameters_of_pairs
    ]
    return node


def _calibrated(row: models.CalibrationVersion) -> str:
    return f"calibration {row.id}: axis {row.axis} version {row.version}"


def _back(undone_at: str | None) -> str:
    return "" if undone_at is None else f", taken back on {undone_at}"


_KINDS: dict[str, tuple[type[models.Base], Callable[[Session, Any], Node]]] = {
    "prediction": (models.Prediction, _prediction),
    "parameters": (models.CuttingParameters, _parameters),
    "force": (models.SensedForce, _sensed),
    "calibration": (models.CalibrationVersion, _calibration),
    "model": (models.ChannelModel, _model),
    "scale": (models.DriveScale, _scale),
    "mismatch": (models.Mismatch, _mismatch),
    "recording": (models.StoredRecording, _recording),
}
