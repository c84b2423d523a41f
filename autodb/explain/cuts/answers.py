"""What a table of cuts holds, component by component: causes, own terms, where, how it fits."""

from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import (
    Cause,
    ChannelAnswer,
    ChannelTrace,
    FitQuality,
    IntervalValue,
    Where,
    considered,
    largest_first,
    unnamed_cause,
)
from autodb.explain.cuts.candidates.effect_parameters import (
    EffectInCuts,
    effect_parameters,
    shape_words,
)
from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.cut_search import FoundInCuts, look_in_cuts, stack_of
from autodb.explain.cuts.distinguishing import after_forces
from autodb.explain.cuts.fit import CutsFit, all_columns, beside_own, fit_cuts, held_out_rows
from autodb.explain.cuts.plain_rows import plain_rows
from autodb.explain.cuts.stack import FLANK_WEAR, Stack, tells_edge_from_size
from autodb.explain.engine.candidates import UNKNOWN, Choice
from autodb.explain.engine.confidence import Mistuned, of_mistuned, with_laws
from autodb.explain.engine.entries import (
    is_undecided,
    named_entry,
    own_term_entries,
    undecided_entry,
)
from autodb.explain.engine.fit import rms
from autodb.explain.engine.locate import regimes
from autodb.explain.engine.plain.odds import UNSURE
from autodb.explain.engine.standing import Standing
from autodb.fitting.gaussian import NORMAL_95
from autodb.records.tables import CutTable
from autodb.terms.vocabulary import all_terms, term_called
from autodb.wording import significant, stored_msgid

Array = NDArray[np.float64]

HAS = stored_msgid("The simulation has {term} {had}; the recording says {value} ({low} to {high}).")
SENSED = 9.0
"""Fall of the sum of squares by an effect in one component, above which it is sensed there."""

FEW_CUTS = 100
"""Cuts up to which white rows say how sure a law is: more show what every real law gets wrong in
shape, and a curve without a name follows that. Of more, evidence is compared with laws of more
columns. Chosen."""


def explain_cuts(
    table: CutTable, simulation: dict[str, Array], includes: list[str] | None
) -> dict[str, tuple[ChannelAnswer, ChannelTrace]]:
    """Say what the simulation of a cut table's forces leaves out, by channel.

    ``simulation``: force channel → (n,) in the table's order of cuts.
    """
    result = look_in_cuts(stack_of(table, simulation, includes), includes)
    return answers(table, result, frozenset(includes or ()))


def answers(
    table: CutTable, result: FoundInCuts, includes: frozenset[str]
) -> dict[str, tuple[ChannelAnswer, ChannelTrace]]:
    """Return the answer of every component and its trace."""
    found = _Answers(result, includes)
    return {
        name: (found.answer(i, table.unit(name)), found.trace(i))
        for i, name in enumerate(result.stack.names)
    }


