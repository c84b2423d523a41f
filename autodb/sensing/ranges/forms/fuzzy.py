"""A Sugeno system (ANFIS) of the current and one or more of a cut's conditions (P1, section 12).

Two fuzzy sets an input, every combination a rule, the consequents with their posterior covariance;
the premises count as known. More load never shows as less current: the output keeps to one
direction. Beyond the box of the cuts that it learned from it says how far.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.linear import Undetermined
from autodb.sensing.ranges.forms.form import Array, FittedForm, MeasuredCuts, form_moves

if TYPE_CHECKING:
    from autodb.fitting.anfis.premises import Premises
    from autodb.fitting.anfis.standardised import Scaling

SETS = 2
"""Fuzzy sets of each input; more are not held by as many cuts as a shop has."""
CUTS_A_PARAMETER = 3
"""Cuts for each parameter of rules and sets from which on a system is tried; chosen."""
PARAMETERS_A_SET = 3
"""Of a bell: half width, slope, centre."""


@dataclass(frozen=True)
class Input:
    """One quantity that a system looks at: its attribute of ``MeasuredCuts``, its name and unit."""

    attribute: str
    name: str
    unit: str


CURRENT = Input("current", "current", "A")
SPEED = Input("speed_rpm", "spindle speed", "rpm")
FEED_SPEED = Input("feed_mm_s", "feed speed", "mm/s")
FEED = Input("feed_mm", "feed", "mm")
DEPTH = Input("depth_mm", "depth of cut", "mm")
AREA = Input("area_mm2", "chip area", "mm²")
INPUTS = {one.attribute: one for one in (CURRENT, SPEED, FEED_SPEED, FEED, DEPTH, AREA)}


@dataclass(frozen=True)
class Fuzzy:
    """Rules over ``inputs``; ``learned`` is what it has beside its consequents, None before."""

    inputs: tuple[Input, ...]
    learned: "LearnedRules | None" = None

    kind = "anfis"
    margin = 2.0

    @property
    def label(self) -> str:
        """What it is called among the forms compared."""
        return f"ANFIS {{{', '.join(one.name for one in self.inputs)}}}"

    def fits(self, sensed: MeasuredCuts) -> bool:
        """Say whether all inputs are known, differ, and cuts are enough for the parameters."""
        columns = _columns(self.inputs, sensed)
        d = len(self.inputs)
        parameters = SETS**d * (d + 1) + d * SETS * PARAMETERS_A_SET
        return bool(
            len(columns) >= CUTS_A_PARAMETER * parameters
            and np.isfinite(columns).all()
            and np.all(np.ptp(columns, axis=0) > 0)
        )

    def fit(self, sensed: MeasuredCuts, target: Array) -> FittedForm:
        """Fit by variable projection, monotone in the current in the direction of the cuts.

        Raises Undetermined where the cuts do not hold it.
        """
        from autodb.fitting import anfis

        columns = _columns(self.inputs, sensed)
        falling = float(np.cov(columns[:, 0], target)[0, 1]) < 0.0
        rule = anfis.Monotone(0, falling=falling)
        start = anfis.premise_grid((SETS,) * len(self.inputs))
        try:
            model = anfis.fit_anfis(columns, target, [start], monotone=rule)
        except (
            anfis.TooFewRows, anfis.Unvarying, anfis.NotMonotone, anfis.PremisesNotSettled
        ) as error:  # fmt: skip
            raise Undetermined([]) from error
        spread = model.hull.sd * model.scaling.half
        learned = LearnedRules(
            model.premises, model.scaling, model.hull.low, model.hull.high, spread
        )
        form = Fuzzy(self.inputs, learned)
        return FittedForm(model.consequents.ravel(), model.covariance, form)

    def value(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the target (n,)."""
        learned = self._learned()
        return learned.scaling.outputs(self._design(sensed) @ coefficients)

    def slopes(self, coefficients: Array, sensed: MeasuredCuts) -> Array:  # noqa: ARG002 - it is linear
        """Return the target's derivatives by the consequents, (n, p)."""
        return np.asarray(self._learned().scaling.output_size * self._design(sensed))

    def scaling(self, coefficients: Array) -> Array:
        """Return the change of the consequents: the rules' constants also hold the mean."""
        scale = self._learned().scaling
        constant = np.arange(len(coefficients)) % (len(self.inputs) + 1) == 0
        return np.asarray(coefficients + constant * scale.output_middle / scale.output_size)

    def moves(self, coefficients: Array, slopes: Array, value: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """Return shift and share (n, p): every rule follows the current, so all is a share."""
        return form_moves(slopes, value, idle=np.zeros_like(value), first=0)

    def beyond(self, sensed: MeasuredCuts) -> Array:
        """Return the standard deviation (n,) to add outside the box: the output's for each one of
        the inputs'.
        """
        learned = self._learned()
        columns = _columns(self.inputs, sensed)
        over = np.maximum(learned.low - columns, columns - learned.high)
        distance = np.sqrt(np.sum((np.maximum(over, 0.0) / learned.spread) ** 2, axis=1))
        return np.asarray(learned.scaling.output_size * distance)

    def parameters(self) -> dict[str, Any] | None:
        """Return what ``of_parameters`` makes it from."""
        learned = self._learned()
        return {
            "inputs": [one.attribute for one in self.inputs],
            "sets": [one.tolist() for one in learned.premises.sets],
            "middle": learned.scaling.middle.tolist(),
            "half": learned.scaling.half.tolist(),
            "output": [learned.scaling.output_middle, learned.scaling.output_size],
            "low": learned.low.tolist(),
            "high": learned.high.tolist(),
            "spread": learned.spread.tolist(),
        }

    @classmethod
    def of_parameters(cls, kept: dict[str, Any]) -> "Fuzzy":
        """Return a form that was kept."""
        from autodb.fitting import anfis
        from autodb.fitting.anfis.standardised import Scaling

        inputs = tuple(INPUTS[attribute] for attribute in kept["inputs"])
        start = anfis.premise_grid((SETS,) * len(inputs))
        sets = tuple(np.array(one) for one in kept["sets"])
        scale = Scaling(np.array(kept["middle"]), np.array(kept["half"]), *kept["output"])
        ends = (np.array(kept[name]) for name in ("low", "high", "spread"))
        return cls(
            inputs, LearnedRules(anfis.Premises(start.membership, sets, start.rules), scale, *ends)
        )

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:  # noqa: ARG002
        """Return how many rules over what; the sentences say the rules."""
        rules = SETS ** len(self.inputs)
        names = ", ".join(one.name for one in self.inputs)
        return f"{rules} fuzzy rules over {names}, in {unit}"

    def _learned(self) -> "LearnedRules":
        if self.learned is None:
            raise Undetermined([])
        return self.learned

    def _design(self, sensed: MeasuredCuts) -> Array:
        from autodb.fitting.anfis.premises import rule_columns

        learned = self._learned()
        return rule_columns(learned.premises, learned.scaling.inputs(_columns(self.inputs, sensed)))


@dataclass(frozen=True)
class LearnedRules:
    """Premises, scaling, and the box of the inputs (d,) with their standard deviations."""

    premises: "Premises"
    scaling: "Scaling"
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    spread: NDArray[np.float64]


def _columns(inputs: tuple[Input, ...], sensed: MeasuredCuts) -> Array:
    return np.column_stack([getattr(sensed, one.attribute) for one in inputs])


OF_CURRENT = Fuzzy((CURRENT,))
OF_CURRENT_FEED = Fuzzy((CURRENT, FEED_SPEED))
OF_CURRENT_SPEED = Fuzzy((CURRENT, SPEED))
FEED_SETS = tuple(Fuzzy((CURRENT, *more)) for more in ((FEED,), (DEPTH,), (FEED, DEPTH)))
SPINDLE_SETS = tuple(
    Fuzzy((CURRENT, SPEED, *more)) for more in ((FEED,), (DEPTH,), (AREA,), (FEED, DEPTH))
)
"""Sets of P1, section 12, that also look at what the cut was meant to be."""
