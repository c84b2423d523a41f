"""An accepted effect of an axis as an entry of the answer: sizes, certainty, alternatives."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import Cause, IntervalValue
from autodb.explain.axis.apart import move_that_tells
from autodb.explain.axis.form import Short, short_form
from autodb.explain.axis.read_off import READ_OFF, READ_WELL
from autodb.explain.axis.reading import (
    AxisReading,
    acting_name,
    change_size,
    changed_own,
    size_of,
    value_of,
)
from autodb.explain.axis.sensors_of_axis import DELAYS_S
from autodb.explain.axis.tilt import TILT_NAMES, level_and_phase, term_of
from autodb.explain.engine.candidates import UNKNOWN, Choice
from autodb.explain.engine.confidence import LIKELIER_THAN_NOT, Mistuned, of_missing, of_mistuned
from autodb.explain.engine.entries import (
    own_term_entries,
    retuned_words,
    size_words,
    told_entries,
    undecided_entry,
)
from autodb.explain.engine.plain.odds import beside_plain, of_plain
from autodb.explain.engine.standing import Standing
from autodb.explain.engine.tuning import BesideShapes, Tuned, tuned
from autodb.explain.engine.weighing import weighing
from autodb.fitting.gaussian import NORMAL_95
from autodb.terms.term import Term
from autodb.terms.vocabulary import term_called
from autodb.wording import significant, stored_msgid

Array = NDArray[np.float64]
Read = Mapping[str, IntervalValue]

AS_MUCH = 0.985
"""Share of what a smooth curve does from which on a short form does as much."""
INDISTINCT: Mapping[str, tuple[str, ...]] = {"gravity": ("sensor_drift",)}
"""Effects that no recording of forces can tell apart: a constant load and a sensor's constant."""

OFFSET, LOAD, SMALL_LOAD = 0.05, 0.8, 0.6
"""Share of the effort's range above which a constant is a load so probably, and how probably it is
below: zero points of current sensors are within a few per cent of what they measure. Chosen."""

SIZE_LEFT_OUT = stored_msgid("The simulation leaves it out: {size} ({size_low} to {size_high}).")
THESE_MOVES = stored_msgid("These moves")
HAS_OTHERWISE = stored_msgid("The simulation has it otherwise: {size} ({size_low} to {size_high}).")


def causes(reading: AxisReading) -> list[Cause]:
    """Return the entries of accepted effects, then of the simulation's own terms that are off.

    An effect that shows in so few rows that its size is none is not said.
    """
    made = [_effect(reading, number) for number in range(len(reading.everything))]
    entries = [entry for entry in made if entry.parameters["size"].value > 0.0]
    named = {_of_weights(entry) for entry in entries}
    again = _mistuned(reading, beside=entries)
    return [*told_entries(_merged(entries)), *(c for c in again if _of_weights(c) not in named)]


def _of_weights(entry: Cause) -> tuple[str, bool]:
    """Return the term of an entry, and whether it is a weight that turns, which is no constant."""
    return entry.term, entry.term == "gravity" and bool(entry.variables)


def _merged(entries: list[Cause]) -> list[Cause]:
    """Return one entry a term and kind, the largest: one effect in two shapes is one cause."""
    kept: dict[tuple[str, str, bool], Cause] = {}
    for entry in sorted(entries, key=lambda e: -e.parameters["size"].value):
        kept.setdefault(_merges(entry), entry)
    return [entry for entry in entries if kept[_merges(entry)] is entry]


def _merges(entry: Cause) -> tuple[str, str, bool]:
    """Return what entries have in common that are one: a weight that turns is no constant load."""
    return acting_name(entry), entry.kind, bool(entry.variables)


def _effect(reading: AxisReading, number: int) -> Cause:
    choice = reading.inquiry.choices[number]
    size = size_of(reading, number)
    turns = choice.candidate.forms[0].names == TILT_NAMES
    always = () if turns else INDISTINCT.get(choice.candidate.term, ())
    stands = standing_of(reading, number, but=always)
    others, sure = list(stands.near), stands.confidence
    if not choice.candidate.named:
        return _unknown(reading, number, size, others, sure)
    term = term_called(choice.candidate.term, "tilt" if turns else "")
    alternatives = tuple(dict.fromkeys([*always, *others]))
    kind: Literal["missing", "mistuned"] = "mistuned" if term.name in reading.had else "missing"
    apart = move_that_tells(reading, number, others, always)
    if kind == "missing" and others and sure <= LIKELIER_THAN_NOT:
        any_of = replace(stands, near=alternatives)
        entry = undecided_entry(choice, any_of, size, where=THESE_MOVES, apart=apart)
        return entry.model_copy(update={"variables": ()})
    return Cause(
        term=term.name,
        kind=kind,
        confidence=sure * (_is_a_load(reading, size.value) if always else 1.0),
        statement=f"{term.statement} {_size_words(size, kind)}",
        parameters={"size": size, **best_law_values(reading, choice, term)},
        alternatives=alternatives,
        variables=choice.candidate.variables,
        to_tell_apart=apart,
    )


