"""Semi-inverse: sensed forces change the belief about a pair, by iterated Gauss-Newton.

Maximum of the posterior of law and shared errors, readings linearised anew at every step:

    y = F(θ) (1 + C δ) + L(θ) λ + ε,  ε ~ N(0, sd² + Σ (share · part of F)²),  θ, δ, λ ~ prior

δ errors of calibrations, λ the shares and the direction by which the law is off in an operation, L
the parts of F and F turned.
What is assumed of cuts (an entering angle nobody stated) is one more such error: its column is what
one standard deviation of it changes.

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
from autodb.pairs.belief import CUT_SHARE, FAR, OWN, Belief, OffLaw, Scatter
from autodb.pairs.observed import Observed

Array = NDArray[np.float64]

FORCE = 2
"""Parts of a reading that are force; the third is a chip's thickness."""
SCATTERED = 3
"""Times that scatter and state are fitted in turn."""
ROUNDS = 20
CLOSE_BY = 1
"""Steps from a belief that is close. Chosen: where much is assumed of a tool, far from each other
two maxima may say nearly the same, and what is learnt beside stays at the one where it was."""
HALVINGS = 8
TINY = 1e-12
"""Square of a part, N², below which there is none."""
SURER = 20.0
"""Odds from which on a law is taken to be far off. Chosen: what is usual for strong evidence."""
CLOSE = 1e-3
"""Change of the state in its own standard deviations at which it has settled."""


def learn(belief: Belief, observed: Observed, *, near: Belief | None = None) -> Belief:
    """Return the belief after readings.

    ``near``: one that is close to it, from which the maximum is looked for; it tells nothing else.
    """
    prior, model = _met(belief, observed)
    scatter, state = prior.scatter, prior.state
    if near is not None:
        scatter, state = near.scatter, Gaussian(_begun(prior, near), prior.state.covariance)
    rounds = ROUNDS if near is None else CLOSE_BY
    for _ in range(SCATTERED):
        state = _settled(prior.state, state, model, scatter, rounds)
        scatter = _scatter(prior.scatter, state, model, scatter)
    return replace(
        prior, state=state, scatter=scatter, cuts=prior.cuts + len(np.unique(observed.cut))
    )


def _begun(prior: Belief, near: Belief) -> Array:
    """Return the state of a prior, with the numbers that a belief near has of it."""
    mean = prior.state.mean.copy()
    mean[:OWN] = near.state.mean[:OWN]
    known = {one.key for one in near.shared}
    for one in prior.shared:
        if one.key in known:
            mean[prior.columns(one.key)] = near.state.mean[near.columns(one.key)]
    return mean


def learn_choosing(belief: Belief, observed: Observed, *, near: Belief | None = None) -> Belief:
    """Return the belief after a pair's first readings: of a law near, or FAR off if they say so.

    They say so where the evidence for it is more than SURER times as large. ``near`` as in learn.
    """
    far = replace(belief, off_law=FAR)
    held, let_go = learn(belief, observed, near=near), learn(far, observed, near=near)
    odds = evidence(far, let_go, observed) - evidence(belief, held, observed)
    return let_go if odds > np.log(SURER) else held


def evidence(before: Belief, after: Belief, observed: Observed) -> float:
    """Return the logarithm of the probability of readings, but for a constant.

    After Laplace: at the posterior's maximum, times the share of the prior that it leaves.
    """
    prior, model = _met(before, observed)
    active = np.diag(prior.state.covariance) > 0
    rows = np.ix_(active, active)
    wide, narrow = (one.state.covariance[rows] for one in (prior, after))
    noise = model.noise(after.state.mean, after.scatter)
    left = (observed.value - model.expected(after.state.mean)) / noise
    off = (after.state.mean - prior.state.mean)[active]
    misfit = left @ left + off @ np.linalg.solve(wide, off)
    volume = np.linalg.slogdet(wide)[1] - np.linalg.slogdet(narrow)[1]
    return float(-0.5 * (misfit + 2.0 * np.sum(np.log(noise)) + volume))


def expected_of(belief: Belief, observed: Observed) -> tuple[Array, Array]:
    """Return what a belief expects of readings before they are learnt: (m,), covariance (m, m)."""
    known, model = _met(belief, observed)
    design = model.design(known.state.mean)
    own = model.noise(known.state.mean, known.scatter)
    covariance = design @ known.state.covariance @ design.T + np.diag(own**2)
    return model.expected(known.state.mean), covariance


