"""A gain of a sensing axis that has drifted is opened as one mismatch, with all pairs it shows in.

Looked for in what the newest recordings of all pairs sensed with one calibration an axis, beside
what each pair's newest version expects (``autodb.pairs.changes.drifting_gain``).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from math import exp
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.rows.mismatches import GAIN_TERM, SINCE, is_of_axis, mismatch_line, recordings_of
from autodb.agent.rows.posteriors import as_posterior, latest, pair_name
from autodb.agent.rows.recorded_edges import cut_before_s
from autodb.agent.rows.refresh_cursor import Span
from autodb.agent.rows.sensed_forces import QUANTITY, Calibrations, as_cuts, forces_of_pair
from autodb.cutting.turning import PASSIVE_AXIS
from autodb.errors import UnusableInput
from autodb.fitting.gaussian import NORMAL_95
from autodb.pairs.changes.drifting_gain import GainDrift, drifted_gain
from autodb.pairs.changes.shared_shifts import PAIRS, SensedShares
from autodb.pairs.engaged import DEPTH, FEED, RPM
from autodb.pairs.forecast import expected_means
from autodb.store import models
from autodb.terms.chip import HARD_SPOT
from autodb.wording import stored_msgid

NEWEST = 24
"""Recordings that are looked at. Chosen: some seconds' work, and a month of a shop."""
HARDER = HARD_SPOT.name
"""What else the cuts of pairs that read higher may be."""
TOO_HIGH = stored_msgid(
    "since {file} {channel} reads {share} ({low} to {high}) too high in {count} pairs ({pairs}), "
    "whatever the age of their edges, and other components do not: the calibration of {axis} is due"
)
TOO_LOW = stored_msgid(
    "since {file} {channel} reads {share} ({low} to {high}) too low in {count} pairs ({pairs}), "
    "whatever the age of their edges, and other components do not: the calibration of {axis} is due"
)
MAKE_AGAIN = stored_msgid(
    "make cut {cut} of the calibration again with a new edge (depth {depth}, feed {feed}, "
    "{speed}): {channel} near {force} in place of {before} says that the axis has drifted"
)


@dataclass(frozen=True)
class SensedBesideExpected:
    """A force that a calibration sensed, and what its pair's newest version expects, N."""

    force: models.SensedForce
    expected_N: float


def open_drifted_gains(
    session: Session, owner: models.Machine, span: Span, sensed: Sequence[Calibrations]
) -> list[str]:
    """Open or bring up to date the mismatch of an axis whose gain has drifted; say which.

    Nothing is looked for where no cut came in, or fewer than PAIRS pairs are sensed.
    """
    if span.upto <= span.old:
        return []
    read = sensed_beside_expected(session, owner, span, sensed)
    if len({one.force.cut.pair_id for one in read}) < PAIRS:
        return []
    recordings = sorted({one.force.cut.recording.first_id for one in read})
    components = sorted({one.force.component for one in read})
    pairs = sorted({one.force.cut.pair_id or 0 for one in read})
    found = drifted_gain(_shares(read, pairs, recordings, components))
    if found is None:
        return []
    component = components[found.component]
    own = [one for one in read if one.force.component == component]
    since = [r for r in recordings if r >= recordings[found.since]]
    drift = _Drift(session, owner, found, own, [pairs[k] for k in found.pairs], since)
    return drift.kept()


