"""The short form of an axis' effect without a name, where one holds on stretches left out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.reading import AxisReading
from autodb.explain.axis.signals import AxisSignals
from autodb.explain.engine.candidates import UNKNOWN, Candidate, CandidateForm, Choice
from autodb.explain.engine.fit import Folds
from autodb.explain.engine.prior import coefficient_costs
from autodb.explain.engine.search import MARGIN
from autodb.explain.engine.symbolic import ProductForm, Variable, forms, nearest_candidates, written
from autodb.explain.engine.tuning import BesideShapes, Tuned, tuned
from autodb.explain.engine.weighing import weighing
from autodb.files.channels import unit_of

Array = NDArray[np.float64]

SHARE = 0.85
"""A form is said when it does at least this share of what the smooth curve does on stretches left
out, after the price of the search. Chosen."""
ALIKE = 2.0
"""Forms whose squares differ by less than so many variances of a row do equally well: the simplest
is said. Chosen."""
HOPELESS = 0.5
"""A form that does less than this share before its values are tuned is not tuned. Chosen."""
SHORTLIST = 6
"""Forms that are scored on stretches left out: those nearest to the smooth curve."""
LEVEL_SDS = 2.0
"""A level of fewer standard deviations than this is none."""
SCREENED = 1500
"""Rows that forms are compared with the smooth curve at."""
GAP_S = 0.25
"""Rows this near to a stretch left out are not fitted on."""


@dataclass(frozen=True)
class Short:
    """A form that holds, tuned, and what its coefficients are fitted beside.

    ``words``: the product without its coefficient; ``carrier_words``: what a level beside it is
    multiplied by; ``share`` of what the smooth curve does on stretches left out that it does.
    """

    form: ProductForm
    law: Tuned
    beside: BesideShapes
    words: str
    carrier_words: str
    share: float


def short_form(reading: AxisReading, number: int) -> Short | None:
    """Return the short form of an effect of the final fit, or None when none holds.

    On white rows of stretches left out of each fit, beside the own terms and the other effects, the
    form must do nearly what the effect's smooth curve does, and clearly better than neither. Taken
    off it is 2·ln of the number of forms tried, times the variance of a row.
    """
    choice, (_, variance) = reading.choices[number], reading.noise
    turned, variables = variables_of(reading.signals, choice.candidate.variables)
    tried = forms(variables, period=choice.shape.shape.get("period"))
    if not tried:
        return None
    left = _Left(reading, number, turned, variables)
    near = [tried[i] for i in sorted(left.nearest(tried))]
    listed = [*near, *(replace(form, level=True) for form in near)]
    none, smooth, *squares = left.scored([None, choice, *(left.choice(f) for f in listed)])
    if none - min(squares) < HOPELESS * (none - smooth):
        return None
    best = next(i for i, s in enumerate(squares) if s <= min(squares) + ALIKE * variance)
    found = left.tuned(listed[best])
    (square,) = left.scored([found.law.choice])
    gain = none - square - 2.0 * variance * float(np.log(2 * len(tried)))
    if gain < MARGIN * variance or gain < SHARE * (none - smooth):
        return None
    return replace(found, share=(none - square) / max(none - smooth, none - square))


def variables_of(s: AxisSignals, names: Sequence[str]) -> tuple[bool, tuple[Variable, ...]]:
    """Return whether an effect turns with the direction, and what else it depends on.

    An effect of the axis' speed alone turns with it, as friction does.
    """
    place, speed, surge = (s.channel(w) for w in ("position", "velocity", "acceleration"))
    known = {
        "t": Variable("t", "s", s.t_s, ends=True),
        place: Variable(place.partition(".")[2], s.unit, s.position, ends=True),
        speed: Variable("speed", f"{s.unit}/s", np.abs(s.velocity), ends=False),
        surge: Variable("acceleration", f"{s.unit}/s²", s.acceleration, ends=False),
    }
    for name, values in s.others.items():
        ends = name.endswith((".position", ".angle"))
        known[name] = Variable(name, unit_of(name) or "", values, ends=ends)
    turned = s.channel("direction") in names or tuple(names) == (speed,)
    return turned, tuple(known[name] for name in names if name in known)


class _Left:
    """What own terms and other effects leave for an effect and for its short forms."""

    def __init__(
        self, reading: AxisReading, number: int, turned: bool, variables: Sequence[Variable]
    ) -> None:
        self.reading = reading
        self.number = number
        self.values = [v.values for v in variables]
        self.turned = turned
        self.key = f"{reading.choices[number].candidate.key}, short"
        self.carrier = reading.signals.sense if turned else np.ones_like(reading.signals.t_s)
        self.others = (*reading.choices[:number], *reading.choices[number + 1 :])

    def nearest(self, tried: Sequence[ProductForm]) -> list[int]:
        """Return the places of the forms that come nearest to the smooth curve."""
        fitted, bench = self.reading.fitted, self.reading.bench
        rows = slice(None, None, max(1, len(self.carrier) // SCREENED))
        beside = [c for i, c in enumerate(fitted.columns) if i != self.number]
        base = np.column_stack([bench.own_columns(), *beside, self.carrier])[rows]
        carrier, values = self.carrier[rows], [u[rows] for u in self.values]
        candidates = [form.columns(carrier, values, **form.shape) for form in tried]
        return nearest_candidates(fitted.effects[self.number][rows], base, candidates, SHORTLIST)

    def choice(self, form: ProductForm) -> Choice:
        """Return a form as a choice, which is fitted as others are."""

        def law(**shape: float) -> Array:
            return form.columns(self.carrier, self.values, **shape)

        rung_ones = CandidateForm(law, form.shape, form.within, form.names)
        return Choice(Candidate(self.key, UNKNOWN, (rung_ones,)), 0)

    def scored(self, choices: Sequence[Choice | None]) -> list[float]:
        """Return white squares on stretches left out, with each choice in the effect's place."""
        bench, (whitener, _) = self.reading.bench, self.reading.noise
        base = bench.chosen(self.others)
        blocks = [self._block(choice) for choice in choices]
        rows = np.column_stack([bench.reduced_difference, base, *(b for b, _ in blocks)])
        folds = Folds(whitener(rows), self._gap())
        cost = coefficient_costs(bench, self.others, self.reading.noise)
        squares, at = [], 1 + base.shape[1]
        for block, its_cost in blocks:
            columns = [*range(1, 1 + base.shape[1]), *range(at, at + block.shape[1])]
            squares.append(folds.squares(columns, np.concatenate([cost, its_cost])))
            at += block.shape[1]
        return squares

    def _block(self, choice: Choice | None) -> tuple[Array, Array]:
        """Return a choice's columns at the working rate (m, p), and what they cost (p,)."""
        bench = self.reading.bench
        if choice is None:
            return np.empty((len(bench.reduced_difference), 0)), np.zeros(0)
        columns = bench.reduce(bench.built(choice.shape))
        if choice.shape.names:
            return columns, np.zeros(columns.shape[1])
        cost = coefficient_costs(bench, [*self.others, choice], self.reading.noise)
        return columns, cost[len(cost) - columns.shape[1] :]

    def _gap(self) -> int:
        step_s = float(np.median(np.diff(self.reading.signals.t_s)))
        return round(GAP_S / (step_s * self.reading.bench.factor))

    def tuned(self, form: ProductForm) -> Short:
        """Return a form with its values tuned on all rows; a level that may be none goes."""
        bench, choice = self.reading.bench, self.choice(form)
        bench.forget([self.key])
        noise = weighing(bench, [*self.others, choice], self.reading.inquiry.noise, of=choice)
        beside = BesideShapes(bench, self.others, noise)
        law = tuned(choice, beside)
        coefficients, covariance = beside.fit(law.choice.shape)
        if form.level and abs(coefficients[-1]) < LEVEL_SDS * np.sqrt(covariance[-1, -1]):
            return self.tuned(replace(form, level=False))
        values = dict(zip(form.names, coefficients, strict=True)) | dict(law.choice.shape.shape)
        way = "direction · " if self.turned else ""
        level_way = " · direction" if self.turned else ""
        return Short(form, law, beside, f"{way}{written(form, values)}", level_way, 0.0)
