"""What a pair's cuts do not determine, by name, and what would.

A number of the law is open where the cuts left more than OPEN of the standard deviation that it had
before them. Two are tied where either is open and their errors go together: forces see only what
both make. What would help is computed, not read from a table: each measurement that a shop can make
is added to the posterior as if it had been made, and named where it would take away a quarter of
what is open.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.shear import NAMES, PARAMETERS
from autodb.fitting.gaussian import posterior_after
from autodb.pairs.modelled import own_variance
from autodb.pairs.observed import CHIP, Observed, PairCuts
from autodb.pairs.posterior import OWN, PairPosterior
from autodb.wording import listed, msgid, phrase

Array = NDArray[np.float64]

OPEN = 0.7
TIED = 0.9
HELPS = 0.75
CHIP_SHARE = 0.05
"""How well a chip's thickness is measured. Chosen: a ball micrometer on a saw-toothed chip."""


@dataclass(frozen=True)
class UndeterminedNumbers:
    """Numbers of the law that cuts leave open, what share of their sd is left, what would help."""

    names: tuple[str, ...]
    left: float
    helps: tuple[str, ...]

    @property
    def statement(self) -> str:
        """One sentence in shop words."""
        meaning = {p.name: p.meaning for p in PARAMETERS}
        if len(self.names) > 1:
            names = listed(self.names, phrase(" and "))
            said = phrase("{numbers} not separable from these cuts", numbers=names)
        else:
            name = self.names[0]
            said = phrase(
                "{number} ({meaning}) not determined by these cuts",
                number=name,
                meaning=phrase(meaning[name]),
            )
        if not self.helps:
            return phrase("{said}; nothing that was tried determines it better", said=said)
        helps = listed(map(phrase, self.helps), phrase(" or "))
        return phrase("{said}; add {what}", said=said, what=helps)


@dataclass(frozen=True)
class PossibleMeasurement:
    """A measurement that a shop can make: what it is called, readings as of it."""

    called: str
    observed: Observed


def undetermined(
    prior: PairPosterior, posterior: PairPosterior, trials: Sequence[PossibleMeasurement]
) -> tuple[UndeterminedNumbers, ...]:
    """Return what cuts leave open of a posterior that began as ``prior``."""
    before, after = (np.sqrt(np.diag(one.law.covariance)) for one in (prior, posterior))
    left = np.divide(after, before, out=np.zeros_like(after), where=before > 0)
    size = np.where(after > 0, after, 1.0)
    together = posterior.law.covariance / np.outer(size, size)
    open_ = [k for k in np.argsort(-left) if left[k] > OPEN]
    found, described = [], set[int]()
    for k in open_:
        if k in described:
            continue
        others = [j for j in range(OWN) if j != k and abs(together[k, j]) > TIED]
        group = (int(k), *others)
        described.update(group)
        helps = tuple(one.called for one in trials if _left_after(posterior, one, k) < HELPS)
        found.append(UndeterminedNumbers(tuple(NAMES[j] for j in group), float(left[k]), helps))
    return tuple(found)


def _left_after(posterior: PairPosterior, trial: PossibleMeasurement, k: int) -> float:
    """Return which share of a number's sd a trial would leave."""
    observed = trial.observed
    theta = posterior.law.mean
    noise = np.sqrt(
        observed.sd**2 + own_variance(posterior.scatter, posterior.off_law, observed.off(theta))
    )
    expected = observed.parts(theta).sum(axis=1)
    after = posterior_after(posterior.law, observed.slopes(theta), expected, noise)
    return float(np.sqrt(after.covariance[k, k] / posterior.law.covariance[k, k]))


def chip_thickness(posterior: PairPosterior, cuts: PairCuts) -> PossibleMeasurement:
    """Return the trial of measuring the chips of cuts."""
    count = cuts.elements.count
    readings = Observed(
        (cuts,), np.arange(count), np.full(count, CHIP), np.zeros(count), np.ones(count),
        np.zeros((count, 0)),
    )  # fmt: skip
    expected = readings.parts(posterior.law.mean).sum(axis=1)
    return PossibleMeasurement(
        msgid("a measured chip thickness"),
        replace(readings, value=expected, sd=CHIP_SHARE * expected),
    )
