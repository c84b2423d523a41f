"""What an ampere of a feed drive is, told by a known load, and kept for the loads that follow.

A mass clamped on adds mass over motor constant to the inertia; a force beside the load, or a cut
whose force is known, gives newtons over the amperes it took.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.as_imported import signed
from autodb.agent.ingest.importing import import_file
from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.identifying import newest_model, refuse_faults, stored_terms, version_names
from autodb.agent.sense.reconstructing import Scale, drive_model, scale_of
from autodb.errors import UnusableInput
from autodb.files.channels import LINEAR_AXES
from autodb.fitting.gaussian import NORMAL_95
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.fit.axis_model import IdentifiedTerm
from autodb.sensing.drives.moves.prepared import effort_axis, effort_channel
from autodb.sensing.drives.reconstruct import DriveLoad, reconstruct
from autodb.sensing.drives.scales import ForceScale, by_force, by_step
from autodb.standard import ReferenceForce
from autodb.store import Store, models
from autodb.wording import localized, phrase, significant, stored_msgid

BY_MASS = stored_msgid("{mass} added {added} A·s²/mm of inertia")
BY_CUT = stored_msgid("standard cut {name}, force.{axis} {force}, {file}")
BY_FORCE = stored_msgid("force.{component} of {file}")
TONNE_KG = 1000.0
"""1 N s²/mm is a tonne."""
UNSURE = 0.25
"""Half width of the 95 % interval, as a share, above which a load tells nothing of use. Chosen."""
LOAD_HZ = 10.0
"""Bandwidth of the loads that a scale is told from."""


@dataclass(frozen=True)
class DeterminedScale:
    """Newtons an ampere of an axis, and its relative sd; which ``kind`` of load told, and how."""

    axis: str
    newtons_per_ampere: float
    share: float
    kind: str
    source: str

    @property
    def percent(self) -> float:
        """Half width of the 95 % interval, percent."""
        return 100.0 * NORMAL_95 * self.share


def by_mass(
    store: Store,
    machine: str,
    moves: Recording,
    *,
    mass_kg: float,
    axis: str | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> DeterminedScale:
    """Tell the scale from moves with ``mass_kg`` clamped on the axis.

    Without it the axis is as its newest version has it. Raises UnusableInput where there is none,
    where the effort is not in amperes, or where the mass does not show beyond its uncertainty.
    """
    with store.reading() as session:
        owner = find_machine(session, machine)
        row = _model_in_amperes(session, owner, moves, axis)
        own, name = signed(moves, owner), row.axis
        light, terms = _inertia(stored_terms(row)), version_names(row)
    refuse_faults(own, axis)
    progress("fitting")
    heavy = _inertia(identify(own, axis=axis, terms=terms).fitted)
    if light is None or heavy is None:
        raise UnusableInput(
            phrase(
                "{file}: the inertia of {name} is not known; make quicker moves, with rapids",
                file=moves.path,
                name=name,
            )
        )
    added = heavy.value - light.value
    sd = float(np.hypot(heavy.sd or 0.0, light.sd or 0.0))
    if added <= 0 or NORMAL_95 * sd > UNSURE * added:
        raise UnusableInput(
            phrase(
                "{file}: {mass} kg add {added} ± {sd} A·s²/mm to the inertia of {name}, too "
                "little to determine the force constant; use a larger mass or quicker moves",
                file=moves.path,
                mass=localized(f"{mass_kg:g}"),
                added=localized(f"{added:.2g}"),
                sd=localized(f"{NORMAL_95 * sd:.1g}"),
                name=name,
            )
        )
    source = BY_MASS.format(mass=f"{mass_kg:g} kg", added=f"{added:.3g}")
    return DeterminedScale(name, mass_kg / TONNE_KG / added, sd / added, "added-mass", source)


def by_measured_force(
    store: Store, machine: str, push: Recording, *, axis: str | None = None
) -> DeterminedScale:
    """Tell the scale from a recording with the force on the axis beside its current.

    A slow push against a load cell, or a cut on a dynamometer. Raises UnusableInput without a force
    or a model in amperes, or where the two do not go together.
    """
    load = _load(store, machine, push, axis)
    channel = f"force.{load.axis}"
    if channel not in push.channels:
        raise UnusableInput(
            phrase(
                "{file}: no known load; record '{channel}' beside the current, or use "
                "--added-mass KG or --standard-cut",
                file=push.path,
                channel=channel,
            )
        )
    found = by_force(load, push[channel], rate_hz=push.rate_hz)
    if found is None:
        raise UnusableInput(
            phrase(
                "{file}: {axis} hardly moves while {channel} changes, and at standstill "
                "friction may hold the load; push slowly for a second or longer",
                file=push.path,
                axis=load.axis,
                channel=channel,
            )
        )
    return _told(
        push, load, found, "force", BY_FORCE.format(component=load.axis, file=push.path.name)
    )


def by_standard_cut(
    store: Store,
    machine: str,
    cut: Recording,
    reference: Callable[[str], ReferenceForce],
    *,
    name: str,
    axis: str | None = None,
) -> DeterminedScale:
    """Tell the scale from a cut that begins in air; ``reference`` knows its mean force on an axis.

    ``name``: of the cut, for the record. Raises UnusableInput without a model in amperes, or where
    air and cut are not told apart.
    """
    load = _load(store, machine, cut, axis)
    known = reference(load.axis)
    share = (known.upper - known.lower) / (2.0 * NORMAL_95) / abs(known.value)
    found = by_step(load, known.value, share, rate_hz=cut.rate_hz)
    if found is None:
        raise UnusableInput(
            phrase(
                "{file}: the load on {axis} shows no cut after an air approach; start the "
                "recording in air, and use an axis that feeds",
                file=cut.path,
                axis=load.axis,
            )
        )
    source = BY_CUT.format(
        name=name, axis=load.axis, force=f"{known.value:g} N", file=cut.path.name
    )
    return _told(cut, load, found, "standard-cut", source)


@dataclass(frozen=True)
class KeptScale:
    """The version of an axis' scale, and whether the same load had told the same before."""

    version: int
    already_there: bool


