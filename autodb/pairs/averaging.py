"""Over laws that are near, far and farther off: each is learnt, and their posteriors are averaged.

Forces are not linear in the law's numbers, and quite other numbers may give nearly the same ones (a
low shear angle and a low shear stress): a posterior has several hills. Each law is learnt from
where the prior is and from where another law was found, and all hills count, by their posterior
odds (Hoeting, Madigan, Raftery, Volinsky 1999, Statistical Science 14:382). What is returned is
the normal posterior with the mean and covariance of the mixture; the lower hills are first carried
to the highest, to numbers there that expect the same readings.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb.errors import UnusableInput
from autodb.fitting.gaussian import Gaussian, root_of
from autodb.pairs.observed import Observed
from autodb.pairs.posterior import FAR, FARTHER, PairPosterior, Scatter, Shared, averaged_law
from autodb.pairs.updating import AtKnownMaximum, met, posterior_of_readings

Array = NDArray[np.float64]

STEPS = 200
"""Steps in which a hill is climbed. Chosen: 20 to 80 do where one is clear; on a ridge, or far from
one, they may be thousands, for a hill that does not count."""
MANY_STEPS = 10 * STEPS
"""Steps where no hill is found in STEPS. Chosen: at some milliseconds each, seconds."""
SCATTERS = 0.25, 4.0
"""Shares of the scatter expected from which hills are climbed, too: where cuts are few, a law that
follows them and one that calls them scatter may both be hills. Chosen."""
ALIKE = 1e-3
"""Standard deviations within which two hills are one. Chosen: they are known to 1e-9."""
CARRIED = 1e-9
"""How near, as a share of the way, numbers that are carried from hill to hill are known. Chosen."""
SHUT = 1e-13
"""Share of the greatest variance, of numbers in their standard deviations, that is rounding."""


def learn_averaging(posterior: PairPosterior, observed: Observed) -> PairPosterior:
    """Return the posterior after a pair's first readings, over laws near, FAR and FARTHER off.

    Beforehand each is as likely. Chosen: cuts of some published tables speak for one, of others for
    another. A climb that is far below a hill is left. Where none is found in STEPS, nor in
    MANY_STEPS, the near law is learnt in as many as it takes.

    Raises UnusableInput where learning does not come to rest.
    """
    laws = tuple(replace(posterior, off_law=one) for one in (posterior.off_law, FAR, FARTHER))
    for most in (STEPS, MANY_STEPS):
        hills = _hills(laws, observed, most)
        if hills:
            logs = np.array([hill.evidence for hill in hills])
            shares = np.exp(logs - logs.max())
            found = [hill.there for hill in hills]
            return _averaged(found, shares / shares.sum(), prior=laws[2], observed=observed)
    return posterior_of_readings(posterior, observed)


@dataclass(frozen=True)
class _Hill:
    """A hill that was climbed: the posterior there, and the logarithm of its evidence."""

    there: PairPosterior
    evidence: float


def _hills(laws: Sequence[PairPosterior], observed: Observed, most: int) -> list[_Hill]:
    """Return the hills that ``laws`` have within ``most`` steps.

    Each is climbed from its prior, with less and with more scatter than expected, and from where
    the next law was found: that may be another hill of its own.
    """
    found: list[list[_Hill]] = [[] for _ in laws]

    def climb(k: int, near: PairPosterior | None = None) -> None:
        best = max((hill.evidence for some in found for hill in some), default=-np.inf)
        there = _climbed(
            laws[k], observed, most,
            near=near, known=[hill.there for hill in found[k]], beaten=best,
        )  # fmt: skip
        if there is not None:
            found[k].append(_Hill(there, log_evidence(laws[k], there, observed)))

    for k in range(len(laws)):
        climb(k)
    for k, law in enumerate(laws):
        for times in SCATTERS:
            share = times * law.scatter.share
            climb(k, replace(law, scatter=Scatter(share, law.scatter.weight)))
    first = [some[0].there if some else None for some in found]
    for k in range(len(laws)):
        near = first[(k + 1) % len(laws)]
        if near is not None:
            climb(k, near)
    return [hill for some in found for hill in some]


def _climbed(
    law: PairPosterior,
    observed: Observed,
    most: int,
    *,
    near: PairPosterior | None,
    known: Sequence[PairPosterior],
    beaten: float,
) -> PairPosterior | None:
    """Return the hill that is climbed; None where none is, or one that is ``known``, or one far
    below the evidence by which it would be ``beaten``.
    """
    try:
        there = posterior_of_readings(
            law, observed, near=near, most=most, known=known[0] if known else None, beaten=beaten
        )
    except (UnusableInput, AtKnownMaximum):
        return None
    return None if any(_alike(there, other) for other in known) else there


def _alike(one: PairPosterior, other: PairPosterior) -> bool:
    sd = np.sqrt(np.diag(one.state.covariance))
    return bool(np.all(np.abs(one.state.mean - other.state.mean) <= ALIKE * sd))


def _averaged(
    hills: Sequence[PairPosterior], shares: Array, *, prior: PairPosterior, observed: Observed
) -> PairPosterior:
    """Return one posterior in place of several, which have ``shares`` of the probability."""

    def mean(values: Iterable[Array]) -> Array:
        return np.tensordot(shares, np.array(list(values)), 1)

    highest = hills[int(np.argmax(shares))]
    states = [
        one.state if one is highest else carried(one, highest, prior, observed) for one in hills
    ]
    middle = mean(state.mean for state in states)
    apart = [np.outer(state.mean - middle, state.mean - middle) for state in states]
    return replace(
        highest,
        state=Gaussian(middle, mean(s.covariance + a for s, a in zip(states, apart, strict=True))),
        shared=tuple(
            Shared(some[0].key, mean(one.covariance for one in some))
            for some in zip(*(one.shared for one in hills), strict=True)
        ),
        scatter=Scatter(
            np.sqrt(mean(one.scatter.share**2 for one in hills)),
            mean(one.scatter.weight for one in hills),
        ),
        off_law=averaged_law([one.off_law for one in hills], shares.tolist()),
    )


def carried(
    one: PairPosterior, other: PairPosterior, prior: PairPosterior, observed: Observed
) -> Gaussian:
    """Return the state of one posterior as numbers about the other's that expect the same readings.

    What readings do not tell stays as the other has it: the least change, by the prior. It is
    looked for step by step: forces that bend would be far off after one, at half of it too.
    """
    known, model = met(prior, observed)
    there, steep = model.steep(one.state.mean)
    noise = model.noise(model.seen(other.state.mean), other.scatter)[:, None]
    root, middle = root_of(known.state.covariance), other.state.mean

    def off(z: Array) -> Array:
        expected = model.seen(middle + root @ z).expected
        return np.concatenate([(expected - there.expected) / noise[:, 0], z])

    def slopes(z: Array) -> Array:
        columns = model.steep(middle + root @ z)[1] @ root / noise
        return np.vstack([columns, np.eye(len(z))])

    z = least_squares(off, np.zeros(root.shape[1]), slopes, xtol=CARRIED, ftol=None, gtol=None).x
    other_steep = model.steep(middle + root @ z)[1]
    columns = other_steep @ root / noise
    least = root @ np.linalg.solve(columns.T @ columns + np.eye(root.shape[1]), columns.T) / noise.T
    ways = np.eye(len(middle)) + least @ (steep - other_steep)
    return Gaussian(middle + root @ z, ways @ one.state.covariance @ ways.T)


def log_evidence(before: PairPosterior, after: PairPosterior, observed: Observed) -> float:
    """Return the logarithm of the probability of readings, but for a constant.

    After Laplace: at the posterior's maximum, times the share of the prior that it leaves, and how
    probable the scatter found was before.
    """
    prior, model = met(before, observed)
    open_ways = _open(prior.state.covariance)
    wide, narrow = (open_ways.T @ one.state.covariance @ open_ways for one in (prior, after))
    seen = model.seen(after.state.mean)
    noise = model.noise(seen, after.scatter)
    left = (observed.value - seen.expected) / noise
    off = open_ways.T @ (after.state.mean - prior.state.mean)
    misfit = left @ left + off @ np.linalg.solve(wide, off)
    volume = np.linalg.slogdet(wide)[1] - np.linalg.slogdet(narrow)[1]
    scatter = before.scatter.log_chance(after.scatter)
    return float(scatter - 0.5 * (misfit + 2.0 * np.sum(np.log(noise)) + volume))


def _open(covariance: Array) -> Array:
    """Return the combinations (p, k) of numbers that a covariance (p, p) leaves open."""
    sd = np.sqrt(np.diag(covariance))
    size = np.where(sd > 0.0, sd, 1.0)
    spread, ways = np.linalg.eigh(covariance / np.outer(size, size))
    return np.asarray((ways / size[:, None])[:, spread > SHUT * spread[-1]])
