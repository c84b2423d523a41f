"""Stored cuts and their measured and sensed forces as readings that a pair's posterior learns from.

A force of a cut counts once: where it was measured, what is sensed of it does not count. A
calibration on measured forces has the errors of their dynamometer too, under the same keys, so that
cuts measured and cuts sensed never average what they share. What a cut that it was calibrated on
has for itself (noise) is not tied to the calibration's coefficients: over their cuts it averages.
"""

from collections.abc import Container, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Select, select
from sqlalchemy.orm import Session

from autodb.agent.rows.calibrations import as_calibration, beyond_its_range
from autodb.agent.rows.catalogue import numbers_of
from autodb.agent.rows.corrected import is_after
from autodb.agent.rows.drifted import DriftedGain, drifted_gains
from autodb.agent.rows.edges_in_use import conditions_in_use
from autodb.agent.rows.force_errors import MEASURED, errors_of, shared_key
from autodb.agent.rows.stored_cuts import cuts_as_table
from autodb.errors import UnusableInput
from autodb.pairs.confirmed import with_terms
from autodb.pairs.determined import CHIP_SHARE
from autodb.pairs.engaged import BY_NAME, UNSAID
from autodb.pairs.observed import CHIP, Observed, PairCuts, X, Y, Z
from autodb.pairs.posterior import CALIBRATION, DAY, GAIN, NO_TERMS, REFERENCES, PairTerms, Shared
from autodb.sensing.ranges.chosen import choose
from autodb.sensing.ranges.error_kinds import day_moves
from autodb.store import models

Array = NDArray[np.float64]
Calibrations = list[models.CalibrationVersion]
"""Those of one axis that hold now, newest first."""
QUANTITY = {"x": X, "y": Y, "z": Z}
CHIP_THICKNESS = "chip.thickness"


@dataclass(frozen=True)
class PairForces:
    """Forces of one pair, oldest cut first; how many cuts are not learnt from, by the reason.

    ``after``: only of cuts with larger ids, no version has learnt any; 0: all of the pair's.
    """

    pair: models.Pair
    forces: list[models.SensedForce]
    left_out: dict[str, int]
    after: int = 0


def operation_of(cut: models.Cut) -> str:
    """Return the operation of a cut; one that does not say it counts as turning."""
    return cut.operation or UNSAID


def forces_of_pair(
    session: Session,
    machine_id: int,
    pair: models.Pair,
    calibrations: Sequence[Calibrations],
    *,
    cuts: tuple[int, int] | None = None,
) -> PairForces:
    """Return the forces that were measured on a pair, or sensed by axes and other sensors.

    ``cuts``: of those alone with an id above the first, up to the second.

    ``calibrations``: those of each axis. A sensed force counts where the one that sensed it is
    still the one that holds for the cut: of a cut that did not state what, a later calibration may
    say otherwise. Of several sensors of a force the surest counts, and a measured force before all.
    """
    sensed = _sensed(machine_id, pair.id)
    if cuts is not None:
        sensed = sensed.where(models.Cut.id > cuts[0], models.Cut.id <= cuts[1])
    forces = [f for current in calibrations for f in _of_axis(session, sensed, current)]
    forces = _surest([*forces, *_of_others(session, sensed)], _measured(session, sensed))
    reasons = {force.cut_id: _unusable(force.cut) for force in forces}
    left_out: dict[str, int] = {}
    for reason in reasons.values():
        if reason is not None:
            left_out[reason] = left_out.get(reason, 0) + 1
    forces.sort(key=lambda force: (force.cut_id, force.component))
    kept = [force for force in forces if reasons[force.cut_id] is None]
    return PairForces(pair, kept, left_out, after=0 if cuts is None else cuts[0])


def forces_of_cuts(
    session: Session, cuts: Sequence[int], calibrations: Sequence[Calibrations]
) -> list[models.SensedForce]:
    """Return one force of each component of some cuts, by id, as ``forces_of_pair`` chooses it."""
    known = (
        select(models.SensedForce)
        .join(models.Cut)
        .where(models.Cut.id.in_(cuts), models.SensedForce.value_N.is_not(None))
    )
    forces = [f for current in calibrations for f in _of_axis(session, known, current)]
    return _surest([*forces, *_of_others(session, known)], _measured(session, known))


