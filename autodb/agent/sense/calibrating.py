"""Calibrate a machine's axes on its imported cuts; versions are kept."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb import standard
from autodb.agent.rows.calibration_records import keep_calibration
from autodb.agent.rows.calibrations import current_calibrations
from autodb.agent.rows.machines import as_file, find_machine
from autodb.agent.rows.recordings import cuts_as_table
from autodb.agent.sense.measured import reference_errors
from autodb.errors import UnusableInput
from autodb.fitting.linear import Undetermined
from autodb.records.tables import CutTable
from autodb.sensing.dynamometer import ForceStatement, errors_of_table
from autodb.sensing.ranges import calibration, faults
from autodb.sensing.ranges.calibration import Calibration
from autodb.sensing.ranges.feeding import moving
from autodb.sensing.ranges.points import COMPONENT_OF_AXIS
from autodb.sensing.ranges.validity import ANY, Holds, holds_of, partition, unstated
from autodb.store import Store, models
from autodb.wording import listed, phrase

FEWEST = 2
"""Cuts of a feed direction from which on it shares the gain of the other. Chosen."""
FORCE_COMPONENTS = tuple(sorted(COMPONENT_OF_AXIS.values()))


@dataclass(frozen=True)
class Calibrated:
    """What calibrating ``axes`` on a table gave; ``left_out``: sentences why not the others.

    ``sources``: name and SHA-256 of each recording. Of a machine also the ``versions`` stored, and
    whether each is ``new``.
    """

    table: CutTable
    axes: tuple[str, ...]
    calibrations: list[Calibration]
    left_out: list[str]
    sources: list[tuple[str, str]]
    versions: tuple[int, ...] = ()
    new: tuple[bool, ...] = ()


def calibrate_table(
    table: CutTable,
    *,
    axes: tuple[str, ...],
    protocol: standard.CutProtocol | None = None,
    known: faults.KnownOfCuts | None = None,
    names: Sequence[str] | None = None,
) -> tuple[list[Calibration], list[str]]:
    """Calibrate every axis that a table can calibrate; the others come back as sentences why not.

    An axis has as many calibrations as its cuts state gear ranges, coolants, spindle states and
    feed directions. ``names`` (n,) of the cuts in messages; default their numbers. Raises
    UnusableInput when the data show a fault that concerns all axes, or no axis can be calibrated.
    """
    if protocol is None and not any(f"force.{c}" in table for c in FORCE_COMPONENTS):
        raise UnusableInput(
            phrase(
                "{file}: no channel force.x, force.y or force.z{near}; add what a dynamometer "
                "measured, or calibrate standard cuts with --protocol NAME",
                file=table.path,
                near=table.near("force.z"),
            )
        )
    known = known or faults.KnownOfCuts(protocol)
    faults.refuse(table.path, faults.checks_of_units(table, axes, known))
    faults.refuse(table.path, faults.checks_of_signs(table, known))
    names = names or [f"cut {number:g}" for number in table.cut]
    parts = {axis: partition(holds_of(table, axis)) for axis in axes}
    forces = known_forces(table, protocol)
    for rows in _together(table, parts):
        alike = {component: _only(force, rows) for component, force in forces.items()}
        heard = [axis for axis in axes if axis not in faults.silent(table, alike, axes)]
        faults.refuse(table.path, faults.exchanged(table, alike, heard, names))
    done: list[Calibration] = []
    left_out: list[str] = []
    for axis, groups in parts.items():
        out = unstated(holds_of(table, axis), groups, moving(table, axis))
        left_out += [f"{table.path}: axis {axis}: {out}"] if out else []
        for holds, rows in groups.items():
            found = _calibrated(table, axis, holds, rows, protocol=protocol, axes=axes)
            if isinstance(found, Calibration):
                done.append(found)
            else:
                left_out.append(found)
    if not done:
        raise _nothing_calibrated(table, left_out)
    return done, left_out


def _nothing_calibrated(table: CutTable, left_out: Sequence[str]) -> UnusableInput:
    """Return the refusal of a table that calibrates no axis; of one without a current, what to do.

    Its forces were measured, and teach as they are.
    """
    names = listed([one.removeprefix(f"{table.path}: ") for one in left_out], "; ")
    if any(".current" in name for name in table.channels):
        said = phrase("{file}: no axis can be calibrated: {names}", file=table.path, names=names)
    else:
        said = phrase(
            "{file}: no axis can be calibrated: {names}; forces that were measured need no "
            "calibration: run 'autodb refresh'",
            file=table.path,
            names=names,
        )
    return UnusableInput(said)


def _together(
    table: CutTable, parts: dict[str, dict[Holds, NDArray[np.bool_]]]
) -> Iterator[NDArray[np.bool_]]:
    """Yield the rows (n,) that all axes take together: what two axes say is compared in those."""
    labels = np.full((len(table), len(parts)), -1)
    for column, groups in enumerate(parts.values()):
        for label, rows in enumerate(groups.values()):
            labels[rows, column] = label
    for one in np.unique(labels, axis=0):
        yield np.all(labels == one, axis=1)


def _only(force_N: NDArray[np.float64], rows: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return forces (n,) of some rows, NaN in the others."""
    return np.where(rows, force_N, np.nan)


