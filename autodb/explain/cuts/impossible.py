"""Effects that a table of cuts cannot hold, whatever their evidence, or hardly.

No effect is larger than the forces that were measured. Harder material is harder in most
components, by cuts left out: what scales one of several alone is its sensor, and is looked for as
that. And hardly do the sensors of all components drift as the settings go.
"""

from collections.abc import Collection

import numpy as np

from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.fit import fit_cuts, held_out_rows
from autodb.explain.cuts.stack import Stack, designed
from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.search import FoundSet
from autodb.terms.chip import HARD_SPOT
from autodb.terms.sensor import SENSOR_DRIFT


def impossible(
    stack: Stack, own: dict[str, LawColumns], found: FoundSet, founded: Collection[str]
) -> list[Choice]:
    """Return the shapes of effects of a set that the table cannot hold.

    ``founded``: keys of laws that cuts left out need, which may be of any size.
    """
    return [*_too_large(stack, own, found, founded), *_harder_in_few(stack, own, found)]


def _too_large(
    stack: Stack, own: dict[str, LawColumns], found: FoundSet, founded: Collection[str]
) -> list[Choice]:
    """Return those beside the laws that add more to a component than was measured of it."""
    most = np.abs(stack.recording).max(axis=1)
    parts = fit_cuts(stack, own, found.choices).parts[len(own) :]
    return [
        choice
        for choice, part in zip(found.choices, parts, strict=True)
        if choice.candidate.key not in founded and np.any(np.abs(part).max(axis=1) > most)
    ]


def _harder_in_few(stack: Stack, own: dict[str, LawColumns], found: FoundSet) -> list[Choice]:
    """Return every shape of harder material that helps to predict few components."""
    few = [
        choice.candidate
        for choice in found.choices
        if choice.candidate.term == HARD_SPOT.name and not _helps_most(stack, own, found, choice)
    ]
    return _all_shapes(few)


def _helps_most(stack: Stack, own: dict[str, LawColumns], found: FoundSet, choice: Choice) -> bool:
    """Whether most components of cuts left out of the fit are predicted better with an effect."""
    whole, without = (
        np.sum(held_out_rows(stack, own, choices) ** 2, axis=1)
        for choices in (found.choices, found.without(choice.candidate.key))
    )
    return bool(2 * np.count_nonzero(whole < without) > len(stack.names))


def drifting_in_all(stack: Stack, choices: Collection[Choice]) -> bool:
    """Whether each of several components has a sensor that drifts, in a table whose clock follows
    the settings of its cuts: each has a zero of its own, and what all show is rather of the cuts.
    """
    drifts = [one for one in choices if one.candidate.term == SENSOR_DRIFT.name]
    several = len(drifts) >= max(len(stack.names), 2)
    return several and designed(stack).holds(stack.known.t_s[:, None])


def _all_shapes(candidates: Collection[Candidate]) -> list[Choice]:
    return [Choice(one, number) for one in candidates for number in range(len(one.forms))]
