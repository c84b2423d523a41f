"""Calibrate a machine's axes on its imported cuts; versions are kept."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb import standard
from autodb.agent import holding
from autodb.agent.importing import cuts_as_table
from autodb.agent.machines import as_file, find_machine
from autodb.errors import UnusableInput
from autodb.fitting import Undetermined
from autodb.records import CutTable
from autodb.sensing import faults, ranges
from autodb.sensing.error_kinds import ErrorKinds
from autodb.sensing.forms import kept
from autodb.sensing.outliers import Outlier
from autodb.sensing.ranges import Calibration, Scores
from autodb.store import Store, models

FORCE_COMPONENTS = tuple(sorted(ranges.COMPONENT_OF_AXIS.values()))


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
    protocol: standard.Protocol | None = None,
    known: faults.Known | None = None,
    names: Sequence[str] | None = None,
) -> tuple[list[Calibration], list[str]]:
    """Calibrate every axis that a table can calibrate; the others come back as sentences why not.

    ``names`` (n,) of the cuts in messages; default their numbers. Raises UnusableInput when the
    data show a fault that concerns all axes, or no axis can be calibrated.
    """
    faults.refuse(table.path, faults.checks_of_units(table, axes, known or faults.Known(protocol)))
    forces = known_forces(table, protocol)
    silent = faults.silent(table, forces, axes)
    heard = [axis for axis in axes if axis not in silent]
    names = names or [f"cut {number:g}" for number in table.cut]
    faults.refuse(table.path, faults.exchanged(table, forces, heard, names))
    done: list[Calibration] = []
    left_out = [f"{table.path}: {check.sentence}" for check in silent.values()]
    for axis in heard:
        try:
            done.append(_calibrate(table, axis, protocol))
        except UnusableInput as error:
            left_out.append(str(error))
        except Undetermined:
            left_out.append(
                f"{table.path}: axis {axis}: too few different currents for a line with some cuts "
                "left out; more cuts, at several feeds and depths, would work"
            )
    if not done:
        reasons = [sentence.removeprefix(f"{table.path}: ") for sentence in left_out]
        raise UnusableInput(f"{table.path}: no axis can be calibrated: {'; '.join(reasons)}")
    return done, left_out


def known_forces(
    table: CutTable, protocol: standard.Protocol | None
) -> dict[str, NDArray[np.float64]]:
    """Return the forces (n,) that the axes are calibrated against, N, by component (NaN: none)."""
    if protocol is None:
        return {c: table[f"force.{c}"] for c in FORCE_COMPONENTS if f"force.{c}" in table}
    made = [cut for cut in protocol.cut if standard.rows_of(table, cut).any()]
    return {
        component: standard.references(table, protocol, component).force_N
        for component in FORCE_COMPONENTS
        if any(component in cut.reference for cut in made)
    }


def _calibrate(table: CutTable, axis: str, protocol: standard.Protocol | None) -> Calibration:
    if protocol is None:
        return ranges.calibrate(table, axis)
    component = ranges.COMPONENT_OF_AXIS[axis]
    reference = standard.references(table, protocol, component)
    return ranges.calibrate(table, axis, force_N=reference.force_N, reference_share=reference.share)


def calibrate_machine(
    store: Store,
    machine: str,
    *,
    recordings: list[int] | None = None,
    protocol: standard.Protocol | None = None,
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
                f"machine '{machine}': no imported cuts with force.*; "
                "import cuts made with a dynamometer, or give --protocol"
            )
        table = cuts_as_table(cuts, path=_named(cuts))
        used = sorted({cut.recording_id for cut in cuts})
        axes = tuple(a.name for a in owner.axes if a.name in ranges.COMPONENT_OF_AXIS)
        sources = list(
            {
                cut.recording_id: (Path(cut.recording.path).name, cut.recording.sha256)
                for cut in cuts
            }.values()
        )
        known = faults.Known(protocol, as_file(owner))
        holding.refuse_mixed(list({cut.recording_id: cut.recording for cut in cuts}.values()))
        names = _names(cuts)
        _refuse_wrong_units(cuts, axes, known)
        machine_id = owner.id
    if progress:
        progress("fitting and scoring on groups left out")
    done, left_out = calibrate_table(table, axes=axes, protocol=protocol, known=known, names=names)
    with store.writing() as session:
        kept = [_keep(session, machine_id, used, calibration) for calibration in done]
    versions, new = zip(*kept, strict=True)
    return Calibrated(table, axes, done, left_out, sources, versions, new)


def _calibration_cuts(
    session: Session, machine_id: int, recordings: list[int] | None, *, needs_force: bool
) -> list[models.Cut]:
    query = (
        select(models.Cut)
        .join(models.Recording)
        .where(models.Recording.machine_id == machine_id)
        .order_by(models.Cut.recording_id, models.Cut.number)
    )
    if recordings is not None:
        query = query.where(models.Recording.id.in_(recordings))
    return [
        cut
        for cut in session.scalars(query)
        if not needs_force or any(name.startswith("force.") for name in cut.measured)
    ]


def _refuse_wrong_units(cuts: list[models.Cut], axes: tuple[str, ...], known: faults.Known) -> None:
    """Check each recording by itself: one in a wrong unit would drown among the others.

    A shop's cuts beside the standard ones are no fault, so the protocol is left to all of them.
    """
    alone = replace(known, protocol=None)
    for recording_id in dict.fromkeys(cut.recording_id for cut in cuts):
        own = [cut for cut in cuts if cut.recording_id == recording_id]
        table = cuts_as_table(own, path=_named(own))
        faults.refuse(table.path, faults.checks_of_units(table, axes, alone))


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


def _keep(
    session: Session, machine_id: int, recordings: list[int], calibration: Calibration
) -> tuple[int, bool]:
    """Store a calibration unless it is there already; return its version and whether it is new."""
    last = latest_calibration(session, machine_id, calibration.axis)
    coefficients = calibration.coefficients.tolist()
    if last is not None and sorted(r.id for r in last.recordings) == recordings:
        alike = (last.kind, last.channel) == (calibration.form.kind, calibration.channel)
        told_apart = last.cut_sd is not None
        close = alike and np.allclose(last.coefficients, coefficients, rtol=1e-9, atol=0.0)
        if told_apart and close:
            return last.version, False
    version = 1 if last is None else last.version + 1
    sources = list(
        session.scalars(select(models.Recording).where(models.Recording.id.in_(recordings)))
    )
    session.add(
        models.Calibration(
            machine_id=machine_id,
            axis=calibration.axis,
            version=version,
            component=calibration.component,
            kind=calibration.form.kind,
            **holding.holds_for(calibration.axis, sources),
            parameters=calibration.form.parameters(),
            channel=calibration.channel,
            current_unit=calibration.current_unit,
            unit=calibration.unit,
            coefficients=coefficients,
            covariance=calibration.covariance.tolist(),
            cut_sd=calibration.errors.cut_sd,
            gain_share=calibration.errors.gain_share,
            reference_share=calibration.errors.reference_share,
            current_sd=calibration.errors.current_sd,
            group_covariance=_listed(calibration.errors.group),
            scores=asdict(calibration.scores),
            scores_with_transients=asdict(calibration.scores_with_transients),
            transients=list(calibration.transients),
            outliers=[asdict(one) for one in calibration.outliers],
            trials={k: None if np.isnan(v) else v for k, v in calibration.trials.items()},
            current_low=calibration.current_low,
            current_high=calibration.current_high,
            offered=calibration.offered,
            verdict=calibration.verdict,
            recordings=sources,
        )
    )
    return version, True


def latest_calibration(session: Session, machine_id: int, axis: str) -> models.Calibration | None:
    """Return the newest version of an axis' calibration, offered or not."""
    return session.scalar(
        select(models.Calibration)
        .where(models.Calibration.machine_id == machine_id, models.Calibration.axis == axis)
        .order_by(models.Calibration.version.desc())
        .limit(1)
    )


