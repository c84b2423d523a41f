"""What machines know together, to be shown.

A machine that disagrees with others, in words and as it is kept.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from sqlalchemy.orm import Session

from autodb.agent.learn.shared_priors import known_materials, newest_prior
from autodb.cutting import shear
from autodb.errors import UnusableInput
from autodb.fitting.gaussian import NORMAL_95
from autodb.pairs.disagreeing import DisagreementCause, Disagrees
from autodb.store import models
from autodb.wording import localized, msgid, phrase, significant
from autodb.wording.kept import said_again

DISAGREES = {
    DisagreementCause.CALIBRATION.value: msgid(
        "{machine} disagrees in {pairs}: its calibration is off: {off}"
    ),
    DisagreementCause.CUTTING.value: msgid(
        "{machine} disagrees in {pairs}: its cutting is another in {pair}"
    ),
    DisagreementCause.EITHER.value: msgid(
        "{machine} disagrees in {pairs}: its calibration or its cutting is off ({off}, or {pair} "
        "is cut otherwise)"
    ),
}


@dataclass(frozen=True)
class DisagreeingMachine:
    """A machine that disagrees with others: in which pairs, and why.

    ``gain``: what its calibration would be off by along and across, shares, with ``gain_sd``;
    ``likeliest``: the pair whose cutting would be the cause; ``told_by``: from what the cause is
    determined.
    """

    machine: str
    pairs: tuple[str, ...]
    cause: str
    gain: tuple[float, float]
    gain_sd: tuple[float, float]
    likeliest: str
    told_by: str

    @property
    def words(self) -> str:
        """Say it in one sentence."""
        shares = (*self.gain, *(NORMAL_95 * one for one in self.gain_sd))
        along, across, along_half, across_half = (100.0 * one for one in shares)
        off = phrase(
            "force along {along} ± {along_half} %, across {across} ± {across_half} %",
            along=f"{along:+.0f}", along_half=f"{along_half:.0f}",
            across=f"{across:+.0f}", across_half=f"{across_half:.0f}"
        )  # fmt: skip
        said = phrase(
            DISAGREES[self.cause], machine=self.machine, pairs=", ".join(self.pairs), off=off,
            pair=self.likeliest
        )  # fmt: skip
        if self.told_by:
            said = phrase("{what}; determined from {by}", what=said, by=said_again(self.told_by))
        if self.cause == DisagreementCause.EITHER.value:
            said = phrase("{what}; make a standard cut on it to decide which", what=said)
        return said


def named_of(machine: str, pairs: Sequence[str], found: Disagrees) -> DisagreeingMachine:
    """Return how a machine with these pairs, by name, is named."""
    return DisagreeingMachine(
        machine=machine,
        pairs=tuple(pairs[k] for k in found.pairs),
        cause=found.cause.value,
        gain=found.gain,
        gain_sd=found.gain_sd,
        likeliest=pairs[found.pair],
        told_by=found.determined_from,
    )


def as_named(kept: Mapping[str, Any]) -> DisagreeingMachine:
    """Return a machine that disagrees from JSON."""
    tuples = {name: tuple(kept[name]) for name in ("pairs", "gain", "gain_sd")}
    return DisagreeingMachine(**{**kept, **tuples})


@dataclass(frozen=True)
class OfMaterial:
    """What machines know together of a material, to be shown: how far tools and machines are
    apart, shares of what metals are; ``numbers`` of the law with 95 % intervals.
    """

    material: str
    machines: int
    tools: int
    tools_apart: float
    machines_apart: float
    numbers: tuple[str, ...]


@dataclass(frozen=True)
class SharedKnowledge:
    """What machines know together, by material, and the machines that disagree."""

    materials: list[OfMaterial]
    named: list[DisagreeingMachine]


SHOWN = ("shear_stress", "friction_angle", "K_te")


def shared_knowledge(session: Session) -> SharedKnowledge:
    """Return what machines know together now; raises UnusableInput where that is nothing."""
    materials: list[OfMaterial] = []
    named: dict[str, DisagreeingMachine] = {}
    for number in known_materials(session):
        prior = newest_prior(session, number)
        if prior is None or prior.known is None:
            continue
        named |= {one["machine"]: as_named(one) for one in prior.known["named"]}
        materials.append(_shown(prior, prior.known))
    if not materials:
        raise UnusableInput(
            phrase("nothing has been fitted for all machines yet; run 'autodb fleet learn'")
        )
    ordered = sorted(materials, key=lambda one: one.material)
    return SharedKnowledge(ordered, [named[name] for name in sorted(named)])


def _shown(prior: models.FleetPrior, known: Mapping[str, Any]) -> OfMaterial:
    mean, sd = np.array(prior.mean), np.sqrt(np.diag(np.array(prior.covariance)))
    low, high = (shear.law_values(mean + side * NORMAL_95 * sd) for side in (-1.0, 1.0))
    middle = shear.law_values(mean)
    ends = {"value": middle, "low": low, "high": high}
    return OfMaterial(
        material=prior.material.name,
        machines=prior.machines,
        tools=len(known["tools"]),
        tools_apart=known["shares"]["tools"],
        machines_apart=known["shares"]["machines"],
        numbers=tuple(
            phrase(
                "{value} ({low} to {high})",
                **{end: localized(significant(at[n])) for end, at in ends.items()},
            )
            for n in SHOWN
        ),
    )
