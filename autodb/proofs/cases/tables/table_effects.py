"""Effects of known size in a published table: what each changes in the forces of its cuts."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from autodb.proofs.cases.tables.published_tables import Array
from autodb.proofs.cases.tables.table_columns import band_places, speed_bell
from autodb.proofs.cases.tables.table_models import TABLE_TERMS, PublishedModel

Rng = np.random.Generator
MOST_WORN = 2.0
"""Growth of the force at the end of an edge's life, of its mean: milling cutters grew 3 to 8 times,
turning inserts to about 3 times."""
MOST_HARDER, MOST_BAND, MOST_THIN, MOST_SOFTER = 0.6, 0.6, 1.5, 0.4
MOST_DEPTH, MOST_BENT = 0.3, 0.3
"""Of the smallest depth."""
MOST_GAIN, MOST_DRIFT = 0.5, 0.6
SHARES = (0.5, 1.5)
"""Of an effect that each component takes in its own measure, over its mean force."""


@dataclass(frozen=True)
class TableEffect:
    """A shape (C, n) in N whose factor is at most ``most``; zero in components it leaves alone."""

    shape: Array
    most: float

    @property
    def touched(self) -> tuple[int, ...]:
        """Return the places of the components that change."""
        return tuple(int(i) for i in np.flatnonzero(np.any(self.shape != 0.0, axis=1)))


def effect_in(term: str, model: PublishedModel, rng: Rng) -> TableEffect:
    """Draw an effect on a table whose full model is known."""
    return MAKERS[term](model, rng)


def effects_into(name: str) -> tuple[str, ...]:
    """Return the effects that a table's model lacks, and that can act there."""
    own = TABLE_TERMS[name]
    return tuple(term for term in MAKERS if term not in own)


def _shares(model: PublishedModel, rng: Rng) -> Array:
    return rng.uniform(*SHARES, size=(len(model.channels), 1))


def _level(model: PublishedModel) -> Array:
    """Return the mean force of each component over its depth, (C, 1), N/mm."""
    return np.asarray(np.mean(model.components / model.table.depth, axis=1, keepdims=True))


def _wear(model: PublishedModel, rng: Rng) -> TableEffect:
    grown = model.table.depth * model.table.worn ** rng.uniform(0.7, 1.5)
    return TableEffect(_shares(model, rng) * _level(model) * grown, MOST_WORN)


def _run(n: int, rng: Rng) -> Array:
    """Return ones over a run of a fifth to a third of the cuts, (n,)."""
    length = round(n * rng.uniform(0.2, 0.33))
    first = int(rng.integers(1, n - length))
    inside = np.zeros(n)
    inside[first : first + length] = 1.0
    return inside


def _hard_spot(model: PublishedModel, rng: Rng) -> TableEffect:
    return TableEffect(model.components * _run(len(model.table), rng), MOST_HARDER)


def _built_up_edge(model: PublishedModel, rng: Rng) -> TableEffect:
    places = band_places(model.table)
    at, width = places[int(rng.integers(len(places)))]
    shape = -_shares(model, rng) * model.part("shear") * speed_bell(model.table, at, width)
    return TableEffect(shape, MOST_BAND)


def _size_effect(model: PublishedModel, rng: Rng) -> TableEffect:
    thin = model.table.feed / np.median(model.table.feed) / rng.uniform(0.3, 1.0)
    return TableEffect(_shares(model, rng) * model.part("shear") * np.exp(-thin), MOST_THIN)


def _speed_softening(model: PublishedModel, rng: Rng) -> TableEffect:
    shape = -_shares(model, rng) * model.part("shear") * model.table.log_speed
    return TableEffect(shape, MOST_SOFTER)


def _depth_error(model: PublishedModel, rng: Rng) -> TableEffect:
    sign = float(rng.choice((-1.0, 1.0)))
    return TableEffect(sign * float(model.table.depth.min()) * model.slope(), MOST_DEPTH)


def _deflection(model: PublishedModel, rng: Rng) -> TableEffect:
    """Return less depth, the more the larger one component is."""
    pushing = model.components[int(rng.integers(len(model.channels)))]
    bent = float(model.table.depth.min()) * pushing / np.max(np.abs(pushing))
    return TableEffect(-bent * model.slope(), MOST_BENT)


def _one_component(model: PublishedModel, rng: Rng, course: Array, most: float) -> TableEffect:
    shape = np.zeros_like(model.components)
    one = int(rng.integers(len(model.channels)))
    shape[one] = float(rng.choice((-1.0, 1.0))) * course[one]
    return TableEffect(shape, most)


def _gain(model: PublishedModel, rng: Rng) -> TableEffect:
    """Return a gain that steps in the middle half, or drifts."""
    n = len(model.table)
    step = np.arange(n) >= int(rng.integers(n // 4, 3 * n // 4))
    course = step if rng.random() < 0.5 else np.arange(n) / n
    return _one_component(model, rng, model.components * course, MOST_GAIN)


def _sensor_drift(model: PublishedModel, rng: Rng) -> TableEffect:
    level = np.mean(model.components, axis=1, keepdims=True)
    return _one_component(model, rng, level * model.table.t / model.table.t[-1], MOST_DRIFT)


MAKERS: dict[str, Callable[[PublishedModel, Rng], TableEffect]] = {
    "tool_wear": _wear,
    "hard_spot": _hard_spot,
    "built_up_edge": _built_up_edge,
    "size_effect": _size_effect,
    "speed_softening": _speed_softening,
    "depth_error": _depth_error,
    "deflection": _deflection,
    "gain": _gain,
    "sensor_drift": _sensor_drift,
}