def sd_beside_N(force: models.SensedForce, known: Container[str]) -> float:
    """Return a force's standard deviation, N, without the errors of which the key is ``known``."""
    readings = Readings([force])
    shared = [float(sd[0]) for key, sd in readings.moved_N().items() if key not in known]
    return float(np.linalg.norm([float(readings.sd_N[0]), *shared]))


def _sensed(machine_id: int, pair_id: int) -> Select[models.SensedForce]:
    """Return what asks for the forces that were sensed on a pair."""
    return (
        select(models.SensedForce)
        .join(models.Cut)
        .where(
            models.Cut.recording.has(machine_id=machine_id),
            models.Cut.pair_id == pair_id,
            models.Cut.superseded_at.is_(None),
            models.SensedForce.value_N.is_not(None),
        )
    )


def _of_axis(
    session: Session, sensed: Select[models.SensedForce], current: Calibrations
) -> list[models.SensedForce]:
    by_these = models.SensedForce.calibration_id.in_([row.id for row in current])
    measured = list(session.scalars(sensed.where(by_these).order_by(models.Cut.id)))
    if len(current) == 1 or not measured:
        return measured
    cuts = [force.cut for force in measured]
    table = cuts_as_table(cuts, path=Path(cuts[0].recording.path))
    chosen = choose(table, [as_calibration(row) for row in current])
    ids = [row.id for row in current]
    return [
        force
        for force, by in zip(measured, chosen, strict=True)
        if isinstance(by, int) and force.calibration_id == ids[by]
    ]


def _of_others(session: Session, sensed: Select[models.SensedForce]) -> list[models.SensedForce]:
    """Return what sensors that are no calibrated ranges sensed; of each kind its newest version."""
    sensor = models.SensedForce.estimator_id
    query = sensed.where(sensor.is_not(None)).order_by(sensor)
    return list({(f.cut_id, f.component, f.estimator): f for f in session.scalars(query)}.values())


def _measured(session: Session, sensed: Select[models.SensedForce]) -> list[models.SensedForce]:
    """Return the forces that were measured, of each the newest row."""
    query = sensed.where(models.SensedForce.estimator == MEASURED).order_by(models.SensedForce.id)
    return list({(f.cut_id, f.component): f for f in session.scalars(query)}.values())


def _surest(
    forces: Sequence[models.SensedForce], measured: Sequence[models.SensedForce]
) -> list[models.SensedForce]:
    """Return one force of each component of a cut: measured, else of the least sd."""
    found = {(force.cut_id, force.component): force for force in measured}
    known = set(found)
    for force in forces:
        key = force.cut_id, force.component
        if key in known:
            continue
        if key not in found or _whole_sd_N(force) < _whole_sd_N(found[key]):
            found[key] = force
    return list(found.values())


def _whole_sd_N(force: models.SensedForce) -> float:
    """Return a force's standard deviation; with its gain's of a sensor that is no range.

    Of a range with what the form's choice adds beyond what its calibration was made with.
    """
    shared = 0.0 if force.sensor is None else gain_share(force) * float(force.value_N or 0.0)
    if force.common and force.calibration is not None and force.calibration.domain is not None:
        shared = float(force.common[-1])
    return float(np.hypot(float(force.sd_N or 0.0), shared))


def gain_share(force: models.SensedForce) -> float:
    """Return the relative sd of the gain of what sensed a force, if it is no calibrated range."""
    return float(force.common[0]) if force.common else 0.0


def usable(cut: models.Cut) -> bool:
    """Say whether a cut states what its forces are worked out from."""
    return cut.pair_id is not None and _unusable(cut) is None


def _unusable(cut: models.Cut) -> str | None:
    """Return why a cut is not learnt from; None: it is."""
    operation = BY_NAME.get(operation_of(cut))
    if operation is None:
        return f"operation '{cut.operation}' has no model"
    lacking = operation.lacking(cut.conditions)
    return f"{operation.name} without {' and '.join(lacking)}" if lacking else None


