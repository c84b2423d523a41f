"""What moved over a run of standard cuts, in sentences."""

from collections.abc import Iterator

from autodb.explain.answer.answer import Cause, IntervalValue
from autodb.explain.cuts.candidates.currents import FRICTION, GAIN, OFFSET, WEAR
from autodb.sensing.ranges.repeated_cut import CurrentChange

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


def effect(term: str, change: IntervalValue, *, air_too: bool, air: bool, or_force: bool) -> str:
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
        f"Held-out cuts are predicted to within {with_it:.2g} {unit} with it, {without:.2g} "
        f"{unit} without it."
    )


def force(end: CurrentChange, force_unit: str, beside: CurrentChange, unit: str) -> str:
    """Return that the measured force moved, and the current no further than that."""
    return (
        f"What moved is {NAMES[FORCE]}, not the sensing: it was measured and moved by "
        f"{end.change:+.3g} {force_unit} ({end.low:+.3g} to {end.high:+.3g}) {LAST}. Beside what "
        f"that force gives the rise moved by {beside.change:+.2g} {unit} ({beside.low:+.2g} to "
        f"{beside.high:+.2g}): no more than repeats scatter."
    )
