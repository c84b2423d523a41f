"""A fitted Sugeno system and what it predicts, with an interval and whether it has been there.

    f(x) = Σ_r share_r(x) · (c_r0 + c_r1 x_1 + … + c_rd x_d)

(Takagi and Sugeno 1985; Jang 1993, rules of type 3). The consequents c are a Bayesian linear
regression given the premises; with s² the residual variance and h(x) = φᵀ(ΦᵀΦ + λ1)⁻¹φ the leverage
of a point, the predictive variance is s²(1 + h), and Student's t with the degrees of freedom left.
The premises are taken as known in h; they cost degrees of freedom only.

A point is *outside* where it leaves the box of the training inputs, or has a higher leverage than
any training row had (hidden extrapolation, in a corner of the box that no row was near; Montgomery,
Peck and Vining, Introduction to Linear Regression Analysis, section 3.8). Beyond the box the
variance grows by (output sd · distance)², the distance in standard deviations of the inputs: out
there the output may go as far from the model as it varied in training. That is a choice, wide on
purpose; nothing in the rows says how far.

New rows in a fitted system: consequents move, premises and hull stay.

    tallied = tally(model, inputs, values)      # sums of rows: tallied + others, in any order
    newer = refreshed(model, tallied)           # as if fitted to all rows at once
    undone(newer, tallied)                      # the first model again

What a point outside the training box is remains what the premises were learned on: rows out there
sharpen the consequents, but no set was ever shaped to them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.anfis.monotone import Monotone, constrained
from autodb.fitting.anfis.premises import Premises, rule_columns
from autodb.fitting.anfis.standardised import Scaling
from autodb.fitting.anfis.sums import Sums, consequent_sums, posterior

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Hull:
    """Where the training rows were: the box of inputs (d,), their sd (d,), their highest leverage.

    Lowest and highest in the inputs' own units, sd and leverage in scaled ones.
    """

    low: Array
    high: Array
    sd: Array
    leverage: float


@dataclass(frozen=True)
class ConsequentPrior:
    """What the consequents are before any row: a plane (d + 1,) and the weight of it."""

    plane: Array
    ridge: float


@dataclass(frozen=True)
class AnfisPrediction:
    """Mean, standard deviation and whether inside, all of one shape; distance outside the box.

    ``freedom``: degrees of freedom of the residual variance.
    """

    mean: Array
    sd: Array
    inside: NDArray[np.bool_]
    distance: Array
    freedom: float

    def interval(self, level: float = 0.95) -> tuple[Array, Array]:
        """Return the lower and upper end of the predictive interval for a new value."""
        from scipy.stats import t

        half = float(t.ppf(0.5 + 0.5 * level, self.freedom)) * self.sd
        return self.mean - half, self.mean + half


@dataclass(frozen=True)
class Anfis:
    """A fitted system; ``consequents`` (R, d + 1) and ``root`` (p, p) in scaled units.

    ``variance``: of the residual, in squared units of the output. ``learned``: how many parameters
    of the premises were fitted to these rows.
    """

    premises: Premises
    scaling: Scaling
    posterior: ConsequentPrior
    sums: Sums
    hull: Hull
    learned: int
    monotone: Monotone | None
    consequents: Array
    root: Array
    variance: float
    freedom: float

    @property
    def covariance(self) -> Array:
        """Covariance of the consequents (p, p), scaled, rule by rule.

        Of the unconstrained posterior: a monotone rule only narrows it.
        """
        return self.variance / self.scaling.output_size**2 * (self.root.T @ self.root)

    @property
    def sd(self) -> float:
        """Standard deviation of the residual, in the output's unit."""
        return float(np.sqrt(self.variance))


class TooFewRows(ValueError):  # noqa: N818 - the data's state, not a program error
    """Fewer rows than what is fitted to them."""