def _calibrated(
    table: CutTable,
    axis: str,
    holds: Holds,
    rows: NDArray[np.bool_],
    *,
    protocol: standard.CutProtocol | None,
    axes: tuple[str, ...],
) -> Calibration | str:
    """Calibrate one of the axes on some rows, or return why it cannot be, in a sentence."""
    where = f" ({holds.words()})" if holds != ANY else ""
    beside = _other_way(table, axis, holds)
    forces = {c: _only(force, rows) for c, force in known_forces(table, protocol).items()}
    silent = faults.silent(table, forces, axes)
    if axis in silent:
        return f"{table.path}: {silent[axis].sentence}{where}"
    try:
        return replace(_calibrate(table, axis, rows, protocol, beside), holds=holds)
    except UnusableInput as error:
        return f"{error}{where}"
    except Undetermined:
        return (
            f"{table.path}: axis {axis}{where}: too few different currents to fit a line and "
            "test it on held-out cuts; add cuts at several feeds and depths"
        )


def known_forces(
    table: CutTable, protocol: standard.CutProtocol | None
) -> dict[str, NDArray[np.float64]]:
    """Return the forces (n,) that the axes are calibrated against, N, by component (NaN: none)."""
    if protocol is None:
        return {c: table[f"force.{c}"] for c in FORCE_COMPONENTS if f"force.{c}" in table}
    made = [cut for cut in protocol.cut if standard.rows_of_cut(table, cut).any()]
    return {
        component: standard.reference_forces(table, protocol, component).force_N
        for component in FORCE_COMPONENTS
        if any(component in cut.reference for cut in made)
    }


def _other_way(table: CutTable, axis: str, holds: Holds) -> NDArray[np.bool_] | None:
    """Return the cuts (n,) that differ from those of a calibration in the feed's direction alone.

    None where they, or its own, are too few to have a level.
    """
    moves, parts = moving(table, axis), partition(holds_of(table, axis))
    own = int((parts[holds] & moves).sum())
    for other, rows in parts.items():
        beside = rows & moves
        if other.against(holds) == ["feed_direction"] and min(own, int(beside.sum())) >= FEWEST:
            return beside
    return None


def _calibrate(
    table: CutTable,
    axis: str,
    rows: NDArray[np.bool_],
    protocol: standard.CutProtocol | None,
    other_way: NDArray[np.bool_] | None,
) -> Calibration:
    component, share = COMPONENT_OF_AXIS[axis], 0.0
    if protocol is None:
        force_N = table[f"force.{component}"]
    else:
        reference = standard.reference_forces(table, protocol, component)
        force_N, share = reference.force_N, reference.share
    used = rows if other_way is None else rows | other_way
    return calibration.calibrate(
        table, axis, force_N=_only(force_N, used), reference_share=share, other_way=other_way
    )


def with_errors_of_dynamometer(one: Calibration, table: CutTable) -> Calibration:
    """Return a calibration on a table's measured forces with what its side file states of them."""
    statement = ForceStatement(table.side.dynamometer, table.side.source)
    forces = known_forces(table, None)
    return replace(one, reference_errors=errors_of_table(statement, one.component, forces))


