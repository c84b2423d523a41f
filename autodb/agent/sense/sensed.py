"""Stored cuts and their measured and sensed forces as readings that a pair's posterior learns from.

A force of a cut counts once: where it was measured, what is sensed of it does not count. A
calibration on measured forces has the errors of their dynamometer too, under the same keys, so that
cuts measured and cuts sensed never average what they share. What a cut that it was calibrated on
has for itself (noise) is not tied to the calibration's coefficients: over their cuts it averages.
"""

from collections.abc import Container, Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.agent.rows.calibration_records import as_calibration
from autodb.agent.rows.calibrations import beyond_its_range
from autodb.agent.rows.drifted import DriftedGain, drifted_gains, is_after
from autodb.agent.rows.force_errors import errors_of, shared_key
from autodb.agent.rows.sensed_forces import QUANTITY, as_cuts, gain_share
from autodb.pairs.confirmed import with_terms
from autodb.pairs.determined import CHIP_SHARE
from autodb.pairs.observed import CHIP, Observed
from autodb.pairs.posterior import CALIBRATION, DAY, GAIN, NO_TERMS, REFERENCES, PairTerms, Shared
from autodb.sensing.ranges.error_kinds import day_moves
from autodb.store import models

Array = NDArray[np.float64]
CHIP_THICKNESS = "chip.thickness"


def sd_beside_N(force: models.SensedForce, known: Container[str]) -> float:
    """Return a force's standard deviation, N, without the errors of which the key is ``known``."""
    readings = Readings([force])
    shared = [float(sd[0]) for key, sd in readings.moved_N().items() if key not in known]
    return float(np.linalg.norm([float(readings.sd_N[0]), *shared]))


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
