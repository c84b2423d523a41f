"""The largest feed, depth or speed of a cut at which a machine's limits are surely kept.

What is asked for grows from nothing: that value is the answer behind which, for the first time, a
load is above a share of its limit with more than the chance that is allowed, or a speed is above
its limit. Values between are tried in steps that get finer; all of a step are worked out together.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import floor, log10
from typing import Literal

import numpy as np

from autodb.agent.answer.prediction_basis import LookedUp, PredictionBasis
from autodb.errors import UnusableInput, near_words
from autodb.files.job_cut import KEYS, LEAST, MOST_CUT, JobCut
from autodb.files.machine import AxisLimits
from autodb.forward.limits import LimitStanding, limit_standings
from autodb.wording import amount_words, localized, phrase, stored_msgid

Wanted = Literal["feed", "depth", "speed"]
WHAT: tuple[str, ...] = (stored_msgid("feed"), stored_msgid("depth"), stored_msgid("speed"))
STATES_NONE = stored_msgid(
    "machine '{machine}' states no limit; state one, such as axes.spindle.limits.torque_N_m, with "
    "'autodb machine update'"
)
NONE_SMALL = stored_msgid(
    "no {what} is small enough: {found} at {value}; state other numbers of the cut"
)
FASTEST_M_MIN = 2000.0
"""Cutting speed up to which is searched. Chosen: aluminium is milled so."""
SMALLEST = 1e-3
"""Part of the largest that the search begins at. Chosen."""
STEPS, ROUNDS = 24, 3
"""Values that are tried together, and how often: the answer is then known to 10⁻⁴. Chosen."""
LOADS = ("force_N", "torque_N_m", "power_W")


@dataclass(frozen=True)
class Largest:
    """The largest value of what is asked for, the cut with it, and which limit ends it.

    ``share`` of each load's limit is kept with ``sure``; ``ends``: None where the search's end,
    and no limit, does.
    """

    what: str
    value: float
    unit: str
    share: float
    sure: float
    ends: LimitStanding | None
    cut: JobCut
    answer: LookedUp

    @property
    def statement(self) -> str:
        """The answer to the question, in a line."""
        said = phrase(
            "largest {what} within {share} % of each limit with {sure} % probability: {value}",
            what=phrase(self.what),
            share=localized(f"{100 * self.share:.4g}"),
            sure=localized(f"{100 * self.sure:.4g}"),
            value=amount_words(self.value, self.unit, ".4g"),
        )
        if self.ends is None:
            return phrase("{said}, beyond which is not searched", said=said)
        return phrase("{said}; what ends it is {what}", said=said, what=self.ends.what)


def largest_value(
    basis: PredictionBasis, cut: JobCut, what: str, *, share: float, sure: float
) -> Largest:
    """Return the largest value of ``what`` of a cut; what the cut states of it does not count.

    ``share`` (0 to 1] of each limit on a force, a torque or a power is kept with a probability
    ``sure``. Raises UnusableInput for another word, an operation that has no such number, a machine
    without limits, and where even the smallest exceeds one.
    """
    key, most, unit = _asked(cut, what)
    limits = {axis: _shared(one, share) for axis, one in basis.limits.items()}
    low, high, ends = SMALLEST * most, most, None
    best: float | None = None
    for _ in range(ROUNDS):
        tried = np.geomspace(low, high, STEPS)
        found, _ = basis.predict([_with(cut, key, float(value)) for value in tried])
        stands = [limit_standings([one], limits) for one in found]
        if all(one.standing == "not entered" for one in stands[0]):
            raise UnusableInput(phrase(STATES_NONE, machine=basis.machine))
        kept = [_beyond(one, sure) is None for one in stands]
        first = kept.index(False) if False in kept else STEPS
        if first == 0:
            break
        best = float(tried[first - 1])
        if first == STEPS:
            break
        ends = _beyond(stands[first], sure)
        low, high = best, float(tried[first])
    if best is None:
        over = _beyond(stands[0], sure)
        raise UnusableInput(
            phrase(
                NONE_SMALL,
                what=phrase(what),
                found="" if over is None else over.words,
                value=amount_words(float(tried[0]), unit, ".3g"),
            )
        )
    there = _with(cut, key, _rounded_down(best))
    return Largest(what, getattr(there, key), unit, share, sure, ends, there, basis.look_up(there))


def _asked(cut: JobCut, what: str) -> tuple[str, float, str]:
    """Return the key of what is asked for, the largest that is tried, and its unit."""
    if what not in WHAT:
        raise UnusableInput(
            phrase("'{what}' is nothing to look for{hint}", what=what, hint=near_words(what, WHAT))
        )
    keys = KEYS[cut.operation]
    most = MOST_CUT[keys.kind]
    if what == "speed":
        return "speed_m_min", FASTEST_M_MIN, "m/min"
    if what == "depth":
        if "depth_mm" not in keys.needs:
            raise UnusableInput(
                phrase("operation '{operation}' has no depth; use feed or speed",
                    operation=cut.operation)
            )  # fmt: skip
        return "depth_mm", most["depth_mm"], "mm"
    key = "feed_mm_tooth" if "feed_mm_tooth" in keys.needs else "feed_mm_rev"
    return key, most[key], "mm/tooth" if key == "feed_mm_tooth" else "mm/rev"


def _with(cut: JobCut, key: str, value: float) -> JobCut:
    other = {"speed_rpm": None} if key == "speed_m_min" else {}
    return cut.model_copy(update={key: max(value, LEAST), **other})


def _rounded_down(value: float) -> float:
    """Return a value with four digits, none of them larger."""
    step = 10.0 ** (floor(log10(value)) - 3)
    return float(f"{step * floor(value / step):.4g}")


def _shared(most: AxisLimits, share: float) -> AxisLimits:
    """Return limits of which a share of every load counts."""
    loads = {key: share * limit for key in LOADS if (limit := getattr(most, key)) is not None}
    curves = {
        key: tuple((rpm, share * at) for rpm, at in curve)
        for key in ("torque_curve", "power_curve")
        if (curve := getattr(most, key)) is not None
    }
    return most.model_copy(update={**loads, **curves})


def _beyond(standings: Sequence[LimitStanding], sure: float) -> LimitStanding | None:
    """Return the limit that is exceeded most probably, if more so than is allowed."""
    known = [one for one in standings if one.probability is not None]
    worst = max(known, key=lambda one: one.probability or 0.0, default=None)
    if worst is None or (worst.probability or 0.0) <= 1.0 - sure:
        return None
    return replace(worst, standing="exceeded")