def as_observed(
    forces: Sequence[models.SensedForce],
    *,
    terms: PairTerms = NO_TERMS,
    known: Container[int] = (),
) -> Observed:
    """Return forces of one pair's cuts, measured or sensed, as readings of it.

    With the chips that were measured of the cuts, but of those ``known`` before, by id; ``terms``:
    those of the pair beside the law. Raises UnusableInput where the pair's tool cannot make the
    cuts.
    """
    cuts = list({force.cut_id: force.cut for force in forces}.values())
    number, made = as_cuts(cuts)
    sensed = Readings(forces)
    thick = [c for c in cuts if CHIP_THICKNESS in c.conditions and c.id not in known]
    chip_mm = np.array([c.conditions[CHIP_THICKNESS] for c in thick], dtype=np.float64)
    none = np.zeros((len(thick), sensed.share.shape[1]))
    observed = Observed(
        cuts=made,
        cut=np.array([number[f.cut_id] for f in forces] + [number[c.id] for c in thick], np.intp),
        quantity=np.array([QUANTITY[f.component] for f in forces] + [CHIP] * len(thick), np.intp),
        value=np.concatenate([sensed.value_N, chip_mm]),
        sd=np.concatenate([sensed.sd_N, CHIP_SHARE * chip_mm]),
        common=np.vstack([sensed.share, none]),
        shared=sensed.shared,
        shift=np.vstack([sensed.shift, none]),
    )
    return with_terms(observed, terms)


def as_cuts(cuts: Sequence[models.Cut]) -> tuple[dict[int, int], tuple[PairCuts, ...]]:
    """Return cuts of one pair as elements, by operation, and the number of each by its id."""
    number: dict[int, int] = {}
    made = []
    for name in dict.fromkeys(operation_of(cut) for cut in cuts):
        some = [cut for cut in cuts if operation_of(cut) == name]
        number |= {cut.id: len(number) + k for k, cut in enumerate(some)}
        tool = some[0].pair.tool if some[0].pair else None
        if tool is None:
            raise UnusableInput(f"cut {some[0].number:g}: its work-tool pair is not known")
        conditions = conditions_in_use(some)
        its = BY_NAME[name].cuts(numbers_of(tool), conditions, called=tool.name)
        made.append(replace(its, lots=tuple(cut.lot for cut in some)))
    return number, tuple(made)


