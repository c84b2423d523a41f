"""The simulation's own terms that a milled waveform contradicts."""

from collections.abc import Collection, Mapping
from functools import partial

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer.answer import Cause
from autodb.explain.engine.confidence import Mistuned, Standing, of_mistuned
from autodb.explain.engine.entries import own_term_entries
from autodb.explain.waves.candidates import OWN_WAYS
from autodb.explain.waves.fit import WavesFit
from autodb.explain.waves.look import FoundInWaves
from autodb.explain.waves.parameters import interval_value

Array = NDArray[np.float64]

LEAST = 0.01
"""Change of a term, as a share of itself, below which it is not called mistuned."""
TERMS = ("shear", "edge_force")


def mistuned_of_waves(looked: FoundInWaves) -> dict[str, Mistuned]:
    """Return how sure it is of each own term that it is off, in all components together."""
    return {term: _judged(looked, [term]) for term in TERMS if term in looked.bench.own}


def retuned_of_waves(
    looked: FoundInWaves,
    own: Mapping[str, Mistuned],
    fitted: WavesFit,
    component: int,
    *,
    beside: Collection[Cause],
) -> list[Cause]:
    """Return the own terms that are off in one component, as ``mistuned_of_waves``.

    ``beside``: what else is told of the component.
    """
    causes = {
        term: _cause(term, fitted, _places(looked, fitted, term), component, off.standing)
        for term, off in own.items()
    }
    changed = {term: cause for term, cause in causes.items() if cause is not None}
    return own_term_entries(own, changed, beside=beside, jointly=partial(_judged, looked))


def _judged(looked: FoundInWaves, terms: Collection[str]) -> Mistuned:
    """Return how sure it is that own terms are off, in one way or another."""
    own = [number for number, term in enumerate(looked.bench.own) if term in terms]
    places = None
    for choice in looked.found.choices:
        if choice.candidate.key == OWN_WAYS:
            at = looked.search.products.places[choice.key]
            names = [name for name, count in choice.shape.shape.items() for _ in range(int(count))]
            places = at[[name in terms for name in names]]
    return of_mistuned(looked.search, looked.found, own, ways=places)


def change_of_own(
    looked: FoundInWaves, fitted: WavesFit, terms: Collection[str], component: int
) -> Array:
    """Return what the re-tuning of own terms adds to one component, (n,)."""
    places = [at for term in dict.fromkeys(terms) for at in _places(looked, fitted, term)]
    return np.asarray(fitted.columns[component][:, places] @ fitted.coefficients[places])


def _places(looked: FoundInWaves, fitted: WavesFit, term: str) -> list[int]:
    """Return where the factor of an own term is among the coefficients, then those of its ways."""
    places = [k for k, name in enumerate(looked.bench.own) if name == term]
    for choice, at in zip(looked.found.choices, fitted.places, strict=True):
        if choice.candidate.key == OWN_WAYS and places:
            start = at.start
            for name, count in choice.shape.shape.items():
                places += range(start, start + int(count)) if name == term else []
                start += int(count)
    return places


def _cause(
    term: str, fitted: WavesFit, places: list[int], component: int, sure: Standing
) -> Cause | None:
    """Return the entry of an own term in one component; None where it hardly changes there."""
    columns = fitted.columns[component][:, places]
    change, spread = fitted.coefficients[places], fitted.covariance[np.ix_(places, places)]
    base, part = columns[:, 0], columns @ change
    share = base @ columns / max(float(base @ base), 1e-300)
    factor = interval_value(
        1.0 + float(share @ change), float(np.sqrt(share @ spread @ share)), "1"
    )
    off = abs(factor.value - 1.0)
    if off < max(LEAST, factor.high - factor.value):
        return None
    peak = int(np.argmax(np.abs(part)))
    sd = float(np.sqrt(max(float(columns[peak] @ spread @ columns[peak]), 0.0)))
    size = interval_value(abs(float(part[peak])), sd, "N")
    words = term.replace("_", " ")
    return Cause(
        term=term,
        kind="mistuned",
        confidence=sure.confidence,
        statement=(
            f"The recording has {factor.value:.3g} times the {words} of the simulation "
            f"({factor.low:.3g} to {factor.high:.3g})."
        ),
        parameters={"size": size, "factor": factor},
        alternatives=sure.near,
    )
