"""Steady motion of an axis: effort at a place and speed, friction over speed, with uncertainty."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.deviation import Deviating
from autodb.sensing.drives.fit.deviation import SPEED, deviating, deviation_groups, follows
from autodb.sensing.drives.fit.discrepancy import FrictionDiscrepancy
from autodb.sensing.drives.fit.linearised import Linearised
from autodb.sensing.drives.moves.motion import SPINDLE
from autodb.sensing.drives.moves.prepared import Prepared
from autodb.terms.channel import (
    ChannelPart,
    channel_columns,
    free_shape,
    linear_parameters,
    reshaped,
)

Array = NDArray[np.float64]

STEADY = SPEED | {"position"}
"""What motion at constant speed is told by, cold, long after a reversal."""


@dataclass(frozen=True)
class SteadyMotion:
    """What an identified model says of motion at constant speed, up to the highest moved at.

    ``off_law``: what the parts that act then are off their laws, with m weights; ``values`` (p,) of
    these parts' coefficients and free shape; ``covariance`` (p + m, p + m) of both.
    """

    off_law: FrictionDiscrepancy
    values: Array
    covariance: Array

    def friction(self, velocity_mm_s: Array) -> tuple[Array, Array]:
        """Return friction (n,) at velocities (n,), its mean over the travel, and its sd (n,).

        Weight and other loads are not in it. Raises ValueError beyond the highest speed moved at.
        """
        return self._at(np.zeros_like(velocity_mm_s), velocity_mm_s, over_speed=True)

    def effort(self, position_mm: Array, velocity_mm_s: Array) -> tuple[Array, Array]:
        """Return the whole effort (n,) at places and velocities (n,), and its sd (n,).

        Raises ValueError beyond the highest speed moved at.
        """
        return self._at(position_mm, velocity_mm_s, over_speed=False)

    def _at(
        self, position_mm: Array, velocity_mm_s: Array, *, over_speed: bool
    ) -> tuple[Array, Array]:
        """Return value and sd, of everything or of friction over speed only."""
        seen, parts = self.off_law, self.off_law.parts
        if np.max(np.abs(velocity_mm_s)) > seen.highest_mm_s:
            raise ValueError(f"no move was faster than {seen.highest_mm_s:g} mm/s")
        sense = np.sign(velocity_mm_s)
        inputs = {"position": position_mm, "velocity": velocity_mm_s, "direction": sense}
        names = [part for part, _ in (*linear_parameters(parts), *free_shape(parts))]
        wanted = np.array([follows(part.term, SPEED) or not over_speed for part in names])
        count = len(linear_parameters(parts))
        linear, shape = self.values[:count] * wanted[:count], self.values[count:]

        def effort(values: Array) -> Array:
            told: Array = channel_columns(reshaped(parts, values), inputs) @ linear
            return told

        # Gradient over the law's coefficients, its shape, and the deviation
        base = channel_columns(parts, inputs)
        slopes = [
            (effort(shape + step) - effort(shape - step)) / (2.0 * step.sum())
            for step in np.diag(1e-6 * np.maximum(np.abs(shape), 1e-6))
        ]
        law = np.column_stack([base, *slopes]) * wanted
        groups = deviation_groups(parts, highest_mm_s=seen.highest_mm_s, travel_mm=seen.travel_mm)
        free = np.column_stack(
            [g.columns(inputs) * (g.over_speed or not over_speed) for g in groups]
        )
        gradient = np.column_stack([law, free])
        variance = np.einsum("ij,jk,ik->i", gradient, self.covariance, gradient)
        value: Array = effort(shape) + free @ seen.weights
        return value, np.sqrt(np.maximum(variance, 0.0))


@dataclass(frozen=True)
class Deviation:
    """The deviation's columns on a recording's rows: (m, k) a group; and what they are beside.

    ``places``: the steady parts' parameters in the problem.
    """

    groups: list[Array]
    parts: tuple[ChannelPart, ...]
    places: list[int]
    highest_mm_s: float
    travel_mm: tuple[float, float]

    def off_law(self, weights: Array) -> FrictionDiscrepancy:
        """Return by what friction deviates with ``weights`` (m,)."""
        return FrictionDiscrepancy(self.parts, weights, self.highest_mm_s, self.travel_mm)

    def steady(self, fit: Deviating, values: Array, weights: Array) -> SteadyMotion:
        """Return steady motion of a fit that is told as ``values`` (p,) and ``weights`` (m,)."""
        together = [*self.places, *range(fit.columns, fit.columns + len(weights))]
        return SteadyMotion(
            off_law=self.off_law(weights),
            values=values[self.places],
            covariance=fit.whole_covariance[np.ix_(together, together)],
        )


def friction_deviation(rows: Prepared, problem: Linearised) -> Deviation | None:
    """Return how the problem's axis may deviate from its laws; None where it has none of friction.

    The columns are computed at every row and then reduced, because a reversal lasts few rows.
    """
    if rows.axis == SPINDLE:
        return None
    acts = [i for i, (part, _) in enumerate(problem.names) if follows(part.term, STEADY)]
    parts = tuple({problem.names[i][0].key: problem.names[i][0] for i in acts}.values())
    highest = float(np.quantile(np.abs(rows.inputs["velocity"]), 0.999))
    place = rows.inputs["position"]
    travel = (float(place.min()), float(place.max()))
    groups = deviation_groups(parts, highest_mm_s=highest, travel_mm=travel)
    if not groups:
        return None
    made = [rows.reduced(one) for one in deviating(groups, problem.parts, rows.inputs)]
    return Deviation(made, parts, acts, highest, travel)