class Readings:
    """Forces (m,) measured, or sensed by calibrations and others, and how their errors move them.

    What the reference forces have in a calibration is an error of its own, which all calibrations
    of a component on them share; and what is a day's, each recording has for itself. Any other
    sensor has a gain, which all that it sensed share; a dynamometer has what is stated of it.
    """

    def __init__(self, forces: Sequence[models.SensedForce]) -> None:
        self.value_N = np.array([f.value_N for f in forces], dtype=np.float64)
        self.sd_N = np.array([f.sd_N for f in forces], dtype=np.float64)
        self._cuts = [f.cut for f in forces]
        self._recordings = np.array([cut.recording.first_id for cut in self._cuts])
        self._moved: dict[str, tuple[Shared, Array, Array]] = {}
        rows = {f.calibration.id: f.calibration for f in forces if f.calibration is not None}
        for row in rows.values():
            sensed = np.array([f.calibration_id == row.id for f in forces])
            common = np.array([f.common for f in forces if f.calibration_id == row.id])
            self._add_calibration(row, sensed, common)
        for number in sorted({f.estimator_id for f in forces if f.estimator_id is not None}):
            sensed = np.array([f.estimator_id == number for f in forces])
            share = np.array([[gain_share(f)] for f in forces if f.estimator_id == number])
            error = Shared(f"{GAIN} of sensor {number}", np.eye(1))
            self._add(error, sensed, np.zeros_like(share), share)
        for one in drifted_gains(forces) if rows else ():
            self._add_drift(one, forces)
        self._add_measured(forces)
        self.shared = tuple(one for one, _, _ in self._moved.values())
        none = np.zeros((len(forces), 0))
        self.shift = np.column_stack([none, *(shift for _, shift, _ in self._moved.values())])
        self.share = np.column_stack([none, *(share for _, _, share in self._moved.values())])

    def moved_N(self) -> dict[str, Array]:
        """Return by how much each shared error moves the readings (m,), sd, by its key."""
        moves, begin, found = self.shift + self.share * self.value_N[:, None], 0, {}
        for one in self.shared:
            columns = moves[:, begin : begin + len(one.covariance)]
            found[one.key] = np.sqrt(np.einsum("mi,ij,mj->m", columns, one.covariance, columns))
            begin += len(one.covariance)
        return found

    def _add_measured(self, forces: Sequence[models.SensedForce]) -> None:
        """Add the errors that measured forces share with others."""
        found: dict[str, dict[int, tuple[float, float]]] = {}
        for at, force in enumerate(forces):
            for one in errors_of(force):
                if one.of is not None:
                    key = shared_key(one, int(self._recordings[at]))
                    found.setdefault(key, {})[at] = (one.shift_N, one.share)
        for key, moved in found.items():
            there = np.isin(np.arange(len(forces)), list(moved))
            shift, share = np.array([moved[at] for at in sorted(moved)]).T[:, :, None]
            self._add(Shared(key, np.eye(1)), there, shift, share)

    def _add_drift(self, drift: DriftedGain, forces: Sequence[models.SensedForce]) -> None:
        """Add the gain that a calibration's axis has since it drifted."""
        there = (self._recordings >= drift.since) & np.array(
            [force.calibration_id == drift.calibration for force in forces]
        )
        if there.any():
            key = f"{GAIN} of calibration {drift.calibration} since recording {drift.since}"
            share = np.full((int(there.sum()), 1), drift.share)
            self._add(Shared(key, np.eye(1)), there, np.zeros_like(share), share)

    def _add_calibration(
        self, row: models.CalibrationVersion, sensed: NDArray[np.bool_], common: Array
    ) -> None:
        calibration = as_calibration(row)
        coefficients, form = calibration.coefficients, calibration.form
        kinds, scaling, p = calibration.errors, form.scaling(coefficients), len(coefficients)
        shift, share = form.moves(coefficients, common[:, :p], self.value_N[sensed])
        own = calibration.covariance + kinds.standing(scaling)
        self._add(Shared(f"{CALIBRATION} {row.id}", own), sensed, shift, share)
        if kinds.reference_share > 0.0:
            references = kinds.reference_share * scaling
            error = Shared(f"{REFERENCES} {row.component}", np.eye(1))
            self._add(error, sensed, *((one @ references)[:, None] for one in (shift, share)))

        # The form's choice, beyond what the calibration was made with
        if calibration.domain is not None and common[:, -1].any():
            error = Shared(beyond_its_range(row.id), np.eye(1))
            self._add(error, sensed, common[:, -1:], np.zeros((len(common), 1)))
        for k, by in enumerate(row.corrections or ()):
            later = np.array([is_after(by, cut) for cut in self._cuts])[sensed, None]
            error = Shared(f"{CALIBRATION} {row.id} corrected {k}", np.array([[by["sd"] ** 2]]))
            self._add(error, sensed, 0.0 * later, later.astype(np.float64) / by["factor"])
        for one in calibration.reference_errors:
            by = one.share * scaling
            error = Shared(shared_key(one, 0), np.eye(1))
            self._add(error, sensed, *((each @ by)[:, None] for each in (shift, share)))

        # A day's offset and gain: the offset moves what was read by the derivative kept with it
        known = kinds.group is not None
        offset = common[:, p : p + 1] if known else np.zeros((len(common), 1))
        shift = np.column_stack([shift, offset]) @ day_moves(scaling)
        share = np.column_stack([share, 0.0 * offset]) @ day_moves(scaling)
        for recording in sorted(set(self._recordings[sensed].tolist())):
            there = sensed & (self._recordings == recording)
            error = Shared(f"{DAY} of calibration {row.id}, recording {recording}", kinds.of_a_day)
            self._add(error, there, shift[there[sensed]], share[there[sensed]])

    def _add(self, error: Shared, sensed: NDArray[np.bool_], shift: Array, share: Array) -> None:
        none = np.zeros((len(sensed), len(error.covariance)))
        _, shifts, shares = self._moved.setdefault(error.key, (error, none, none.copy()))
        shifts[sensed] += shift
        shares[sensed] += share
