"""What a machine can feel: every force sensor it has, how near it comes, and since when."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.calibrations import current_calibrations
from autodb.agent.rows.estimators import FUSION, newest
from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.dynamometers import KIND as DYNAMOMETER
from autodb.agent.sense.identifying import newest_model
from autodb.agent.sense.inspecting import KIND as INSPECTION
from autodb.agent.sense.networks import KIND as LSTM
from autodb.agent.sense.reconstructing import known_scale
from autodb.files.channels import LINEAR_AXES
from autodb.sensing.fusion import DRIVE, NETWORK, TABLE
from autodb.sensing.ranges.points import COMPONENT_OF_AXIS
from autodb.store import models
from autodb.wording import amount_words, listed, msgid, phrase, phrase_many

OF_IT = msgid("of it")
"""Unit of an error that is a share of what is sensed."""
RANGE, INSPECTED, TOGETHER = msgid("current range"), msgid("finished part"), msgid("together")


@dataclass(frozen=True)
class Sensor:
    """A sensor of a force: what it is, its version, its error in ``unit`` and of what, since when.

    ``why_not``: why it is not used, None where it is.
    """

    force: str
    kind: str
    source: str
    version: int
    error: float | None
    unit: str
    of: str
    since: str
    why_not: str | None = None


def sensors_of(session: Session, machine: str) -> tuple[list[Sensor], list[str]]:
    """Return the sensors of a machine, by force, and the forces that nothing feels.

    Raises UnusableInput for a machine that is not there.
    """
    owner = find_machine(session, machine)
    found = [
        *_ranges(session, owner),
        *_drives(session, owner),
        *_others(session, owner),
    ]
    found.sort(key=lambda one: one.force)
    sensed = {one.force for one in found if one.why_not is None}
    return found, [f"force.{c}" for c in "xyz" if f"force.{c}" not in sensed]


def _ranges(session: Session, owner: models.Machine) -> Iterator[Sensor]:
    for axis in COMPONENT_OF_AXIS:
        for row in current_calibrations(session, owner.id, axis):
            yield Sensor(
                force=f"force.{row.component}",
                kind=RANGE,
                source=row.channel,
                version=row.version,
                error=row.scores["rmse"],
                unit=row.unit,
                of=msgid("held-out cuts"),
                since=row.created_at,
                why_not=None if row.offered else row.verdict,
            )


def _drives(session: Session, owner: models.Machine) -> Iterator[Sensor]:
    channels = session.scalars(
        select(models.ChannelModel.channel)
        .where(models.ChannelModel.machine_id == owner.id)
        .distinct()
    )
    axes = {axis.name: axis for axis in owner.axes}
    for channel in sorted(channels):
        row = newest_model(session, owner.id, channel)
        if row is None or row.errors is None or row.axis not in LINEAR_AXES:
            continue
        scale = known_scale(session, axes[row.axis]) if row.axis in axes else None
        newtons = 1.0 if row.unit == "N" else None if scale is None else scale.per_ampere
        worst = max(max(one) for one in row.errors["rms"])
        yield Sensor(
            force=f"force.{row.axis}",
            kind=DRIVE,
            source=row.channel,
            version=row.version,
            error=worst * (newtons or 1.0),
            unit=row.unit if newtons is None else "N",
            of=msgid("held-out moves in air, the worst"),
            since=row.created_at,
            why_not=None if newtons else phrase("its force constant (N/A) is not known"),
        )


def _others(session: Session, owner: models.Machine) -> Iterator[Sensor]:
    """Give what senses forces over time beside drive models, and all of it together."""
    for row in newest(session, owner.id, LSTM):
        air = (row.normalisation or {}).get("on_air")
        of = msgid("held-out moves in air") if air else msgid("held-out recordings")
        yield _over_time(row, NETWORK, _recordings(row), of)
    for row in newest(session, owner.id, DYNAMOMETER):
        yield _over_time(row, TABLE, _recordings(row), msgid("moves in air"))
    for row in newest(session, owner.id, INSPECTION):
        bar = (row.model or {})["bar"]
        source = phrase(
            "a bar of {diameter}, {length} free",
            diameter=amount_words(bar["diameter_mm"], "mm"),
            length=amount_words(bar["length_mm"], "mm"),
        )
        yield replace(_over_time(row, INSPECTED, source, msgid("its stiffness alone")), unit=OF_IT)
    for row in newest(session, owner.id, FUSION):
        names = listed(map(phrase, (row.model or {})["names"]), phrase(" and "))
        yield _over_time(row, TOGETHER, names, msgid("held-out recordings"))


def _recordings(row: models.Estimator) -> str:
    count = len(row.recordings)
    return phrase_many("{count} recording", "{count} recordings", count)


def _over_time(row: models.Estimator, kind: str, source: str, of: str) -> Sensor:
    return Sensor(
        force=f"force.{row.component}",
        kind=kind,
        source=source,
        version=row.version,
        error=row.scores.get("rmse_N", row.scores.get("share")),
        unit="N",
        of=of,
        since=row.since,
    )
