"""All that the answer about one axis channel is read from, and what each cause adds."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import Cause, ChannelTrace, FitQuality, IntervalValue
from autodb.explain.axis.signals import AxisSignals
from autodb.explain.axis.tilt import ACROSS, CONSTANT, term_of
from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import UNKNOWN, Choice
from autodb.explain.engine.fit import AS_RECORDED, FittedRows, quality
from autodb.explain.engine.fitted import FittedEffects, fit_white_rows
from autodb.explain.engine.inquiry import Inquiry
from autodb.explain.engine.noise import Noise
from autodb.explain.engine.normal import columns_side_by_side
from autodb.explain.engine.prior import OWN_SD
from autodb.fitting.gaussian import NORMAL_95
from autodb.records.tables import Recording
from autodb.terms.vocabulary import term_called

Array = NDArray[np.float64]

GAP_S = 0.25
"""Rows this near to a block left out are not fitted on: noise is correlated over such times."""
WORSE = 1.02
"""Factor on the held-out error from which on a fit is clearly worse than another. Chosen."""
DOUBLES, ALIKE = 1.0, 0.9
"""Share of itself by which an own term changes at least, and cosine between that change and an
effect, from which on the change is counted to the effect. Chosen."""
RETUNED = 0.01
"""Relative change of an own term below which it is not called mistuned."""
MOTION = ("position", "velocity", "acceleration", "direction")


@dataclass(frozen=True)
class AxisReading:
    """``bench`` has what the simulation lacks by plain rows as own columns; ``noise`` weighs its
    rows in the final fit; ``choices`` are what was found beside, tuned; ``had``: the terms of the
    simulation, read off it or said to be; ``whole``: the rows as recorded, less the simulation.
    """

    bench: WhiteRows
    inquiry: Inquiry
    noise: Noise
    choices: tuple[Choice, ...]
    fitted: FittedEffects
    signals: AxisSignals
    had: frozenset[str]
    unit: str
    whole: WhiteRows

    @property
    def everything(self) -> tuple[Choice, ...]:
        """All that was found: laws that plain rows need, then the choices."""
        return (*self.inquiry.founded, *self.choices)

    @property
    def white(self) -> bool:
        """Whether its sizes are those of white rows."""
        return self.noise[0] is self.inquiry.whitener

    @property
    def correction(self) -> Array:
        """What all that was found adds, and the simulation's own terms re-tuned, (n,)."""
        return sum((law.effect for law in self.inquiry.laws), start=self.fitted.correction)


def sized_anew(inquiry: Inquiry, noise: Noise, bench: WhiteRows) -> range:
    """Return the numbers of own columns that are laws of plain rows, where white rows size them."""
    white = noise[0] is inquiry.whitener
    return range(bench.firm - len(inquiry.laws) * white, bench.firm)


def best_reading(
    read: Sequence[AxisReading], trace: ChannelTrace
) -> tuple[FitQuality, AxisReading]:
    """Return the reading that predicts rows left out best, with its errors.

    They are compared with the same own terms re-tuned: what a further one follows of slow noise
    says nothing against an effect.
    """
    shown = [_predicting(reading, trace) for reading in read]
    own = {n for _, one in shown for n in one.fitted.retuned if n < one.bench.firm}
    noise = shown[0][1].noise
    fits = [
        _quality(
            _refitted(replace(one, noise=noise), exact=not one.fitted.deviates, also=own), trace
        )
        for _, one in shown
    ]
    return shown[int(np.argmin([left_out_error(fit) for fit in fits]))]


def _refitted(
    reading: AxisReading,
    *,
    exact: bool = False,
    free: bool = False,
    also: Collection[int] = (),
) -> AxisReading:
    bench, choices, noise, inquiry = reading.bench, reading.choices, reading.noise, reading.inquiry
    also = {*also, *sized_anew(inquiry, noise, bench)}
    fitted = fit_white_rows(
        bench, choices, noise, inquiry.founded, exact=exact, free=free, also=also
    )
    return replace(reading, fitted=fitted)


def _predicting(reading: AxisReading, trace: ChannelTrace) -> tuple[FitQuality, AxisReading]:
    """Return a reading with its errors: beside laws of plain rows with the sizes of these, and
    without what laws get wrong in shape, where rows that were left out are predicted clearly better
    so, and with all of the simulation's own terms re-tuned.

    White rows may show a shape that plain ones do not hold; and a law's coefficient is that beside
    own terms that are free: without their change, which slow noise may hide, it makes no sense.
    Where white rows size effects they size own terms beside them, too, unless rows left out are
    predicted clearly worse so, or than by the simulation; else all of them change only where these
    are predicted clearly better.
    """
    shown = _quality(reading, trace), reading
    plainly = reading.white and bool(reading.inquiry.laws)
    if plainly or shown[0].rms_after > shown[0].rms_before:
        plain = replace(reading, noise=reading.inquiry.plain_noise)
        shown = _better(shown, _refitted(plain), trace)
    if shown[1].fitted.deviates:
        shown = _better(shown, _refitted(shown[1], exact=True), trace)
    fit, reading = shown
    if len(reading.fitted.retuned) == len(reading.bench.own):
        return shown
    free = _refitted(reading, exact=not reading.fitted.deviates, free=True)
    if reading.white and reading.everything:
        its = _quality(free, trace)
        fair = left_out_error(its) <= min(WORSE * left_out_error(fit), fit.heldout_before)
        return (its, free) if fair else shown
    return _better(shown, free, trace)


