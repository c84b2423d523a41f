"""Errors of forces that a dynamometer measured, or that a publication states.

    F_read = F (1 + Σ share_i δ_i) + Σ shift_i δ_i,  δ_i ~ N(0, 1)

Errors of the certificate, of cross-talk and of the mounting are the same in all forces of one
dynamometer, drift in those of one recording; noise is each force's own. Limits count as those of a
rectangular distribution, expanded uncertainties are divided by their k (JCGM 100:2008, 4.3.3,
4.3.7). What is not stated is no error here, but in two places, where it would make a force exact:
a gain, for which DEFAULT_SHARE stands, and noise.
"""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.files.dynamometer import (
    DynamometerSection,
    PublicationSection,
    StatedUncertainty,
    of_component,
)
from autodb.fitting.uncertainty import Evaluation, limits_as_standard
from autodb.wording import stored_msgid

Array = NDArray[np.float64]

DEFAULT_SHARE = 0.01
"""Standard uncertainty of the gain, of the force, where nothing is stated of it. Chosen: 2 % with
k = 2."""
DEFAULT_NOISE = 0.005
"""Noise of a force, of the largest one in its recording, unless it is stated or repeats say that it
is less. Chosen."""
ENOUGH_REPEATS = 4
"""Degrees of freedom from which on the scatter of repeats bounds the noise. Chosen."""
CERTIFICATE, CROSSTALK, DRIFT, MOUNTING, NOISE = (
    stored_msgid("dynamometer certificate"), stored_msgid("cross-talk"), stored_msgid("drift"),
    stored_msgid("mounting"), stored_msgid("noise of the dynamometer"),
)  # fmt: skip
NAMED = stored_msgid("dynamometer {name}")
UNNAMED = stored_msgid("dynamometer, not stated which")
CERTIFIED = stored_msgid("{found}, certificate {certificate}")
UNCERTIFIED = stored_msgid("{found}, certificate not stated")
OF_FORCE = stored_msgid("{share} of the force, k = {k}: {found}")
BESIDE_IT = stored_msgid("{size}, k = 2: {found}")
BESIDE = stored_msgid("uncertainty as stated, beside")
FROM_OTHER = stored_msgid("cross-talk from force.{axis}")
LIMIT_OF_OTHER = stored_msgid("limit {share} of force.{axis}, rectangular")
LIMIT = stored_msgid("limit {size} over a recording, rectangular")
TAKEN_NOISE = stored_msgid(
    "not stated; {share} of the recording's largest force is taken in its place"
)
WHOLE = stored_msgid("uncertainty as stated")
TAKEN = stored_msgid("not stated; {share} of the force is taken in its place")
WITHIN = stored_msgid("limit {share} of the force, rectangular")
PARTS = (CERTIFICATE, CROSSTALK, DRIFT, MOUNTING)
"""What a budget of a measured force names in any case."""
K_OF_WHOLE = 2.0


@dataclass(frozen=True)
class ForceError:
    """One error of a force: what one standard deviation of it moves, and where it is known from.

    By ``share`` of the force, and ``shift_N`` beside that. ``of``: what it is the error of, where
    forces share it; None: the force's own. ``passing``: only forces of one recording share it.
    ``freedom``: degrees of freedom; None: it is taken as known.
    """

    name: str
    share: float
    shift_N: float
    evaluation: Evaluation
    source: str
    of: str | None = None
    passing: bool = False
    freedom: float | None = None

    def standard_N(self, force_N: float) -> float:
        """Return the standard uncertainty that it gives to a force."""
        return abs(self.share * force_N + self.shift_N)


