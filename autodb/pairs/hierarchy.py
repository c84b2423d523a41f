"""Several machines' posterior of one material: a mean, tools around it, machines around those.

    θ_{m,t} = μ + τ_t + ε_{m,t},   μ ~ start,  τ_t ~ N(0, a² T),  ε ~ N(0, b² E)

θ coordinates of the law of machine m's pair with tool t; T and E how far any two metals are apart,
but for an edge's own numbers, of which half of that is the tool's whatever a is. a and b are
estimated from the pairs themselves: the mean of their posterior on a grid of both (empirical Bayes;
Efron and Morris 1975), where between its points posteriors are averaged.

Of each pair counts only the information of its own cuts, Λ and Λθ: that of its posterior less that
of what it began with, so that nothing counts twice in one that began from the others. Everything
else is sums of these, for each tool and each b of the grid: a pair is added, taken out or replaced
at the cost of that pair alone, and the result is the same in any order.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.shear import NAMES
from autodb.fitting.gaussian import Gaussian
from autodb.pairs.posterior import OWN, PairPosterior
from autodb.pairs.prior import OF_EDGE, RELATIVE, any_metal, of_relative

Array = NDArray[np.float64]

ANY = any_metal().law
ACTIVE = np.flatnonzero(np.diag(ANY.covariance) > 0.0)
"""Coordinates that differ between metals at all."""
METALS = np.diag(ANY.covariance)[ACTIVE]
EDGES = np.array([NAMES[k] in OF_EDGE for k in ACTIVE])
MACHINES = 0.07
"""Machines move a pair by 7 % of what metals differ by, before any has cut. Chosen."""
OF_EDGES = 0.5
"""Share of the variance of an edge's own numbers that is the tool's. Chosen."""
FOLDS = 0.6
"""Standard deviation of ln a and ln b around RELATIVE and MACHINES. Chosen: the pairs of three
machines outweigh it."""
STEPS = np.arange(-5, 6) / 4.0
"""Logarithms of the grid's shares over RELATIVE and MACHINES."""
MANY = 60
"""Pairs from which on the spreads are estimated without regard to any one of them. Chosen."""
CLIP = 1e-9
"""Information, of that in a metal's own spread, below which there is none."""


@dataclass(frozen=True)
class InformationOfCuts:
    """Information of cuts on the law's active coordinates: Λ (..., a, a) and Λθ (..., a)."""

    precision: Array
    weighted: Array


@dataclass(frozen=True)
class OfTool:
    """Information of all machines on μ + τ of one tool, for each b of the grid (s, ...).

    ``log`` (s,): logarithm of how probable the pairs are among themselves; ``machines``: how many.
    """

    information: InformationOfCuts
    log: Array
    machines: int

    @classmethod
    def nothing(cls) -> "OfTool":
        """Return no information, of no machine."""
        size = len(STEPS), len(ACTIVE)
        return cls(
            InformationOfCuts(np.zeros((*size, size[1])), np.zeros(size)), np.zeros(size[0]), 0
        )

    def changed(self, pair: InformationOfCuts, sign: int) -> "OfTool":
        """Return it with a pair added (1), or taken out (-1)."""
        alike = InformationOfCuts(
            np.broadcast_to(pair.precision, self.information.precision.shape),
            np.broadcast_to(pair.weighted, self.information.weighted.shape),
        )
        log, passed = _beyond(alike, OF_MACHINES)
        return OfTool(
            InformationOfCuts(
                self.information.precision + sign * passed.precision,
                self.information.weighted + sign * passed.weighted,
            ),
            self.log + sign * log,
            self.machines + sign,
        )


OF_MACHINES = (MACHINES * np.exp(STEPS))[:, None] ** 2 * METALS
"""Variances (s, a) of ε."""
OF_TOOLS = np.where(EDGES, OF_EDGES, (RELATIVE * np.exp(STEPS))[:, None] ** 2) * METALS
"""Variances (s, a) of τ."""