def _better(
    shown: tuple[FitQuality, AxisReading], other: AxisReading, trace: ChannelTrace
) -> tuple[FitQuality, AxisReading]:
    """Return a reading with its errors, or another where it is clearly better."""
    its = _quality(other, trace)
    return (its, other) if left_out_error(its) * WORSE < left_out_error(shown[0]) else shown


def left_out_error(fit: FitQuality) -> float:
    """Return what a correction leaves of rows left out of the fit, or of all where it harms these.

    Coefficients of white rows may leave more of all rows than was there: a mass, say, follows what
    trembles alone.
    """
    return fit.heldout_after if fit.rms_after <= fit.rms_before else fit.rms_after


def _quality(reading: AxisReading, trace: ChannelTrace) -> FitQuality:
    """Return the errors of the simulation, and with all that was found, on all and other rows.

    Two own terms that only the rows left out tell apart say nothing of these: a simulation's terms
    are off by a share of themselves, as for plain rows, or by what all rows show.
    """
    fitted, laws, bench = reading.fitted, reading.inquiry.laws, reading.bench
    whitener = reading.noise[0]
    sizes = fitted.values.copy()
    firm = [number for number in fitted.retuned if number < bench.firm]
    shown = np.abs(fitted.values[: len(firm)])
    sizes[: len(firm)] = np.maximum(OWN_SD * bench.own_sizes[firm], shown)
    before = trace.recording - trace.simulation
    return quality(
        before=before,
        after=before - reading.correction,
        columns=columns_side_by_side(
            np.empty((len(before), 0)), *(law.columns for law in laws), fitted.design
        ),
        values=np.concatenate([*(law.coefficients for law in laws), sizes]),
        gap=round(GAP_S / float(np.median(np.diff(trace.x)))),
        fitted_on=FittedRows(bench.rate, whitener) if whitener.coefficients.size else AS_RECORDED,
    )


def value_of(value: float, sd: float, unit: str) -> IntervalValue:
    """Return a value with its 95 % interval."""
    return IntervalValue.around(value, NORMAL_95 * sd, unit)


def size_of(reading: AxisReading, number: int) -> IntervalValue:
    """Return the peak of all that effects of a name add together; its interval is that of the sum
    at its peak. What an own term would have to more than double for, along them, is theirs.
    """
    choices = reading.inquiry.choices
    key = key_of_effect(choices[number])
    alike = [
        n for n, one in enumerate(choices) if one.candidate.named and key_of_effect(one) == key
    ]
    fits = [_fit_of(reading, n) for n in alike or [number]]
    alone = choices[number].shape.alone
    effect = np.sum([one for one, *_ in fits], axis=0) if alone is None else alone()
    if alone is None and choices[number].candidate.named:
        effect = effect + own_along(reading, effect)
    peak = float(np.quantile(np.abs(effect), 0.9995))
    row = int(np.argmin(np.abs(np.abs(effect) - peak)))
    variance = sum(float(columns[row] @ known @ columns[row]) for _, columns, known in fits)
    return value_of(peak, float(np.sqrt(max(variance, 0.0))), reading.unit)


def own_along(reading: AxisReading, effect: Array) -> Array:
    """Return the changes of own terms along an effect that would more than double them, (n,).

    Where both are one curve the rows do not tell which of them changes: a simulation is rather off
    by some per cent than by its own size. What other own terms take back of a change is none of it:
    over a small angle a weight that turns is nearly a constant load, and both change by much.
    """
    along = np.zeros_like(effect)
    whole = sum((_retuned(reading, name) for name in reading.fitted.own), start=along)
    for name, had in reading.signals.had.items():
        change = _retuned(reading, name)
        both = float(np.linalg.norm(change) * np.linalg.norm(effect))
        if both == 0.0 or float(change @ effect) < ALIKE * both:
            continue
        kept = min(float(whole @ change) / float(change @ change), 1.0)
        if kept * abs(reading.fitted.of_own(name)[0]) > DOUBLES * abs(had):
            along = along + kept * change
    return along


