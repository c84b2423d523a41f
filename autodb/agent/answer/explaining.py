"""The machine's own stored models as the simulation; what they leave out is kept as mismatches."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.as_imported import as_imported, signed
from autodb.agent.ingest.importing import import_file
from autodb.agent.rows.calibration_records import as_calibration
from autodb.agent.rows.calibrations import current_calibrations
from autodb.agent.rows.drifted import corrected
from autodb.agent.rows.edges_in_use import conditions_in_use
from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.posteriors import as_posterior, latest
from autodb.agent.rows.recordings import counted_cuts, cuts_as_table
from autodb.agent.rows.sensed_forces import QUANTITY, as_cuts, usable
from autodb.errors import UnusableInput
from autodb.explain import Explained, explain
from autodb.explain.answer import Cause, ChannelAnswer
from autodb.files.side import StatedColumns
from autodb.pairs.forecast import means_of_lots
from autodb.records import source as records
from autodb.records.tables import CutTable, Recording
from autodb.sensing.ranges import chosen
from autodb.store import Store, models
from autodb.wording import phrase

Array = NDArray[np.float64]

Stamps = Mapping[int, tuple[float, float]]
"""Number and time, s, of cuts by id, in an order and on a clock that several recordings share."""
Key = tuple[str, str, str]
"""Channel, term and kind of a cause."""


@dataclass(frozen=True)
class KeptCause:
    """A cause's row in the database: its number, and whether it was decided on already."""

    number: int
    status: str


@dataclass(frozen=True)
class AgainstMachine:
    """An explanation, and where each of its causes is kept."""

    explained: Explained
    kept: dict[Key, KeptCause]


def explain_with_machine(
    store: Store, machine: str, path: Path, *, columns: StatedColumns = None
) -> AgainstMachine:
    """Explain a recording against the machine's own stored models.

    The terms that a model has can only be mistuned. The recording is kept if it is not there yet,
    to be explained alone: nothing is learnt from it, unless it is imported or a mismatch is
    confirmed; mismatches are kept as open, once for a recording, channel, term and kind.

    Raises UnusableInput when the machine has no model of any channel of the recording.
    """
    imported = import_file(store, path, machine=machine, columns=columns, looked_at=True)
    table = records.read(path, columns=columns)
    with store.reading() as session:
        owner = find_machine(session, machine)
        if isinstance(table, CutTable):
            row = session.get_one(models.StoredRecording, imported.recording_id)
            explained = _of_cuts(session, owner, row)
        else:
            explained = _over_time(session, owner, table)
    with store.writing(machine) as session:
        kept = keep_mismatches(session, imported.recording_id, explained)
    return AgainstMachine(explained, kept)


def explain_recording(session: Session, row: models.StoredRecording) -> Explained:
    """Explain a recording of the database against its machine's models now; nothing is kept.

    Raises UnusableInput where no file of it is there as it was imported, or as
    ``explain_with_machine``.
    """
    owner = session.get_one(models.Machine, row.machine_id)
    table = as_imported(row)
    if isinstance(table, CutTable):
        return _of_cuts(session, owner, row)
    return _over_time(session, owner, table)


def _of_cuts(session: Session, owner: models.Machine, row: models.StoredRecording) -> Explained:
    sensed, predicted, has = expected_and_sensed(session, owner, counted_cuts(row))
    return explain(sensed, predicted, includes=has)


def _over_time(session: Session, owner: models.Machine, recording: Recording) -> Explained:
    from autodb.agent.answer.explaining_over_time import explain_over_time

    return explain_over_time(session, owner, signed(recording, owner))


def expected_and_sensed(
    session: Session,
    owner: models.Machine,
    cuts: list[models.Cut],
    *,
    stamps: Stamps | None = None,
) -> tuple[CutTable, CutTable, list[str]]:
    """Return the sensed forces of cuts, those that the pairs' posteriors expect, and these' terms.

    Both hold the components that are sensed in every cut; cuts of pairs not learnt yet, and those
    whose forces cannot be worked out, are left out. ``stamps``: of cuts of several recordings;
    None: each has its own number and time. Raises UnusableInput when nothing is left.
    """
    kept, expected_N, has = _expected(session, owner, cuts)
    if stamps is not None:
        order = sorted(range(len(kept)), key=lambda k: stamps[kept[k].id])
        kept, expected_N = [kept[k] for k in order], expected_N[order]
    if not kept:
        raise UnusableInput(
            phrase(
                "no cut belongs to a work-tool pair that the machine has parameters of; run "
                "'autodb refresh' first"
            )
        )
    table = cuts_as_table(kept, path=Path(kept[0].recording.path), conditions=_in_use(kept))
    if stamps is not None:
        number, t_s = np.array([stamps[cut.id] for cut in kept]).T
        table = replace(table, channels={**table.channels, "cut": number, "t": t_s})
    sensed: dict[str, Array] = {}
    predicted: dict[str, Array] = {}
    for axis in owner.axes:
        current = current_calibrations(session, owner.id, axis.name)
        if not any(row.offered for row in current):
            continue
        component = current[0].component
        force = _sensed_N(table, kept, current)
        mean = expected_N[:, QUANTITY[component]]
        if np.isfinite(force).all() and np.isfinite(mean).all():
            sensed[f"force.{component}"] = force
            predicted[f"force.{component}"] = mean
    if not sensed:
        raise UnusableInput(
            phrase("{file}: no force component is sensed in every cut", file=table.path)
        )
    others = {n: c for n, c in table.channels.items() if not n.startswith("force.")}
    known = {n: c for n, c in others.items() if np.isfinite(c).all()}
    return (
        CutTable(path=table.path, channels={**known, **sensed}, texts=table.texts),
        CutTable(path=table.path, channels={"cut": table.cut, **predicted}),
        has,
    )


