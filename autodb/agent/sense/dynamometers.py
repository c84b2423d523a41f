"""A machine's table dynamometer: identified from moves without a cut, kept, and used."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sqlalchemy.orm import Session

from autodb.agent.ingest.importing import import_file
from autodb.agent.rows.estimators import FittedComponent, is_learnt_from, keep_estimator, newest
from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.reconstructing import ReconstructedLoad
from autodb.errors import UnusableInput
from autodb.records import source as records
from autodb.records.tables import Recording
from autodb.sensing.drives.reconstruct import DriveLoad
from autodb.sensing.table.engaged import engaged
from autodb.sensing.table.forces import TableForces, envelopes, table_forces
from autodb.sensing.table.heat import Heat
from autodb.sensing.table.identify import (
    BareMoves,
    air_left_N,
    identify_table,
    moves_among,
)
from autodb.sensing.table.kinematics import DIRECTIONS, Kinematics, order_of
from autodb.sensing.table.model import TableModel
from autodb.sensing.table.resonance import BAND, Modes
from autodb.store import Store, models
from autodb.wording import phrase, significant

KIND = "table"
HIGHEST = 0.2
"""Share of a recording's rate up to which forces are told: below P4's 2 kHz of 5 kHz."""


@dataclass(frozen=True)
class Levelled:
    """A version of a machine's table dynamometer; ``left_N`` (3,): rms that moves in air leave."""

    version: int
    model: TableModel
    left_N: tuple[float, ...]
    already_there: bool


