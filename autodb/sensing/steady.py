"""Steady motion of an axis: effort at a place and speed, friction over speed, with uncertainty.

The model's law, and how far the moves showed friction to be off it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from autodb import fitting
from autodb.sensing.linearised import Linearised
from autodb.sensing.prepared import SPINDLE, Prepared
from autodb.terms.channel import Part, coefficients, columns, free_shape, reshaped

Array = NDArray[np.float64]

OVER_SPEED = frozenset({"coulomb", "viscous", "stribeck", "asymmetry"})
"""Friction that is a function of speed and direction alone."""
STEADY = OVER_SPEED | {"position_friction", "gravity", "spring", "cogging"}
"""What acts in motion at constant speed, cold, long after a reversal."""
FINE_MM_S = 0.1
"""Speed below which the deviation's columns are even in speed, above in its logarithm."""
FINE_COLUMNS, EVEN_COLUMNS = 12, 16
EVEN_SPEEDS = 200
"""Speeds at which a law is compared with the deviation's columns."""


@dataclass(frozen=True)
class SteadyMotion:
    """What an identified model says of motion at constant speed, up to ``highest_mm_s``.

    ``parts`` that act then; ``values`` (p,) of their coefficients and free shape; ``weights`` (m,)
    of the deviation's basis; ``taken`` (f, m) what of the basis the law of friction over speed says
    already; ``covariance`` (p + m, p + m) of values and weights.
    """

    parts: tuple[Part, ...]
    values: Array
    weights: Array
    taken: Array
    covariance: Array
    highest_mm_s: float

    def friction(self, velocity_mm_s: Array) -> tuple[Array, Array]:
        """Return friction (n,) at velocities (n,), its mean over the travel, and its sd (n,).

        Weight and other loads are not in it. Raises ValueError beyond the highest speed moved at.
        """
        names = [part.term.name for part, _ in (*coefficients(self.parts), *free_shape(self.parts))]
        rubs = np.array([name in OVER_SPEED for name in names])
        return self._at(np.zeros_like(velocity_mm_s), velocity_mm_s, rubs)

    def effort(self, position_mm: Array, velocity_mm_s: Array) -> tuple[Array, Array]:
        """Return the whole effort (n,) at places and velocities (n,), and its sd (n,).

        Raises ValueError beyond the highest speed moved at.
        """
        return self._at(position_mm, velocity_mm_s, np.ones(len(self.values), dtype=np.bool_))

    def _at(
        self, position_mm: Array, velocity_mm_s: Array, wanted: NDArray[np.bool_]
    ) -> tuple[Array, Array]:
        if np.max(np.abs(velocity_mm_s)) > self.highest_mm_s:
            raise ValueError(f"no move was faster than {self.highest_mm_s:g} mm/s")
        inputs = _steady(position_mm, velocity_mm_s)
        count = len(coefficients(self.parts))
        linear, shape = self.values[:count], self.values[count:]

        def effort(values: Array) -> Array:
            return columns(reshaped(self.parts, values), inputs) @ (linear * wanted[:count])

        # Gradient over the law's coefficients, its shape, and the deviation
        base = columns(reshaped(self.parts, shape), inputs)
        slopes = [
            (effort(shape + step) - effort(shape - step)) / (2.0 * step.sum())
            for step in np.diag(1e-6 * np.maximum(np.abs(shape), 1e-6))
        ]
        law = np.column_stack([base, *slopes]) * wanted
        even = _differs(self.parts)
        basis = np.column_stack(_basis(velocity_mm_s, self.highest_mm_s, even=even))
        free = basis - base[:, _places(self.parts)] @ self.taken
        gradient = np.column_stack([law, free])
        value = effort(shape) + free @ self.weights
        variance = np.einsum("ij,jk,ik->i", gradient, self.covariance, gradient)
        return value, np.sqrt(np.maximum(variance, 0.0))


@dataclass(frozen=True)
class Deviation:
    """Columns by which friction may deviate from its law: (m, k) a group, free of the law's own.

    ``places`` of the steady parts' parameters in the problem; ``taken`` (f, k): what of the basis
    the law says.
    """

    groups: list[Array]
    parts: tuple[Part, ...]
    places: list[int]
    taken: Array
    highest_mm_s: float

    def steady(self, fit: fitting.Deviating, values: Array) -> SteadyMotion:
        """Return steady motion of a fit whose parameters are told as ``values`` (p,)."""
        weights = list(range(fit.columns, len(fit.whole)))
        together = [*self.places, *weights]
        return SteadyMotion(
            parts=self.parts,
            values=values[self.places],
            weights=fit.whole[weights],
            taken=self.taken,
            covariance=fit.whole_covariance[np.ix_(together, together)],
            highest_mm_s=self.highest_mm_s,
        )