def _sensed_N(
    table: CutTable, cuts: list[models.Cut], current: list[models.CalibrationVersion]
) -> Array:
    """Return the force that an axis senses in cuts (n,), corrected; NaN where it senses none."""
    read = chosen.sense_each(table, [as_calibration(row) for row in current])
    sensed = [corrected(current, cut, one).force_N for cut, one in zip(cuts, read, strict=True)]
    return np.array([np.nan if force is None else force for force in sensed])


def _in_use(cuts: Sequence[models.Cut]) -> dict[int, Mapping[str, Any]]:
    """Return the conditions of cuts by id, with the edges that they were made with."""
    found: dict[int, Mapping[str, Any]] = {}
    for pair_id in dict.fromkeys(cut.pair_id for cut in cuts):
        own = [cut for cut in cuts if cut.pair_id == pair_id]
        found |= {cut.id: one for cut, one in zip(own, conditions_in_use(own), strict=True)}
    return found


def _expected(
    session: Session, owner: models.Machine, cuts: list[models.Cut]
) -> tuple[list[models.Cut], Array, list[str]]:
    """Return the cuts of pairs that the machine has learnt, and the forces x, y, z expected, N.

    And the terms that these have: beside the law's own those that were confirmed of a pair.
    """
    has = ["shear", "edge_force"]
    kept: list[models.Cut] = []
    forces: list[Array] = []
    for pair_id in dict.fromkeys(cut.pair_id for cut in cuts if usable(cut)):
        row = None if pair_id is None else latest(session, owner.id, pair_id)
        if row is not None:
            posterior = as_posterior(row)
            has += [str(one.confirmed_term) for one in row.mismatches]
            number, made = as_cuts([cut for cut in cuts if cut.pair_id == pair_id and usable(cut)])
            means = np.concatenate([means_of_lots(posterior, some)[:, :3] for some in made])
            for cut in cuts:
                if cut.id in number:
                    kept.append(cut)
                    forces.append(means[number[cut.id]])
    order = np.argsort([cut.number for cut in kept], kind="stable")
    expected_N = np.array([forces[k] for k in order]).reshape(-1, 3)
    return [kept[k] for k in order], expected_N, list(dict.fromkeys(has))


def keep_mismatches(
    session: Session, recording_id: int, explained: Explained
) -> dict[Key, KeptCause]:
    """Keep every cause that is not there yet as an open mismatch; return where all of them are.

    Of several of one term and kind in a channel, as without a name, the first is kept: the largest.
    """
    old = session.scalars(
        select(models.Mismatch).where(models.Mismatch.found_in_any([recording_id]))
    )
    known = {key_of(row): row for row in old}
    found = [
        ((channel, cause.term, cause.kind), cause_columns(channel, answer, cause))
        for channel, answer in explained.explanation.channels.items()
        for cause in answer.missing
    ]
    rows: dict[Key, models.Mismatch] = {}
    for key, columns in found:
        if key not in rows:
            rows[key] = known.get(key) or models.Mismatch(recording_id=recording_id, **columns)
    session.add_all(rows.values())
    session.flush()
    return {key: KeptCause(row.id, row.status) for key, row in rows.items()}


def key_of(row: models.Mismatch) -> Key:
    """Return what tells a mismatch from others of its recordings."""
    return (row.channel, row.confirmed_term or row.term, row.kind)


def cause_columns(channel: str, answer: ChannelAnswer, cause: Cause) -> dict[str, Any]:
    """Return what a mismatch keeps of a cause, by column; nobody has decided on it."""
    return {
        "channel": channel,
        "term": cause.term,
        "kind": cause.kind,
        "confidence": cause.confidence,
        "parameters": {k: v.model_dump() for k, v in cause.parameters.items()},
        "statement": cause.statement,
        "alternatives": list(cause.alternatives),
        "variables": list(cause.variables),
        "intervals": [list(interval) for interval in answer.where.intervals],
        "regime": [regime.model_dump() for regime in answer.where.regime],
        "to_tell_apart": cause.to_tell_apart,
        "status": "open",
    }
