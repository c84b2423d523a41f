"""A machine's network: trained on its own recordings with known forces, kept, and used."""

import base64
import hashlib
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from sqlalchemy.orm import Session

from autodb.agent.ingest.as_imported import signed
from autodb.agent.ingest.importing import import_file
from autodb.agent.rows.estimators import (
    FUSION,
    FittedComponent,
    is_learnt_from,
    keep_estimator,
    newest,
)
from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.dynamometers import table_on_machine, told_on_table
from autodb.agent.sense.identifying import newest_model
from autodb.agent.sense.reconstructing import (
    ReconstructedLoad,
    drive_model,
    efforts_of,
    known_scale,
)
from autodb.errors import UnusableInput
from autodb.files.channels import LINEAR_AXES, axis_of
from autodb.records import source as records
from autodb.records.tables import Recording
from autodb.sensing.drives.reconstruct import reconstruct
from autodb.sensing.network import need_torch
from autodb.store import Store, models
from autodb.wording import phrase

if TYPE_CHECKING:
    from autodb.sensing.network.beside import NetworkBeside
    from autodb.sensing.network.drive_loads import LoadedDrive
    from autodb.sensing.network.recordings import ComponentErrors

Array = NDArray[np.float64]

KIND = "lstm"

SLOWEST = 0.25
"""Share of the rate up to which loads are reconstructed."""
TRAINED_SHARE = 0.01
"""Relative sd of the gain of the dynamometer that a network was trained on. Chosen."""


@dataclass(frozen=True)
class Trained:
    """A version of a machine's network; ``on_air``: no force was known, moves in air were."""

    version: int
    recordings: int
    on_air: bool
    scores: "tuple[ComponentErrors, ...]"
    already_there: bool


