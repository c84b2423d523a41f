"""Bands of speed with lower forces, found in all cuts of a pair: a built-up edge nobody named.

Each is one mismatch of its pair, found in the recordings that have cuts in the band, and waits for
a person: once it is confirmed, the pair's posterior has the band in it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.mismatches import IN_BAND, around, mismatch_line, recordings_of
from autodb.agent.rows.posteriors import as_posterior, latest, pair_name
from autodb.agent.rows.recorded_edges import cut_before_s
from autodb.agent.rows.sensed_forces import QUANTITY, PairForces, as_cuts, operation_of
from autodb.cutting.elements import mean_speed_m_min
from autodb.cutting.turning import PASSIVE_AXIS
from autodb.errors import UnusableInput
from autodb.fitting.gaussian import NORMAL_95
from autodb.pairs.changes.speed_bands import CutsAtSpeeds, FoundBand, speed_band
from autodb.pairs.engaged import DEPTH, FEED, SPEED
from autodb.pairs.forecast import means_of_lots
from autodb.pairs.posterior import BAND
from autodb.store import models
from autodb.terms.chip import BUILT_UP_EDGE
from autodb.wording import stored_msgid

Array = NDArray[np.float64]

LOWER = stored_msgid(
    "{pair}: around {centre} m/min all forces are lower than at other speeds ({shares}), in {cuts} "
    "cuts of {count} recordings, whatever the feed, the depth and the age of the edge"
)


def infer_speed_band(
    session: Session, machine_id: int, found: PairForces, *, upto: int
) -> list[str]:
    """Open the mismatch of a band of speeds that a pair's forces show, or bring it up to date.

    Nothing is looked for where the pair's posterior has a band, or a person has decided on one of
    these recordings. ``upto``: the last cut that counts, by id. Returns what to say.
    """
    usual = latest(session, machine_id, found.pair.id)
    if usual is None or as_posterior(usual).terms.band is not None:
        return []
    cuts = list({f.cut_id: f.cut for f in found.forces if f.cut_id <= upto}.values())
    try:
        read, expected_N = _read(usual, found, cuts)
    except UnusableInput:
        return []
    band = speed_band(read)
    if band is None:
        return []
    inside = [cut for cut, there in zip(cuts, band.inside, strict=True) if there]
    recordings = list({cut.recording_id: cut.recording for cut in inside}.values())
    known = _known(session, found.pair.id, {one.id for one in recordings})
    if any(row.status != "open" for row in known):
        return []
    columns = _columns(band, found.pair, inside, expected_N[band.inside])
    row = known[0] if known else models.Mismatch(recording=recordings[0])
    if known and row.found_in == columns["found_in"]:
        return []
    for name, value in columns.items():
        setattr(row, name, value)
    row.recording, row.further, row.pairs = recordings[0], recordings[1:], [found.pair]
    session.add(row)
    session.flush()
    return [mismatch_line(row, again=bool(known), said=row.statement)]


def _read(
    usual: models.CuttingParameters, found: PairForces, cuts: list[models.Cut]
) -> tuple[CutsAtSpeeds, Array]:
    """Return cuts with what each force is of the expected one, and the latter (n, 3), N."""
    number, made = as_cuts(cuts)
    order = [number[cut.id] for cut in cuts]
    mean = np.concatenate([means_of_lots(as_posterior(usual), some) for some in made])[order, :3]
    off, sd = (np.full(mean.shape, np.nan) for _ in range(2))
    place = {cut.id: k for k, cut in enumerate(cuts)}
    for force in found.forces:
        k, column = place.get(force.cut_id), QUANTITY[force.component]
        passive = PASSIVE_AXIS.get(operation_of(force.cut)) == force.component
        if k is not None and not passive and (force.value_N or 0.0) * mean[k, column] > 0.0:
            off[k, column] = np.log((force.value_N or 0.0) / mean[k, column])
            sd[k, column] = (force.sd_N or 0.0) / abs(force.value_N or 1.0)
    groups = [(cut.recording.first_id, operation_of(cut)) for cut in cuts]
    stated = [[_ln(cut, FEED), _ln(cut, DEPTH), cut_before_s(cut) or 0.0] for cut in cuts]
    speed = np.concatenate([mean_speed_m_min(some.elements) for some in made])[order]
    return CutsAtSpeeds(
        off,
        sd,
        np.array([sorted(set(groups)).index(one) for one in groups], dtype=np.intp),
        np.array([cut.recording.first_id for cut in cuts], dtype=np.intp),
        speed,
        np.array(stated).reshape(len(cuts), -1),
    ), mean


def _ln(cut: models.Cut, name: str) -> float:
    value = float(cut.conditions.get(name, 1.0))
    return float(np.log(value)) if value > 0.0 else 0.0


def _known(session: Session, pair_id: int, recordings: set[int]) -> list[models.Mismatch]:
    """Return the mismatches of a band of a pair in some recordings, those decided on first."""
    rows = session.scalars(
        select(models.Mismatch)
        .where(
            models.Mismatch.of_pair(pair_id),
            models.Mismatch.term == BAND,
            models.Mismatch.channel.startswith("force."),
        )
        .order_by(models.Mismatch.id)
    )
    return [row for row in rows if recordings & recordings_of([row])]


def _columns(
    band: FoundBand, pair: models.Pair, inside: Sequence[models.Cut], expected_N: Array
) -> dict[str, Any]:
    falls = {name: band.change[k] for name, k in QUANTITY.items() if np.isfinite(band.change[k])}
    component = min(falls, key=lambda name: falls[name])
    change = falls[component]
    half = NORMAL_95 * abs(change) / np.sqrt(2.0 * band.evidence)
    most_N = float(np.max(np.abs(expected_N[:, QUANTITY[component]])))
    apart = float(np.exp(0.5 * band.width))
    shares = ", ".join(f"force.{name} {100 * fall:.0f} %" for name, fall in falls.items())
    return {
        "channel": f"force.{component}",
        "term": BAND,
        "kind": "missing",
        "confidence": 1.0 / (1.0 + float(np.exp(-0.5 * band.evidence))),
        "parameters": {
            "size": around(-change * most_N, half * most_N, "N"),
            "change": around(change, half, "1"),
            "centre": {
                "value": band.centre_m_min,
                "low": band.centre_m_min / apart,
                "high": band.centre_m_min * apart,
                "unit": "m/min",
            },
            "width": around(band.width, 0.5 * band.width, "1"),
        },
        "statement": LOWER.format(
            pair=pair_name(pair),
            centre=f"{band.centre_m_min:.0f}",
            shares=shares,
            cuts=len(inside),
            count=len({cut.recording_id for cut in inside}),
        ),
        "alternatives": [],
        "variables": [SPEED],
        "intervals": [],
        "regime": [],
        "to_tell_apart": BUILT_UP_EDGE.excited_by,
        "status": "open",
        "found_in": {
            "cuts": len(inside),
            "excluded": 0,
            "edges": [],
            IN_BAND: [cut.id for cut in inside],
        },
    }
