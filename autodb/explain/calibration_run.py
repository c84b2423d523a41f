"""What moved over a run of standard cuts: the gain of current over force, an offset, friction.

Asked where the cut that opened a run and closed it moved by more than repeats scatter. All cuts of
the run are examined, not those two alone: a gain moves each cut's rise by one share, an offset all
by one amount, friction the current in air and no rise. Where they hold no more than the two cuts
say, what it may be is named with the cut that would decide.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import Cause, IntervalValue
from autodb.explain.cuts.answers import SENSED
from autodb.explain.cuts.candidates.currents import (
    AIR,
    FRICTION,
    GAIN,
    OFFSET,
    RISE,
    WEAR,
    StandardRun,
    at_the_end,
    own_of_run,
    run_candidates,
    stack_of_run,
)
from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.cut_search import FoundInCuts, look_for
from autodb.explain.cuts.distinguishing import made_again
from autodb.explain.cuts.fit import CutsFit, fit_cuts, held_out_rows
from autodb.explain.engine.candidates import UNKNOWN, Choice
from autodb.explain.engine.confidence import of_missing
from autodb.explain.engine.fit import rms
from autodb.fitting.gaussian import NORMAL_95
from autodb.sensing.ranges.repeated_cut import CurrentChange, moved_between
from autodb.wording import significant

Array = NDArray[np.float64]

SURE = 0.7
"""A name with rivals that is less likely than this is not given: gain and offset differ only as far
as light and heavy cuts do. Chosen on virtual runs (seeds 101 to 130)."""
LEVEL = 0.95
"""Confidence that something moved, by the interval of ``sensing.ranges.repeated_cut``."""
FORCE = "shear"
"""The cutting force itself: the term of the chip, of another size than the reference."""
NAMES = {
    GAIN: "the gain of current over force",
    OFFSET: "an offset of the current",
    FRICTION: "friction (the current in air)",
    WEAR: "the force, as edges wear",
    FORCE: "the force itself",
}
"""What the terms are called where they move between the first cut and the last."""
MEASURED = (
    "Measure the force where the cut is repeated; a dynamometer separates the force from the gain."
)
LAST = "from the first cut to the last"


@dataclass(frozen=True)
class Ends:
    """By how much the cut that opened a run differs when it closes it; None: not known.

    ``rise`` and ``air`` in the current's unit; ``force`` where it was measured in each cut, in
    ``force_unit``. ``conditions`` (n,): cuts of one number were made alike.
    """

    conditions: NDArray[np.generic]
    rise: CurrentChange | None
    air: CurrentChange | None
    force: CurrentChange | None
    force_unit: str

    @property
    def beyond(self) -> list[int]:
        """The components that moved by more than repeats scatter."""
        ends = ((RISE, self.rise), (AIR, self.air))
        return [component for component, end in ends if end is not None and end.beyond]


def explain_moved(run: StandardRun, ends: Ends) -> tuple[Cause, ...]:
    """Return what moved over a run: what all its cuts show, and what only its ends do.

    Nothing where no effect stands in all cuts and the ends moved no more than repeats scatter.
    """
    if not run.enough:
        return tuple(_open(run, ends, component, None) for component in ends.beyond)
    result = look_for(stack_of_run(run), run_candidates(measured=run.measured))
    found = _Causes(run, result)
    left = [component for component in ends.beyond if not found.sensed(component)]
    return (*found.causes(), *(_unnamed(run, ends, component, result) for component in left))


class _Causes:
    """What was found in a run, and how sure each name is."""

    def __init__(self, run: StandardRun, result: FoundInCuts) -> None:
        self.run, self.result, self.stack = run, result, result.stack
        self.choices = result.found.choices

    @cached_property
    def fit(self) -> CutsFit:
        """The columns that are free anyhow and the effects, fitted together."""
        return fit_cuts(self.stack, self.result.own, self.choices)

    def sensed(self, component: int) -> bool:
        """Whether what was found is sensed in a component."""
        parts = [part[component] for part in self.fit.parts[len(self.result.own) :]]
        return any(np.sum((part / self.stack.sd[component]) ** 2) > SENSED for part in parts)

    def causes(self) -> tuple[Cause, ...]:
        """Return a cause for each effect that was found."""
        return tuple(self._cause(number) for number in range(len(self.choices)))

    def _cause(self, number: int) -> Cause:
        choice = self.choices[number]
        term, acts = choice.candidate.term, _acts_on(choice)
        sure = of_missing(self.result.search, self.result.found, choice)
        near = (*sure.near, *self._alike(term, acts))
        named = not sure.near or sure.confidence >= SURE
        change = self._change(number, acts[0])
        said = effect_words(
            term,
            change,
            air_too=len(acts) > 1,
            air=len(self.stack.names) > 1,
            or_force=FORCE in near,
        )
        unsure = undecided_words(amount(change, term), (term, *near))
        return Cause(
            term=term if named else UNKNOWN,
            kind="missing",
            confidence=sure.confidence if named else 1.0 - sure.confidence,
            statement=f"{said if named else unsure} {self._left_out(acts[0])}",
            parameters={"change": change},
            alternatives=near if named else (term, *near),
            variables=choice.candidate.variables,
            to_tell_apart=self._distinguishing(choice, sure.near),
        )

    def _alike(self, term: str, acts: list[int]) -> tuple[str, ...]:
        """Return what no run of this kind distinguishes an effect from."""
        if term == GAIN and acts == [RISE] and not self.run.measured:
            return (FORCE,)
        if term == OFFSET and len(self.stack.names) == 1:
            return (FRICTION,)
        return ()

    def _change(self, number: int, component: int) -> IntervalValue:
        """Return by how much an effect moved a component from the first cut to the last."""
        choice, at = self.choices[number], self.fit.places[len(self.result.own) + number]
        law = choice.shape.law
        assert isinstance(law, LawColumns)  # every candidate of a cut table is made of laws
        course = law.of(component)
        if choice.candidate.term == GAIN:
            course = course / self.stack.simulation[component][:, None]
        step = course[-1] - course[0]
        half = NORMAL_95 * float(np.sqrt(max(step @ self.fit.covariance[at, at] @ step, 0.0)))
        unit = "1" if choice.candidate.term == GAIN else self.run.unit
        return IntervalValue.around(float(step @ self.fit.coefficients[at]), half, unit)

    def _left_out(self, component: int) -> str:
        """Return how far cuts left out of the fit are predicted with what was found, and
        without."""
        with_it, without = (
            rms(held_out_rows(self.stack, self.result.own, choices)[component])
            for choices in (self.choices, ())
        )
        return held_out_words(with_it, without, self.run.unit)

    def _distinguishing(self, choice: Choice, rivals: tuple[str, ...]) -> str | None:
        teller = made_again(self.result, own_of_run, unit=self.run.unit)
        cuts = teller.distinguishing(choice, choice.candidate.term, rivals)
        force = FORCE in self._alike(choice.candidate.term, _acts_on(choice))
        lines = [line for line in (cuts, MEASURED if force else None) if line is not None]
        return " ".join(lines) if lines else None


def _acts_on(choice: Choice) -> list[int]:
    """Return the components that an effect acts on."""
    law = choice.shape.law
    assert isinstance(law, LawColumns)
    return [component for component, mix in enumerate(law.mix) if np.any(mix)]


def _unnamed(run: StandardRun, ends: Ends, component: int, result: FoundInCuts) -> Cause:
    """Return what is known of a component that moved, where the search found nothing."""
    if component == RISE and run.measured and ends.force is not None:
        beside = _beside_force(run, ends)
        if ends.force.beyond and not beside.beyond:
            return _force(run, ends.force, ends.force_unit, beside)
    return _open(run, ends, component, result)


def _beside_force(run: StandardRun, ends: Ends) -> CurrentChange:
    """Return by how much the rise moved beside what the measured force gives."""
    last = len(run.rise) - 1
    return moved_between(run.rise - run.expected, ends.conditions, first=[0], last=[last])


def _force(run: StandardRun, force: CurrentChange, force_unit: str, beside: CurrentChange) -> Cause:
    """Return that the force moved, and what is sensed did as it says."""
    return Cause(
        term=FORCE,
        kind="mistuned",
        confidence=LEVEL,
        statement=force_words(force, force_unit, beside, run.unit),
        parameters={"change": _value(force, force_unit)},
    )


def _open(run: StandardRun, ends: Ends, component: int, result: FoundInCuts | None) -> Cause:
    """Return what may have moved, by the ends of the run alone, and the cut that would decide."""
    end = ends.rise if component == RISE else ends.air
    assert end is not None  # it moved
    change = _value(end, run.unit)
    names = _candidates(run, component, ends)
    return Cause(
        term=UNKNOWN,
        kind="missing",
        confidence=LEVEL,
        statement=undecided_words(moved_words(change, air=component == AIR), names),
        parameters={"change": change},
        alternatives=names,
        to_tell_apart=_by_the_end(result, component, run.unit) if result else None,
    )


def _candidates(run: StandardRun, component: int, ends: Ends) -> tuple[str, ...]:
    """Return what may have moved a component: the force too, unless measured force excludes it."""
    if component == AIR:
        return (FRICTION, GAIN)
    without_air = () if run.air is not None else (FRICTION,)
    sensing = run.measured and _beside_force(run, ends).beyond
    return (GAIN, OFFSET, *without_air, *(() if sensing else (FORCE,)))


def _by_the_end(result: FoundInCuts, component: int, unit: str) -> str | None:
    """Return the cut whose repeat would decide what moved the last cut alone: gain, offset,
    friction.

    None where none of the run's cuts would.
    """
    pair = ((FRICTION, AIR), (GAIN, None)) if component == AIR else ((GAIN, RISE), (OFFSET, RISE))
    first, second = (at_the_end(result.stack, term, where) for term, where in pair)
    teller = made_again(result, own_of_run, unit=unit)
    best = teller.between((first,), (second,))
    return None if best is None else teller.line(best, (pair[0][0], pair[1][0]))


def _value(end: CurrentChange, unit: str) -> IntervalValue:
    return IntervalValue(value=end.change, low=end.low, high=end.high, unit=unit)


def cause_sentences(causes: tuple[Cause, ...]) -> Iterator[str]:
    """Yield what is said of causes: each with what else it may be, and what would decide."""
    for cause in causes:
        sure = "" if cause.term == "unknown" else f" (confidence {cause.confidence:.2f})"
        head, *rest = cause.statement.split(". ", maxsplit=1)
        yield ". ".join([f"{head.rstrip('.')}{sure}", *rest]) + ("" if rest else ".")
        if cause.alternatives and cause.term != "unknown":
            yield f"These cuts do not separate it from: {names_listed(cause.alternatives)}."
        if cause.to_tell_apart is not None:
            yield f"To tell apart: {cause_in_words(cause.to_tell_apart)}"


def names_listed(names: tuple[str, ...]) -> str:
    """Return names as a list of what they are called."""
    return ", ".join(NAMES[name] for name in names)


def cause_in_words(sentence: str) -> str:
    """Return a sentence with the names of terms as they are called here."""
    for name, called in NAMES.items():
        sentence = sentence.replace(f" {name} ", f" {called} ")
    return sentence


def effect_words(
    term: str, change: IntervalValue, *, air_too: bool, air: bool, or_force: bool
) -> str:
    """Return what an effect did; ``air``: whether the current in air is known."""
    by = f"moved by {amount(change, term)} {LAST}"
    if term == GAIN:
        other = f", or {NAMES[FORCE]}, which was not measured in these cuts" if or_force else ""
        said = f"What moved is {NAMES[term]}{other}: it {by}, the rise of every cut by one share."
        return f"{said} {_air(went_with_it=air_too) if air else 'That in air is not recorded.'}"
    rest = {
        OFFSET: "the rise of every cut by one amount, whatever the force.",
        FRICTION: "and the rise over it did not.",
        WEAR: "with the cutting time of the edges; the force was not measured in these cuts.",
    }
    subject = "the current in air" if term == FRICTION else "the rise"
    return f"What moved is {NAMES[term]}: {subject} {by}, {rest[term]}"


def _air(*, went_with_it: bool) -> str:
    if went_with_it:
        return "The current in air went with it: the sensor's or the motor's constant."
    return "The current in air did not go with it: no constant of sensor or motor moved."


def amount(change: IntervalValue, term: str) -> str:
    """Return a change with its interval, a gain's in percent."""
    numbers = (change.value, change.low, change.high)
    if term == GAIN:
        middle, low, high = (f"{100.0 * number:+.2g}" for number in numbers)
        return f"{middle} % ({low} to {high})"
    middle, low, high = (f"{number:+.2g}" for number in numbers)
    return f"{middle} {change.unit} ({low} to {high})"