def keep_scale(
    store: Store, machine: str, told: DeterminedScale, path: Path, *, columns: Path | None = None
) -> KeptScale:
    """Keep a scale as the next version of its axis', with the recording it is from, once."""
    recording_id = import_file(store, path, machine=machine, columns=columns).recording_id
    with store.writing(machine) as session:
        owner = find_machine(session, machine)
        own = models.DriveScale.machine_id == owner.id, models.DriveScale.axis == told.axis
        by_version = models.DriveScale.version.desc()
        newest = session.scalar(select(models.DriveScale).where(*own).order_by(by_version).limit(1))
        if newest is not None and _same(newest, told, recording_id):
            return KeptScale(newest.version, already_there=True)
        row = models.DriveScale(
            machine_id=owner.id,
            axis=told.axis,
            version=1 if newest is None else newest.version + 1,
            kind=told.kind,
            per_ampere=told.newtons_per_ampere,
            share=told.share,
            source=told.source,
            recording_id=recording_id,
        )
        session.add(row)
        return KeptScale(row.version, already_there=False)


def _same(row: models.DriveScale, told: DeterminedScale, recording_id: int) -> bool:
    """Say whether a version was told by the same load of the same recording, as much."""
    load = (row.recording_id, row.kind, row.source, row.per_ampere, row.share)
    return load == (recording_id, told.kind, told.source, told.newtons_per_ampere, told.share)


def stated(store: Store, machine: str, axis: str) -> Scale | None:
    """Return what the machine's file says an ampere of an axis is; None where it does not."""
    with store.reading() as session:
        owner = find_machine(session, machine)
        row = next((a for a in owner.axes if a.name == axis), None)
        return scale_of(row) if row else None


def _load(store: Store, machine: str, recording: Recording, axis: str | None) -> DriveLoad:
    with store.reading() as session:
        owner = find_machine(session, machine)
        model = drive_model(_model_in_amperes(session, owner, recording, axis))
        own = signed(recording, owner)
    return reconstruct(own, model, bandwidth_hz=min(LOAD_HZ, 0.25 * recording.rate_hz))


def _model_in_amperes(
    session: Session, owner: models.Machine, recording: Recording, axis: str | None
) -> models.ChannelModel:
    name, channel = effort_axis(recording, axis), effort_channel(recording, axis)
    if name not in LINEAR_AXES:
        raise UnusableInput(
            phrase("{file}: {name} is no feed axis; use x, y or z", file=recording.path, name=name)
        )
    row = newest_model(session, owner.id, channel)
    if row is None or recording.unit(channel) != "A":
        what = phrase("no version")
        if row is not None:
            what = phrase("nothing to scale: its effort is not in amperes")
        raise UnusableInput(
            phrase(
                "{file}: {channel} has {what}; identify {name} with --machine {owner} from "
                "moves in amperes without the load",
                file=recording.path,
                channel=channel,
                what=what,
                name=name,
                owner=owner.name,
            )
        )
    return row


def _told(
    recording: Recording, load: DriveLoad, found: ForceScale, kind: str, source: str
) -> DeterminedScale:
    if found.newtons_per_ampere < 0:
        raise UnusableInput(
            phrase(
                "{file}: the load on {axis} grows where the force should relieve it, so a sign "
                "is reversed; state the force of the work on the tool (side file: sign = -1)",
                file=recording.path,
                axis=load.axis,
            )
        )
    if NORMAL_95 * found.share > UNSURE:
        raise UnusableInput(
            phrase(
                "{file}: the force constant of {axis} is {newtons_per_ampere} N/A ± {share} %, "
                "too uncertain to use; apply a larger force, or apply it longer",
                file=recording.path,
                axis=load.axis,
                newtons_per_ampere=significant(found.newtons_per_ampere),
                share=localized(f"{100 * NORMAL_95 * found.share:.0f}"),
            )
        )
    return DeterminedScale(load.axis, found.newtons_per_ampere, found.share, kind, source)


def _inertia(terms: "list[IdentifiedTerm] | tuple[IdentifiedTerm, ...]") -> IdentifiedTerm | None:
    return next((t for t in terms if t.term == "inertia" and t.sd is not None), None)