def train_network(
    store: Store,
    machine: str,
    files: Sequence[Path],
    *,
    columns: Path | None = None,
    folder: Path | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Trained:
    """Train a network on recordings of a machine's drives with the forces that were known.

    Where none has a force they are taken as moves in air. Forces of a table dynamometer that the
    machine has are those on the tool, in machine axes, where angles of the table were recorded. The
    recordings are imported; the same ones again are said to be there already. ``folder``: where
    training is kept, so that it goes on after a kill.

    Raises UnusableInput without PyTorch, without drive models or newtons an ampere, and where
    recordings differ in channels or rate.
    """
    need_torch()
    from autodb.sensing.network import learning
    from autodb.sensing.network.beside import networks_beside
    from autodb.sensing.network.kept import to_bytes
    from autodb.sensing.network.network import device
    from autodb.sensing.network.recordings import pieces_with_forces, rate_of, scored_components

    recordings = [_read(path, columns) for path in files]
    with store.reading() as session:
        owner = find_machine(session, machine)
        own = [_in_machine_axes(session, owner, signed(one, owner)) for one in recordings]
        drives = _drives(session, owner, own[0])
    rate_hz = rate_of(own)
    known, on_air = pieces_with_forces(own, drives)
    ids = _imported(store, machine, files, columns)
    with store.reading() as session:
        old = _same(session, machine, ids)
    if old is not None:
        return old
    plan = learning.plan_of(known)
    box = learning.train_grey_box(
        known, drives, rate_hz=rate_hz, plan=plan, folder=folder, device=device(),
        progress=lambda member, epoch, _: progress(
            f"network {member + 1} of {learning.MEMBERS}, epoch {epoch} of {plan.epochs}"
        ),
    )  # fmt: skip
    scores = scored_components(box, drives, known)
    progress("network and drive models together")
    both = networks_beside(box, drives, known)
    with store.writing(machine) as session:
        old = _same(session, machine, ids)
        if old is not None:  # another has trained it meanwhile
            return old
        rows = [session.get_one(models.StoredRecording, one) for one in dict.fromkeys(ids)]
        content = to_bytes(box, [row.sha256 for row in rows])
        version = _keep(session, machine, rows, content, scores)
        _keep_fusion(session, machine, both, rows)
    if folder is not None:
        shutil.rmtree(folder, ignore_errors=True)
    return Trained(version, len(files), on_air, scores, already_there=False)


def _imported(store: Store, machine: str, files: Sequence[Path], columns: Path | None) -> list[int]:
    """Import recordings, and return the number of each in the database."""
    return [
        import_file(store, path, machine=machine, columns=columns).recording_id for path in files
    ]


def _keep_fusion(
    session: Session,
    machine: str,
    both: "Mapping[str, NetworkBeside]",
    rows: Sequence[models.StoredRecording],
) -> None:
    """Keep how network and drive models go together, by component."""
    fitted = {c: FittedComponent(o.fusion.to_json(), {"rmse_N": o.rmse_N}) for c, o in both.items()}
    keep_estimator(session, find_machine(session, machine).id, FUSION, fitted, rows)


def _read(path: Path, columns: Path | None) -> Recording:
    found = records.read(path, columns=columns)
    if not isinstance(found, Recording):
        raise UnusableInput(
            phrase("{file}: a table of cuts; a network needs drives over time", file=path)
        )
    return found


def _in_machine_axes(session: Session, owner: models.Machine, recording: Recording) -> Recording:
    """Return a recording whose forces, read on a table that turns, are those on the tool."""
    known = table_on_machine(session, owner)
    angles = [f"{axis}.angle" for axis in known[0].kinematics.order] if known else []
    if known is None or not set(angles) <= set(recording.channels):
        return recording
    told = told_on_table(known[0], recording)
    forces = {f"force.{c}": told.force_N[k] for k, c in enumerate("xyz")}
    return replace(recording, channels={**recording.channels, **forces})


def _drives(
    session: Session, owner: models.Machine, recording: Recording
) -> "dict[str, LoadedDrive]":
    """Return the drive of each axis that the recording has an effort and the machine a model of."""
    from autodb.sensing.network.drive_loads import LoadedDrive

    found: dict[str, LoadedDrive] = {}
    axes = {axis.name: axis for axis in owner.axes}
    for channel in efforts_of(recording):
        name = axis_of(channel)
        row = newest_model(session, owner.id, channel)
        if name not in LINEAR_AXES or row is None or row.errors is None:
            continue
        scale = known_scale(session, axes[name]) if name in axes else None
        if row.unit == "A" and scale is None:
            raise UnusableInput(
                phrase(
                    "{file}: the force constant (N/A) of {name} is not known; run 'autodb scale' "
                    "with a known load, or state torque_constant_N_m_A in the machine's file",
                    file=recording.path,
                    name=name,
                )
            )
        found[name] = LoadedDrive(
            drive_model(row), scale.per_ampere if row.unit == "A" and scale else 1.0
        )
    if not found:
        raise UnusableInput(
            phrase(
                "{file}: machine '{owner}' has no model of its axes; make one with 'autodb "
                "identify MOVES --machine {owner}'",
                file=recording.path,
                owner=owner.name,
            )
        )
    return found


def _same(session: Session, machine: str, ids: Sequence[int]) -> Trained | None:
    """Return the newest version where it was trained on the same recordings."""
    rows = newest(session, find_machine(session, machine).id, KIND)
    if not is_learnt_from(rows, ids):
        return None
    from autodb.sensing.network.recordings import ComponentErrors

    scores = tuple(ComponentErrors(**row.scores) for row in rows)
    on_air = bool((rows[0].normalisation or {}).get("on_air"))
    return Trained(rows[0].version, len(ids), on_air, scores, already_there=True)


def _keep(
    session: Session,
    machine: str,
    rows: Sequence[models.StoredRecording],
    content: bytes,
    scores: "Sequence[ComponentErrors]",
) -> int:
    """Add a version: a row a component, the networks in the first."""
    from autodb.sensing.network.kept import of_bytes

    owner = find_machine(session, machine)
    box = of_bytes(content).box
    shown = [*(f"load of {axis.name}" for axis in box.axes if box.hears), *box.seen]
    normalisation = {
        "rate_hz": box.rate_hz,
        "on_air": not box.hears,
        "seen": {n: [float(a), float(b)] for n, a, b in zip(shown, box.low, box.high, strict=True)},
    }
    network = {"sha256": hashlib.sha256(content).hexdigest()}
    whole = network | {"npz": base64.b64encode(content).decode("ascii")}
    ordered = sorted(scores, key=lambda score: score.component)
    fitted = {
        one.component: FittedComponent(network if number else whole, asdict(one), normalisation)
        for number, one in enumerate(ordered)
    }
    return keep_estimator(session, owner.id, KIND, fitted, rows)


def _refuse_lacking(lacking: list[str], recording: Recording) -> None:
    """Refuse a recording that lacks efforts which a network was trained with."""
    if lacking:
        raise UnusableInput(
            phrase(
                "{file}: no drive effort of {names} that the machine has a model of; the "
                "network was trained with it",
                file=recording.path,
                names=", ".join(lacking),
            )
        )


def forces_on_machine(
    store: Store, machine: str, recording: Recording, *, progress: Callable[[str], None]
) -> list[ReconstructedLoad]:
    """Return the forces that a machine's newest network tells of a recording, as loads of axes.

    Raises UnusableInput without PyTorch or a network, and for a recording that is unlike those that
    it was trained on: other channels, another rate, ranges beyond.
    """
    need_torch()
    from autodb.sensing.network import stream
    from autodb.sensing.network.kept import of_bytes
    from autodb.sensing.network.recordings import channels_of

    with store.reading() as session:
        owner = find_machine(session, machine)
        rows = newest(session, owner.id, KIND)
        if not rows:
            raise UnusableInput(
                phrase(
                    "machine '{machine}' has no network; train one with 'autodb calibrate CUT… "
                    "--machine {machine} --network'",
                    machine=machine,
                )
            )
        box = of_bytes(base64.b64decode((rows[0].model or {})["npz"])).box
        own = signed(recording, owner)
        every = _drives(session, owner, own)
        _refuse_lacking([axis.name for axis in box.axes if axis.name not in every], recording)
        drives = {axis.name: every[axis.name] for axis in box.axes}
        version = rows[0].version
    progress("networks")
    tables, channels = box.tables(drives), channels_of(own, drives)
    stream.check(box, tables, channels, rate_hz=own.timing.rate_hz, where=str(recording.path))
    told = [
        stream.network_forces(
            box, tables, {name: values[piece] for name, values in channels.items()}
        )
        for piece in own.pieces
    ]
    force_N = np.concatenate([one.force_N for one in told])
    sd_N = np.concatenate([one.sd_N for one in told])
    said = f"network {version} of machine '{machine}'"
    found = []
    for k, c in enumerate(box.components):
        bandwidth_hz = min(float(box.cutoff_hz[k]), SLOWEST * own.timing.rate_hz)
        load = reconstruct(own, drives[c].model, bandwidth_hz=bandwidth_hz)
        load = replace(load, unit="N", value=-force_N[:, k], sd=sd_N[:, k])
        found.append(
            ReconstructedLoad(
                load,
                said,
                None,
                said="estimated in newtons, as it was trained",
                share=TRAINED_SHARE,
            )
        )
    return found