@dataclass(frozen=True)
class KnownMaterial:
    """What is known of a material: where it started, and the information of each tool's pairs.

    ``held``: where on the grid, in its steps, the spreads are taken to be; None: where the pairs
    put them.
    """

    start: Gaussian
    tools: Mapping[str, OfTool] = field(default_factory=dict)
    held: tuple[float, float] | None = None

    def changed(
        self,
        tool: str,
        *,
        more: InformationOfCuts | None = None,
        less: InformationOfCuts | None = None,
    ) -> "KnownMaterial":
        """Return it with a pair's information added, or taken out."""
        found = self.tools.get(tool) or OfTool.nothing()
        for pair, sign in ((more, 1), (less, -1)):
            if pair is not None:
                found = found.changed(pair, sign)
        tools = {**self.tools, tool: found}
        if not found.machines:
            del tools[tool]
        return replace(self, tools=tools)

    def without(self, tool: str, pair: InformationOfCuts) -> "KnownMaterial":
        """Return what the others know: with their own spreads, where one pair could move those."""
        held = self._spread if self.pairs > MANY else self.held
        return replace(self, held=held).changed(tool, less=pair)

    @property
    def pairs(self) -> int:
        """Number of pairs in it."""
        return sum(tool.machines for tool in self.tools.values())

    @property
    def shares(self) -> tuple[float, float]:
        """How far tools and machines are apart, shares a and b of what metals are."""
        a, b = (np.interp(at, np.arange(len(STEPS)), STEPS) for at in self._spread)
        return RELATIVE * float(np.exp(a)), MACHINES * float(np.exp(b))

    @cached_property
    def _spread(self) -> tuple[float, float]:
        """Where on the grid, in its steps, tools' and machines' shares are."""
        if self.held is not None:
            return self.held
        log = -0.5 * (STEPS[:, None] ** 2 + STEPS**2) / FOLDS**2
        for a, of_tools in enumerate(OF_TOOLS):
            log[a] += self._evidence(of_tools)
        weight = np.exp(log - log.max())
        weight /= weight.sum()
        at = np.arange(len(STEPS))
        return float(weight.sum(1) @ at), float(weight.sum(0) @ at)

    def _corners(self) -> list[tuple[int, int, float]]:
        """Return the points of the grid around the spreads, with their weights."""
        sides = []
        for at in self._spread:
            lower = min(int(at), len(STEPS) - 2)
            sides.append([(lower, 1.0 - (at - lower)), (lower + 1, at - lower)])
        return [(a, b, of_a * of_b) for a, of_a in sides[0] for b, of_b in sides[1] if of_a * of_b]

    def _evidence(self, of_tools: Array) -> Array:
        """Return the logarithm of how probable the pairs' information is, for each b."""
        own = _active(self.start)
        nothing = OfTool.nothing()
        precision, weighted, log = (
            nothing.information.precision,
            nothing.information.weighted,
            nothing.log,
        )
        for tool in self.tools.values():
            own_log, passed = _beyond(tool.information, np.broadcast_to(of_tools, OF_TOOLS.shape))
            precision, weighted = precision + passed.precision, weighted + passed.weighted
            log = log + tool.log + own_log
        expected = precision @ own.mean
        moved = weighted - expected
        log = log + weighted @ own.mean - 0.5 * expected @ own.mean
        loose = np.eye(len(own.mean)) + precision @ own.covariance
        inner = own.covariance @ np.linalg.solve(loose, moved[..., None])
        quadratic = np.einsum("si,sij->s", moved, inner) - np.linalg.slogdet(loose)[1]
        return np.asarray(log + 0.5 * quadratic)

    def material(self) -> Gaussian:
        """Return the posterior about μ (a,) from all tools."""
        return _mixed([(self._material(a, b), weight) for a, b, weight in self._corners()])

    def pair(self, tool: str) -> Gaussian:
        """Return the posterior about the pair of a machine that has not cut it, all coordinates."""
        return whole_law(_mixed([(self._pair(tool, a, b), w) for a, b, w in self._corners()]))

    def _material(self, a: int, b: int, *, but: str | None = None) -> Gaussian:
        """Return the posterior about μ at a point of the grid, from all tools or all but one."""
        posterior = _active(self.start)
        for name, tool in self.tools.items():
            if name != but:
                one = InformationOfCuts(
                    tool.information.precision[b : b + 1], tool.information.weighted[b : b + 1]
                )
                _, passed = _beyond(one, OF_TOOLS[a : a + 1])
                posterior = _posterior(posterior, passed.precision[0], passed.weighted[0])
        return posterior

    def _pair(self, tool: str, a: int, b: int) -> Gaussian:
        others = self._material(a, b, but=tool)
        posterior = Gaussian(others.mean, others.covariance + np.diag(OF_TOOLS[a]))
        if tool in self.tools:
            of_tool = self.tools[tool].information
            posterior = _posterior(posterior, of_tool.precision[b], of_tool.weighted[b])
        return Gaussian(posterior.mean, posterior.covariance + np.diag(OF_MACHINES[b]))