def sensed_beside_expected(
    session: Session, owner: models.Machine, span: Span, sensed: Sequence[Calibrations]
) -> list[SensedBesideExpected]:
    """Return what the newest calibration of each component has sensed in the newest recordings."""
    current = {rows[0].id for rows in sensed}
    force, cut, recording = models.SensedForce, models.Cut, models.StoredRecording
    sensed_by_them = (
        select(cut.id)
        .join(force, force.cut_id == cut.id)
        .where(
            cut.recording_id == recording.id,
            cut.id <= span.upto,
            models.counting_cut(cut.superseded_at),
            force.calibration_id.in_(current),
            force.value_N.is_not(None),
        )
        .exists()
    )
    newest = session.scalars(
        select(recording.id)
        .where(recording.machine_id == owner.id, sensed_by_them)
        .order_by(recording.id.desc())
        .limit(NEWEST)
    ).all()
    if not newest:
        return []
    pairs = session.scalars(
        select(models.Pair)
        .where(models.Pair.id.in_(select(cut.pair_id).where(cut.recording_id.in_(newest))))
        .order_by(models.Pair.id)
    ).all()
    first = session.scalar(select(func.min(cut.id)).where(cut.recording_id.in_(newest))) or 1
    of_cuts = (first - 1, span.upto)
    every = (_of_pair(session, owner, pair, sensed, of_cuts=of_cuts) for pair in pairs)
    return [
        one
        for one in chain.from_iterable(every)
        if one.force.cut.recording_id in newest and one.force.calibration_id in current
    ]


def _of_pair(
    session: Session,
    owner: models.Machine,
    pair: models.Pair,
    sensed: Sequence[Calibrations],
    *,
    of_cuts: tuple[int, int],
) -> list[SensedBesideExpected]:
    """Return what was sensed of a pair that the machine has learnt, each force above none.

    ``of_cuts``: behind which cut, by id, and up to which.
    """
    usual = latest(session, owner.id, pair.id)
    forces = forces_of_pair(session, owner.id, pair, sensed, cuts=of_cuts).forces
    if usual is None or not forces:
        return []
    try:
        number, made = as_cuts(list({force.cut_id: force.cut for force in forces}.values()))
        posterior = as_posterior(usual)
        mean = np.concatenate([expected_means(posterior, some) for some in made])
    except UnusableInput:
        return []
    every = [
        SensedBesideExpected(force, float(mean[number[force.cut_id], QUANTITY[force.component]]))
        for force in forces
        if force.component != PASSIVE_AXIS.get(force.cut.operation or "")
    ]
    return [one for one in every if (one.force.value_N or 0.0) * one.expected_N > 0.0]


def _shares(
    read: Sequence[SensedBesideExpected],
    pairs: list[int],
    recordings: list[int],
    components: list[str],
) -> SensedShares:
    cuts = [one.force.cut for one in read]
    ratio = [(one.force.value_N or 0.0) / one.expected_N for one in read]
    used = [np.nan if one is None else one for one in map(cut_before_s, cuts)]
    clock = np.array([float(cut.conditions.get("t", 0.0)) for cut in cuts])
    of = np.array([cut.recording_id for cut in cuts])
    for number in np.unique(of):
        clock[of == number] -= clock[of == number].min()
    return SensedShares(
        pair=np.array([pairs.index(cut.pair_id or 0) for cut in cuts], dtype=np.intp),
        recording=np.array([recordings.index(c.recording.first_id) for c in cuts], dtype=np.intp),
        component=np.array([components.index(r.force.component) for r in read], dtype=np.intp),
        off=np.log(ratio),
        used_s=np.array(used),
        clock_s=clock,
    )