def with_best_consequents(
    premises: Premises,
    scaling: Scaling,
    before: ConsequentPrior,
    rows: Sums,
    *,
    hull: Hull,
    learned: int,
    monotone: Monotone | None,
) -> Anfis:
    """Return the system whose consequents are the best ones for these sums of rows.

    Raises TooFewRows where no degree of freedom is left for the residual.
    """
    found = posterior(rows, before.ridge)
    freedom = found.freedom - learned
    if freedom <= 0:
        raise TooFewRows(
            f"{rows.rows} rows for {rows.rows - freedom:.0f} parameters: fewer sets or more rows"
        )
    mode = found.mode
    if monotone is not None:
        mode = constrained(premises, before.plane, found, monotone)
    variance = rows.left(mode) / freedom * scaling.output_size**2
    consequents = mode.reshape(len(premises.rules), -1) + before.plane
    return Anfis(
        premises, scaling, before, rows, hull, learned, monotone,
        consequents, found.root, variance, freedom,
    )  # fmt: skip


def evaluate(model: Anfis, inputs: Array) -> Array:
    """Return the output (…) at inputs (…, d)."""
    x = _scaled(model, inputs)
    scaled = rule_columns(model.premises, x) @ model.consequents.ravel()
    return model.scaling.outputs(scaled).reshape(np.shape(inputs)[:-1])


def predict_anfis(model: Anfis, inputs: Array) -> AnfisPrediction:
    """Return output, standard deviation and whether the model has been there, at inputs (…, d)."""
    shape = np.shape(inputs)[:-1]
    columns = rule_columns(model.premises, _scaled(model, inputs))
    leverage = leverages(columns, model.root)
    distance = box_distances(model, inputs).reshape(-1)
    beyond = (model.scaling.output_size * distance) ** 2
    inside = (distance == 0.0) & (leverage <= model.hull.leverage * (1.0 + 1e-9))
    return AnfisPrediction(
        model.scaling.outputs(columns @ model.consequents.ravel()).reshape(shape),
        np.sqrt(model.variance * (1.0 + leverage) + beyond).reshape(shape),
        inside.reshape(shape),
        distance.reshape(shape),
        model.freedom,
    )


def box_distances(model: Anfis, inputs: Array) -> Array:
    """Return how far inputs (…, d) are from the box, in standard deviations of the inputs."""
    over = np.maximum(model.hull.low - inputs, inputs - model.hull.high)
    excess = np.maximum(over, 0.0) / (model.scaling.half * model.hull.sd)
    return np.asarray(np.sqrt(np.sum(excess**2, axis=-1)))


def leverages(columns: Array, root: Array) -> Array:
    """Return φᵀ(ΦᵀΦ + λ1)⁻¹φ of every row (n,) of columns (n, p)."""
    return np.asarray(np.sum((columns @ root.T) ** 2, axis=1))


def _scaled(model: Anfis, inputs: Array) -> Array:
    given = np.asarray(inputs, dtype=np.float64)
    return model.scaling.inputs(given).reshape(-1, given.shape[-1])


def tally(model: Anfis, inputs: Array, values: Array) -> Sums:
    """Return what rows, inputs (n, d) and values (n,), say to a model with these premises."""
    x = model.scaling.inputs(inputs)
    plane = model.posterior.plane
    left = model.scaling.values(values) - (plane[0] + x @ plane[1:])
    return consequent_sums(rule_columns(model.premises, x), left)


def refreshed(model: Anfis, rows: Sums) -> Anfis:
    """Return the model with the rows added. Raises NotMonotone as ``fit`` does."""
    return _with(model, model.sums + rows)


def without_rows(model: Anfis, rows: Sums) -> Anfis:
    """Return the model without rows that were added before.

    Raises TooFewRows where they leave nothing for the residual, NotMonotone.
    """
    return _with(model, model.sums - rows)


def _with(model: Anfis, rows: Sums) -> Anfis:
    return with_best_consequents(
        model.premises, model.scaling, model.posterior, rows,
        hull=model.hull, learned=model.learned, monotone=model.monotone,
    )  # fmt: skip
