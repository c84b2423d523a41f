"""What a new version of a pair expects of a usual cut, where that has moved."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autodb.agent.learn.usual_cut import nearest_to_median
from autodb.agent.rows.catalogue import numbers_of
from autodb.agent.rows.sensed_forces import QUANTITY, operation_of
from autodb.fitting.gaussian import NORMAL_95
from autodb.pairs.engaged import BY_NAME, DEPTH, FEED, SPEED
from autodb.pairs.forecast import forecast
from autodb.pairs.posterior import PairPosterior
from autodb.store import models
from autodb.wording import amount_words, localized, phrase, shop_amount
from autodb.wording.kept import said_again


@dataclass(frozen=True)
class ForceShift:
    """A force component of a cut: what was expected ± 95 %, and what is now; in N."""

    pair: str
    cut: str
    component: str
    before_N: float
    half_N: float
    after_N: float
    half_after_N: float

    @property
    def words(self) -> str:
        """Return it as a sentence."""
        ends = (
            (self.before_N, self.half_N),
            (self.after_N, self.half_after_N),
        )
        before, after = (f"{_mean(mean)} ± {amount_words(half, 'N', '.0f')}" for mean, half in ends)
        return phrase(
            "{pair}: force.{axis} of a typical cut ({cut}) moved from {before} to {after}",
            pair=self.pair,
            axis=self.component,
            cut=said_again(self.cut),
            before=before,
            after=after,
        )


def _mean(force_N: float) -> str:
    return localized(f"{shop_amount(force_N, 'N')[0]:.0f}")


def shifts(
    name: str, before: PairPosterior, after: PairPosterior, forces: Sequence[models.SensedForce]
) -> list[ForceShift]:
    """Return which mean forces of a usual cut moved by more than was open of them (95 %).

    ``forces``: those learnt since, whose cut nearest to the median of depth, feed and speed is the
    usual one; of the components that were sensed.
    """
    cuts = list({force.cut_id: force.cut for force in forces}.values())
    cut = nearest_to_median(cuts)
    tool = cut.pair.tool if cut.pair else None
    if tool is None:
        return []
    made = BY_NAME[operation_of(cut)].cuts(numbers_of(tool), [cut.conditions], called=tool.name)
    was, now = forecast(before, made), forecast(after, made)
    found = []
    for component in sorted({force.component for force in forces}):
        k = QUANTITY[component]
        half, half_now = (
            NORMAL_95 * float(np.sqrt(max(one.sd[0, k] ** 2 - one.own[0, k], 0.0)))
            for one in (was, now)
        )
        old, new = float(was.mean[0, k]), float(now.mean[0, k])
        if abs(new - old) > half:
            found.append(ForceShift(name, _words(cut), component, old, half, new, half_now))
    return found


def _words(cut: models.Cut) -> str:
    said = [
        f"{cut.conditions[channel]:g} {unit}"
        for channel, unit in ((DEPTH, "mm deep"), (FEED, "mm feed"), (SPEED, "m/min"))
        if channel in cut.conditions
    ]
    return ", ".join([operation_of(cut), *said])
