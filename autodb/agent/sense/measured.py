"""Forces that were measured in cuts, beside those that are sensed: each with its own errors.

A force channel of a cut is kept as a force once, with what is known of its errors: from the side
file, else from the machine's file (``autodb.sensing.dynamometer``). Where a machine's file comes to
state another dynamometer, its recordings' forces are kept anew; the newest counts.
"""

from collections.abc import Hashable, Sequence
from dataclasses import asdict

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.refresh_cursor import Span
from autodb.files.dynamometer import COMPONENTS, DynamometerSection
from autodb.files.side import SideFile
from autodb.pairs.posterior import DAY, GAIN
from autodb.sensing.dynamometer import ForceError, ForceStatement, MeasuredForces, mean_errors
from autodb.store import models

MEASURED = "dynamometer"
"""What a measured force has as its estimator."""
_CHANNELS = {c: f"force.{c}" for c in COMPONENTS}
_SAME_CUT = (
    "cutting.feed", "cutting.depth", "cutting.width", "cutting.speed", "cutting.direction",
    "spindle.speed", "work.diameter", "tool.edge",
)  # fmt: skip
"""What repeats of a cut have in common, to three digits."""


def statement_of(owner: models.Machine, recording: models.StoredRecording) -> ForceStatement:
    """Return where the forces of a recording are from: its side file says, else the machine's."""
    side = SideFile.model_validate(recording.side)
    if side.dynamometer is not None or side.source is not None or owner.dynamometer is None:
        return ForceStatement(side.dynamometer, side.source)
    return ForceStatement(DynamometerSection.model_validate(owner.dynamometer))


def measured_in(cut: models.Cut) -> dict[str, float]:
    """Return the forces that were measured in a cut, N by component."""
    return {c: float(cut.measured[name]) for c, name in _CHANNELS.items() if name in cut.measured}


def take_measured(session: Session, owner: models.Machine, span: Span) -> None:
    """Keep the forces that were measured in the cuts of a span, unless they are kept as stated."""
    cuts = session.scalars(
        select(models.Cut)
        .where(
            models.Cut.id > span.after,
            models.Cut.id <= span.upto,
            models.Cut.superseded_at.is_(None),
            models.Cut.recording.has(machine_id=owner.id),
        )
        .order_by(models.Cut.id)
    )
    by_recording: dict[int, list[models.Cut]] = {}
    for cut in cuts:
        if measured_in(cut):
            by_recording.setdefault(cut.recording_id, []).append(cut)
    for some in by_recording.values():
        _take(session, owner, some)
    session.flush()


def _take(session: Session, owner: models.Machine, cuts: Sequence[models.Cut]) -> None:
    """Keep the measured forces of some cuts of one recording."""
    recording = cuts[0].recording
    statement = statement_of(owner, recording)
    counting = [cut for cut in recording.cuts if cut.superseded_at is None]
    every = MeasuredForces(
        [measured_in(cut) for cut in counting], [_conditions(cut) for cut in counting]
    )
    noise = {c: statement.noise(c, every) for c in COMPONENTS}
    kept = _kept(session, cuts)
    for cut in cuts:
        forces_N = measured_in(cut)
        for c, force_N in forces_N.items():
            errors = [noise[c], *statement.errors(c, forces_N)]
            row = measured_row(cut, c, force_N, errors)
            before = kept.get((cut.id, c))
            if before is None or _shared(before) != _shared(row):
                session.add(row)


def measured_row(
    cut: models.Cut, component: str, force_N: float, errors: Sequence[ForceError]
) -> models.SensedForce:
    """Return a measured force as the database keeps it; its own errors make its sd."""
    own = [one.standard_N(force_N) for one in errors if one.of is None]
    return models.SensedForce(
        cut_id=cut.id,
        component=component,
        estimator=MEASURED,
        value_N=force_N,
        sd_N=float(np.linalg.norm(own)),
        errors=[asdict(one) for one in errors],
    )


def errors_of(row: models.SensedForce) -> list[ForceError]:
    """Return the errors of a measured force."""
    return [ForceError(**one) for one in row.errors or ()]


def _shared(row: models.SensedForce) -> list[ForceError]:
    """Return what a force shares with others: noise that more cuts tell better is no news."""
    return [one for one in errors_of(row) if one.of is not None]


def shared_key(error: ForceError, recording: int) -> str:
    """Return the key under which a pair's posterior keeps an error that forces share."""
    return (
        f"{DAY} of {error.of}, recording {recording}" if error.passing else f"{GAIN} of {error.of}"
    )


def _kept(
    session: Session, cuts: Sequence[models.Cut]
) -> dict[tuple[int, str], models.SensedForce]:
    """Return the newest measured force of each component of cuts, by cut and component."""
    rows = session.scalars(
        select(models.SensedForce)
        .join(models.Cut)
        .where(
            models.SensedForce.estimator == MEASURED,
            models.Cut.recording_id == cuts[0].recording_id,
        )
        .order_by(models.SensedForce.id)
    )
    return {(row.cut_id, row.component): row for row in rows}


def _conditions(cut: models.Cut) -> Hashable:
    """Return what repeats of a cut have in common."""
    said = [cut.conditions.get(name) for name in _SAME_CUT]
    short = [f"{one:.3g}" if isinstance(one, float) else one for one in said]
    return (cut.pair_id, cut.operation, *short)


def reference_errors(
    owner: models.Machine, cuts: Sequence[models.Cut], component: str
) -> tuple[ForceError, ...]:
    """Return the errors of the dynamometer that all forces of a calibration's cuts share."""
    statements: dict[int, ForceStatement] = {}
    errors, forces_N = [], []
    for cut in cuts:
        measured = measured_in(cut)
        if component in measured:
            if cut.recording_id not in statements:
                statements[cut.recording_id] = statement_of(owner, cut.recording)
            errors.append(statements[cut.recording_id].errors(component, measured))
            forces_N.append(measured[component])
    return tuple(mean_errors(errors, np.array(forces_N)))