def _met(belief: Belief, observed: Observed) -> "tuple[Belief, _Model]":
    """Return a belief that has met what readings share, and the readings as its functions."""
    laws = tuple(belief.law_error(operation) for operation in observed.operations)
    known = belief.also((*observed.shared, *laws, *observed.assumed))
    return known, _Model(known, observed)


class _Model:
    """Readings as functions of a belief's state."""

    def __init__(self, belief: Belief, observed: Observed) -> None:
        self.observed = observed
        self._off_law = belief.off_law
        self._gains = np.zeros((len(observed.value), len(belief.state.mean) - OWN))
        self._shifts = np.zeros_like(self._gains)
        begin = 0
        for one in observed.shared:
            columns = slice(begin, begin + len(one.covariance))
            place = _behind(belief, one.key)
            self._gains[:, place] = observed.common[:, columns]
            if observed.shift is not None:
                self._shifts[:, place] = observed.shift[:, columns]
            begin = columns.stop
        self._assumed = [
            (_behind(belief, one.key).start, observed.as_if(one.key)) for one in observed.assumed
        ]
        self._laws = [
            (_behind(belief, belief.law_error(name).key), observed.within(name)[:, None])
            for name in observed.operations
        ]

    def expected(self, state: Array) -> Array:
        """Return the readings expected (m,)."""
        parts = self.observed.parts(state[:OWN])
        return np.asarray(parts.sum(axis=1) + self._shared(parts, state[:OWN]) @ state[OWN:])

    def design(self, state: Array) -> Array:
        """Return derivatives (m, p) of the readings by the state."""
        theta = state[:OWN]
        errors = state[OWN:]
        felt = 1.0 + self._gains @ errors
        as_assumed = self.observed.slopes(theta)
        slopes = as_assumed * felt[:, None]
        for place, other in self._assumed:
            if errors[place]:
                slopes += errors[place] * (other.slopes(theta) - as_assumed)
        return np.column_stack([slopes, self._shared(self.observed.parts(theta), theta)])

    def _shared(self, parts: Array, theta: Array) -> Array:
        """Return derivatives (m, k) of the readings, in parts (m, 3), by what they share."""
        whole = parts.sum(axis=1)
        columns = np.asarray(self._gains * whole[:, None] + self._shifts)
        off = self.observed.off(theta)
        for place, inside in self._laws:
            columns[:, place] = np.where(inside, off, 0.0)
        for place, other in self._assumed:
            columns[:, place] = other.parts(theta).sum(axis=1) - whole
        return columns

    def variances(self, state: Array, share: Array | float) -> Array:
        """Return the variance (m, 2) of readings whose parts are off by shares."""
        return np.asarray((self.observed.parts(state[:OWN])[:, :FORCE] * share) ** 2)

    def noise(self, state: Array, scatter: Scatter) -> Array:
        """Return the sd (m,): the sensor's, the law's from chip to chip, the repeated cut's."""
        own = own_variance(scatter, self._off_law, self.observed.off(state[:OWN]))
        return np.asarray(np.sqrt(self.observed.sd**2 + own))


def own_variance(scatter: Scatter, law: OffLaw, off: Array) -> Array:
    """Return the variance (...,) that is one cut's own, of what errors of the law change (..., 6).

    What repeats scatter by, and what the law is off from one chip to another.
    """
    share = np.array([*(scatter.share**2 + CUT_SHARE**2), law.cut_direction_rad**2])
    return np.asarray(off[..., : len(share)] ** 2 @ share)


def _behind(belief: Belief, key: str) -> slice:
    """Return where errors stand behind the law's coordinates."""
    columns = belief.columns(key)
    return slice(columns.start - OWN, columns.stop - OWN)


def _settled(
    prior: Gaussian, start: Gaussian, model: _Model, scatter: Scatter, rounds: int
) -> Gaussian:
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
    for _ in range(rounds):
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
    variances, parts = model.variances(state.mean, now.share), model.variances(state.mean, 1.0)
    whole = model.noise(state.mean, now)[:, None] ** 2
    share = variances / whole
    felt = share**2 * square[:, None] + variances * (1.0 - share)
    counts = parts / np.maximum(parts.sum(axis=1, keepdims=True), TINY)
    each = np.where(counts > 0.0, felt / np.maximum(parts, TINY), 0.0)
    weight = prior.weight + counts.sum(axis=0)
    total = prior.weight * prior.share**2 + (counts * each).sum(axis=0)
    return Scatter(np.sqrt(total / weight), weight)
