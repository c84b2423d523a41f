"""Semi-inverse: sensed forces change the posterior about a pair, by iterated Gauss-Newton.

Maximum of the posterior of law and shared errors, readings linearised anew at every step:

    y = (F(θ) + A(θ) α) (1 + C δ) + S δ + L(θ) λ + ε,  ε ~ N(0, sd² + Σ (share · part)²)

δ errors of calibrations and dynamometers, λ the shares and the direction by which the law is off in
an operation, L the parts of F and F turned. α is what is assumed of cuts (an entering angle nobody
stated), A what one standard deviation of it changes.

A step that does not raise the posterior is halved; where rounds do not come to rest, one that
overshoots is shortened. The share that cuts scatter by is learnt along with it: expectation and
maximisation, every round one step of both, Anderson's mixing over the last rounds
(``fitting.stationary``). Learning ends where a round moves nothing by 1e-9 of its own standard
deviation, so that the same cuts give one answer, whatever unit, order or processor they come in. A
cut costs the same however many came before. Source: Bell and Cathey
1993 for the iterated filter as Gauss-Newton.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtrtri, dtrtrs

from autodb.cutting.turning import TURNED
from autodb.errors import UnusableInput
from autodb.fitting.gaussian import Gaussian, root_of
from autodb.fitting.rounds import NotSettled, stationary
from autodb.pairs.modelled import FORCE, Modelled, Seen
from autodb.pairs.observed import Observed
from autodb.pairs.posterior import OWN, PairPosterior, PassiveKnown, Scatter
from autodb.wording import phrase

Array = NDArray[np.float64]

STEPS, CLOSE = 20, 0.3
"""Steps with one noise, and how near, in standard deviations, the maximum has to be for one step to
be enough. Chosen."""
HALVINGS = 8
RESTLESS = 150
"""Rounds after which a step that overshoots is shortened. Chosen: what rests does so in fewer."""
TOLD, STRAIGHT, SHORTEST = 1e-10, 0.8, 0.1
"""Share of the misfit that a step must promise for its bend to be told from rounding, length of a
step from which on it is left as it is, and the shortest. Chosen."""
TINY = 1e-12
"""Square of a part, N², below which there is none."""
MOSTLY = np.sqrt(0.5)
"""Share of a force off the surface from which on its reading is one of the passive force."""
REACHED = 1e-2
"""Standard deviations within which a climb is at a maximum that is known. Chosen: rounds near one
end at it."""
PATIENCE, HOPELESS = 40, 30.0
"""Steps after which a climb is left where its evidence is lower than a known one by a factor of
exp(HOPELESS): no digit of an average over both would tell it. Chosen."""
ENOUGH = 1e-3
"""Standard deviations that the last of many rounds may move a number by. Chosen: far below what any
answer shows."""


class AtKnownMaximum(Exception):  # noqa: N818 - where a climb is, not an error
    """A climb that comes to a maximum that is known."""


def posterior_of_readings(
    posterior: PairPosterior,
    observed: Observed,
    *,
    near: PairPosterior | None = None,
    most: int | None = None,
    known: PairPosterior | None = None,
    beaten: float = -np.inf,
) -> PairPosterior:
    """Return the posterior after readings.

    ``near``: one that is close to it, from which the maximum is searched for; it has no other
    effect where there is one maximum. ``known``: the posterior at a maximum that was found before.
    ``beaten``: the log evidence of another law, far below which this one is of no use.

    Raises UnusableInput where learning does not come to rest, or not in ``most`` steps, or is
    ``beaten``, and AtKnownMaximum where it comes to the one that is ``known``.
    """
    prior, model = met(posterior, observed)
    begun = (
        prior if near is None else replace(prior, scatter=near.scatter, state=_begun(prior, near))
    )
    try:
        state, scatter = _Rounds(prior, model, most, known, beaten).settled(begun)
    except NotSettled as error:
        cuts = len(np.unique(observed.cut))
        raise UnusableInput(
            phrase(
                "{cuts} cuts do not determine the pair ({error}); leave out those that stand out",
                cuts=cuts,
                error=error,
            )
        ) from error
    return replace(
        prior,
        state=state,
        scatter=scatter,
        cuts=prior.cuts + len(np.unique(observed.cut)),
        passive=_passive_known(prior, observed),
    )


def _passive_known(prior: PairPosterior, observed: Observed) -> dict[str, PassiveKnown]:
    """Return what is known of passive forces, with those among readings."""
    known = dict(prior.passive)
    mostly = np.abs(observed.off_surface()) > MOSTLY
    for operation in TURNED:
        read = observed.within(operation) & mostly
        if read.any():
            before = known.get(operation, PassiveKnown(0, 0.0))
            known[operation] = before.also(observed.sd[read])
    return known


def _begun(prior: PairPosterior, near: PairPosterior) -> Gaussian:
    """Return the state of a prior, with the numbers that a posterior near has of it."""
    mean = prior.state.mean.copy()
    mean[:OWN] = near.state.mean[:OWN]
    known = {one.key for one in near.shared}
    for one in prior.shared:
        if one.key in known:
            mean[prior.columns(one.key)] = near.state.mean[near.columns(one.key)]
    return Gaussian(mean, prior.state.covariance)


def expected_of(posterior: PairPosterior, observed: Observed) -> tuple[Array, Array]:
    """Return what is expected of readings before they are learnt: (m,), covariance (m, m)."""
    known, model = met(posterior, observed)
    seen, design = model.steep(known.state.mean)
    own = model.noise(seen, known.scatter)
    columns = design @ root_of(known.state.covariance)  # a square, which no rounding makes negative
    return seen.expected, columns @ columns.T + np.diag(own**2)


def log_evidence_near(posterior: PairPosterior, observed: Observed, near: PairPosterior) -> float:
    """Return the logarithm of the probability of readings, but for a constant, linearised.

    At what a posterior ``near`` found of the same state, with its scatter: one step of algebra in
    place of a search, exact in all that moves readings linearly, as wear does.
    """
    prior, model = met(posterior, observed)
    there = _begun(prior, near).mean
    seen, design = model.steep(there)
    noise = model.noise(seen, near.scatter)
    columns = design @ root_of(prior.state.covariance) / noise[:, None]
    off = observed.value - seen.expected + design @ (there - prior.state.mean)

    # By QR, as a step: normal equations lose what a wide prior leaves open to rounding
    open_, known = columns.shape[1], np.vstack([columns, np.eye(columns.shape[1])])
    left = np.concatenate([off / noise, np.zeros(open_)])
    whole = np.abs(np.linalg.qr(np.column_stack([known, left]), mode="r"))
    volume = np.sum(np.log(noise)) + np.sum(np.log(np.diag(whole)[:open_]))
    return float(-0.5 * whole[open_, open_] ** 2 - volume)


@dataclass(frozen=True)
class ReadingErrors:
    """Standard deviations (m,) of what makes readings differ from the law: ``own`` of each reading,
    ``process`` of its cut, ``shared`` with other readings, by key.
    """

    own: Array
    process: Array
    shared: Mapping[str, Array]


def reading_errors(posterior: PairPosterior, observed: Observed) -> ReadingErrors:
    """Return the errors with which readings enter a posterior, where it expects them to be."""
    known, model = met(posterior, observed)
    seen, design = model.steep(known.state.mean)
    whole = model.noise(seen, known.scatter)
    shared = {}
    for one in observed.shared:
        moves = design[:, known.columns(one.key)]
        shared[one.key] = np.sqrt(np.einsum("mi,ij,mj->m", moves, one.covariance, moves))
    process = np.sqrt(np.maximum(whole**2 - observed.sd**2, 0.0))
    return ReadingErrors(observed.sd, process, shared)


def met(posterior: PairPosterior, observed: Observed) -> tuple[PairPosterior, Modelled]:
    """Return a posterior that has met what readings share, and the readings as its functions."""
    laws = posterior.law_errors(*observed.operations)
    known = posterior.also((*observed.shared, *laws, *observed.assumed, *posterior.open_terms))
    return known, Modelled(known, observed)


class _Rounds:
    """Rounds of Gauss-Newton and of expectation, on state and scatter at once.

    The state is searched in z, θ = prior mean + root · z, so that the prior of z is N(0, 1) and a
    step is one least-squares problem, solved by QR: normal equations would know it to 1e-6 sd only.
    """

    def __init__(
        self,
        prior: PairPosterior,
        model: Modelled,
        most: int | None,
        known: PairPosterior | None,
        beaten: float,
    ) -> None:
        self._prior, self._model = prior, model
        self._root = root_of(prior.state.covariance)
        self._most = most
        self._known = None if known is None else self._place(known)
        self._beaten = beaten - HOPELESS
        self._rounds, self._steps, self._length = 0, 0, 1.0

    def settled(self, begun: PairPosterior) -> tuple[Gaussian, Scatter]:
        """Return the normal posterior at the maximum of the posterior, and what cuts scatter by."""
        weight, triangle = self._prior.scatter.weight, np.eye(self._root.shape[1])

        def moved(place: Array) -> tuple[Array, Array]:
            nonlocal weight, triangle
            z, scatter = place[:-FORCE], Scatter(np.exp(0.5 * place[-FORCE:]), weight)
            z, found, triangle = self._stepped(z, scatter)
            weight = found.weight
            spread = np.linalg.norm(dtrtri(triangle)[0], axis=1)
            there = np.concatenate([z, 2.0 * np.log(found.share)])
            size = np.concatenate([spread, np.sqrt(2.0 / weight)])
            if self._known is not None and np.all(np.abs(there - self._known) < REACHED * size):
                raise AtKnownMaximum
            return there, size

        place = stationary(moved, self._place(begun), enough=ENOUGH)
        spread = self._root @ dtrtri(triangle)[0]
        state = Gaussian(self._mean(place[:-FORCE]), spread @ spread.T)
        return state, Scatter(np.exp(0.5 * place[-FORCE:]), weight)

    def _place(self, posterior: PairPosterior) -> Array:
        """Return z and the logarithms of scatter's variances of a posterior."""
        off = posterior.state.mean - self._prior.state.mean
        z = np.linalg.lstsq(self._root, off, rcond=1e-12)[0]
        return np.concatenate([z, 2.0 * np.log(posterior.scatter.share)])

    def _mean(self, z: Array) -> Array:
        return np.asarray(self._prior.state.mean + self._root @ z)

    def _stepped(self, z: Array, scatter: Scatter) -> tuple[Array, Scatter, Array]:
        """Return z after steps, scatter there, R of its precision (all as the noise was before).

        One step, but as many as lead near the maximum where that is far: a noise that follows every
        step of a long way would never let it end.
        """
        self._rounds += 1
        seen, design = self._model.steep(self._mean(z))
        noise = self._model.noise(seen, scatter)
        for taken in range(STEPS):
            self._steps += 1
            if self._most is not None and self._steps > self._most:
                raise NotSettled(f"not at rest after {self._most} steps")
            triangle, columns, step = self._step(z, seen, design, noise)
            promised = float(np.sum((triangle @ step) ** 2))
            before = z
            z, seen = self._halved(z, seen, step, noise, promised=promised)
            if np.max(np.abs(step) / np.linalg.norm(dtrtri(triangle)[0], axis=1)) < CLOSE:
                break
            if z is before:  # no length led down, nor would it in all the other steps
                self._steps += STEPS - 1 - taken
                break
            seen, design = self._model.steep(self._mean(z))
        likely = self._prior.scatter.log_chance(scatter)
        likely += self._log_evidence(z, seen, noise, triangle)
        if self._steps > PATIENCE and likely < self._beaten:
            raise NotSettled(f"far below another law after {self._steps} steps")
        known = dtrtrs(triangle, columns.T, trans=1)[0]
        return z, self._scatter(seen, np.sum(known**2, axis=0), scatter), triangle

    def _step(
        self, z: Array, seen: Seen, design: Array, noise: Array
    ) -> tuple[Array, Array, Array]:
        """Return R (p, p) of the precision, the readings' columns by z (m, p), and the step."""
        columns = design @ self._root
        rows = np.vstack([columns / noise[:, None], np.eye(len(z))])
        left = np.concatenate([(self._model.observed.value - seen.expected) / noise, -z])
        whole = np.asarray(np.linalg.qr(np.column_stack([rows, left]), mode="r"))
        triangle = whole[: len(z), : len(z)]
        return triangle, columns, dtrtrs(triangle, whole[: len(z), len(z)])[0]

    def _halved(
        self, z: Array, seen: Seen, step: Array, noise: Array, *, promised: float
    ) -> tuple[Array, Seen]:
        """Return z after a step, halved until it leads down, and the readings there.

        ``promised``: by how much the misfit falls, were readings linear. Where rounds do not come
        to rest, a step that overshoots is shortened to the lowest point of the parabola through
        both; so are the next, that promise too little to tell from rounding.
        """
        value = self._model.observed.value

        def misfit(there: Seen, z: Array) -> float:
            left = (value - there.expected) / noise
            return float(left @ left + z @ z)

        best = misfit(seen, z)
        if self._rounds > RESTLESS and promised > TOLD * best:
            bend = misfit(self._model.seen(self._mean(z + step)), z + step) - best + 2.0 * promised
            length = promised / bend if bend > 0.0 else 1.0
            self._length = 1.0 if length > STRAIGHT else max(length, SHORTEST)
        step = self._length * step
        for _ in range(HALVINGS):
            there = self._model.seen(self._mean(z + step))
            if misfit(there, z + step) <= best * (1.0 + 1e-9):
                return z + step, there
            step = 0.5 * step
        return z, seen

    def _log_evidence(self, z: Array, seen: Seen, noise: Array, triangle: Array) -> float:
        """Return about the logarithm of the probability of the readings, were this a maximum and
        the scatter known.
        """
        left = (self._model.observed.value - seen.expected) / noise
        volume = np.sum(np.log(noise)) + np.sum(np.log(np.abs(np.diag(triangle))))
        return float(-0.5 * (left @ left + z @ z) - volume)

    def _scatter(self, seen: Seen, known: Array, now: Scatter) -> Scatter:
        """Return what cuts scatter by: the prior's weight and one expectation over the readings.

        Of a reading's error the share that a part's scatter has in its variance is that part's.
        ``known`` (m,): variance of what is expected.
        """
        prior = self._prior.scatter
        square = (self._model.observed.value - seen.expected) ** 2 + known
        parts = seen.parts[:, :FORCE] ** 2
        variances = parts * now.share**2
        share = variances / self._model.noise(seen, now)[:, None] ** 2
        rest = np.maximum(1.0 - share, 0.0)  # a scatter tried far off has all of it, but rounding
        sensed = share**2 * square[:, None] + variances * rest
        counts = parts / np.maximum(parts.sum(axis=1, keepdims=True), TINY)
        each = np.where(counts > 0.0, sensed / np.maximum(parts, TINY), 0.0)
        weight = prior.weight + counts.sum(axis=0)
        total = prior.weight * prior.share**2 + (counts * each).sum(axis=0)
        return Scatter(np.sqrt(total / weight), weight)
