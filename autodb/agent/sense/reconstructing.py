"""Reconstruct the loads of a recording from its drives, with models identified from moves."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import pi

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.as_imported import signed
from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.identifying import newest_model, off_law_of, stored_terms
from autodb.errors import UnusableInput
from autodb.files.channels import ROTARY_AXES, axis_of, effort_channels
from autodb.fitting.gaussian import NORMAL_95
from autodb.records.tables import Recording
from autodb.sensing.drives.fit.axis_model import Identified
from autodb.sensing.drives.fit.drive_errors import DriveErrors
from autodb.sensing.drives.reconstruct import DriveLoad, DriveModel, observe, reconstruct
from autodb.store import Store, models
from autodb.wording import localized, phrase, stored_msgid
from autodb.wording.kept import said_again

Array = NDArray[np.float64]

LEAST_SHARE = 0.05
"""A torque constant of a data sheet is no surer than ± 5 %, 95 % (assumed)."""
MM_IN_M = 1000.0


@dataclass(frozen=True)
class Scale:
    """Newtons (newton metres of a rotary axis) an ampere; ``share``: its relative sd, which all
    samples share.
    """

    per_ampere: float
    unit: str
    share: float
    source: str


BY_GEAR = stored_msgid("torque constant {constant} N·m/A ({source}), gear {gear}")
BY_SCREW = stored_msgid("torque constant {constant} N·m/A ({source}), screw {pitch} mm")
NO_SOURCE = stored_msgid("no source")


@dataclass(frozen=True)
class ReconstructedLoad:
    """Load of one axis, with the model that it comes from and what made newtons of amperes.

    ``scale`` is None where the effort was in newtons, or nothing is known that makes it so: then
    the load stays in amperes. ``said``: of a sensor that is no drive, what is to be said of it;
    ``share``: relative sd of its gain, which all rows share; ``weight`` (n,): of several put
    together, by how much each made a row; ``disagrees``: which of them did not agree, in words.
    ``envelope_N`` (n,) each: lower and upper one of the force on the tool over a spindle's turn.
    """

    load: DriveLoad
    model: str
    scale: Scale | None
    said: str | None = None
    share: float = 0.0
    weight: Mapping[str, Array] = field(default_factory=dict)
    disagrees: str | None = None
    envelope_N: tuple[Array, Array] | None = None


def reconstruct_on_machine(
    store: Store,
    machine: str,
    recording: Recording,
    *,
    axis: str | None,
    bandwidth_hz: float,
    observer: bool,
    scale: Scale | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> list[ReconstructedLoad]:
    """Return the load of each axis that the recording has an effort and the machine a model of.

    ``scale`` replaces what the machine knows. Raises UnusableInput when there is no model.
    """
    with store.reading() as session:
        owner = find_machine(session, machine)
        own = signed(recording, owner)
        channels = efforts_of(recording, axis)
        sensed, without = [], []
        for channel in channels:
            row = newest_model(session, owner.id, channel)
            if row is None or row.errors is None:
                without.append(channel)
                continue
            progress(f"load of {row.axis}")
            stated = next((a for a in owner.axes if a.name == row.axis), None)
            said = phrase(
                "version {version} of machine '{machine}'", version=row.version, machine=machine
            )
            known = scale or (known_scale(session, stated) if stated else None)
            load = _load(own, drive_model(row), bandwidth_hz=bandwidth_hz, observer=observer)
            sensed.append(_sensed(load, said, known))
    if not sensed:
        raise UnusableInput(
            phrase(
                "{file}: machine '{machine}' has no model of {names}; make one with 'autodb "
                "identify MOVES --machine {machine}'",
                file=recording.path,
                machine=machine,
                names=", ".join(without),
            )
        )
    return sensed


def reconstruct_with(
    model: Identified,
    recording: Recording,
    *,
    moves: str,
    bandwidth_hz: float,
    observer: bool,
    scale: Scale | None = None,
) -> ReconstructedLoad:
    """Return the load of the axis that a model was identified of, from the file ``moves``."""
    if model.errors is None:
        raise UnusableInput(
            phrase(
                "{moves}: {axis} has no load to reconstruct; use an axis",
                moves=moves,
                axis=model.axis,
            )
        )
    load = _load(recording, DriveModel.of(model), bandwidth_hz=bandwidth_hz, observer=observer)
    return _sensed(load, phrase("identified from {file}", file=moves), scale)


def efforts_of(recording: Recording, axis: str | None = None) -> Sequence[str]:
    """Return the drives' efforts of an axis or all; raises UnusableInput where there is none."""
    found = [
        name
        for name in effort_channels(list(recording.channels))
        if axis is None or axis_of(name) == axis
    ]
    if not found:
        wanted = f"{axis or 'x'}.current"
        raise UnusableInput(
            phrase(
                "{file}: no drive effort{near}; record '{wanted}' or '{axis}.drive_force'",
                file=recording.path,
                near=recording.near(wanted),
                wanted=wanted,
                axis=axis or "x",
            )
        )
    return found


