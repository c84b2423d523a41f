"""Posteriors about pairs as the database keeps them, and what each began with."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from sqlalchemy import ColumnElement, Select, func, select
from sqlalchemy.orm import Session

from autodb.errors import UnusableInput
from autodb.fitting.gaussian import Gaussian
from autodb.pairs.posterior import (
    BAND,
    CALIBRATION,
    GAIN,
    NEAR,
    REFERENCES,
    WEAR,
    LawDiscrepancy,
    PairPosterior,
    PairTerms,
    PassiveKnown,
    Scatter,
    Shared,
    SpeedBand,
    Wear,
)
from autodb.store import models
from autodb.store.models.learning import EVERY
from autodb.terms.chip import HARD_SPOT
from autodb.wording import phrase

LAW = "thin_shear_zone"
POWER_SD = 0.3
"""How well the power of a wear is known that was kept before this was. Chosen: a step of those that
are tried."""
OF_CALIBRATIONS = (CALIBRATION, REFERENCES, GAIN)
"""What keys of errors begin with that are of what senses a machine's forces."""


def as_posterior(row: models.CuttingParameters) -> PairPosterior:
    """Return a stored version as a posterior; raises UnusableInput for an earlier law's."""
    if row.shared is None or row.scatter is None:
        raise UnusableInput(
            phrase(
                "parameters {number} are of an earlier law ({law}); run 'autodb refresh' to "
                "fit the pair again",
                number=row.id,
                law=row.law,
            )
        )
    columns = (row.mean, row.covariance, row.shared, row.scatter, row.terms)
    return posterior_of(*columns, cuts=row.n_cuts)


def posterior_of(
    mean: list[Any],
    covariance: list[Any],
    shared: list[Any],
    scatter: Mapping[str, Any],
    terms: Mapping[str, Any] | None,
    *,
    cuts: int,
) -> PairPosterior:
    """Return the posterior that a version's columns keep."""
    return PairPosterior(
        state=Gaussian(np.array(mean), np.array(covariance)),
        shared=tuple(Shared(one["key"], np.array(one["covariance"])) for one in shared),
        scatter=Scatter(np.array(scatter["share"]), np.array(scatter["weight"])),
        cuts=cuts,
        off_law=_off_law(scatter["off_law"]),
        terms=_terms(terms or {}),
        passive={k: PassiveKnown(**one) for k, one in scatter.get("passive", {}).items()},
    )


def _off_law(kept: Mapping[str, Any]) -> LawDiscrepancy:
    """Return how far off a law is; a version of before did not know a law that grows with chips."""
    grow, in_chip = tuple(kept["grow"]), tuple(kept.get("grow_in_chip", NEAR.grow_in_chip))
    return LawDiscrepancy(**{**kept, "grow": grow, "grow_in_chip": in_chip})


def _terms(kept: Mapping[str, Any]) -> PairTerms:
    return PairTerms(
        wear=_wear(kept[WEAR]) if WEAR in kept else None,
        band=_band(kept[BAND]) if BAND in kept else None,
        lots=tuple(kept.get(HARD_SPOT.name, ())),
    )


def _wear(kept: Mapping[str, Any]) -> Wear:
    along, across = kept["size"]
    power_sd = kept.get("power_sd", POWER_SD)
    return Wear(kept["power"], kept["reference_s"], kept["between"], (along, across), power_sd)


def _band(kept: Mapping[str, Any]) -> SpeedBand:
    (one, two), (three, four) = kept["covariance"]
    return SpeedBand(kept["centre_m_min"], kept["width"], ((one, two), (three, four)))


def _kept_terms(terms: PairTerms) -> dict[str, Any] | None:
    """Return what a version keeps of terms beside the law; None: there are none."""
    kept: dict[str, Any] = {}
    if terms.wear is not None:
        kept[WEAR] = asdict(terms.wear)
    if terms.band is not None:
        kept[BAND] = asdict(terms.band)
    if terms.lots:
        kept[HARD_SPOT.name] = list(terms.lots)
    return kept or None


def posterior_columns(posterior: PairPosterior) -> dict[str, Any]:
    """Return what a version keeps of a posterior, by column."""
    return {
        "law": LAW,
        "operation": EVERY,
        "component": EVERY,
        "mean": posterior.state.mean.tolist(),
        "covariance": posterior.state.covariance.tolist(),
        "shared": [
            {"key": one.key, "covariance": one.covariance.tolist()} for one in posterior.shared
        ],
        "scatter": {
            "share": posterior.scatter.share.tolist(),
            "weight": posterior.scatter.weight.tolist(),
            "off_law": asdict(posterior.off_law),
            "passive": {name: asdict(one) for name, one in posterior.passive.items()},
        },
        "terms": _kept_terms(posterior.terms),
        "n_cuts": posterior.cuts,
    }


def latest(
    session: Session, machine_id: int, pair_id: int, state: str | None = None
) -> models.CuttingParameters | None:
    """Return the newest version of a pair's posterior in a process state, none withdrawn."""
    return session.scalar(
        select(models.CuttingParameters)
        .where(
            *_of_pair(machine_id, pair_id),
            models.CuttingParameters.state.is_(None)
            if state is None
            else models.CuttingParameters.state == state,
            models.CuttingParameters.undone_at.is_(None),
        )
        .order_by(models.CuttingParameters.version.desc())
        .limit(1)
    )