def _mixed(some: list[tuple[Gaussian, float]]) -> Gaussian:
    """Return the normal posterior with mean and covariance of posteriors averaged with weights."""
    mean = sum((weight * one.mean for one, weight in some), np.zeros_like(some[0][0].mean))
    covariance = np.zeros_like(some[0][0].covariance)
    for one, weight in some:
        off = one.mean - mean
        covariance += weight * (one.covariance + np.outer(off, off))
    return Gaussian(mean, covariance)


def information_of_cuts(after: Gaussian, before: Gaussian) -> InformationOfCuts:
    """Return the information of readings: the posterior after them less that before, (OWN,) both.

    What linearising makes negative is nothing.
    """
    a, b = _active(after), _active(before)
    now, then = np.linalg.inv(a.covariance), np.linalg.inv(b.covariance)
    precision = now - then
    weighted = now @ a.mean - then @ b.mean
    size = np.sqrt(METALS)
    values, vectors = np.linalg.eigh(precision * np.outer(size, size))
    kept = np.where(values > CLIP, values, 0.0)
    turned = np.where(values > CLIP, vectors.T @ (size * weighted), 0.0)
    back = vectors / size[:, None]
    return InformationOfCuts((back * kept) @ back.T, back @ turned)


def of_relatives(
    first: PairPosterior, start: Gaussian, own_cuts: Mapping[str, InformationOfCuts], tool: str
) -> PairPosterior:
    """Return what pairs of one machine and material say of it with another tool.

    Errors of the machine's calibrations are in all of them alike. So the material's numbers are
    worked out as if there were none, θ_0, and the errors δ put back as the first pair has them,
    θ = θ_0 + G δ with G its regression of the law on them: no number of tools averages a gain away.

    ``first``: one of them, with the errors of all calibrations that sensed any; ``start``: what was
    known of the law before any was cut; ``own_cuts``: what each tool's cuts say as if these errors
    were none.
    """
    known = KnownMaterial(start)
    for name, information in own_cuts.items():
        known = known.changed(name, more=information)
    law, relative = known.pair(tool), of_relative(first)
    mean, covariance = relative.state.mean.copy(), relative.state.covariance.copy()
    errors = slice(OWN, len(mean))
    regression = covariance[:OWN, errors] @ np.linalg.pinv(covariance[errors, errors])
    mean[:OWN] = law.mean + regression @ mean[errors]
    covariance[:OWN, :OWN] = law.covariance + regression @ covariance[errors, :OWN]
    return PairPosterior(
        Gaussian(mean, covariance), relative.shared, first.scatter, 0, first.off_law
    )


def whole_law(active: Gaussian) -> Gaussian:
    """Return a posterior about the active coordinates as one about all."""
    mean, covariance = ANY.mean.copy(), np.zeros((OWN, OWN))
    mean[ACTIVE] = active.mean
    covariance[np.ix_(ACTIVE, ACTIVE)] = active.covariance
    return Gaussian(mean, covariance)


def _beyond(some: InformationOfCuts, variances: Array) -> tuple[Array, InformationOfCuts]:
    """Return the information on a mean where θ is off it by draws of ``variances`` (s, a).

    Λ − ΛCΛ and w − ΛCw with C = (Λ + V⁻¹)⁻¹; and first the logarithm of what is left when the draw
    is integrated out, ½ (wᵀCw − ln|1 + ΛV|), (s,).
    """
    loose = some.precision + _diagonal(1.0 / variances)
    left = np.linalg.solve(loose, some.precision)
    inner = np.linalg.solve(loose, some.weighted[..., None])[..., 0]
    precision = some.precision - some.precision @ left
    weighted = some.weighted - np.einsum("sij,sj->si", some.precision, inner)
    volume = np.linalg.slogdet(loose)[1] + np.sum(np.log(variances), axis=-1)
    log = 0.5 * (np.sum(some.weighted * inner, axis=-1) - volume)
    return log, InformationOfCuts(0.5 * (precision + precision.swapaxes(-1, -2)), weighted)


def _diagonal(values: Array) -> Array:
    return values[..., None] * np.eye(values.shape[-1])


def _posterior(before: Gaussian, precision: Array, weighted: Array) -> Gaussian:
    covariance = np.linalg.inv(np.linalg.inv(before.covariance) + precision)
    mean = before.mean + covariance @ (weighted - precision @ before.mean)
    return Gaussian(mean, 0.5 * (covariance + covariance.T))


def _active(start: Gaussian) -> Gaussian:
    return Gaussian(start.mean[ACTIVE], start.covariance[np.ix_(ACTIVE, ACTIVE)])
