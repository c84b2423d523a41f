"""Readings as functions of a posterior's state: what is expected of them, and how it changes.

    y = (F(θ) + A(θ) α) (1 + C δ) + S δ + L(θ) λ + B L(θ) c

θ coordinates of the law, δ errors of calibrations and of dynamometers, α of what is assumed of the
cuts, λ of the law in an operation, c what a band of speeds changes and B how far cuts are in it,
each behind the other in the state. A gain is of the force at
what was found of a cut, not at what was assumed, which may be far from it.

In a band of cutting speeds the forces along and across the cutting speed change by a share each:

    F_c (1 + c_c b(v)),  F_p (1 + c_p b(v)),    b(v) = exp(-½ (ln(v/v_c)/w)²)

with b the bell of the term `built_up_edge`. c is learnt with the state, as errors of the law are.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.elements import (
    force_parts,
    joined_elements,
    linearised_forces,
    mean_speed_m_min,
)
from autodb.pairs.observed import (
    CHIP,
    Observed,
    PairCuts,
    chip_bends,
    grown_parts,
    growth,
)
from autodb.pairs.posterior import (
    BAND,
    CUT_SHARE,
    LAW_BENDS,
    OF_BENDS,
    OF_CARD,
    OF_GROWTH,
    OF_OPERATION,
    OWN,
    LawDiscrepancy,
    PairPosterior,
    Scatter,
    SpeedBand,
)
from autodb.terms.chip import built_up_edge

Array = NDArray[np.float64]

IN_OPERATION = OF_OPERATION, OF_GROWTH
FORCE = 2
"""Parts of a reading that are force; the third is a chip's thickness."""


@dataclass(frozen=True)
class Seen:
    """Readings (m,) at a state: their ``parts`` (m, 3), what errors of the law change (m, …), and
    what is expected.

    The first two with what is assumed as it was found to be.
    """

    parts: Array
    off: Array
    expected: Array


@dataclass(frozen=True)
class _LawPart:
    """Errors of the law: their ``place`` in the state, the share by which they act on readings (m,)
    and the ``columns`` of what errors of the law change.
    """

    place: slice
    inside: Array
    columns: slice


@dataclass(frozen=True)
class _Worked:
    """Readings as assumed, and, for each assumption, as if it were off by its sd (v + 1, m, …).

    ``off_slopes`` (m, p): of what the law's errors add to the first.
    """

    parts: Array
    off: Array
    slopes: Array | None
    off_slopes: Array | None


