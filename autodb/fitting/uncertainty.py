"""Uncertainty budgets after the GUM: contributions, combined and expanded standard uncertainty.

    u_c² = Σ u_i²,  ν = u_c⁴ / Σ (u_i⁴ / ν_i),  U = k u_c,  k = t((1 + 0.9545)/2, ν)

u_i standard uncertainties of contributions that do not correlate, ν_i their degrees of freedom
(Welch and Satterthwaite). Source: JCGM 100:2008, 5.1.2 (10), G.4.1 (G.2b) and table G.2.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import stdtrit

from autodb.wording import amount_words, localized, phrase
from autodb.wording.kept import said_again

COVERAGE = 0.9545
"""Share that an expanded uncertainty with k = 2 covers of a normal distribution."""
Evaluation = Literal["A", "B"]
"""A: from a series of observations; B: from what is stated otherwise (GUM 4.2, 4.3)."""


@dataclass(frozen=True)
class BudgetEntry:
    """A contribution to an uncertainty, by name: its standard uncertainty, in the quantity's unit.

    ``standard`` None: nobody stated it, and ``source`` says so. ``freedom``: degrees of freedom;
    None: so many that they do not count.
    """

    name: str
    standard: float | None
    evaluation: Evaluation
    source: str
    freedom: float | None = None


def limits_as_standard(half_width: float) -> float:
    """Return the standard uncertainty of a quantity that is known to lie within limits, GUM 4.3.7.

    >>> round(limits_as_standard(3.0), 3)
    1.732
    """
    return half_width / float(np.sqrt(3.0))


@dataclass(frozen=True)
class UncertaintyBudget:
    """A quantity with the contributions to its uncertainty."""

    quantity: str
    value: float
    unit: str
    contributions: tuple[BudgetEntry, ...]

    @property
    def combined(self) -> float:
        """Combined standard uncertainty, of all that is stated."""
        return float(np.sqrt(sum(u**2 for u, _ in self._stated)))

    @property
    def freedom(self) -> float:
        """Effective degrees of freedom; infinite where no contribution has few."""
        few = sum(u**4 / nu for u, nu in self._stated if nu is not None and u > 0.0)
        return self.combined**4 / few if few > 0.0 else float("inf")

    @property
    def coverage_factor(self) -> float:
        """What the combined uncertainty is multiplied by: 2 where the degrees are many."""
        return float(stdtrit(self.freedom, 0.5 * (1.0 + COVERAGE)))

    @property
    def expanded(self) -> float:
        """Expanded uncertainty, which covers COVERAGE."""
        return self.coverage_factor * self.combined

    @property
    def _stated(self) -> list[tuple[float, float | None]]:
        known = [one for one in self.contributions if one.standard is not None]
        return [(float(one.standard or 0.0), one.freedom) for one in known]

    def lines(self) -> list[str]:
        """Return the contributions in words, a line each."""
        return [self._line(one) for one in self.contributions]

    def _line(self, one: BudgetEntry) -> str:
        name, source = said_again(one.name), said_again(one.source)
        if one.standard is None:
            return phrase("{name}: {source}", name=name, source=source)
        value = amount_words(one.standard, self.unit, ".3g")
        if one.freedom is None:
            how = phrase("type {letter}", letter=one.evaluation)
        else:
            how = phrase(
                "type {letter}, {freedom} degrees of freedom",
                letter=one.evaluation, freedom=localized(f"{one.freedom:.0f}")
            )  # fmt: skip
        return phrase(
            "{name}: {value} ({how}): {source}", name=name, value=value, how=how, source=source
        )

    def total(self) -> str:
        """Return the combined and the expanded uncertainty in words."""
        return phrase(
            "combined standard uncertainty {combined}, expanded {expanded} (k = {k})",
            combined=amount_words(self.combined, self.unit, ".3g"),
            expanded=amount_words(self.expanded, self.unit, ".3g"),
            k=localized(f"{self.coverage_factor:.2f}"),
        )