def as_calibration(row: models.Calibration) -> Calibration:
    """Return a stored calibration as the record that sensing takes."""
    return Calibration(
        form=kept(row.kind, row.parameters),
        axis=row.axis,
        component=row.component,
        channel=row.channel,
        current_unit=row.current_unit,
        unit=row.unit,
        coefficients=np.array(row.coefficients),
        covariance=np.array(row.covariance),
        errors=_error_kinds(row),
        scores=Scores(**row.scores),
        scores_with_transients=Scores(**row.scores_with_transients),
        transients=tuple(row.transients),
        outliers=tuple(Outlier(**one) for one in row.outliers or ()),
        trials={k: np.nan if v is None else v for k, v in (row.trials or {}).items()},
        current_low=row.current_low,
        current_high=row.current_high,
    )


def _error_kinds(row: models.Calibration) -> ErrorKinds:
    """Return the kinds of error; 0.1.0 kept one, and what is shared in the covariance."""
    if row.cut_sd is None:
        return ErrorKinds(cut_sd=row.scores["rmse"], gain_share=0.0, reference_share=0.0)
    group = None if row.group_covariance is None else np.array(row.group_covariance)
    shares = (row.gain_share or 0.0, row.reference_share or 0.0)
    return ErrorKinds(row.cut_sd, *shares, group, row.current_sd or 0.0)


def _listed(matrix: NDArray[np.float64] | None) -> list[list[float]] | None:
    return None if matrix is None else [[float(one) for one in row] for row in matrix]