def level_dynamometer(
    store: Store,
    machine: str,
    files: Sequence[Path],
    *,
    columns: Path | None = None,
    bare: Sequence[Path] = (),
    work_kg: float | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Levelled:
    """Identify a machine's table dynamometer from recordings of moves without a cut.

    ``bare``: moves without the work, which weighs ``work_kg``. The recordings are imported; the
    same ones again are said to be there already.

    Raises UnusableInput where the machine's file states no rotary axes that carry the work, and as
    ``identify_table`` does.
    """
    recordings = [_read(path, columns) for path in files]
    without = BareMoves([_read(path, columns) for path in bare], work_kg or 0.0) if bare else None
    with store.reading() as session:
        kinematics = _kinematics(find_machine(session, machine))
    progress("mass, lever arm and matrix of the sensor")
    model = identify_table(recordings, kinematics, bare=without)
    left_N = tuple(float(one) for one in air_left_N(model, moves_among(recordings, kinematics)))
    ids = [
        import_file(store, path, machine=machine, columns=columns).recording_id
        for path in (*files, *bare)
    ]
    with store.writing(machine) as session:
        owner = find_machine(session, machine)
        before = newest(session, owner.id, KIND)
        if is_learnt_from(before, ids) and _model(before).to_json() == before[0].model:
            scores = tuple(row.scores["rmse_N"] for row in before)
            return Levelled(before[0].version, _model(before), scores, already_there=True)
        rows = [session.get_one(models.StoredRecording, one) for one in dict.fromkeys(ids)]
        kept = model.to_json()
        fitted = {c: FittedComponent(kept, {"rmse_N": left_N[k]}) for k, c in enumerate("xyz")}
        version = keep_estimator(session, owner.id, KIND, fitted, rows)
    return Levelled(version, model, left_N, already_there=False)


def _read(path: Path, columns: Path | None) -> Recording:
    found = records.read(path, columns=columns)
    if not isinstance(found, Recording):
        raise UnusableInput(
            phrase(
                "{file}: a table of cuts; a table dynamometer needs force.* over time", file=path
            )
        )
    return found


def _kinematics(owner: models.Machine) -> Kinematics:
    carrying = {
        axis.name: axis.carried_by
        for axis in owner.axes
        if axis.name in DIRECTIONS and axis.carries == "work"
    }
    if not carrying:
        raise UnusableInput(
            phrase(
                "machine '{owner}' states no rotary axis that carries the work; state [axes.a] "
                'and [axes.c] with carries = "work", and carried_by of the upper one, in its '
                "file ('autodb machine update')",
                owner=owner.name,
            )
        )
    return Kinematics(order_of(carrying))


def _model(rows: Sequence[models.Estimator]) -> TableModel:
    return TableModel.of_json(rows[0].model or {})


def table_on_machine(session: Session, owner: models.Machine) -> tuple[TableModel, int] | None:
    """Return a machine's newest table dynamometer and its version, or None."""
    rows = newest(session, owner.id, KIND)
    return (_model(rows), rows[0].version) if rows else None


def forces_on_table(
    store: Store,
    machine: str,
    recording: Recording,
    *,
    bandwidth_hz: float | None = None,
    removed_kg: float = 0.0,
) -> list[ReconstructedLoad]:
    """Return the forces of the work on the tool in machine axes that a machine's table tells.

    ``bandwidth_hz``: up to which; None: HIGHEST of the rate. ``removed_kg``: what chips took away
    since it was tared, evenly while it cuts. Raises UnusableInput without a table dynamometer, a
    component or an angle.
    """
    with store.reading() as session:
        found = table_on_machine(session, find_machine(session, machine))
    if found is None:
        raise UnusableInput(
            phrase(
                "machine '{machine}' has no table dynamometer; run 'autodb calibrate MOVES… "
                "--machine {machine} --table' to identify one",
                machine=machine,
            )
        )
    model, version = found
    hz = HIGHEST * recording.timing.rate_hz if bandwidth_hz is None else bandwidth_hz
    told = told_on_table(model, recording, bandwidth_hz=hz, removed_kg=removed_kg)
    said = f"table dynamometer, version {version} of machine '{machine}'"
    loads = [_load("xyz"[k], told.force_N[k], told.sd_N[k], hz) for k in range(3)]
    heat, rows = _heat_words(told.heat), _rows_of_a_turn(recording)
    heat = "; ".join([heat, *resonance_words(model.modes, bandwidth_hz=hz)])
    return [
        ReconstructedLoad(
            load, said, None, said=heat, share=model.gain_sd,
            envelope_N=None
            if rows is None
            else envelopes(-load.value, recording.pieces, rows=rows),
        )
        for load in loads
    ]  # fmt: skip


def _rows_of_a_turn(recording: Recording) -> int | None:
    """Return how many rows a turn of the spindle has; None where its speed is not known."""
    speed = recording.get("spindle.speed")
    rpm = recording.side.cut.speed_rpm if speed is None else float(np.median(np.abs(speed)))
    return round(60.0 * recording.timing.rate_hz / rpm) if rpm else None


def told_on_table(
    model: TableModel,
    recording: Recording,
    *,
    bandwidth_hz: float | None = None,
    removed_kg: float = 0.0,
) -> TableForces:
    """Return the forces of a recording on a table, as ``forces_on_table`` does, with its heat."""
    hz = HIGHEST * recording.timing.rate_hz if bandwidth_hz is None else bandwidth_hz
    cutting = engaged(recording)
    gone = _gone(cutting, removed_kg)
    return table_forces(model, recording, cutting, cutoff_hz=hz, removed_kg=gone)


def _heat_words(heat: Heat) -> str:
    if heat.why is not None:
        return f"heat of chips: {heat.why}"
    most = ", ".join(significant(one) for one in np.abs(heat.drift_N).max(axis=1))
    times = f"a time constant of {significant(heat.times_s[0], 2)} s"
    if len(heat.times_s) > 1:
        quick, slow = (significant(one, 2) for one in heat.times_s)
        times = (
            f"time constants of {quick} s ({100.0 * heat.share:.0f} % of the level) and {slow} s"
        )
    by = "with the size of the force" if heat.by_force else "as long as it cuts"
    return f"heat of chips: up to {most} N in the sensor's x, y, z, {by}, with {times}, subtracted"


def resonance_words(modes: Modes, *, bandwidth_hz: float) -> Iterator[str]:
    """Yield how a sensor rings, and up to where its forces are corrected for it; nothing of one
    whose taps nobody recorded.
    """
    for k, mode in enumerate(modes):
        if mode is not None:
            up_to = significant(min(bandwidth_hz, BAND * mode.hz))
            yield (
                f"resonance of the sensor's {'xyz'[k]} at {significant(mode.hz)} Hz corrected, up "
                f"to {up_to} Hz"
            )


def _gone(cutting: NDArray[np.bool_], removed_kg: float) -> NDArray[np.float64] | None:
    """Return the mass (n,) that left by each row."""
    if removed_kg == 0.0 or not cutting.any():
        return None
    return np.asarray(removed_kg * np.cumsum(cutting) / np.sum(cutting))


def _load(
    axis: str, force_N: NDArray[np.float64], sd_N: NDArray[np.float64], bandwidth_hz: float
) -> DriveLoad:
    """Return a force on the tool as the load that its axis would feel; no row is marked."""
    none = np.zeros(len(force_N), dtype=np.bool_)
    return DriveLoad(
        axis=axis, unit="N", bandwidth_hz=bandwidth_hz, value=-force_N, sd=sd_N,
        direction=np.zeros(len(force_N)), standing=none, turned=none, outside=none, braking=none,
        at_limit=none,
    )  # fmt: skip
