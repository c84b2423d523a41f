"""What a milled waveform holds, component by component: causes in words, where, and how it fits."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import (
    Cause,
    ChannelAnswer,
    ChannelTrace,
    Considered,
    FitQuality,
    IntervalValue,
    Where,
    considered,
    largest_first,
    unnamed_cause,
)
from autodb.explain.engine.candidates import UNKNOWN, Choice
from autodb.explain.engine.confidence import Mistuned, with_laws
from autodb.explain.engine.entries import is_undecided, named_entry, undecided_entry
from autodb.explain.engine.fit import SAME, no_difference, rms
from autodb.explain.engine.locate import regimes
from autodb.explain.engine.plain.rows import PlainRows
from autodb.explain.engine.standing import Standing
from autodb.explain.waves.candidates import OWN_WAYS, candidates_by_key
from autodb.explain.waves.fit import WavesFit, component_noise_sd, fit_waves
from autodb.explain.waves.look import FoundInWaves, but_for_laws, look_in_waves
from autodb.explain.waves.parameters import (
    EffectInWaves,
    change_of_own,
    interval_value,
    mistuned_of_waves,
    of_one,
    retuned_of_waves,
    shared,
)
from autodb.explain.waves.plain_rows import WaveRows
from autodb.explain.waves.refined import as_one
from autodb.records.tables import Recording
from autodb.wording import stored_msgid

Array = NDArray[np.float64]

SENSED = 9.0
"""Sum of squares of white rows that an effect adds to a component, above which it acts there."""
TURNS = 3.0
"""Turns of the spindle that are drawn close up."""
STATEMENTS = {
    "edge_force": "The cutting edge rubs: a force that does not depend on the chip's thickness.",
    "size_effect": "Thin chips take more force for their area than thick ones.",
    "tool_wear": "The edge wears while it cuts: its rubbing force grows within the recording.",
    "runout": "The teeth do not stand out alike: one takes more, the next finds less.",
    "depth_error": "The mill cut deeper or shallower than the simulation has it.",
    "deflection": "Tool or work springs away: the harder the cut, the less of it is taken.",
    "chatter": "The cut rings at a frequency of its own, which is no multiple of the spindle's.",
    "hard_spot": "For a stretch the material is harder or softer.",
    "gain": "One component is scaled while the others are not.",
    "sensor_drift": "The sensor's zero wanders with the clock, in air too.",
    "thermal_drift": "The sensor's zero moves while chips heat it, and comes back in air.",
    "crosstalk": "The sensor mixes its components: one shows a share of another.",
    "table_gravity": "A mass on the tilted table weighs on the sensor.",
    "table_inertia": "A mass on the swinging table pulls on the sensor.",
}
APART: dict[frozenset[str], str] = {
    frozenset(pair): words
    for *pair, words in (
        ("edge_force", "size_effect", "Repeat the cut at a tenth of the feed: the edge's force "
         "stays as it is, the extra force of thin chips nearly goes with the chip."),
        ("edge_force", "depth_error", "Repeat the cut at twice the depth: the edge's force "
         "doubles, what a wrong depth adds stays."),
        ("edge_force", "tool_wear", "Repeat the cut with a new edge: worn-on force is gone, the "
         "edge's own is there."),
        ("tool_wear", "sensor_drift", "Let the sensor stand in air after the cut: drift goes on, "
         "wear shows nothing there."),
        ("tool_wear", "thermal_drift", "Repeat the cut after a pause of some minutes: heat has "
         "gone, wear has not."),
        ("tool_wear", "gain", "Repeat the cut with a new edge: wear falls back, a scale does not."),
        ("tool_wear", "hard_spot", "Repeat the cut beside the last one: a hard place is in the "
         "work, wear is on the edge and goes on."),
        ("sensor_drift", "thermal_drift", "Record some minutes of air after the cut: heat drift "
         "comes back, the clock's goes on."),
        ("sensor_drift", "table_gravity", "Tilt the table once without cutting: weight follows the "
         "angle, drift the clock."),
        ("sensor_drift", "table_inertia", "Swing the table once without cutting: inertia shows "
         "there, drift does not follow it."),
        ("runout", "deflection", "Repeat the cut at twice the feed: run-out stays the same in "
         "millimetres, bending grows with the force."),
        ("runout", "depth_error", "Compare single turns: run-out differs from tooth to tooth, a "
         "depth does not."),
        ("runout", "chatter", "Repeat the cut at another spindle speed: run-out stays at multiples "
         "of the turn, chatter at its own frequency."),
        ("gain", "depth_error", "Load the sensor with a known weight: a scale shows, a depth does "
         "not."),
        ("gain", "crosstalk", "Load the sensor along one axis with a known weight: crosstalk shows "
         "in the others."),
        ("gain", "deflection", "Load the sensor with a known weight: a scale shows, bending of the "
         "tool does not."),
        ("deflection", "depth_error", "Repeat the cut with a shorter overhang: bending goes, a "
         "wrong depth stays."),
        ("deflection", "size_effect", "Repeat the cut with a shorter overhang: bending goes, the "
         "force of thin chips stays."),
        ("hard_spot", "depth_error", "Measure the depth along the cut: over a hard stretch it is "
         "as elsewhere."),
    )
}  # fmt: skip
MOST = 2
"""Alternatives that are told what would separate."""


def explain_waves(
    recording: Recording, simulation: dict[str, Array], includes: list[str] | None
) -> dict[str, tuple[ChannelAnswer, ChannelTrace]]:
    """Say what the simulation of a mill's forces over time leaves out, by channel.

    ``simulation``: force channel → (n,) at the recording's times.

    Raises UnusableInput where the side file says too little of the mill and its cut.
    """
    if all(_is_same(recording[name], values) for name, values in simulation.items()):
        return {name: _nothing(recording, name) for name in simulation}
    looked, whole = look_in_waves(recording, simulation, includes)
    return _Told(recording, looked, whole, frozenset(includes or ())).answers()


@dataclass(frozen=True)
class _Told:
    """What was looked for and found in a recording, put in words.

    ``looked``: as it was searched for, ``whole``: at every row; ``includes``: own terms.
    """

    recording: Recording
    looked: FoundInWaves
    whole: FoundInWaves
    includes: frozenset[str]

    def answers(self) -> dict[str, tuple[ChannelAnswer, ChannelTrace]]:
        """Return the answer of every component, and its trace."""
        names = self.whole.world.waves.names
        return {name: self._answer(i, name) for i, name in enumerate(names)}

    @property
    def choices(self) -> tuple[Choice, ...]:
        """The effects that were found, where they were searched for."""
        return self.looked.found.choices

    @cached_property
    def fit(self) -> WavesFit:
        """Own terms and effects fitted together."""
        whole = self.whole
        known = whole.plainly or OWN_WAYS in whole.found.keys
        ways = candidates_by_key(whole.world, () if known else (OWN_WAYS,)).values()
        beside = [Choice(one, len(one.forms) - 1) for one in ways]
        choices = as_one(whole.world, whole.bench, whole.found, whole.quiet)
        named = tuple(c for c in choices if c.candidate.named)
        choices = tuple(c if c.candidate.named else self._left(c, named) for c in choices)
        fit = fit_waves(whole.bench, choices, whole.quiet, beside=beside)
        return replace(fit, covariance=(whole.repeats or 1.0) * fit.covariance)

    def _left(self, course: Choice, named: Sequence[Choice]) -> Choice:
        """Return a course without a name in what effects with a name leave of it: its own part."""
        left = but_for_laws(self.whole.bench, named, course, self.whole.quiet)
        key = f"{left.candidate.key}, left"
        return Choice(replace(left.candidate, key=key), left.form)

    @cached_property
    def standing(self) -> list[Standing]:
        """How sure the name of each effect is."""
        looked = self.looked
        rows = PlainRows(
            WaveRows(looked.bench, looked.quiet), looked.search.candidates, self.choices
        )
        return [
            with_laws(looked.search, looked.found, choice, rows=rows, laws=looked.laws)
            for choice in self.choices
        ]

    @cached_property
    def own_terms(self) -> dict[str, Mistuned]:
        """How sure it is of each own term that it is off."""
        return mistuned_of_waves(self.looked)

    @cached_property
    def effects(self) -> list[EffectInWaves]:
        """Each effect with what stands beside it."""
        looked = self.looked
        return [
            EffectInWaves(
                looked.world,
                looked.bench,
                looked.quiet,
                c,
                looked.found.without(c.candidate.key),
                looked.repeats or 1.0,
            )
            for c in self.choices
        ]

    @cached_property
    def shared(self) -> list[dict[str, IntervalValue]]:
        """The parameters of each effect that are the same in all components."""
        return [shared(effect) for effect in self.effects]

    @cached_property
    def held_out(self) -> Array:
        """What is left of blocks of time that the fit did not see (C, n)."""
        return self.whole.bench.held_out(self.whole.found.choices, self.whole.quiet)[0]

    @cached_property
    def sensed(self) -> Array:
        """Whether each effect is sensed in each component (effects, C)."""
        parts = np.array([self.fit.part(number) for number in range(len(self.choices))])
        white = [self.whole.quiet.each(part) for part in parts]
        return np.array([[np.sum(one**2) > SENSED for one in part] for part in white])

    def _causes(self, component: int) -> tuple[tuple[Cause, ...], tuple[float, ...]]:
        """Return the causes seen in one component, the largest first, and their shares of the
        squared error.
        """
        numbers = [
            number
            for number, choice in enumerate(self.choices)
            if choice.candidate.key != OWN_WAYS and self.sensed[number, component]
        ]
        causes = [self._cause(number, component) for number in numbers]
        again = retuned_of_waves(self.looked, self.own_terms, self.fit, component, beside=causes)
        own = [(c.term,) if c.term != UNKNOWN else c.alternatives for c in again]
        return largest_first(
            [*causes, *again],
            [self.fit.part(number)[component] for number in numbers]
            + [change_of_own(self.looked, self.fit, terms, component) for terms in own],
            correction=self.fit.correction[component],
            difference=self.whole.bench.difference[component],
        )

    def _cause(self, number: int, component: int) -> Cause:
        choice, sure = self.choices[number], self.standing[number]
        size = self._size(number, component)
        if not choice.candidate.named:
            return self._unnamed(number, component, size)
        apart = words_that_tell(choice.candidate.term, sure.near)
        if is_undecided(choice, sure):
            return undecided_entry(
                choice, sure, size, where=stored_msgid("These turns"), apart=apart
            )
        values = {**self.shared[number], **of_one(self.effects[number], component)}
        statement = STATEMENTS[choice.candidate.term]
        return named_entry(
            choice, sure, statement, {"size": size, **values}, includes=self.includes, apart=apart
        )

    def _unnamed(self, number: int, component: int, size: IntervalValue) -> Cause:
        choice, sure = self.choices[number], self.standing[number]
        return unnamed_cause(
            choice.candidate.variables,
            f"{_course_words(choice)}.",
            difference=self.whole.bench.difference[component],
            part=self.fit.part(number)[component],
            size=size,
            confidence=sure.confidence,
            alternatives=sure.near,
        )

    def _size(self, number: int, component: int) -> IntervalValue:
        """Return the largest contribution with its interval."""
        part, at = self.fit.part(number)[component], self.fit.places[number]
        peak = int(np.argmax(np.abs(part)))
        row = self.fit.columns[component, peak, at]
        variance = float(row @ self.fit.covariance[at, at] @ row)
        return interval_value(abs(float(part[peak])), float(np.sqrt(max(variance, 0.0))), "N")

    def _answer(self, component: int, name: str) -> tuple[ChannelAnswer, ChannelTrace]:
        causes, takes = self._causes(component)
        before = self.whole.bench.difference[component]
        correction = self.fit.correction[component] if self.choices else np.zeros_like(before)
        held = self.held_out[component] if self.choices else before
        signals = _signals(self.recording)
        acted = {name for cause in causes for name in cause.variables}
        answer = ChannelAnswer(
            unit=self.recording.unit(name),
            mismatch=bool(causes),
            where=Where(
                intervals=self._intervals(component),
                regime=regimes(
                    before, correction, {name: signals[name] for name in signals if name in acted}
                ),
            ),
            missing=causes,
            fit=FitQuality(
                rms_before=rms(before),
                rms_after=rms(before - correction),
                heldout_before=rms(before),
                heldout_after=rms(held),
                noise_floor=self._noise(component),
            ),
        )
        trace = self._trace(name, component, correction, signals)
        return answer, replace(trace, takes=takes)

    def _noise(self, component: int) -> float:
        """Return the noise of a component: of plain rows all that the fit leaves."""
        if self.whole.plainly:
            return rms(self.whole.bench.difference[component] - self.fit.correction[component])
        return float(component_noise_sd(self.whole.quiet)[component])

    def _intervals(self, component: int) -> tuple[tuple[float, float], ...]:
        return tuple(
            choice.candidate.interval
            for number, choice in enumerate(self.choices)
            if choice.candidate.interval is not None and self.sensed[number, component]
        )

    def _trace(
        self, name: str, component: int, correction: Array, signals: dict[str, Array]
    ) -> ChannelTrace:
        waves = self.whole.world.waves
        simulation = waves.simulation[component]
        return ChannelTrace(
            x_name="t",
            x=waves.t_s,
            recording=self.recording[name],
            simulation=simulation,
            corrected=simulation + correction,
            regime_signals=signals,
            considered=self._considered,
            close_up=_turns(self.whole, correction),
        )

    @cached_property
    def _considered(self) -> tuple[Considered, ...]:
        """Every candidate as it would do alone, the strongest first."""
        offers = self.looked.search.offers(())
        alone = {offer.choice.candidate.key: offer.worth for offer in offers}
        return considered(alone, self.looked.found.keys)


def _signals(recording: Recording) -> dict[str, Array]:
    """Return the places that were recorded and differ."""
    ends = (".position", "a.angle", "b.angle", "c.angle")
    return {
        name: values
        for name, values in recording.channels.items()
        if name.endswith(ends) and np.ptp(values) > 0.0
    }


def _course_words(choice: Choice) -> str:
    shape = choice.shape.shape
    if "frequency" in shape:
        return f": a tone of {shape['frequency']:.4g} Hz, in air too"
    if "turns" in shape:
        return f": it comes round {shape['turns']:.3g} times in the work"
    return ""


def _turns(looked: FoundInWaves, correction: Array) -> tuple[float, float]:
    """Return from when to when to look closely: turns in the work where most is corrected."""
    world = looked.world
    t = world.waves.t_s
    inside = np.flatnonzero(world.engaged > 0.0)
    turn_s = 1.0 / max(world.turns_a_s, 1e-9)
    middle = (
        inside[np.argmax(np.abs(correction[inside]))]
        if np.any(correction)
        else inside[len(inside) // 2]
    )
    low = float(np.clip(t[middle] - 0.5 * TURNS * turn_s, t[inside[0]], t[inside[-1]]))
    return low, low + TURNS * turn_s


def _is_same(measured: Array, simulated: Array) -> bool:
    return rms(measured - simulated) <= SAME * max(rms(measured), rms(simulated))


def _nothing(recording: Recording, name: str) -> tuple[ChannelAnswer, ChannelTrace]:
    values = recording[name]
    trace = ChannelTrace("t", recording.t_s, recording=values, simulation=values, corrected=values)
    return no_difference(recording.unit(name)), trace


def words_that_tell(name: str, others: Sequence[str]) -> str | None:
    """Return what would tell an effect from its nearest alternatives; None where none is known."""
    pairs = (frozenset((name, other)) for other in others[:MOST])
    lines = dict.fromkeys(APART[pair] for pair in pairs if pair in APART)
    return " ".join(lines) or None
