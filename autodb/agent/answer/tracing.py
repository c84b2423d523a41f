"""Trace: from a stored answer down to the recordings it came from."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.answer.budgets import budget_of_force
from autodb.agent.answer.notes import terms_words
from autodb.agent.answer.traced_forces import (
    Node,
    calibration_node,
    cause_node,
    force_node,
    newtons_words,
    origin_words,
    recording_node,
    sensor_node,
    stored_day,
)
from autodb.agent.learn.shared_priors import RECORDINGS
from autodb.agent.matching.past_predictions import past_cuts
from autodb.agent.rows.mismatches import decision_words
from autodb.agent.rows.posteriors import LAW, as_posterior, pair_name, version_chain
from autodb.cutting import shear
from autodb.errors import NotThere, near_words
from autodb.files.dynamometer import COMPONENTS
from autodb.fitting.gaussian import NORMAL_95
from autodb.forward.scored import Width
from autodb.store import Store, models
from autodb.wording import (
    listed,
    localized,
    msgid,
    phrase,
    shop_amount,
    significant,
)
from autodb.wording.kept import said_again

ARMAREGO = ("shear_stress", "friction_angle", "chip_ratio", "K_te", "K_re")
EARLIER_LAWS = {
    "linear_edge_nose": (("K_c", "N/mm²"), ("K_e", "N/mm"), ("K_n", "N")),
}


ENDS = ("value", "low", "high")
MATCHED_BY = {"name": msgid("name"), "conditions": msgid("conditions"), "stated": msgid("stated")}
"""What a cut is known by to be the one that was predicted."""
MADE = msgid("cut '{name}': cut {cut} of recording {number}, by {by}")
MADE_ONCE = msgid(
    "cut '{name}': cut {cut} of recording {number}, by {by}, which does not count any more"
)


def trace(store: Store, kind: str, number: int) -> Node:
    """Return where row ``number`` of ``kind`` came from, down to recordings.

    Raises NotThere for an unknown kind or number.
    """
    if kind not in _KINDS:
        raise NotThere(
            phrase(
                "nothing called '{kind}' is traced{hint}", kind=kind, hint=near_words(kind, _KINDS)
            )
        )
    model, describe = _KINDS[kind]
    with store.reading() as session:
        row = session.get(model, number)
        if row is None:
            raise NotThere(
                phrase("there is no {kind} {number} in this database", kind=kind, number=number)
            )
        return describe(session, row)


def _budgets(session: Session, forces: list[models.SensedForce]) -> Iterator[Node]:
    """Yield the uncertainty of each component's median force, and where these forces are from."""
    for component in COMPONENTS:
        some = [force for force in forces if force.component == component]
        some.sort(key=lambda force: abs(force.value_N or 0.0))
        if some:
            middle = some[len(some) // 2]
            budget = budget_of_force(session, middle)
            yield Node(
                phrase(
                    "force.{component}: {value}, the median: {total}; 'autodb trace force "
                    "{number}' lists the contributions",
                    component=component,
                    value=newtons_words(budget.value),
                    total=budget.total(),
                    number=middle.id,
                )
            )
    measured = [force for force in forces if force.errors is not None]
    of_recording = {force.cut.recording_id: force for force in measured}
    for text in dict.fromkeys(origin_words(session, one) for one in of_recording.values()):
        yield Node(text)


def _parameters(session: Session, row: models.CuttingParameters) -> Node:
    node = Node(
        phrase("{parameters}, {count} cuts", parameters=_named(row), count=row.n_cuts),
        [Node(_posterior(row) if row.law == LAW else _earlier_law(row))],
    )
    causes = [cause_node(session, mismatch) for mismatch in row.mismatches]
    if row.state is not None:
        node.sources.append(Node(phrase("of the state '{state}'", state=row.state), causes))
    elif row.mismatches:
        held = [str(one.confirmed_term or one.term) for one in row.mismatches]
        said = listed(map(said_again, terms_words(as_posterior(row), held)), "; ")
        node.sources.append(Node(said or phrase("with {terms}", terms=", ".join(held)), causes))
    if row.started_from is not None:
        begun = [] if row.relative is None else [_parameters(session, row.relative)]
        begun += [
            Node(_named(session.get_one(models.CuttingParameters, number)))
            for number in (row.start or {}).get("others", ())
        ]
        begun += [] if row.prior is None else [_of_others(session, row.prior, row.machine_id)]
        began = phrase("began as: {what}", what=said_again(row.started_from))
        node.sources.append(Node(began, begun))
    forces = [force for version in version_chain(row) for force in version.forces]
    by_recording: dict[int, list[models.SensedForce]] = {}
    for force in forces:
        by_recording.setdefault(force.cut.recording_id, []).append(force)
    for some in by_recording.values():
        source = recording_node(session, some[0].cut.recording)
        cuts = ", ".join(dict.fromkeys(f"{force.cut.number:g}" for force in some))
        source.sources.append(Node(phrase("cuts {cuts}", cuts=cuts)))
        node.sources.append(source)
    node.sources += _budgets(session, forces)
    sensed_by = {force.calibration.id: force.calibration for force in forces if force.calibration}
    node.sources += [calibration_node(session, calibration) for calibration in sensed_by.values()]
    sensors = {force.sensor.id: force.sensor for force in forces if force.sensor}
    node.sources += [sensor_node(session, sensor) for sensor in sensors.values()]
    return node


def _named(row: models.CuttingParameters) -> str:
    return phrase(
        "parameters {number}: {pair}, version {version}",
        number=row.id, pair=pair_name(row.pair), version=row.version
    )  # fmt: skip


def _posterior(row: models.CuttingParameters) -> str:
    """Return the five numbers of the law with their 95 % intervals."""
    law = as_posterior(row).law
    half = NORMAL_95 * np.sqrt(np.diag(law.covariance))
    low, middle, high = (shear.law_values(law.mean + step * half) for step in (-1.0, 0.0, 1.0))
    units = {one.name: one.unit for one in shear.PARAMETERS}
    said = []
    for name in ARMAREGO:
        scale, unit = shop_amount(1.0, units[name])
        three = (localized(significant(scale * at[name])) for at in (middle, low, high))
        interval = phrase("{value} ({low} to {high})", **dict(zip(ENDS, three, strict=True)))
        said.append(f"{name} {interval} {unit}".rstrip())
    return ", ".join(said)


def _earlier_law(row: models.CuttingParameters) -> str:
    """Return the numbers of a law that earlier versions kept for each operation and component."""
    sd = np.sqrt(np.diag(np.array(row.covariance)))
    values = ", ".join(
        f"{name} {localized(f'{mean:.1f}')} ± {localized(f'{one:.1f}')} {unit}"
        for (name, unit), mean, one in zip(EARLIER_LAWS[row.law], row.mean, sd, strict=True)
    )
    return f"{row.operation}, force.{row.component}: {values}"


def _prediction(session: Session, row: models.Prediction) -> Node:
    node = Node(phrase("prediction {number}: job '{job}'", number=row.id, job=row.job["name"]))
    program = row.job.get("program")
    if program is not None:
        sha256 = program["sha256"][:12]
        said = phrase("program {file}, sha256 {sha256}", file=program["file"], sha256=sha256)
        node.sources.append(Node(said))
    node.sources += [Node(line) for cut in row.cuts for line in _predicted_forces(cut)]
    if row.started_from is not None:
        known = [] if row.prior is None else [_of_others(session, row.prior, row.machine_id)]
        said = phrase("the pair was not learnt: {what}", what=said_again(row.started_from))
        node.sources.append(Node(said, known))
    node.sources += [_parameters(session, p) for p in row.parameters]
    if row.width is not None:
        node.sources.append(_width(session, row))
    if row.made:
        node.sources.append(Node(phrase("then made"), [_made(link) for link in row.made]))
    return node


def _predicted_forces(cut: dict[str, Any]) -> Iterator[str]:
    """Yield the forces of a cut that was predicted, each with its interval."""
    scale, unit = shop_amount(1.0, "N")
    digits = 0 if scale == 1.0 else 1
    name = cut["name"] or phrase("{speed} rpm", speed=localized(f"{cut['speed_rpm']:.0f}"))
    for component in COMPONENTS:
        force = cut[f"force_{component}_N"]
        if force is not None:
            three = {end: localized(f"{scale * force[end]:.{digits}f}") for end in ENDS}
            yield phrase(
                "cut '{name}': force.{component} {value} {unit} ({low} to {high})",
                name=name, component=component, unit=unit, **three
            )  # fmt: skip


def _width(session: Session, row: models.Prediction) -> Node:
    """The factor on a prediction's intervals comes from cuts that were predicted before it."""
    width = Width(**(row.width or {}))
    past = past_cuts(session, row.machine_id, newest=True, upto=width.upto)
    alike = [one for one in past if one.learnt == (row.started_from is None) and one.scored]
    by_recording: dict[int, list[str]] = {}
    for one in alike:
        by_recording.setdefault(one.recording, []).append(f"{one.cut:g}")
    sources = []
    for number, cuts in by_recording.items():
        source = recording_node(session, session.get_one(models.StoredRecording, number))
        source.sources.append(Node(phrase("cuts {cuts}", cuts=", ".join(cuts))))
        sources.append(source)
    return Node(
        phrase(
            "intervals × {factor}: {cuts} cuts of the pair and {others} of other pairs "
            "were off by more than predicted",
            factor=localized(f"{width.factor:.2f}"),
            cuts=width.cuts,
            others=width.others,
        ),
        sources,
    )


def _made(link: models.PredictedCutMade) -> Node:
    sentence = MADE if link.cut.superseded_at is None else MADE_ONCE
    return Node(
        phrase(
            sentence, name=link.name, cut=localized(f"{link.cut.number:g}"),
            number=link.cut.recording_id, by=phrase(MATCHED_BY[link.matched_by])
        )
    )  # fmt: skip


def _of_others(session: Session, row: models.FleetPrior, machine_id: int) -> Node:
    """A prior comes from machines' parameters; of another than one's own no more is shown.

    But of one whose file shares its recordings.
    """
    node = Node(
        phrase(
            "prior {number}: {material}, version {version}, {machines} machines",
            number=row.id, material=row.material.name, version=row.version, machines=row.machines
        )
    )  # fmt: skip
    for one in row.parameters:
        machine = session.get_one(models.Machine, one.machine_id)
        if one.machine_id == machine_id or machine.shares == RECORDINGS:
            node.sources.append(_parameters(session, one))
        else:
            said = phrase(
                "machine '{machine}': {parameters}, {count} cuts",
                machine=machine.name, parameters=_named(one), count=one.n_cuts
            )  # fmt: skip
            node.sources.append(Node(said))
    return node


def _model(session: Session, row: models.ChannelModel) -> Node:
    """A version comes from its recordings, the mismatches confirmed, and the version before."""
    node = Node(
        phrase("{model}: {terms}", model=_version(row), terms=listed(map(_term, row.terms))),
        [recording_node(session, r) for r in row.recordings],
    )
    confirmed = select(models.Mismatch).where(
        models.Mismatch.models.any(models.ChannelModel.id == row.id)
    )
    node.sources += [cause_node(session, mismatch) for mismatch in session.scalars(confirmed)]
    if row.parent is not None:
        node.sources.append(_model(session, row.parent))
    return node


def _version(row: models.ChannelModel) -> str:
    return phrase(
        "model {number}: {channel} version {version}",
        number=row.id, channel=row.channel, version=row.version
    )  # fmt: skip


def _term(t: dict[str, Any]) -> str:
    value = localized(f"{t['value']:.4g}")
    if t["sd"] is None:
        return phrase("{term} {value} in the sum only", term=t["term"], value=value)
    return f"{t['term']} {value} ± {localized(significant(t['sd'], 2))} {t['unit']}"


def _scale(session: Session, row: models.DriveScale) -> Node:
    percent = 100.0 * NORMAL_95 * row.share
    text = phrase(
        "scale {number}: {axis} version {version}: force constant {per_ampere} N/A ± "
        "{percent} % (95 %), {source}",
        number=row.id, axis=row.axis, version=row.version,
        per_ampere=localized(f"{row.per_ampere:.4g}"), percent=localized(f"{percent:.2g}"),
        source=said_again(row.source)
    )  # fmt: skip
    return Node(text, [recording_node(session, row.recording)])


def _mismatch(session: Session, row: models.Mismatch) -> Node:
    """A mismatch leads to its recordings, to all decisions, and to the versions these made."""
    node = cause_node(session, row)
    node.sources += [Node(decision_words(one)) for one in row.decisions]
    for model in row.models:
        said = phrase("confirmed, it made {what}", what=_version(model))
        node.sources.append(Node(_or_back(said, model.undone_at)))
    for one in row.calibrations:
        said = phrase(
            "confirmed, it corrected calibration {number}: axis {axis} version {version}",
            number=one.id, axis=one.axis, version=one.version
        )  # fmt: skip
        node.sources.append(Node(_or_back(said, one.undone_at)))
    for held in row.parameters_of_pairs:
        said = phrase("confirmed, it is in {what}", what=_named(held))
        node.sources.append(Node(_or_back(said, held.undone_at)))
    return node


def _or_back(said: str, undone_at: str | None) -> str:
    if undone_at is None:
        return said
    return phrase("{said}, taken back on {day}", said=said, day=stored_day(undone_at))


_KINDS: dict[str, tuple[type[models.Base], Callable[[Session, Any], Node]]] = {
    "prediction": (models.Prediction, _prediction),
    "parameters": (models.CuttingParameters, _parameters),
    "force": (models.SensedForce, force_node),
    "calibration": (models.CalibrationVersion, calibration_node),
    "model": (models.ChannelModel, _model),
    "scale": (models.DriveScale, _scale),
    "mismatch": (models.Mismatch, _mismatch),
    "recording": (models.StoredRecording, recording_node),
}
