"""The rules of a fitted system in words and in the units of its inputs and output."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.anfis.premises import Premises
from autodb.fitting.anfis.standardised import Scaling
from autodb.fitting.anfis.system import Anfis
from autodb.wording import listed, localized, msgid, phrase

Array = NDArray[np.float64]

WORDS = {
    2: (msgid("low"), msgid("high")),
    3: ("low", msgid("medium"), "high"),
    4: (msgid("very low"), "low", "high", msgid("very high")),
    5: ("very low", "low", "medium", "high", "very high"),
}
"""Words for the sets of an input by their centres; of more sets the centre alone is said."""


@dataclass(frozen=True)
class Rules:
    """What is said of a system that was kept: ``consequents`` (R, d + 1) scaled, as a model's."""

    premises: Premises
    scaling: Scaling
    consequents: Array


def rule_sentences(
    model: Anfis | Rules, names: Sequence[str], units: Sequence[str]
) -> tuple[str, ...]:
    """Return a sentence for each rule; ``names`` and ``units`` (d + 1,): inputs, then the output.

    A unit may be empty. *About* is where in the training range the membership is highest.
    """
    coefficients = plain_consequents(model)
    said = []
    for asked, plane in zip(model.premises.rules, coefficients, strict=True):
        parts = [
            phrase("{input} is {what}", input=name, what=_set(model, j, int(m), unit))
            for j, (m, name, unit) in enumerate(zip(asked, names[:-1], units[:-1], strict=True))
        ]
        terms = "".join(
            f" {'−' if c < 0 else '+'} {localized(f'{abs(c):.4g}')}·{name}"
            for c, name in zip(plane[1:], names[:-1], strict=True)
        )
        first = f"{'−' if plane[0] < 0 else ''}{localized(f'{abs(plane[0]):.4g}')}"
        unit = f" {units[-1]}" if units[-1] else ""
        said.append(
            phrase(
                "If {conditions}, then {output} = {value}",
                conditions=listed(parts, phrase(" and ")),
                output=names[-1],
                value=f"{first}{terms}{unit}",
            )
        )
    return tuple(said)


def plain_consequents(model: Anfis | Rules) -> Array:
    """Return the consequents (R, d + 1) in their own units: constant, then slopes."""
    scale = model.scaling
    slopes = scale.output_size * model.consequents[:, 1:] / scale.half
    constant = scale.outputs(model.consequents[:, 0]) - slopes @ scale.middle
    return np.column_stack([constant, slopes])


def _set(model: Anfis | Rules, along: int, which: int, unit: str) -> str:
    """Return a set's word and centre."""
    centres = model.premises.sets[along][:, -1]
    highest = float(np.clip(centres[which], -1.0, 1.0))
    place = model.scaling.middle[along] + model.scaling.half[along] * highest
    value = localized(f"{place:.3g}") + (f" {unit}" if unit else "")
    about = phrase("about {value}", value=value)
    words = WORDS.get(len(centres))
    if words is None:
        return about
    word = phrase(words[int(np.argsort(np.argsort(centres, kind="stable"))[which])])
    return f"{word} ({about})"