class Modelled:
    """Readings as functions of the state of a posterior that has met what they share."""

    def __init__(self, posterior: PairPosterior, observed: Observed) -> None:
        self.observed = observed
        self._off_law = posterior.off_law
        self._gains = np.zeros((len(observed.value), len(posterior.state.mean) - OWN))
        self._shifts = np.zeros_like(self._gains)
        begin = 0
        for one in observed.shared:
            columns = slice(begin, begin + len(one.covariance))
            place = _behind(posterior, one.key)
            self._gains[:, place] = observed.common[:, columns]
            if observed.shift is not None:
                self._shifts[:, place] = observed.shift[:, columns]
            begin = columns.stop
        self._keys = [one.key for one in observed.assumed]
        self._assumed = [_behind(posterior, key).start for key in self._keys]
        self._laws = [
            _LawPart(_behind(posterior, one.key), observed.within(name).astype(float), columns)
            for name in observed.operations
            for one, columns in zip(posterior.errors_in(name), IN_OPERATION, strict=True)
        ]
        self._bends = _behind(posterior, LAW_BENDS.key)
        cut = (~observed.within(OF_CARD)).astype(float)
        self._laws.append(_LawPart(self._bends, cut, OF_BENDS))
        band = posterior.terms.band
        self._inside = [] if band is None else [inside_band(one, band) for one in observed.cuts]
        if band is not None:
            inside = np.concatenate(self._inside)[observed.cut]
            self._laws.append(_LawPart(_behind(posterior, BAND), inside, slice(0, FORCE)))
        self._band = _behind(posterior, BAND) if band is not None else None
        self._law_of_batch = [
            np.concatenate([np.r_[_behind(posterior, error.key)] for error in errors])
            for errors in (posterior.errors_in(one.operation) for one in observed.cuts)
        ]
        several = [[one.elements, *(v.elements for v in one.variants)] for one in observed.cuts]
        self._joined = [joined_elements(one) for one in several]
        self._at = [_places(one, self._keys) for one in observed.cuts]
        self._shape = [(growth(e), chip_bends(e)) for e in self._joined]
        self._grown = self._of_readings([grown for grown, _ in self._shape])
        self._bent = self._of_readings([bent for _, bent in self._shape])[:, :, None, :]

    def _of_readings(self, values: list[Array]) -> Array:
        """Return values of batches and variants for each reading: (v + 1, m, …)."""
        apart = [_apart(one, at) for one, at in zip(values, self._at, strict=True)]
        return np.asarray(np.concatenate(apart, axis=1)[:, self.observed.cut])

    def seen(self, state: Array) -> Seen:
        """Return the readings at a state."""
        return self._seen(self._worked(state[:OWN]), state)

    def steep(self, state: Array) -> tuple[Seen, Array]:
        """Return the readings at a state and their derivatives (m, p) by it."""
        errors = state[OWN:]
        worked = self._worked(state[:OWN], self._off(state))
        assert worked.slopes is not None
        assert worked.off_slopes is not None
        found = errors[self._assumed]
        moved = (worked.slopes[1:] - worked.slopes[0]).reshape(len(found), worked.slopes[0].size)
        slopes = worked.slopes[0] + (found @ moved).reshape(worked.slopes.shape[1:])
        slopes *= (1.0 + self._gains @ errors)[:, None]
        whole = np.column_stack([slopes + worked.off_slopes, self._by_errors(worked, errors)])
        return self._seen(worked, state), whole

    def noise(self, seen: Seen, scatter: Scatter) -> Array:
        """Return the sd (m,): the sensor's, the law's from chip to chip, the repeated cut's."""
        own = own_variance(scatter, self._off_law, seen.off)
        return np.asarray(np.sqrt(self.observed.sd**2 + own))

    def _seen(self, worked: _Worked, state: Array) -> Seen:
        whole, errors = worked.parts.sum(axis=2), state[OWN:]
        beside = self._shifts @ errors
        for one in self._laws:
            beside += one.inside * (worked.off[0][:, one.columns] @ errors[one.place])

        assumed = errors[self._assumed]

        def found(values: Array) -> Array:
            moved = (values[1:] - values[0]).reshape(len(assumed), values[0].size)
            return np.asarray(values[0] + (assumed @ moved).reshape(values.shape[1:]))

        expected = found(whole) * (1.0 + self._gains @ errors) + beside
        return Seen(found(worked.parts), found(worked.off), expected)

    def _by_errors(self, worked: _Worked, errors: Array) -> Array:
        """Return what each error behind the law changes (m, k)."""
        whole, of_force = worked.parts.sum(axis=2), np.zeros_like(self._gains)
        of_force[:, self._assumed] = (whole[1:] - whole[0]).T
        moved = self._gains * (whole[0] + of_force @ errors)[:, None]
        moved += (1.0 + self._gains @ errors)[:, None] * of_force + self._shifts
        for one in self._laws:
            moved[:, one.place] += one.inside[:, None] * worked.off[0][:, one.columns]
        return np.asarray(moved)

    def _off(self, state: Array) -> list[Array]:
        """Return what the law is off by in each part of each batch's forces, with variants (n, 3).

        Of the variants nothing: what they add is worked out of the law as it is.
        """
        errors, found = state[OWN:], []
        for one, (grown, bent), law in zip(
            self.observed.cuts, self._shape, self._law_of_batch, strict=True
        ):
            off, own = np.zeros((len(grown), 3)), slice(one.elements.count)
            off[own] = errors[law][:3] + grown[own] @ errors[law][3:].reshape(3, 3)
            if one.operation != OF_CARD:
                off[own, :FORCE] += bent[own] @ errors[self._bends].reshape(FORCE, -1).T
            found.append(off)
        for off, inside in zip(found, self._inside, strict=False):
            off[: len(inside), :FORCE] += inside[:, None] * errors[self._band]
        return found

    def _worked(self, theta: Array, off: list[Array] | None = None) -> _Worked:
        """Return the readings as assumed and as if; forces of a batch and its variants at once.

        With slopes where it is given what the law is ``off`` by.
        """
        parts, slopes = [], []
        for k, (elements, at) in enumerate(zip(self._joined, self._at, strict=True)):
            if off is None:
                found = force_parts(theta, elements)
            else:
                _, found, by_law = linearised_forces(theta, elements, off[k])
                slopes.append(_apart(by_law, at))
            parts.append(_apart(found, at))
        return self._read(theta, np.concatenate(parts, axis=1), slopes)

    def _read(self, theta: Array, parts: Array, slopes: list[Array]) -> _Worked:
        """Return what readings are of parts of forces of cuts (v + 1, n, 5, 3), and of chips."""
        observed = self.observed
        force, quantity = observed.quantity != CHIP, observed.quantity % CHIP
        direct = np.where(force[:, None], parts[:, observed.cut, quantity], 0.0)
        bent = direct[..., :FORCE, None] * self._bent
        off = np.concatenate(
            [direct, grown_parts(direct, self._grown), bent.reshape(*bent.shape[:2], -1)], axis=-1
        )
        chips = np.zeros(off.shape[:2])
        steep = np.concatenate(slopes, axis=1)[:, observed.cut, quantity] if slopes else None
        if not force.all():
            for k, one in enumerate((observed, *map(observed.as_if, self._keys))):
                chips[k] = np.where(force, 0.0, one.chips_mm(theta)[observed.cut])
                if steep is not None:
                    steep[k, ~force] = 0.0
                    steep[k, ~force, :OWN] = one.chip_slopes(theta)[observed.cut[~force]]
        whole = np.dstack([off[..., :FORCE], chips])
        if steep is None:
            return _Worked(whole, off, None, None)
        return _Worked(whole, off, steep[..., :OWN], steep[0, :, OWN:])


