"""What every form of current to force or torque can do, and what an axis sensed."""

from dataclasses import dataclass, fields, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NARROWEST = 1.15
"""Ratio of highest to lowest speed from which on a dependence on it is tried."""


@dataclass(frozen=True)
class MeasuredCuts:
    """What an axis sensed in cuts (n,): current, A; feed speed, mm/s, spindle speed, rpm, feed,
    mm a revolution, depth of cut, mm, the spindle's temperature, °C (NaN: not known).
    ``stated_sd``: standard error of the current, A (NaN: not known of that cut; None: of none).
    ``air``: range in air, A, of which ``current`` is the rise; None: it is no rise.
    ``other_way``: 1 in cuts of the feed axis' other direction, mirrored, else 0; None: there are
    none.
    """

    current: Array
    feed_mm_s: Array
    speed_rpm: Array
    feed_mm: Array
    depth_mm: Array
    temperature_C: Array
    stated_sd: Array | None = None
    other_way: Array | None = None
    air: Array | None = None

    @property
    def current_sd(self) -> Array:
        """Standard error of the current, A: the rms of the others where none, 0 if of none."""
        if self.stated_sd is None or not np.isfinite(self.stated_sd).any():
            return np.zeros_like(self.current)
        usual = np.sqrt(np.nanmean(self.stated_sd**2))
        return np.where(np.isfinite(self.stated_sd), self.stated_sd, usual)

    @property
    def one_way(self) -> NDArray[np.bool_]:
        """Which cuts (n,) are of the axis' own direction."""
        if self.other_way is None:
            return np.ones(len(self.current), dtype=np.bool_)
        return np.asarray(self.other_way == 0.0)

    def moved(self, step: Array) -> "MeasuredCuts":
        """Return the cuts with currents larger by ``step`` (n,)."""
        return replace(self, current=self.current + step)

    @property
    def area_mm2(self) -> Array:
        """Area of the chip: feed times depth."""
        return self.feed_mm * self.depth_mm

    def at(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> "MeasuredCuts":
        """Return some of the cuts, or all in another order."""
        known = {f.name: getattr(self, f.name) for f in fields(self)}
        return replace(self, **{name: v[rows] for name, v in known.items() if v is not None})


@dataclass(frozen=True)
class FittedForm:
    """Coefficients (p,) of a form, their covariance (p, p), and the form with all it learned."""

    coefficients: Array
    covariance: Array
    form: "CurrentForm"


class CurrentForm(Protocol):
    """One form of current to force or torque."""

    @property
    def kind(self) -> str:
        """What it is stored as."""

    @property
    def label(self) -> str:
        """What it is called among the forms compared."""

    @property
    def margin(self) -> float:
        """Standard errors by which its squared errors on groups left out must be lower than those
        of a plainer form: one (Breiman, Friedman, Olshen, Stone 1984, Classification and regression
        trees), and of rules, which nobody can check by hand, two.
        """

    def fits(self, sensed: MeasuredCuts) -> bool:
        """Say whether the cuts have what the form depends on, and vary in it."""

    def fit(self, sensed: MeasuredCuts, target: Array) -> FittedForm:
        """Fit it to a target (n,); raises Undetermined where the cuts do not hold it."""

    def value(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the target (n,)."""

    def slopes(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the target's derivatives by the coefficients, (n, p)."""

    def scaling(self, coefficients: Array) -> Array:
        """Return how the coefficients (p,) change, per share, when the whole target is scaled."""

    def moves(self, coefficients: Array, slopes: Array, value: Array) -> tuple[Array, Array]:
        """Return how the coefficients' errors move readings (n,): a shift and a share, each (n, p).

        By ``slopes`` (n, p) at the value that was read; the share is of the value that a law
        expects. Noise of a current is noise of both, and a force that is put down to its own
        scatter would put every scatter down to the calibration.
        """

    def beyond(self, sensed: MeasuredCuts) -> Array:
        """Return the standard deviation (n,) to add where the cuts never were."""

    def parameters(self) -> dict[str, Any] | None:
        """Return what was learned beside the coefficients, as JSON takes it; a law has none."""

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it; I is the current."""


def varies(speed: Array) -> bool:
    """Say whether speeds (n,) are known, above zero, and differ."""
    known = bool(np.isfinite(speed).all()) and bool(np.all(speed > 0))
    return known and float(speed.max()) > NARROWEST * float(speed.min())


def form_moves(slopes: Array, value: Array, *, idle: Array, first: int) -> tuple[Array, Array]:
    """Return ``CurrentForm.moves`` where slopes from column ``first`` on follow the current.

    ``idle`` (n,): value without a current. What is above it, they follow.
    """
    above = value - idle
    shift, share = slopes.copy(), np.zeros_like(slopes)
    sensed = above != 0
    share[sensed, first:] = slopes[sensed, first:] / above[sensed, None]
    shift[sensed, first:] = -share[sensed, first:] * idle[sensed, None]
    return shift, share