def friction_deviation(rows: Prepared, problem: Linearised) -> Deviation | None:
    """Return how friction may deviate from the problem's law; None where it has none.

    It deviates alike in both directions, and where the model's friction differs by direction, by
    direction too.
    """
    acts = [i for i, (part, _) in enumerate(problem.names) if part.term.name in STEADY]
    parts = tuple({problem.names[i][0].key: problem.names[i][0] for i in acts}.values())
    if rows.axis == SPINDLE or not {"coulomb", "viscous"} <= {p.term.name for p in parts}:
        return None
    velocity = rows.sampled("velocity")
    highest = float(np.quantile(np.abs(velocity), 0.999))
    even = _differs(parts)
    taken = _law_in_basis(parts, highest)
    names = coefficients(parts)
    own = problem.columns[:, [acts[i] for i in range(len(names)) if _rubs(names[i][0])]]
    direction = rows.inputs["direction"]
    sense = rows.reduced(np.column_stack([direction, np.abs(direction)]))
    smooth = _speed_basis(velocity, highest)
    groups = [sense[:, :1] * group for group in smooth]
    groups += [sense[:, 1:] * group for group in smooth] if even else []
    free = [group - own @ part for group, part in zip(groups, taken, strict=True)]
    return Deviation(free, parts, acts, np.column_stack(taken), highest)


def _rubs(part: Part) -> bool:
    return part.term.name in OVER_SPEED


def _differs(parts: tuple[Part, ...]) -> bool:
    """Say whether the parts let friction differ by direction."""
    return any(part.term.name == "asymmetry" for part in parts)


def _places(parts: tuple[Part, ...]) -> list[int]:
    """Return the coefficients that are friction over speed."""
    return [i for i, (part, _) in enumerate(coefficients(parts)) if _rubs(part)]


def _law_in_basis(parts: tuple[Part, ...], highest_mm_s: float) -> list[Array]:
    """Return what of each group (m columns) the law says, (f, m): least squares over even speeds.

    So the law's parameters are those of its best approximation to friction between standstill and
    the highest speed, whatever time was spent at which: two recordings agree on them.
    """
    speeds = np.linspace(highest_mm_s / EVEN_SPEEDS, highest_mm_s, EVEN_SPEEDS)
    both = np.concatenate([-speeds, speeds])
    law = columns(parts, _steady(np.zeros_like(both), both))[:, _places(parts)]
    groups = _basis(both, highest_mm_s, even=_differs(parts))
    return [np.linalg.lstsq(law, group, rcond=1e-10)[0] for group in groups]


def _basis(velocity_mm_s: Array, highest_mm_s: float, *, even: bool) -> list[Array]:
    """Return groups of smooth columns over speed, that flip with direction; and that do not."""
    smooth = _speed_basis(velocity_mm_s, highest_mm_s)
    flips = [np.sign(velocity_mm_s)[:, None] * group for group in smooth]
    return [*flips, *smooth] if even else flips


def _speed_basis(velocity_mm_s: Array, highest_mm_s: float) -> list[Array]:
    """Return two groups of smooth columns over |v|: fine towards 0, and even up to the highest."""
    speed = np.minimum(np.abs(velocity_mm_s), highest_mm_s)
    top = float(np.log1p(highest_mm_s / FINE_MM_S))
    return [
        _spline(np.log1p(speed / FINE_MM_S), top, FINE_COLUMNS),
        _spline(speed, highest_mm_s, EVEN_COLUMNS),
    ]


def _spline(values: Array, high: float, count: int) -> Array:
    """Return ``count`` cubic B-splines over 0 to ``high`` with even knots, (n, count)."""
    inner = np.linspace(0.0, high, count - 2)[1:-1]
    knots = np.concatenate([[0.0] * 4, inner, [high] * 4])
    inside = np.clip(values, 0.0, high)
    return np.asarray(BSpline.design_matrix(inside, knots, 3).toarray(), dtype=np.float64)


def _steady(position_mm: Array, velocity_mm_s: Array) -> dict[str, Array]:
    """Return what acts in motion at constant speed."""
    return {
        "position": position_mm,
        "velocity": velocity_mm_s,
        "direction": np.sign(velocity_mm_s),
    }