def _places(cuts: PairCuts, keys: list[str]) -> list[int]:
    """Return which of a batch's elements hold: as assumed, and as if each of the keys were off."""
    own = [one.key for one in cuts.variants]
    return [0, *(1 + own.index(key) if key in own else 0 for key in keys)]


def _apart(values: Array, at: list[int]) -> Array:
    """Return values (v · n, …) of a batch's variants behind each other as (len(at), n, …)."""
    several = max(at) + 1
    return values.reshape(several, -1, *values.shape[1:])[at]


def own_variance(scatter: Scatter, law: LawDiscrepancy, off: Array) -> Array:
    """Return the variance (...,) that is one cut's own, of what errors of the law change (..., k).

    What repeats scatter by, and what the law is off from one chip to another.
    """
    share = np.array([*(scatter.share**2 + CUT_SHARE**2), law.cut_direction_rad**2])
    return np.asarray(off[..., : len(share)] ** 2 @ share)


def _behind(posterior: PairPosterior, key: str) -> slice:
    """Return where errors stand behind the law's coordinates."""
    columns = posterior.columns(key)
    return slice(columns.start - OWN, columns.stop - OWN)


def inside_band(cuts: PairCuts, band: SpeedBand) -> Array:
    """Return how far in a band cuts (n,) are: 1 in its middle, 0 far from it."""
    speed = mean_speed_m_min(cuts.elements)
    whole = built_up_edge(speed, change=1.0, centre_m_min=band.centre_m_min, width=band.width)
    return whole - 1.0


def moved_band(cuts: PairCuts, band: SpeedBand) -> Array:
    """Return what ln centre and width change in how far in a band cuts are: (n, 2)."""
    off = np.log(np.maximum(mean_speed_m_min(cuts.elements), 1e-9) / band.centre_m_min) / band.width
    inside = inside_band(cuts, band)
    return np.column_stack([inside * off / band.width, inside * off**2 / band.width])