class _Answers:
    """The fit of what was found, and how sure each name is."""

    def __init__(self, result: FoundInCuts, includes: frozenset[str]) -> None:
        self.result, self.includes, self.stack = result, includes, result.stack
        self.choices, self.own = result.found.choices, result.own
        joint = fit_cuts(self.stack, self.own, self.choices)
        self.fit: CutsFit = beside_own(self.stack, self.own, self.choices, joint)
        self.rows = plain_rows(self.stack, self.own, result.search.candidates, held=self.choices)
        many = len(self.stack.known) > FEW_CUTS
        self.standing = {
            c.candidate.key: _limited(
                self.stack,
                c,
                with_laws(
                    result.search, result.found, c, rows=self.rows, laws=result.laws, many=many
                ),
            )
            for c in self.choices
        }
        self.own_terms = mistuned_of_cuts(result)
        self.teller = after_forces(result)
        self._apart: dict[str, str | None] = {}

    def part(self, number: int) -> Array:
        """Return the contribution of an effect, (C, n) [N]."""
        return self.fit.parts[len(self.own) + number]

    def sensed(self, number: int, component: int) -> bool:
        """Whether an effect is sensed in a component, with what it changes of the chip's own force:
        of a softening with speed nobody knows at which speed it is none.
        """
        part = self.part(number)[component]
        if self.choices[number].candidate.term == "speed_softening" and "shear" in self.own:
            part = part + self.fit.parts[list(self.own).index("shear")][component]
        return bool(np.sum((part / self.stack.sd[component]) ** 2) > SENSED)

    def causes(self, component: int) -> tuple[Cause, ...]:
        """Return the causes seen in one component, the largest first."""
        return self.told[component][0]

    @cached_property
    def told(self) -> list[tuple[tuple[Cause, ...], tuple[float, ...]]]:
        """The causes seen in each component, and the share of the squared error that each takes."""
        return [self._told(component) for component in range(len(self.stack.names))]

    def _told(self, component: int) -> tuple[tuple[Cause, ...], tuple[float, ...]]:
        if rms(self.held_out[component]) > rms(self._before(component)):
            return (), ()
        sensed = [(n, c) for n, c in enumerate(self.choices) if self.sensed(n, component)]
        causes = [self._cause(n, c, component) for n, c in sensed]
        again = retuned_of_cuts(self.result, self.own_terms, self.fit, component, beside=causes)
        parts = [self.part(n)[component] for n, _ in sensed]
        parts += [self._own_part(cause, component) for cause in again]
        return largest_first(
            [*causes, *again],
            parts,
            correction=np.sum([part[component] for part in self.fit.parts], axis=0),
            difference=self._before(component),
        )

    def _before(self, component: int) -> Array:
        return np.asarray((self.stack.recording - self.stack.simulation)[component])

    @cached_property
    def held_out(self) -> Array:
        """What is left of each component in cuts that the fit of what was found did not see."""
        return held_out_rows(self.stack, self.own, self.choices)

    def _own_part(self, cause: Cause, component: int) -> Array:
        """Return the change of the own term that a cause names, or of all that it may be, (n,)."""
        own = dict(zip(self.own, self.fit.parts, strict=False))
        names = cause.alternatives if cause.term == UNKNOWN else (cause.term,)
        none = np.zeros(len(self.stack.known))
        return sum((own[name][component] for name in names if name in own), start=none)

    def _cause(self, number: int, choice: Choice, component: int) -> Cause:
        sure = self.standing[choice.candidate.key]
        size = self._size(number, component)
        if not choice.candidate.named:
            return _unnamed(self, number, choice, component, size)
        if is_undecided(choice, sure):
            return undecided_entry(
                choice, sure, size, where=stored_msgid("These cuts"), apart=self.apart(choice)
            )
        others = tuple(c for c in self.choices if c.key != choice.key)
        effect = EffectInCuts(self.stack, self.own, choice, others)
        values = {"size": size, **effect_parameters(effect, component)}
        statement = next(t.statement for t in all_terms() if t.name == choice.candidate.term)
        return named_entry(
            choice, sure, statement, values, includes=self.includes, apart=self.apart(choice)
        )

    def apart(self, choice: Choice) -> str | None:
        """Return the cuts that would distinguish an effect from its nearest rivals."""
        key, rivals = choice.candidate.key, self.standing[choice.candidate.key].near
        if key not in self._apart:
            self._apart[key] = self.teller.distinguishing(choice, _name(choice), rivals)
        return self._apart[key]

    def _size(self, number: int, component: int) -> IntervalValue:
        """Return the largest contribution with its interval."""
        at = self.fit.places[len(self.own) + number]
        part = self.part(number)[component]
        peak = int(np.argmax(np.abs(part)))
        columns = all_columns(self.own, self.choices)
        whole = [c.raw(slice(peak, peak + 1))[component, 0] for c in columns]
        row = np.concatenate(whole) @ self.fit.mix[:, at]
        variance = float(row @ self.fit.covariance[at, at] @ row)
        return IntervalValue.around(
            abs(float(part[peak])), NORMAL_95 * float(np.sqrt(max(variance, 0.0))), "N"
        )

    def answer(self, component: int, unit: str) -> ChannelAnswer:
        """Return the answer of one component."""
        stack, causes = self.stack, self.causes(component)
        before = self._before(component)
        correction = self._correction(component, causes)
        held = self.held_out[component] if causes else before
        return ChannelAnswer(
            unit=unit,
            mismatch=bool(causes),
            where=Where(
                intervals=self._intervals(component),
                regime=regimes(before, correction, _acted_on(causes, _signals(stack))),
            ),
            missing=causes,
            fit=FitQuality(
                rms_before=rms(before),
                rms_after=rms(before - correction),
                heldout_before=rms(before),
                heldout_after=rms(held),
                noise_floor=rms(stack.sd[component]),
            ),
        )

    def _correction(self, component: int, causes: tuple[Cause, ...]) -> Array:
        """Return what is added to the simulation; nothing where nothing was found."""
        whole = np.sum([part[component] for part in self.fit.parts], axis=0)
        return np.asarray(whole if causes else np.zeros(len(self.stack.known)))

    def _intervals(self, component: int) -> tuple[tuple[float, float], ...]:
        return tuple(
            choice.candidate.interval
            for number, choice in enumerate(self.choices)
            if choice.candidate.interval is not None and self.sensed(number, component)
        )

    def trace(self, component: int) -> ChannelTrace:
        """Return the arrays behind the answer."""
        stack = self.stack
        correction = self._correction(component, self.causes(component))
        offers = self.result.search.offers(())
        return ChannelTrace(
            x_name="cut",
            x=stack.known.number,
            recording=stack.recording[component],
            simulation=stack.simulation[component],
            corrected=stack.simulation[component] + correction,
            regime_signals=_signals(stack),
            takes=self.told[component][1],
            considered=considered(
                {offer.choice.candidate.key: offer.worth for offer in offers},
                self.result.found.keys,
            ),
        )


