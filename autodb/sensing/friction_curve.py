"""Steady friction over speed: a law, and how far the moves showed it to be off."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from autodb import fitting
from autodb.sensing.linearised import Linearised
from autodb.sensing.prepared import Prepared
from autodb.terms.channel import Part, columns, free_shape, reshaped

Array = NDArray[np.float64]

OVER_SPEED = frozenset({"coulomb", "viscous", "stribeck", "asymmetry"})
"""Friction that is a function of speed and direction alone."""
FINE_MM_S = 0.1
"""Speed below which the deviation's columns are even in speed, above in its logarithm."""
FINE_COLUMNS, EVEN_COLUMNS = 12, 16
EVEN_SPEEDS = 200
"""Speeds at which a law is compared with the deviation's columns."""


@dataclass(frozen=True)
class FrictionCurve:
    """Steady friction over speed: the law's parts, and what the moves showed beside them.

    ``coefficients`` (f,) of the parts; ``weights`` (m,) of the deviation's basis, the same in both
    directions; ``taken`` (f, m): the part of the basis that the law's columns hold already;
    ``covariance`` of (coefficients, free shape, weights). Moved at up to ``highest_mm_s``.
    """

    parts: tuple[Part, ...]
    coefficients: Array
    weights: Array
    taken: Array
    covariance: Array
    highest_mm_s: float

    def at(self, velocity_mm_s: Array) -> tuple[Array, Array]:
        """Return friction (n,) at velocities (n,), its mean over the travel, and its sd (n,).

        Weight and other loads are not in it. Raises ValueError beyond the highest speed moved at.
        """
        if np.max(np.abs(velocity_mm_s)) > self.highest_mm_s:
            raise ValueError(f"no move was faster than {self.highest_mm_s:g} mm/s")
        inputs = _steady(velocity_mm_s)
        shape = np.array([part.shape[p.name] for part, p in free_shape(self.parts)])

        def law(values: Array) -> Array:
            return columns(reshaped(self.parts, values), inputs)

        # Gradient over the law's coefficients, its shape, and the deviation
        base = law(shape)
        slopes = [
            (law(shape + step) - law(shape - step)) @ self.coefficients / (2.0 * step.sum())
            for step in np.diag(1e-6 * np.maximum(np.abs(shape), 1e-6))
        ]
        basis = np.column_stack(_basis(velocity_mm_s, self.highest_mm_s))
        free = basis * np.sign(velocity_mm_s)[:, None] - base @ self.taken
        gradient = np.column_stack([base, *slopes, free])
        value = base @ self.coefficients + free @ self.weights
        variance = np.einsum("ij,jk,ik->i", gradient, self.covariance, gradient)
        return value, np.sqrt(np.maximum(variance, 0.0))


@dataclass(frozen=True)
class Deviation:
    """Columns by which friction may deviate from its law: (m, k) a group, free of the law's own.

    ``law`` and ``shape``: places of the law's coefficients and free shape in the problem;
    ``taken`` (f, k): what of the basis the law's columns hold.
    """

    groups: list[Array]
    parts: tuple[Part, ...]
    law: list[int]
    shape: list[int]
    taken: Array
    highest_mm_s: float

    def curve(self, fit: fitting.Deviating, values: Array) -> FrictionCurve:
        """Return the friction curve of a fit; ``values`` (p,) are those of the law that is told."""
        weights = list(range(fit.columns, len(fit.whole)))
        places = [*self.law, *self.shape, *weights]
        return FrictionCurve(
            parts=self.parts,
            coefficients=values[self.law],
            weights=fit.whole[weights],
            taken=self.taken,
            covariance=fit.whole_covariance[np.ix_(places, places)],
            highest_mm_s=self.highest_mm_s,
        )


def friction_deviation(rows: Prepared, problem: Linearised) -> Deviation | None:
    """Return how friction may deviate from the problem's law; None where it has none."""
    rubbing = [i for i, (part, _) in enumerate(problem.names) if part.term.name in OVER_SPEED]
    parts = {problem.names[i][0].key: problem.names[i][0] for i in rubbing}
    is_axis = "position" in rows.inputs
    if not is_axis or not {"coulomb", "viscous"} <= {p.term.name for p in parts.values()}:
        return None
    shape = [i for i in rubbing if problem.names[i][1] in problem.names[i][0].term.shape]
    law = [i for i in rubbing if i not in shape]
    velocity = rows.sampled("velocity")
    highest = float(np.quantile(np.abs(velocity), 0.999))
    if highest <= 0:
        return None
    sense = rows.reduced(rows.inputs["direction"])
    groups = [sense[:, None] * basis for basis in _basis(velocity, highest)]
    own = problem.columns[:, law]
    taken = _law_in_basis(tuple(parts.values()), highest)
    free = [group - own @ part for group, part in zip(groups, taken, strict=True)]
    together = np.column_stack(taken)
    return Deviation(free, tuple(parts.values()), law, shape, together, highest)


def _law_in_basis(parts: tuple[Part, ...], highest_mm_s: float) -> list[Array]:
    """Return what of each group (m columns) the law says, (f, m): least squares over even speeds.

    So the law's parameters are those of its best approximation to friction between standstill and
    the highest speed, whatever time was spent at which: two recordings agree on them.
    """
    speeds = np.linspace(highest_mm_s / EVEN_SPEEDS, highest_mm_s, EVEN_SPEEDS)
    both = np.concatenate([-speeds, speeds])
    law = columns(parts, _steady(both))
    groups = [np.sign(both)[:, None] * basis for basis in _basis(both, highest_mm_s)]
    return [np.linalg.lstsq(law, group, rcond=1e-10)[0] for group in groups]


def _basis(velocity_mm_s: Array, highest_mm_s: float) -> list[Array]:
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


def _steady(velocity_mm_s: Array) -> dict[str, Array]:
    """Return what friction takes in motion at constant speed."""
    return {"velocity": velocity_mm_s, "direction": np.sign(velocity_mm_s)}