def learnt_pairs(session: Session, machine_id: int) -> list[str]:
    """Return the names of the pairs that a machine has learnt.

    Of each pair one version that counts is looked for: to look at all reads their covariances.
    """
    of_machine = models.CuttingParameters.machine_id == machine_id
    versions = select(models.CuttingParameters.pair_id).where(of_machine).distinct()
    counts = (
        select(models.CuttingParameters.id)
        .where(
            of_machine,
            models.CuttingParameters.pair_id == models.Pair.id,
            models.CuttingParameters.law == LAW,
            models.CuttingParameters.undone_at.is_(None),
        )
        .exists()
    )
    rows = session.execute(
        select(models.Material.name, models.Tool.name)
        .select_from(models.Pair)
        .join(models.Material, models.Material.id == models.Pair.material_id)
        .join(models.Tool, models.Tool.id == models.Pair.tool_id)
        .where(models.Pair.id.in_(versions), counts)
    )
    return [f"{material} / {tool}" for material, tool in rows]


def newest_version(session: Session, machine_id: int, pair_id: int) -> int:
    """Return the highest version number in use, also of versions taken back; 0: none yet."""
    newest = select(func.max(models.CuttingParameters.version))
    return session.scalar(newest.where(*_of_pair(machine_id, pair_id))) or 0


def _of_pair(machine_id: int, pair_id: int) -> tuple[ColumnElement[bool], ...]:
    return (
        models.CuttingParameters.machine_id == machine_id,
        models.CuttingParameters.pair_id == pair_id,
        models.CuttingParameters.operation == EVERY,
        models.CuttingParameters.component == EVERY,
        models.CuttingParameters.law == LAW,
    )


def version_chain(parameters: models.CuttingParameters) -> list[models.CuttingParameters]:
    """Return a version and those it was built on, newest first."""
    versions = [parameters]
    while versions[-1].previous is not None:
        versions.append(versions[-1].previous)
    return versions


def chain_ids(
    versions: Iterable[models.CuttingParameters], *, down_to: int = 0
) -> Select[tuple[int]]:
    """Return the ids of versions and of those that they were built on, as a query: a chain of many
    versions is long, and each holds a covariance.

    ``down_to``: of those built on the ids from this one up, where what older ones learnt is not
    asked for.
    """
    made = models.CuttingParameters
    first = select(made.id, made.previous_id).where(made.id.in_([one.id for one in versions]))
    chain = first.cte("version_chain", recursive=True)
    chain = chain.union(
        select(made.id, made.previous_id)
        .join(chain, made.id == chain.c.previous_id)
        .where(made.id >= down_to)
    )
    return select(chain.c.id)


def resting_on(
    session: Session, machine_id: int, direct: ColumnElement[bool]
) -> list[models.CuttingParameters]:
    """Return a machine's versions of pairs, none taken back, of which a condition holds.

    Or holds of one that they were built on: a version rests on all that those rest on.
    """
    made = models.CuttingParameters
    own = made.machine_id == machine_id, made.undone_at.is_(None)
    resting = set(session.scalars(select(made.id).where(*own, direct)))
    before = select(made.id, made.previous_id).where(made.machine_id == machine_id)
    for number, previous in session.execute(before.order_by(made.id)):
        if previous in resting:
            resting.add(number)
    every = session.scalars(select(made).where(*own).order_by(made.id))
    return [one for one in every if one.id in resting]


def pair_name(pair: models.Pair) -> str:
    """Return 'material / tool'."""
    return f"{pair.material.name} / {pair.tool.name}"


def taken_back_words(row: models.CuttingParameters) -> str:
    """Return in words that a version of a pair is taken back."""
    return phrase(
        "{pair} version {version} is taken back", pair=pair_name(row.pair), version=row.version
    )


@dataclass(frozen=True)
class Start:
    """The posterior of a pair before cuts are learnt, and what it is from.

    ``row``: the related pair's parameters, where it is from one; ``prior``: what other machines
    know, where it is from that. ``before``: the posterior of the law before any of the pair's
    cuts, as it is kept; None: not known.
    """

    posterior: PairPosterior
    said: str | None
    before: Mapping[str, Any] | None
    row: models.CuttingParameters | None = None
    prior: models.FleetPrior | None = None

    @property
    def columns(self) -> dict[str, Any]:
        """What a version keeps of it, by column."""
        return {
            "started_from": self.said,
            "relative": self.row,
            "prior": self.prior,
            "start": None if self.before is None else dict(self.before),
        }


def kept_law(law: Gaussian) -> dict[str, Any]:
    """Return a posterior about the law's coordinates as JSON."""
    return {"mean": law.mean.tolist(), "covariance": law.covariance.tolist()}


def law_from_json(kept: Mapping[str, Any]) -> Gaussian:
    """Return a posterior about the law's coordinates from JSON."""
    return Gaussian(np.array(kept["mean"]), np.array(kept["covariance"]))


def began(row: models.CuttingParameters) -> Start:
    """Return a version as what the next one builds on, which began where it did."""
    return Start(as_posterior(row), row.started_from, row.start, row.relative, row.prior)


def begins(
    posterior: PairPosterior,
    said: str,
    row: models.CuttingParameters | None = None,
    prior: models.FleetPrior | None = None,
    others: Sequence[int] = (),
) -> Start:
    """Return a start from which a pair's own cuts are learnt.

    Where errors of the machine's calibrations are in it already, it is kept without them too.
    ``others``: the parameters, by id, that it is from beside those of ``row``.
    """
    before = kept_law(posterior.law)
    if others:
        before["others"] = list(others)
    if any(one.key.startswith(OF_CALIBRATIONS) for one in posterior.shared):
        before["given"] = kept_law(posterior.given(OF_CALIBRATIONS))
    return Start(posterior, said, before, row, prior)
