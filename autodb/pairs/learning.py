"""Semi-inverse: sensed forces change the belief about a pair, by iterated Gauss-Newton.

Maximum of the posterior of law and shared errors, readings linearised anew at every step:

    y = F(θ) (1 + C δ) + L(θ) λ + ε,  ε ~ N(0, sd² + Σ (share · part of F)²),  θ, δ, λ ~ prior

δ errors of calibrations, λ the shares by which the law is off in an operation, L the parts of F.

A step that does not raise the posterior is halved. The share that cuts scatter by is learnt along
with it, one step of expectation and maximisation a batch, so that a batch and the same cuts one
after the other agree but for what is linearised (a test says how closely). A cut costs the same
however many came before. Source: physics reference, section 7; Bell and Cathey 1993 for the
iterated filter as Gauss-Newton.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.fitting import Gaussian, update
from autodb.pairs.belief import CUT_SHARE, OWN, Belief, Scatter, law_error
from autodb.pairs.observed import Observed

Array = NDArray[np.float64]

SCATTERED = 3
"""Times that scatter and state are fitted in turn."""
ROUNDS = 20
HALVINGS = 8
TINY = 1e-12
"""Square of a part, N², below which there is none."""
CLOSE = 1e-3
"""Change of the state in its own standard deviations at which it has settled."""


def learn(belief: Belief, observed: Observed) -> Belief:
    """Return the belief after readings."""
    laws = tuple(law_error(operation) for operation in observed.operations)
    prior = belief.also((*observed.shared, *laws))
    model = _Model(prior, observed)
    scatter, state = prior.scatter, prior.state
    for _ in range(SCATTERED):
        state = _settled(prior.state, state, model, scatter)
        scatter = _scatter(prior.scatter, state, model, scatter)
    return replace(
        prior, state=state, scatter=scatter, cuts=prior.cuts + len(np.unique(observed.cut))
    )


class _Model:
    """Readings as functions of a belief's state."""

    def __init__(self, belief: Belief, observed: Observed) -> None:
        self.observed = observed
        self._gains = np.zeros((len(observed.value), len(belief.state.mean) - OWN))
        begin = 0
        for one in observed.shared:
            width = len(one.covariance)
            self._gains[:, _behind(belief, one.key)] = observed.common[:, begin : begin + width]
            begin += width
        self._laws = [
            (_behind(belief, law_error(name).key), observed.within(name)[:, None])
            for name in observed.operations
        ]

    def expected(self, state: Array) -> Array:
        """Return the readings expected (m,)."""
        theta = state[:OWN]
        force = self.observed.expected(theta)
        return np.asarray(force + self._shared(theta, force) @ state[OWN:])

    def design(self, state: Array) -> Array:
        """Return derivatives (m, p) of the readings by the state."""
        theta = state[:OWN]
        felt = 1.0 + self._gains @ state[OWN:]
        shared = self._shared(theta, self.observed.expected(theta))
        return np.column_stack([self.observed.slopes(theta) * felt[:, None], shared])

    def _shared(self, theta: Array, force: Array) -> Array:
        """Return derivatives (m, k) of the readings (m,) by what they share."""
        columns = self._gains * force[:, None]
        parts = self.observed.parts(theta)
        for place, inside in self._laws:
            columns[:, place] = np.where(inside, parts, 0.0)
        return columns

    def variances(self, state: Array, scatter: Scatter) -> Array:
        """Return the variance (m, 2) of readings by what cuts scatter along and across."""
        parts = self.observed.parts(state[:OWN])
        return np.asarray((parts * scatter.share) ** 2)

    def noise(self, state: Array, scatter: Scatter) -> Array:
        """Return the sd (m,): the sensor's, the law's from chip to chip, the repeated cut's."""
        law = (CUT_SHARE * self.observed.parts(state[:OWN])) ** 2
        both = law + self.variances(state, scatter)
        return np.asarray(np.sqrt(self.observed.sd**2 + both.sum(axis=1)))


def _behind(belief: Belief, key: str) -> slice:
    """Return where errors stand behind the law's coordinates."""
    columns = belief.columns(key)
    return slice(columns.start - OWN, columns.stop - OWN)


def _settled(prior: Gaussian, start: Gaussian, model: _Model, scatter: Scatter) -> Gaussian:
    """Return the normal belief at the maximum of the posterior."""
    mean, value = start.mean, model.observed.value
    noise = model.noise(mean, scatter)
    size = np.sqrt(np.diag(prior.covariance))
    active = size > 0
    inverse = np.linalg.inv(prior.covariance[np.ix_(active, active)])

    def misfit(state: Array) -> float:
        off = (state - prior.mean)[active]
        left = (value - model.expected(state)) / noise
        return float(left @ left + off @ inverse @ off)

    best = misfit(mean)
    for _ in range(ROUNDS):
        design = model.design(mean)
        linear = value - model.expected(mean) + design @ mean
        posterior = update(prior, design, linear, noise)
        step, scale = posterior.mean - mean, 1.0
        for _ in range(HALVINGS):
            there = misfit(mean + scale * step)
            if np.isfinite(there) and there <= best + 1e-9 * abs(best):
                break
            scale *= 0.5
        else:
            return Gaussian(mean, posterior.covariance)
        mean, best = mean + scale * step, there
        spread = np.sqrt(np.diag(posterior.covariance))
        if np.max(np.abs(scale * step[active]) / spread[active]) < CLOSE:
            break
    return Gaussian(mean, posterior.covariance)


def _scatter(prior: Scatter, state: Gaussian, model: _Model, now: Scatter) -> Scatter:
    """Return what cuts scatter by: the prior's weight and one expectation over the readings.

    Of a reading's error the share that a part's scatter has in its variance is that part's.
    """
    design = model.design(state.mean)
    known = np.einsum("ij,jk,ik->i", design, state.covariance, design)
    square = (model.observed.value - model.expected(state.mean)) ** 2 + known
    variances, parts = model.variances(state.mean, now), model.observed.parts(state.mean[:OWN])
    whole = model.noise(state.mean, now)[:, None] ** 2
    share = variances / whole
    felt = share**2 * square[:, None] + variances * (1.0 - share)
    counts = parts**2 / np.maximum((parts**2).sum(axis=1, keepdims=True), TINY)
    each = np.where(counts > 0.0, felt / np.maximum(parts**2, TINY), 0.0)
    weight = prior.weight + counts.sum(axis=0)
    total = prior.weight * prior.share**2 + (counts * each).sum(axis=0)
    return Scatter(np.sqrt(total / weight), weight)