@dataclass(frozen=True)
class ForceStatement:
    """Where the forces of a recording are from: a dynamometer, a publication, or nobody said."""

    dynamometer: DynamometerSection | None = None
    source: PublicationSection | None = None

    @property
    def called(self) -> str:
        """What forces of the same origin have in common. Unnamed dynamometers count as one."""
        if self.source is not None:
            return self.source.words
        name = self.dynamometer.name if self.dynamometer else None
        return NAMED.format(name=name) if name else "dynamometer"

    @property
    def words(self) -> str:
        """The origin in words, with its certificate."""
        stated = self.dynamometer
        if self.source is not None or stated is None:
            return self.called if self.source is not None else UNNAMED
        dated = ("dated " + stated.certificate_date) if stated.certificate_date else None
        said = [one for one in (stated.certificate, dated) if one]
        if not said:
            return UNCERTIFIED.format(found=self.called)
        return CERTIFIED.format(found=self.called, certificate=", ".join(said))

    def errors(self, component: str, forces_N: Mapping[str, float]) -> list[ForceError]:
        """Return the errors that a component of one cut's ``forces_N`` shares with other forces."""
        whole: StatedUncertainty | None = self.source or self.dynamometer
        if whole is not None and whole.stated:
            return list(self._in_all(component, whole))
        parts = self.dynamometer or DynamometerSection()
        return list(self._parts(component, parts, forces_N))

    def _shared(
        self, component: str, name: str, *, source: str, share: float = 0.0, shift_N: float = 0.0
    ) -> ForceError:
        of = f"{self.called}, {name}, force.{component}"
        return ForceError(name, share, shift_N, "B", source, of)

    def _in_all(self, component: str, whole: StatedUncertainty) -> Iterator[ForceError]:
        """Yield the uncertainty that is stated of the whole, taken as common to all its forces."""
        percent = of_component(whole.uncertainty_percent, component)
        beside_N = of_component(whole.uncertainty_N, component)
        if percent is not None:
            said, share = (
                OF_FORCE.format(share=f"{percent:g} %", k="2", found=self.words),
                0.01 * percent,
            )
            yield self._shared(component, WHOLE, share=share / K_OF_WHOLE, source=said)
        if beside_N is not None:
            said, shift_N = (
                BESIDE_IT.format(size=f"{beside_N:g} N", found=self.words),
                beside_N / K_OF_WHOLE,
            )
            yield self._shared(component, BESIDE, shift_N=shift_N, source=said)

    def _parts(
        self, component: str, stated: DynamometerSection, forces_N: Mapping[str, float]
    ) -> Iterator[ForceError]:
        percent = of_component(stated.certificate_percent, component)
        if percent is None:
            share = DEFAULT_SHARE
            said = TAKEN.format(share=f"{100.0 * share:g} %")
        else:
            share = 0.01 * percent / stated.certificate_k
            said = OF_FORCE.format(
                share=f"{percent:g} %", k=f"{stated.certificate_k:g}", found=self.words
            )
        yield self._shared(component, CERTIFICATE, share=share, source=said)
        percent = of_component(stated.mounting_percent, component)
        if percent is not None:
            said = WITHIN.format(share=f"{percent:g} %")
            share = limits_as_standard(0.01 * percent)
            yield self._shared(component, MOUNTING, share=share, source=said)
        percent = of_component(stated.crosstalk_percent, component)
        for other, force_N in forces_N.items():
            if percent is not None and other != component:
                name, shift_N = FROM_OTHER.format(axis=other), 0.01 * percent * force_N
                said = LIMIT_OF_OTHER.format(share=f"{percent:g} %", axis=other)
                moved_N = limits_as_standard(shift_N)
                yield self._shared(component, name, shift_N=moved_N, source=said)
        limit_N = of_component(stated.drift_N, component)
        if limit_N is not None:
            said = LIMIT.format(size=f"{limit_N:g} N")
            moved_N = limits_as_standard(limit_N)
            drift = self._shared(component, DRIFT, shift_N=moved_N, source=said)
            yield replace(drift, passing=True)

    def noise(self, component: str, measured: "MeasuredForces") -> ForceError:
        """Return a force's own error, of those of its recording that are ``measured``."""
        stated = self.dynamometer
        noise_N = None if stated is None else of_component(stated.noise_N, component)
        if noise_N is not None:
            said = stored_msgid("standard deviation of the mean of one cut, as stated")
            return ForceError(NOISE, 0.0, noise_N, "B", said)
        bound_N, freedom = measured.scatter_of_repeats(component)
        default_N = DEFAULT_NOISE * measured.largest_N
        if freedom >= ENOUGH_REPEATS and bound_N < default_N:
            said = stored_msgid("scatter of repeated cuts, which holds the process too")
            return ForceError(NOISE, 0.0, bound_N, "A", said, freedom=freedom)
        said = TAKEN_NOISE.format(share=f"{100.0 * DEFAULT_NOISE:g} %")
        return ForceError(NOISE, 0.0, default_N, "B", said)


@dataclass(frozen=True)
class MeasuredForces:
    """Forces of a recording's cuts: one mapping by component a cut, and what a cut repeats."""

    forces_N: Sequence[Mapping[str, float]]
    conditions: Sequence[Hashable]

    @property
    def largest_N(self) -> float:
        """The size of the largest force, of any component."""
        return max((abs(value) for one in self.forces_N for value in one.values()), default=0.0)

    def scatter_of_repeats(self, component: str) -> tuple[float, int]:
        """Return the pooled standard deviation of repeats and its degrees of freedom; 0: none."""
        groups: dict[Hashable, list[float]] = {}
        for one, condition in zip(self.forces_N, self.conditions, strict=True):
            if component in one:
                groups.setdefault(condition, []).append(one[component])
        freedom = sum(len(some) - 1 for some in groups.values())
        squares = sum(float(np.var(some)) * len(some) for some in groups.values())
        return (float(np.sqrt(squares / freedom)) if freedom else 0.0), freedom


def errors_of_table(
    statement: ForceStatement, component: str, forces_N: Mapping[str, Array]
) -> tuple[ForceError, ...]:
    """Return what a fit to a component of a table's forces (n,), NaN where none, has of errors."""
    rows = np.flatnonzero(np.isfinite(forces_N[component]))
    each = [{c: float(one[k]) for c, one in forces_N.items() if np.isfinite(one[k])} for k in rows]
    errors = [statement.errors(component, one) for one in each]
    return tuple(mean_errors(errors, forces_N[component][rows]))


def mean_errors(errors: Sequence[Sequence[ForceError]], forces_N: Array) -> list[ForceError]:
    """Return what a fit to forces (n,) has of the errors that these share: each by its mean share.

    An error that only one recording has is left to the fit's own scatter.
    """
    found: dict[str, list[ForceError]] = {}
    for some, force_N in zip(errors, forces_N.tolist(), strict=True):
        for one in some:
            if one.of is not None and not one.passing and force_N != 0.0:
                share = one.share + one.shift_N / force_N
                moved = replace(one, share=share / len(forces_N), shift_N=0.0)
                found.setdefault(one.of, []).append(moved)
    return [
        replace(some[0], share=float(np.sum([one.share for one in some])))
        for some in found.values()
    ]