def _fit_of(reading: AxisReading, number: int) -> tuple[Array, Array, Array]:
    """Return what an effect adds (n,), its columns (n, p) and their coefficients' covariance."""
    laws = reading.inquiry.laws
    beside = number - len(laws)
    if beside < 0:
        return laws[number].effect, laws[number].columns, laws[number].covariance
    fitted = reading.fitted
    return fitted.effects[beside], fitted.columns[beside], fitted.covariances[beside]


def parts_of_causes(causes: Sequence[Cause], reading: AxisReading) -> list[Array]:
    """Return what each cause adds, (n,): all effects of its name, or the change of own terms."""
    effects: dict[tuple[str, bool], Array] = {}
    for number, choice in enumerate(reading.everything):
        key = key_of_effect(choice)
        effects[key] = effects.get(key, 0.0) + _effect(reading, number)

    def part(cause: Cause) -> Array:
        name, varies = acting_name(cause), bool(cause.variables)
        found = (effects[key] for key in ((name, varies), (name, not varies)) if key in effects)
        return next(found, _change(reading, cause))

    return [part(cause) for cause in causes]


def acting_name(cause: Cause) -> str:
    """Return the name of the effects that a cause is, of several that it may be the likeliest."""
    undecided = cause.term == UNKNOWN and not cause.variables
    return cause.alternatives[0] if undecided and cause.alternatives else cause.term


def key_of_effect(choice: Choice) -> tuple[str, bool]:
    """Return what the effects of one cause have in common; a weight that turns is no constant."""
    one = choice.candidate
    return (one.term if one.named else UNKNOWN), bool(one.variables)


def _effect(reading: AxisReading, number: int) -> Array:
    """Return what an effect adds; of a law that plain rows need with its change in white rows."""
    laws = reading.inquiry.laws
    if number >= len(laws):
        return reading.fitted.effects[number - len(laws)]
    law = laws[number]
    return law.effect + _retuned(reading, law.choice.candidate.key)


def _change(reading: AxisReading, cause: Cause) -> Array:
    """Return the change of the own term that a cause names, or of all that it may be."""
    none = np.zeros_like(reading.fitted.correction)
    return sum((_retuned(reading, name) for name in _own_of(cause, reading)), start=none)


def _own_of(cause: Cause, reading: AxisReading) -> list[str]:
    """Return the own columns of a cause: of a weight that turns both, and not the constant load."""
    if cause.term == UNKNOWN:
        return [n for n in reading.fitted.own if term_of(n) in cause.alternatives]
    if reading.signals.rotary and cause.term == "gravity":
        return ["gravity", ACROSS] if cause.variables else [CONSTANT]
    return [cause.term]


def changed_own(reading: AxisReading) -> list[str]:
    """Return the own terms whose coefficient changes by more than its interval and RETUNED, and the
    constant load beside a weight that turns where it does.
    """
    fitted, signals = reading.fitted, reading.signals
    told = {*signals.had, *([CONSTANT] if signals.constant else [])}
    found = []
    for name in (name for name in fitted.own if name in told):
        change, sd = fitted.of_own(name)
        if abs(change) > max(NORMAL_95 * sd, RETUNED * abs(signals.own_size(name))):
            found.append(name)
    return found


def change_size(reading: AxisReading, name: str) -> IntervalValue:
    """Return the peak of an own term's change."""
    change, sd = reading.fitted.of_own(name)
    peak = float(np.max(np.abs(reading.signals.own[name])))
    return value_of(abs(change) * peak, sd * peak, reading.unit)


def _retuned(reading: AxisReading, name: str) -> Array:
    """Return the change of an own column in the correction, (n,)."""
    fitted = reading.fitted
    for at, number in enumerate(fitted.retuned):
        if fitted.own[number] == name:
            return np.asarray(fitted.design[:, at] * fitted.values[at])
    return np.zeros_like(fitted.correction)


def signals_of_causes(
    causes: Sequence[Cause], reading: AxisReading, recording: Recording
) -> dict[str, Array]:
    """Return the signals that causes act on, (n,) by channel, as recorded where they are.

    Those of an own term are the inputs of its law. Time is none: a stretch of it is an interval.
    """
    signals = reading.signals
    moved = {signals.channel(what): getattr(signals, what) for what in MOTION} | signals.others
    names = dict.fromkeys(name for cause in causes for name in _variables(cause, reading))
    return {
        name: recording[name] if name in recording else moved[name]
        for name in names
        if name in moved
    }


def _variables(cause: Cause, reading: AxisReading) -> tuple[str, ...]:
    """Return the channels that a cause acts on; what needs no signal to be seen acts on none."""
    if cause.variables or cause.term == UNKNOWN:
        return cause.variables
    term = term_called(cause.term)
    return tuple(reading.signals.channel(name) for name in term.inputs if term.needs)
