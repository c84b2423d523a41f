"""The cut that opened a run of standard cuts and closes it: by how much current or force moved."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.wording import amount_words, localized, phrase, shop_amount

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CurrentChange:
    """Change from the first to the last cut of one condition with its 95 % interval.

    ``before``: mean of the first cuts. All in the unit of the values.
    """

    before: float
    change: float
    low: float
    high: float

    @property
    def beyond(self) -> bool:
        """Whether it moved by more than repeats scatter: zero lies outside the interval."""
        return self.low > 0.0 or self.high < 0.0

    def sentence(self, name: str, unit: str) -> str:
        """Return it in words."""
        scale, _ = shop_amount(1.0, unit)
        said = phrase(
            "{channel} {before} moved by {change} ({low} to {high}) from the first cut to the last",
            channel=name,
            before=amount_words(self.before, unit, ".4g"),
            change=amount_words(self.change, unit, "+.3g"),
            low=localized(f"{scale * self.low:+.3g}"),
            high=localized(f"{scale * self.high:+.3g}"),
        )
        if self.beyond:
            return phrase("{said}: more than repeats scatter", said=said)
        return phrase("{said}: no more than repeats scatter", said=said)


def moved_between(
    values: Array, conditions: NDArray[np.generic], *, first: list[int], last: list[int]
) -> CurrentChange:
    """Return by how much the cuts ``last`` differ from the cuts ``first``, rows of ``values`` (n,).

    Both are of one condition. The scatter s of single cuts, ν degrees of freedom, is pooled within
    the ``conditions`` (n,) of all other cuts; a drift over the run is in it and widens the
    interval: change ± t(ν) s √(1/n_first + 1/n_last). NaN values are left out.

    Raises ValueError where the two are of several conditions, or no other condition was repeated.
    """
    from scipy import stats

    if len(np.unique(conditions[[*first, *last]])) > 1:
        raise ValueError("first and last cuts are of several conditions; use cuts of one condition")
    others = np.isfinite(values)
    others[[*first, *last]] = False
    sd, dof = pooled_sd(values[others], conditions[others])
    start, end = values[first], values[last]
    change = float(np.mean(end) - np.mean(start))
    half = float(stats.t.ppf(0.975, dof)) * sd * float(np.sqrt(1 / len(start) + 1 / len(end)))
    return CurrentChange(float(np.mean(start)), change, change - half, change + half)


def pooled_sd(values: Array, conditions: NDArray[np.generic]) -> tuple[float, int]:
    """Return the standard deviation of repeats (n,) about their condition's mean, and its dof.

    Raises ValueError where no condition was repeated.
    """
    squares, dof = 0.0, 0
    for condition in np.unique(conditions):
        own = values[conditions == condition]
        squares += float(np.sum((own - own.mean()) ** 2))
        dof += len(own) - 1
    if dof == 0:
        raise ValueError("no condition was repeated between the first and the last cut")
    return float(np.sqrt(squares / dof)), dof
