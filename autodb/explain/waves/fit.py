"""Own terms and effects of a milled waveform, fitted together to white rows."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from autodb.explain.engine.candidates import Choice
from autodb.explain.engine.normal import HELD, normal
from autodb.explain.waves.bench import WhitenedNoise, WhiteWaves
from autodb.fitting import orthonormal_basis

Array = NDArray[np.float64]

MEMORY = 4000
"""Rows after which a noise of ORDER taps has forgotten a knock."""


@dataclass(frozen=True)
class WavesFit:
    """Coefficients (p,), own terms' first, with their covariance (p, p), of ``columns`` (C, n, p).

    ``places``: each effect's among the coefficients; ``own``: how many are own terms'. Coefficients
    beyond the last effect's are ways of own terms.
    """

    columns: Array
    coefficients: Array
    covariance: Array
    places: tuple[slice, ...]
    own: int

    def part(self, number: int) -> Array:
        """Return what an effect adds (C, n)."""
        at = self.places[number]
        return np.asarray(self.columns[..., at] @ self.coefficients[at])

    @property
    def correction(self) -> Array:
        """What is added to the simulation (C, n)."""
        return np.asarray(self.columns @ self.coefficients)


def fit_waves(
    bench: WhiteWaves,
    choices: Sequence[Choice],
    quiet: WhitenedNoise,
    *,
    beside: Sequence[Choice] = (),
) -> WavesFit:
    """Fit own terms and effects; directions that the rows do not hold get nothing.

    ``beside``: own terms' ways, retuned too. Coefficients of these and of curves are drawn to none.
    """
    columns = bench.chosen([*choices, *beside])
    found = normal(quiet(columns), quiet(bench.difference[:, :, None])[:, 0])
    weight = _drawn(bench, [*choices, *beside], quiet)
    widths = [bench.columns(c.key, c.shape).shape[-1] for c in choices]
    ends = np.cumsum([len(bench.own), *widths])
    return WavesFit(
        columns=columns,
        coefficients=found.solved(weight),
        covariance=found.inverse(weight),
        places=tuple(slice(int(a), int(b)) for a, b in pairwise(ends)),
        own=len(bench.own),
    )


def _drawn(bench: WhiteWaves, choices: Sequence[Choice], quiet: WhitenedNoise) -> Array:
    """Return what a squared coefficient costs, (p,) of own and chosen columns.

    Own columns and plain laws cost nothing; of others the size is that of the greatest evidence.
    """
    products = bench.inner({c.key: bench.columns(c.key, c.shape) for c in choices}, quiet)
    weights = [np.zeros(len(bench.own))]
    for choice in choices:
        norm = products.norm[products.places[choice.key]]
        if choice.shape.names or len(norm) == 1:
            weights.append(np.zeros(len(norm)))
            continue
        given = products.given([c.key for c in choices if c is not choice])
        weights.append(norm**2 / given.gain(choice.key).size)
    return np.concatenate(weights)


def component_noise_sd(quiet: WhitenedNoise) -> Array:
    """Return the standard deviation of each component's noise (C,), colour and all."""
    knock = np.zeros(MEMORY)
    knock[0] = 1.0
    sizes = []
    for whitener, sd in zip(quiet.whiteners, quiet.sd, strict=True):
        taps = np.concatenate([[1.0], -whitener.coefficients])
        sizes.append(sd * float(np.sqrt(np.sum(lfilter([1.0], taps, knock) ** 2))))
    return np.array(sizes)


class BesideWaves:
    """White rows after own terms and other effects are projected out of them.

    ``minus`` (C, n): what is taken off the difference first.
    """

    def __init__(
        self,
        bench: WhiteWaves,
        others: Sequence[Choice],
        quiet: WhitenedNoise,
        *,
        minus: Array | None = None,
    ) -> None:
        self.quiet = quiet
        white = quiet(bench.chosen(others))
        self._basis = orthonormal_basis(white, least=HELD)
        difference = bench.difference if minus is None else bench.difference - minus
        self._left = self._clear(difference[:, :, None])[:, 0]

    def _clear(self, columns: Array) -> Array:
        white = self.quiet(columns)
        return np.asarray(white - self._basis @ (self._basis.T @ white))

    def fitted(self, columns: Array) -> tuple[Array, Array]:
        """Return coefficients (p,) of columns (C, n, p) and their covariance (p, p)."""
        found = normal(self._clear(columns), self._left)
        return found.solved(), found.inverse()

    def gain(self, columns: Array) -> float:
        """Return by how much the sum of squares falls by columns (C, n, p)."""
        found = normal(self._clear(columns), self._left)
        return float(found.right @ found.solved())
