"""Straight lines of one feed axis in both directions: the gain is one, friction is not.

Seen along the feed an axis takes I = I_F ± I_0 + F/k: the gain k is that of drive and screw, and
what friction and weight take differs by direction. Cuts of the other direction, mirrored, share the
columns of a line and have a level of their own; where they say so clearly, a gain of their own too.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.ranges.forms.form import FittedForm, MeasuredCuts
from autodb.sensing.ranges.forms.line import StraightLine
from autodb.wording import stored_msgid

Array = NDArray[np.float64]


APART = 2.0
"""Standard errors by which gains apart must be better: what a screw passes on is one. Chosen, as of
rules, which must say more than a law too."""


class OneGain(StraightLine):
    """A line of cuts in both directions: coefficients of ``form``, then the other way's level."""

    words = stored_msgid("{kind}, one gain both ways")

    def __init__(self, form: StraightLine) -> None:
        self.form = form
        self.kind, self.margin = form.kind, form.margin
        self.label = self.words.format(kind=form.label)

    def columns(self, sensed: MeasuredCuts) -> Array:
        """Return the columns (n, p + 1)."""
        return np.column_stack([self.form.columns(sensed), _other(sensed)])

    def fits(self, sensed: MeasuredCuts) -> bool:
        """Say whether cuts of both directions have what the line depends on."""
        return bool(np.ptp(_other(sensed)) > 0.0) and self.form.fits(sensed)

    def one_way(self, law: FittedForm) -> FittedForm:
        """Return what a fit to both says of the direction that was not mirrored."""
        p = self._own(len(law.coefficients))
        return FittedForm(law.coefficients[:p], law.covariance[:p, :p], self.form)

    def _own(self, count: int) -> int:
        """Return how many of the coefficients are the line's."""
        return count - 1


class GainEach(OneGain):
    """The same with all coefficients apart: two lines that share nothing but their scatter."""

    words = stored_msgid("{kind}, a gain each way")

    def __init__(self, form: StraightLine) -> None:
        super().__init__(form)
        self.margin = APART

    def columns(self, sensed: MeasuredCuts) -> Array:
        """Return the columns (n, 2 p)."""
        own = self.form.columns(sensed)
        return np.column_stack([own, own * _other(sensed)[:, None]])

    def _own(self, count: int) -> int:
        """Return how many of the coefficients are the line's."""
        return count // 2


def _other(sensed: MeasuredCuts) -> Array:
    return np.zeros_like(sensed.current) if sensed.other_way is None else sensed.other_way


def of_one_way(law: FittedForm) -> FittedForm:
    """Return what a law says of one direction: itself where it was fitted to one only."""
    return law.form.one_way(law) if isinstance(law.form, OneGain) else law
