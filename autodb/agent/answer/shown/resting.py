"""What rests on a recording: calibrations, drive models, sensors, parameters and mismatches."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Select, select
from sqlalchemy.orm import Session

from autodb.agent.rows.posteriors import pair_name
from autodb.files.channels import axis_words
from autodb.store import models
from autodb.wording import amount_words, phrase

MOST = 200
"""Versions of parameters that are listed of one recording, the newest. Chosen."""


@dataclass(frozen=True)
class Resting:
    """A row that was made with a recording: of which kind and number, as a trace names it.

    ``undone``: it was taken back.
    """

    kind: str
    number: int
    words: str
    made_at: str
    undone: bool = False


def resting_on_recording(session: Session, row: models.StoredRecording) -> tuple[Resting, ...]:
    """Return what was made with a recording, kind by kind, the newest first."""
    of_it = models.StoredRecording.id == row.id
    return tuple(
        one
        for kind, query, words in (
            ("calibration", _with(models.CalibrationVersion, of_it), _calibration),
            ("model", _with(models.ChannelModel, of_it), _model),
            ("scale", _scales(row), _scale),
            ("sensor", _with(models.Estimator, of_it), _sensor),
            ("parameters", _parameters(row), _version),
            ("mismatch", _mismatches(row), _mismatch),
        )
        for one in _each(session, kind, query, words)
    )


def _each(session: Session, kind: str, query: Select[Any], words: Any) -> Iterator[Resting]:
    for one in session.scalars(query.limit(MOST)):
        made_at = one.since if isinstance(one, models.Estimator) else one.created_at
        undone = getattr(one, "undone_at", None) is not None
        yield Resting(kind, one.id, words(one), made_at, undone)


def _with(table: Any, of_it: Any) -> Select[Any]:
    return select(table).where(table.recordings.any(of_it)).order_by(table.id.desc())


def _scales(row: models.StoredRecording) -> Select[Any]:
    table = models.DriveScale
    return select(table).where(table.recording_id == row.id).order_by(table.id.desc())


def _parameters(row: models.StoredRecording) -> Select[Any]:
    """Ask by what links versions to forces: by its index, whatever else the pairs have learnt."""
    link, force, cut = models.cutting_parameters_force.c, models.SensedForce, models.Cut
    numbers = (
        select(link.cutting_parameters_id)
        .join(force, force.id == link.sensed_force_id)
        .join(cut, cut.id == force.cut_id)
        .where(cut.recording_id == row.id)
    )
    table = models.CuttingParameters
    return select(table).where(table.id.in_(numbers)).order_by(table.id.desc())


def _mismatches(row: models.StoredRecording) -> Select[Any]:
    table = models.Mismatch
    return select(table).where(table.found_in_any([row.id])).order_by(table.id.desc())


def _calibration(one: models.CalibrationVersion) -> str:
    return phrase(
        "calibration of {axis}, version {version} ({usable})",
        axis=axis_words(one.axis),
        version=one.version,
        usable=phrase("usable") if one.offered else phrase("not usable"),
    )


def _model(one: models.ChannelModel) -> str:
    return phrase(
        "drive model of {channel}, version {version}", channel=one.channel, version=one.version
    )


def _scale(one: models.DriveScale) -> str:
    return phrase(
        "force constant of {axis}, version {version}: {value}",
        axis=axis_words(one.axis),
        version=one.version,
        value=amount_words(one.per_ampere, "N/A", ".4g"),
    )


def _sensor(one: models.Estimator) -> str:
    return phrase(
        "sensor {kind} of force {axis}, version {version}",
        kind=one.kind,
        axis=one.component.upper(),
        version=one.version,
    )


def _version(one: models.CuttingParameters) -> str:
    return phrase(
        "{pair}, version {version} ({cuts} cuts)",
        pair=pair_name(one.pair),
        version=one.version,
        cuts=one.n_cuts,
    )


def _mismatch(one: models.Mismatch) -> str:
    return phrase(
        "mismatch {number} in {channel}: {term}, {status}",
        number=one.id,
        channel=one.channel,
        term=one.term,
        status=phrase(one.status),
    )