@dataclass(frozen=True)
class _Drift:
    """A drift that was found in what ``own`` forces of its component show, and how it is kept."""

    session: Session
    owner: models.Machine
    found: GainDrift
    own: list[SensedBesideExpected]
    pairs: list[int]
    since: list[int]

    def kept(self) -> list[str]:
        """Keep it, unless it was decided on; say so where it is new or grew by recordings."""
        known = [
            row
            for row in self.session.scalars(
                select(models.Mismatch)
                .join(models.StoredRecording)
                .where(
                    models.StoredRecording.machine_id == self.owner.id,
                    models.Mismatch.term == GAIN_TERM,
                    models.Mismatch.channel == self._channel,
                )
                .order_by(models.Mismatch.id.desc())
            )
            if is_of_axis(row) and set(self.since) & recordings_of([row])
        ]
        if any(row.status != "open" for row in known):
            return []
        recordings = [self.session.get_one(models.StoredRecording, k) for k in self.since]
        row = known[0] if known else models.Mismatch(recording=recordings[0])
        for name, value in self._columns().items():
            setattr(row, name, value)
        row.recording, row.further = recordings[0], recordings[1:]
        row.pairs = [self.session.get_one(models.Pair, number) for number in self.pairs]
        self.session.add(row)
        self.session.flush()
        return [mismatch_line(row, again=bool(known), said=row.statement)]

    @property
    def _channel(self) -> str:
        return f"force.{self.own[0].force.component}"

    @property
    def _calibration(self) -> models.CalibrationVersion:
        found = self.own[0].force.calibration
        assert found is not None  # of what a calibration has sensed
        return found

    def _columns(self) -> dict[str, Any]:
        low, value, high = (
            exp(self.found.share + k * NORMAL_95 * self.found.sd) for k in (-1.0, 0.0, 1.0)
        )
        after = [one for one in self.own if one.force.cut.recording.first_id in self.since]
        most = max(abs(one.expected_N) for one in after)
        sizes = sorted(abs(end - 1.0) * most for end in (low, high))
        return {
            "channel": self._channel,
            "term": GAIN_TERM,
            "kind": "missing",
            "confidence": self.found.probability,
            "parameters": {
                "factor": {"value": value, "low": low, "high": high, "unit": "1"},
                "size": {
                    "value": abs(value - 1.0) * most,
                    "low": sizes[0], "high": sizes[1], "unit": "N",
                },
            },
            "statement": self._statement(value, low, high),
            "alternatives": [HARDER] if self.found.others else [],
            "variables": ["t"],
            "intervals": [],
            "regime": [],
            "to_tell_apart": self._standard_cut(value),
            "status": "open",
            "found_in": {
                "cuts": len({one.force.cut_id for one in after}),
                "excluded": 0,
                "edges": [],
                SINCE: self.since[0],
                "calibration": self._calibration.id,
            },
        }  # fmt: skip

    def _statement(self, value: float, low: float, high: float) -> str:
        ends = sorted(abs(end - 1.0) for end in (low, high))
        names = [pair_name(self.session.get_one(models.Pair, number)) for number in self.pairs]
        first = Path(self.session.get_one(models.StoredRecording, self.since[0]).path).name
        return (TOO_HIGH if value > 1.0 else TOO_LOW).format(
            file=first, channel=self._channel, share=f"{100 * abs(value - 1.0):.1f} %",
            low=f"{100 * ends[0]:.1f}", high=f"{100 * ends[1]:.1f}", count=len(names),
            pairs=", ".join(names), axis=self._calibration.axis,
        )  # fmt: skip

    def _standard_cut(self, factor: float) -> str | None:
        """Return which cut of the calibration, made again, tells the axis from the work."""
        name = self._channel
        cuts = [
            cut
            for recording in self._calibration.recordings
            for cut in recording.cuts
            if name in cut.measured and {DEPTH, FEED, RPM} <= cut.conditions.keys()
            and PASSIVE_AXIS.get(cut.operation or "") != self.own[0].force.component
        ]  # fmt: skip
        if not cuts:
            return None
        cuts.sort(key=lambda cut: abs(float(cut.measured[name])))
        cut = cuts[len(cuts) // 2]
        force = float(cut.measured[name])
        return MAKE_AGAIN.format(
            cut=f"{cut.number:g}", depth=f"{cut.conditions[DEPTH]:g} mm",
            feed=f"{cut.conditions[FEED]:g} mm", speed=f"{cut.conditions[RPM]:.0f} rpm",
            channel=name, force=f"{force * factor:.0f} N", before=f"{force:.0f} N",
        )  # fmt: skip