def _load(
    recording: Recording, model: DriveModel, *, bandwidth_hz: float, observer: bool
) -> DriveLoad:
    if bandwidth_hz > 0.25 * recording.timing.rate_hz:
        raise UnusableInput(
            phrase(
                "--bandwidth: {bandwidth} Hz is too much for {file} at {rate} Hz; use up to "
                "{rate_2} Hz",
                bandwidth=localized(f"{bandwidth_hz:g}"),
                file=recording.path,
                rate=localized(f"{recording.timing.rate_hz:g}"),
                rate_2=localized(f"{0.25 * recording.timing.rate_hz:g}"),
            )
        )
    how = observe if observer else reconstruct
    return how(recording, model, bandwidth_hz=bandwidth_hz)


def _sensed(load: DriveLoad, model: str, scale: Scale | None) -> ReconstructedLoad:
    if scale is None or load.unit != "A":
        return ReconstructedLoad(load, model, None)
    return ReconstructedLoad(
        load.scaled(scale.per_ampere, scale.unit), model, scale, share=scale.share
    )


def drive_model(row: models.ChannelModel) -> DriveModel:
    """Return a stored version, whose errors were counted, as the record that sensing takes."""
    return DriveModel(
        axis=row.axis,
        channel=row.channel,
        unit=row.unit,
        terms=stored_terms(row),
        covariance=np.array(row.covariance),
        errors=DriveErrors.of(row.errors or {}),
        off_law=off_law_of(row),
    )


def newest_scale(session: Session, machine_id: int, axis: str) -> models.DriveScale | None:
    """Return the newest scale that a known load told of an axis and that still holds, or None."""
    return session.scalar(
        select(models.DriveScale)
        .where(
            models.DriveScale.machine_id == machine_id,
            models.DriveScale.axis == axis,
            models.DriveScale.undone_at.is_(None),
        )
        .order_by(models.DriveScale.version.desc())
        .limit(1)
    )


def known_scale(session: Session, axis: models.Axis) -> Scale | None:
    """Return what an ampere of an axis is, by its newest known load or its machine's file: the
    surer of both; None where neither tells.
    """
    row, stated = newest_scale(session, axis.machine_id, axis.name), scale_of(axis)
    if row is None:
        return stated
    told = Scale(
        row.per_ampere,
        "N",
        row.share,
        phrase("scale {version}: {source}", version=row.version, source=said_again(row.source)),
    )
    return told if stated is None or told.share < stated.share else stated


def scale_of(axis: models.Axis) -> Scale | None:
    """Return newtons an ampere by torque constant, gear and screw; None where one is not stated.

    Of a rotary axis newton metres, by constant and gear. Efficiency is not in it: it is part of
    what the bounds must hold.
    """
    constant, pitch_mm = axis.torque_constant_N_m_A, axis.screw_pitch_mm
    rotary = axis.name in ROTARY_AXES
    if constant is None or (pitch_mm is None and not rotary):
        return None
    low, high = axis.torque_constant_lower or constant, axis.torque_constant_upper or constant
    share = max(0.5 * (high - low) / constant, LEAST_SHARE) / NORMAL_95
    gear = axis.gear_ratio or 1.0
    of = axis.torque_constant_source or NO_SOURCE
    said = {"constant": localized(f"{constant:g}"), "source": said_again(of)}
    if pitch_mm is None or rotary:
        return Scale(constant * gear, "N·m", share, phrase(BY_GEAR, **said, gear=f"{gear:g}"))
    per_ampere = constant * 2.0 * pi * gear * MM_IN_M / pitch_mm
    return Scale(per_ampere, "N", share, phrase(BY_SCREW, **said, pitch=f"{pitch_mm:g}"))