def calibrate_machine(
    store: Store,
    machine: str,
    *,
    recordings: list[int] | None = None,
    protocol: standard.CutProtocol | None = None,
    progress: Callable[[str], None] | None = None,
) -> Calibrated:
    """Calibrate a machine on its imported cuts and keep each equation as a new version.

    One is not new where an equal one on the same recordings is already there. Raises UnusableInput.
    """
    with store.reading() as session:
        owner = find_machine(session, machine)
        cuts = _calibration_cuts(session, owner.id, recordings, needs_force=protocol is None)
        if not cuts:
            raise UnusableInput(
                phrase(
                    "machine '{machine}': no imported cuts with force.*; import cuts made with a "
                    "dynamometer, or give --protocol",
                    machine=machine,
                )
            )
        table = cuts_as_table(cuts, path=_named(cuts))
        recordings_of_cuts = np.array([cut.recording_id for cut in cuts])
        axes = tuple(a.name for a in owner.axes if a.name in COMPONENT_OF_AXIS)
        sources = list(
            {
                cut.recording_id: (Path(cut.recording.path).name, cut.recording.sha256)
                for cut in cuts
            }.values()
        )
        known = faults.KnownOfCuts(protocol, as_file(owner), _signs_stated(cuts))
        names = _names(cuts)
        _refuse_faulty(cuts, axes, known)
        errors = {
            c: () if protocol is not None else reference_errors(owner, cuts, c)
            for c in FORCE_COMPONENTS
        }
        machine_id = owner.id
    if progress:
        progress("fitting and scoring on held-out groups")
    done, left_out = calibrate_table(table, axes=axes, protocol=protocol, known=known, names=names)
    done = [replace(one, reference_errors=errors[one.component]) for one in done]
    of = [_recordings(table, one, recordings_of_cuts) for one in done]
    with store.writing(machine) as session:
        kept = [keep_calibration(session, machine_id, of[i], one) for i, one in enumerate(done)]
    versions, new = zip(*kept, strict=True)
    return Calibrated(table, axes, done, left_out, sources, versions, new)


def calibrated_on(store: Store, machine: str) -> set[int]:
    """Return the recordings that a machine's calibrations in use were made on, by number."""
    with store.reading() as session:
        owner = find_machine(session, machine)
        axes = [axis.name for axis in owner.axes]
        found = [row for axis in axes for row in current_calibrations(session, owner.id, axis)]
        return {recording.id for row in found for recording in row.recordings}


def _recordings(table: CutTable, one: Calibration, of_cuts: NDArray[np.int_]) -> list[int]:
    """Return the recordings of the cuts that a calibration was made on."""
    return sorted({int(number) for number in of_cuts[_rows(table, one)]})


def _rows(table: CutTable, one: Calibration) -> NDArray[np.bool_]:
    return partition(holds_of(table, one.axis))[one.holds]


def its_own(
    table: CutTable, one: Calibration, forces: Mapping[str, NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Return the known forces (n,) that a calibration was made on, N; NaN in other cuts."""
    return _only(forces[one.component], _rows(table, one))


def _calibration_cuts(
    session: Session, machine_id: int, recordings: list[int] | None, *, needs_force: bool
) -> list[models.Cut]:
    query = (
        select(models.Cut)
        .join(models.StoredRecording)
        .where(
            models.StoredRecording.machine_id == machine_id,
            models.counting_cut(models.Cut.superseded_at),
        )
        .order_by(models.Cut.recording_id, models.Cut.number)
    )
    if recordings is not None:
        query = query.where(models.StoredRecording.id.in_(recordings))
    return [
        cut
        for cut in session.scalars(query)
        if not needs_force or any(name.startswith("force.") for name in cut.measured)
    ]


def _signs_stated(cuts: list[models.Cut]) -> frozenset[str]:
    """Return the channels of which a recording's side file states that their sign is right."""
    sides = {cut.recording_id: cut.recording.side.get("channels", {}) for cut in cuts}
    channels = [one for side in sides.values() for one in side.items()]
    return frozenset(name for name, spec in channels if spec.get("sign") == 1)


def _refuse_faulty(
    cuts: list[models.Cut], axes: tuple[str, ...], known: faults.KnownOfCuts
) -> None:
    """Check each recording by itself: one in a wrong unit or sign would drown among the others.

    A shop's cuts beside the standard ones are no fault, so the protocol is left to all of them.
    """
    alone = replace(known, protocol=None)
    for recording_id in dict.fromkeys(cut.recording_id for cut in cuts):
        own = [cut for cut in cuts if cut.recording_id == recording_id]
        table = cuts_as_table(own, path=_named(own))
        faults.refuse(table.path, faults.checks_of_units(table, axes, alone))
        signs = replace(alone, signs=_signs_stated(own))
        faults.refuse(table.path, faults.checks_of_signs(table, signs))


def _names(cuts: list[models.Cut]) -> list[str]:
    """Return how messages name each cut: with its file where there are several."""
    several = len({cut.recording_id for cut in cuts}) > 1
    return [
        f"cut {cut.number:g}" + (f" of {Path(cut.recording.path).name}" if several else "")
        for cut in cuts
    ]


def _named(cuts: list[models.Cut]) -> Path:
    """Return the path to name in messages: the recording's, or the first of several."""
    return Path(cuts[0].recording.path)