def _acted_on(causes: Collection[Cause], signals: dict[str, Array]) -> dict[str, Array]:
    """Return the signals that causes act on; of an own term those that its law needs."""
    names = {
        name
        for cause in causes
        for name in cause.variables or (() if cause.term == UNKNOWN else _needs(cause.term))
    }
    return {name: values for name, values in signals.items() if name in names}


def _needs(term: str) -> tuple[str, ...]:
    return next(t.needs for t in all_terms() if t.name == term)


def _signals(stack: Stack) -> dict[str, Array]:
    names = (
        "tool.cutting_time", FLANK_WEAR, "cutting.feed", "cutting.speed", "cutting.depth",
        "z.position",
    )  # fmt: skip
    return {name: stack.known.other[name] for name in names if name in stack.known.other}


def _limited(stack: Stack, choice: Choice, sure: Standing) -> Standing:
    """Return the standing with what no table of this kind distinguishes added to it, and of a law
    that white rows of few cuts make no surer than UNSURE no surer, either: two measures of as few
    cuts see other accounts, and more is claimed only where both do.
    """
    known, also = stack.known, []
    thin = tells_edge_from_size(known)
    if choice.candidate.term == "edge_force" and not thin:
        also = ["size_effect"]
    if choice.candidate.term == "size_effect" and not thin:
        also = ["edge_force"]
    if choice.candidate.term == "tool_wear" and len(known.edges) < 2 and not known.by_land:
        also = ["sensor_drift"]
    few = len(known) <= FEW_CUTS
    confidence = min(sure.confidence, UNSURE) if few and sure.rivalled else sure.confidence
    return replace(sure, confidence=confidence, near=tuple(dict.fromkeys([*sure.near, *also])))


def _name(choice: Choice) -> str:
    """Return the effect's name, or what one without a name depends on."""
    if choice.candidate.named:
        return choice.candidate.term
    return f"what depends on {' and '.join(choice.candidate.variables)}"