def _is_a_load(reading: AxisReading, level: float) -> float:
    """Return the probability that a constant is a load and not the zero point of a sensor."""
    effort = reading.whole.difference + reading.signals.simulation
    return LOAD if level > OFFSET * float(np.ptp(effort)) else SMALL_LOAD


def standing_of(reading: AxisReading, number: int, *, but: Collection[str] = ()) -> Standing:
    """Return how the name of what was found stands beside its rivals."""
    inquiry, choice = reading.inquiry, reading.inquiry.choices[number]
    if inquiry.rows is not None and choice in inquiry.founded:
        return of_plain(inquiry.rows, inquiry.founded, choice, but=but)
    white = of_missing(inquiry.search, inquiry.found, choice, but=but)
    if inquiry.rows is None:
        return white
    return beside_plain(white, inquiry.rows, inquiry.founded, choice)


def _size_words(size: IntervalValue, kind: str) -> str:
    return (SIZE_LEFT_OUT if kind == "missing" else HAS_OTHERWISE).format(**size_words(size))


def best_law_values(reading: AxisReading, choice: Choice, term: Term) -> dict[str, IntervalValue]:
    """Return the values of the plain law that fits best beside the other effects, tuned."""
    law = _plain_law(reading, choice)
    if law is None:
        return {}
    bench, noise = reading.bench, reading.noise
    retuned: list[int] | None = list(reading.fitted.retuned)
    others = reading.inquiry.found.without(choice.candidate.key)
    if choice in reading.inquiry.founded:
        bench, noise, retuned = reading.whole, reading.inquiry.plain_noise, None
        others = tuple(c for c in reading.inquiry.founded if c.key != choice.key)
    elif not reading.inquiry.laws:
        noise = weighing(bench, [*others, law], reading.inquiry.noise, of=law)
    beside = BesideShapes(bench, others, noise, retuned)
    units = {p.name: _unit(p.unit, reading) for p in term.parameters}
    return _values(tuned(law, beside), beside, units, reading)


def _plain_law(reading: AxisReading, choice: Choice) -> Choice | None:
    """Return a choice's best plain law beside the others: its own where plain rows need it."""
    if choice in reading.inquiry.founded:
        return choice
    found, products = reading.inquiry.found, reading.inquiry.search.products
    given = products.given([c.key for c in found.without(choice.candidate.key)])
    plain = [
        Choice(choice.candidate, i)
        for i, form in enumerate(choice.candidate.forms)
        if form.names and (choice.candidate.key, i) in products.places
    ]
    return max(plain, key=lambda c: given.gain(c.key).full, default=None)


def _values(
    law: Tuned, beside: BesideShapes, units: Mapping[str, str], reading: AxisReading
) -> dict[str, IntervalValue]:
    form = law.choice.shape
    coefficients, covariance = beside.fit(form)
    if form.names == TILT_NAMES:
        turned = level_and_phase(coefficients, covariance)
        return {
            "level": value_of(*turned["level"], reading.unit),
            "phase": value_of(*turned["phase"], "deg"),
        }
    linear = {
        name: value_of(float(c), float(np.sqrt(v)), units.get(name, reading.unit))
        for name, c, v in zip(form.names, coefficients, np.diag(covariance), strict=True)
    }
    shape = {
        name: value_of(value, law.sd.get(name, 0.0), units.get(name, ""))
        for name, value in form.shape.items()
    }
    found = _further_ripples({**linear, **shape}, reading)
    for wanted, change in CHANGES:
        if set(wanted) <= found.keys():
            found = change(found, reading)
    return found


def _amplitude(found: Read, reading: AxisReading) -> dict[str, IntervalValue]:
    return _instead(found, ("cosine", "sine"), {"amplitude": _height(found, "", reading)})


