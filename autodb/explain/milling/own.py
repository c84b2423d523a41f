"""The simulation's own terms that a milled waveform contradicts."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import Cause
from autodb.explain.milling.fit import Fit
from autodb.explain.milling.look import Looked
from autodb.explain.milling.parameters import value
from autodb.explain.milling.suspects import OWN_WAYS

Array = NDArray[np.float64]

WORTH = 12.0
"""Evidence above which a re-tuning is told, beyond ln n for each column. Chosen."""
LEAST = 0.01
"""Change of a term, as a share of itself, below which it is not called mistuned."""
SUREST = 0.99
TERMS = ("shear", "edge_force")


def retuned(looked: Looked, fitted: Fit, component: int) -> list[Cause]:
    """Return the own terms that are off in one component, judged in all of them together."""
    found = []
    for term in TERMS:
        places = _places(looked, fitted, term)
        if places and _worth(fitted, places) > WORTH:
            found += _cause(term, fitted, places, component)
    return found


def _places(looked: Looked, fitted: Fit, term: str) -> list[int]:
    """Return where the factor of an own term is among the coefficients, then those of its ways."""
    places = [k for k, name in enumerate(looked.bench.own) if name == term]
    for choice, at in zip(looked.found.choices, fitted.places, strict=True):
        if choice.suspect.key == OWN_WAYS and places:
            start = at.start
            for name, count in choice.shape.shape.items():
                places += range(start, start + int(count)) if name == term else []
                start += int(count)
    return places


def _worth(fitted: Fit, places: list[int]) -> float:
    """Return the evidence that coefficients are needed beside all others."""
    change, spread = fitted.coefficients[places], fitted.covariance[np.ix_(places, places)]
    held = np.linalg.pinv(spread, rcond=1e-9, hermitian=True)
    rows = fitted.columns.shape[0] * fitted.columns.shape[1]
    return float(change @ held @ change - len(places) * np.log(rows))


def _cause(term: str, fitted: Fit, places: list[int], component: int) -> list[Cause]:
    """Return the entry of an own term in one component; none where it hardly changes there."""
    columns = fitted.columns[component][:, places]
    change, spread = fitted.coefficients[places], fitted.covariance[np.ix_(places, places)]
    base, part = columns[:, 0], columns @ change
    share = base @ columns / max(float(base @ base), 1e-300)
    factor = value(1.0 + float(share @ change), float(np.sqrt(share @ spread @ share)), "1")
    off = abs(factor.value - 1.0)
    if off < max(LEAST, factor.high - factor.value):
        return []
    peak = int(np.argmax(np.abs(part)))
    sd = float(np.sqrt(max(float(columns[peak] @ spread @ columns[peak]), 0.0)))
    size = value(abs(float(part[peak])), sd, "N")
    words = term.replace("_", " ")
    return [
        Cause(
            term=term,
            kind="mistuned",
            confidence=SUREST,
            statement=(
                f"The recording has {factor.value:.3g} times the {words} of the simulation "
                f"({factor.low:.3g} to {factor.high:.3g})."
            ),
            parameters={"size": size, "factor": factor},
        )
    ]