def _unnamed(
    found: _Answers, number: int, choice: Choice, component: int, size: IntervalValue
) -> Cause:
    stack, part = found.stack, found.part(number)[component]
    sure = found.standing[choice.candidate.key]
    return unnamed_cause(
        choice.candidate.variables,
        f": {shape_words(stack, choice, part, component)}",
        difference=(stack.recording - stack.simulation)[component],
        part=part,
        size=size,
        confidence=sure.confidence,
        alternatives=sure.near,
        apart=found.apart(choice),
    )


def mistuned_of_cuts(result: FoundInCuts) -> dict[str, Mistuned]:
    """Return how sure it is of each own term that it is off, in all components together."""
    return {name: _judged(result, [name]) for name in result.own}


def _judged(result: FoundInCuts, names: Collection[str]) -> Mistuned:
    places, first = list[int](), 0
    for name, columns in result.own.items():
        after = first + columns.mix.shape[2]
        places += range(first, after) if name in names else ()
        first = after
    return of_mistuned(result.search, result.found, places)


def retuned_of_cuts(
    result: FoundInCuts,
    own: Mapping[str, Mistuned],
    fitted: CutsFit,
    component: int,
    *,
    beside: Collection[Cause],
) -> list[Cause]:
    """Return the own terms of one component whose coefficient changes, as ``mistuned_of_cuts``.

    ``beside``: what else is said of the component.
    """
    causes = {}
    for number, (name, columns) in enumerate(result.own.items()):
        change = _change(columns, fitted, fitted.places[number], component)
        if change.low * change.high > 0:
            causes[name] = _cause(result, name, change, component, own[name].standing)
    return own_term_entries(own, causes, beside=beside, jointly=partial(_judged, result))


def _change(columns: LawColumns, fitted: CutsFit, at: slice, component: int) -> IntervalValue:
    """Return the change of one component's coefficient."""
    place = at.start + _place(columns, component)
    sd = float(np.sqrt(max(fitted.covariance[place, place], 0.0)))
    return IntervalValue.around(float(fitted.coefficients[place]), NORMAL_95 * sd, "")


def _place(columns: LawColumns, component: int) -> int:
    return component if columns.mix.shape[2] > 1 else 0


def _cause(
    result: FoundInCuts, name: str, change: IntervalValue, component: int, sure: Standing
) -> Cause:
    """Return the entry of an own term whose coefficient changes by ``change``."""
    stack, columns = result.stack, result.own[name]
    term, sign = term_called(name), float(stack.sign[component])
    column = columns.raw()[component, :, _place(columns, component)]
    peak, half = float(np.max(np.abs(column))), change.high - change.value
    had, turned = 1.0, 1.0
    if name == "speed_softening" and stack.exponents is not None:
        had = float(stack.exponents[component])
    elif name != "shear":
        turned = sign
        had = float(stack.edge_N_mm[component]) if name == "edge_force" else 0.0
    if name == "tool_wear" and stack.wear is not None:
        had = turned = sign * float(stack.wear.rate(stack.known)[component])
    unit = term.parameters[0].unit.replace("U", "N")
    scale = abs(turned)
    now = IntervalValue.around(had + turned * change.value, scale * half, unit)
    if name == "shear" and now.value < 0:
        text = "Recording and simulation have opposite signs; check the sensor's sign first."
    else:
        text = term.statement
    return Cause(
        term=name,
        kind="mistuned",
        confidence=sure.confidence,
        statement=f"{text} {_has(term.parameters[0].name, had, now)}",
        parameters={
            "size": IntervalValue.around(abs(change.value) * peak, half * peak, "N"),
            term.parameters[0].name: now,
        },
        alternatives=sure.near,
    )


def _has(parameter: str, had: float, now: IntervalValue) -> str:
    """Say what a simulation has a number as, and what the recording says it is."""
    value, low, high = map(significant, (now.value, now.low, now.high))
    return HAS.format(term=parameter, had=significant(had), value=value, low=low, high=high)