def _further_ripples(found: Read, reading: AxisReading) -> dict[str, IntervalValue]:
    """Return height and period of each ripple beside the first, called by its waves in that one."""
    orders = [name.removeprefix("cosine") for name in found if name.startswith("cosine ")]
    for number, order in enumerate(orders, 2):
        new = {
            f"amplitude_{number}": _height(found, order, reading),
            f"period_{number}": _scaled(found["period"], 1.0 / float(order), found["period"].unit),
        }
        found = _instead(found, (f"cosine{order}", f"sine{order}"), new)
    return dict(found)


def _height(found: Read, order: str, reading: AxisReading) -> IntervalValue:
    cosine, sine = found[f"cosine{order}"], found[f"sine{order}"]
    sd = max(cosine.high - cosine.value, sine.high - sine.value) / NORMAL_95
    return value_of(float(np.hypot(cosine.value, sine.value)), sd, reading.unit)


def _rest(found: Read, reading: AxisReading) -> dict[str, IntervalValue]:
    """A constant beside a stiffness shifts the place where the spring is at rest."""
    stiffness, constant, middle = found["stiffness"], found["constant"], found["middle"]
    place = middle.value - constant.value / stiffness.value
    sd = (constant.high - constant.value) / NORMAL_95 / abs(stiffness.value)
    rest = value_of(place, sd, reading.signals.unit)
    return _instead(found, ("constant", "middle"), {"rest": rest})


def _rate(found: Read, reading: AxisReading) -> dict[str, IntervalValue]:
    """A bent drift's change and bend over the recording are a rate at its begin, and its change."""
    span = _span(reading)
    rate, bend = found["change"], found["bend"]
    return _instead(
        found,
        ("change", "bend"),
        {
            "rate": _scaled(rate, 1.0 / span, f"{reading.unit}/s"),
            "bend": _scaled(bend, 1.0 / span**2, f"{reading.unit}/s²"),
        },
    )


def _factor(found: Read, reading: AxisReading) -> dict[str, IntervalValue]:
    """A gain's relative change is a factor; its times are seconds of the recording."""
    span, begin = _span(reading), float(reading.signals.t_s[0])
    change = found["share_of_all"]
    new = {"factor": _shifted(_scaled(change, 1.0, "1"), 1.0)}
    if "start" in found:
        new["start"] = _shifted(_scaled(found["start"], span, "s"), begin)
    if "duration" in found:
        new["duration"] = _scaled(found["duration"], span, "s")
    if "time_constant" in found:
        new["time_constant"] = _scaled(found["time_constant"], span, "s")
    return _instead(found, ("share_of_all",), new)


def _drift(found: Read, reading: AxisReading) -> dict[str, IntervalValue]:
    """A straight drift's change over the recording is a rate."""
    rate = _scaled(found["change"], 1.0 / _span(reading), f"{reading.unit}/s")
    return _instead(found, ("change",), {"rate": rate})


def _delay(found: Read, reading: AxisReading) -> dict[str, IntervalValue]:
    """A shift so small that effort changes in proportion to it is a share of the least delay."""
    least_s = reading.signals.scales.delays(DELAYS_S)[0]
    return _instead(found, ("slight",), {"delay": _scaled(found["slight"], least_s, "s")})


def _nothing(found: Read, reading: AxisReading) -> dict[str, IntervalValue]:  # noqa: ARG001
    """The share of an effect whose size its shape fixes is no value of its own."""
    return _instead(found, ("share",), {})


CHANGES: tuple[
    tuple[tuple[str, ...], Callable[[Read, AxisReading], dict[str, IntervalValue]]], ...
] = (
    (("cosine", "sine"), _amplitude),
    (("stiffness", "constant"), _rest),
    (("change", "bend"), _rate),
    (("change",), _drift),
    (("share_of_all",), _factor),
    (("share",), _nothing),
    (("slight",), _delay),
)
"""Values of a law that are stored and exchanged under other names."""


def _instead(found: Read, gone: tuple[str, ...], new: Read) -> dict[str, IntervalValue]:
    return {**{k: v for k, v in found.items() if k not in gone}, **new}


def _scaled(value: IntervalValue, by: float, unit: str) -> IntervalValue:
    return IntervalValue(
        value=value.value * by, low=value.low * by, high=value.high * by, unit=unit
    )