def moved_words(change: IntervalValue, *, air: bool) -> str:
    """Return by how much a current moved, as the repeated cut alone shows it."""
    return f"{amount(change, '')} {'of the current in air' if air else 'of the rise'}"


def undecided_words(size: str, names: tuple[str, ...]) -> str:
    """Return that something moved by ``size`` which may be any of some names."""
    return f"These cuts do not tell what moved ({size} {LAST}); it may be: {names_listed(names)}."


def held_out_words(with_it: float, without: float, unit: str) -> str:
    """Return how far cuts left out of the fit are predicted."""
    return (
        f"Held-out cuts are predicted to within {significant(with_it, 2)} {unit} with it, "
        f"{significant(without, 2)} "
        f"{unit} without it."
    )


def force_words(end: CurrentChange, force_unit: str, beside: CurrentChange, unit: str) -> str:
    """Return that the measured force moved, and the current no further than that."""
    return (
        f"What moved is {NAMES[FORCE]}, not the sensing: it was measured and moved by "
        f"{end.change:+.3g} {force_unit} ({end.low:+.3g} to {end.high:+.3g}) {LAST}. Beside what "
        f"that force gives the rise moved by {beside.change:+.2g} {unit} ({beside.low:+.2g} to "
        f"{beside.high:+.2g}): no more than repeats scatter."
    )
