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
from autodb.wording import significant


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
        along, across = (100.0 * one for one in self.gain)
        sd = (100.0 * NORMAL_95 * one for one in self.gain_sd)
        off = "force along {:+.0f} ± {:.0f} %, across {:+.0f} ± {:.0f} %".format(
            *(one for pair in zip((along, across), sd, strict=True) for one in pair)
        )
        whose = {
            DisagreementCause.CALIBRATION.value: f"is off: {off}",
            DisagreementCause.CUTTING.value: f"is another in {self.likeliest}",
            DisagreementCause.EITHER.value: f"is off ({off}, or {self.likeliest} is cut otherwise)",
        }[self.cause]
        by = f"; determined from {self.told_by}" if self.told_by else ""
        hint = (
            "; make a standard cut on it to decide which"
            if self.cause == DisagreementCause.EITHER.value
            else ""
        )
        return (
            f"{self.machine} disagrees in {', '.join(self.pairs)}: {self.cause} {whose}{by}{hint}"
        )


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
            "nothing has been fitted for all machines yet; run 'autodb fleet learn'"
        )
    ordered = sorted(materials, key=lambda one: one.material)
    return SharedKnowledge(ordered, [named[name] for name in sorted(named)])


def _shown(prior: models.FleetPrior, known: Mapping[str, Any]) -> OfMaterial:
    mean, sd = np.array(prior.mean), np.sqrt(np.diag(np.array(prior.covariance)))
    low, high = (shear.law_values(mean + side * NORMAL_95 * sd) for side in (-1.0, 1.0))
    middle = shear.law_values(mean)
    return OfMaterial(
        material=prior.material.name,
        machines=prior.machines,
        tools=len(known["tools"]),
        tools_apart=known["shares"]["tools"],
        machines_apart=known["shares"]["machines"],
        numbers=tuple(
            f"{significant(middle[n])} ({significant(low[n])} to {significant(high[n])})"
            for n in SHOWN
        ),
    )