def _shifted(value: IntervalValue, by: float) -> IntervalValue:
    return IntervalValue(
        value=value.value + by, low=value.low + by, high=value.high + by, unit=value.unit
    )


def _span(reading: AxisReading) -> float:
    return float(reading.signals.t_s[-1] - reading.signals.t_s[0])


def _unknown(
    reading: AxisReading, number: int, size: IntervalValue, others: list[str], sure: float
) -> Cause:
    """Return the entry of a family without a name: how much of the error it holds, over what."""
    number -= len(reading.inquiry.laws)
    choice, effect = reading.choices[number], reading.fitted.effects[number]
    left = reading.bench.difference - (reading.fitted.correction - effect)
    share = 1.0 - float(np.sum((left - effect) ** 2) / np.sum(left**2))
    words = choice.candidate.key.rstrip("0123456789 ")
    short = short_form(reading, number)
    values = _values(short.law, short.beside, short.form.units, reading) if short else {}
    return Cause(
        term=UNKNOWN,
        kind="missing",
        confidence=sure,
        statement=(
            f"{100 * max(share, 0.0):.0f} % of the residual of the other causes depends on "
            f"{words}; no law that is known here fits it. It reaches {significant(size.value)} "
            f"{size.unit}.{_short_words(short, values) if short else ''}"
        ),
        parameters={"size": size, **values},
        alternatives=tuple(others),
        variables=choice.candidate.variables,
    )


def _short_words(short: Short, values: Read) -> str:
    """Say a short form with its coefficient, and how much of the smooth curve it is."""
    first = values.get("amplitude") or values["coefficient"]
    said = f"{_signed(first)} · {short.words}"
    if "level" in values:
        level = values["level"]
        said += f" {'+' if level.value >= 0 else '−'} {significant(abs(level.value))} {level.unit}"
        said += short.carrier_words
    curve = "the smooth curve"
    does = f"{100 * short.share:.0f} % of {curve}"
    if short.share > AS_MUCH:
        does = f"as much as {curve}"
    return (
        f" On held-out stretches, {said} explains {does}, beside the simulation's terms fitted "
        "anew."
    )


def _signed(value: IntervalValue) -> str:
    return f"{significant(value.value)} {value.unit}".replace("-", "−")


def _mistuned(reading: AxisReading, *, beside: list[Cause]) -> list[Cause]:
    """Return the simulation's own terms whose coefficient the recording contradicts."""
    off = {name: _judged(reading, [name]) for name in changed_own(reading)}
    causes = {name: _retuned(reading, name, one) for name, one in off.items()}
    told = own_term_entries(off, causes, beside=beside, jointly=partial(_judged, reading))
    return [_of_terms(entry) for entry in told]


def _of_terms(entry: Cause) -> Cause:
    """Return an entry with the terms of the columns that it names."""
    terms = dict.fromkeys(map(term_of, entry.alternatives))
    return entry.model_copy(update={"term": term_of(entry.term), "alternatives": tuple(terms)})


def _judged(reading: AxisReading, names: Collection[str]) -> Mistuned:
    inquiry, own = reading.inquiry, list(reading.bench.own)
    numbers, terms = [own.index(name) for name in names], [term_of(name) for name in names]
    return of_mistuned(inquiry.search, inquiry.found, numbers, but=terms)


def _retuned(reading: AxisReading, name: str, off: Mistuned) -> Cause:
    """Return the entry of an own term that is off."""
    change, sd = reading.fitted.of_own(name)
    term, signals = term_of(name), reading.signals
    had, main = signals.own_size(name), term_called(term).parameters[0]
    read = term in READ_OFF
    said = read and signals.read_share >= READ_WELL
    what, unit = (main.name, main.unit) if said else ("factor", "1")
    by = abs(had) if read and not said else 1.0
    now = value_of((had + change) / by, sd / by, _unit(unit, reading))
    return Cause(
        term=term,
        kind="mistuned",
        confidence=off.standing.confidence,
        statement=retuned_words(name, now, of=(what, had) if said or not read else None),
        parameters={"size": change_size(reading, name), what: now},
        alternatives=off.standing.near,
        variables=(signals.channel("position"),) if signals.rotary and name == "gravity" else (),
    )


def _unit(unit: str, reading: AxisReading) -> str:
    """Return the unit of a term's parameter for the axis' ways and the channel's effort."""
    return unit.replace("mm", reading.signals.unit).replace("U", reading.unit)
