"""The rules' if-parts: which fuzzy set of each input a rule asks for, and how much it then counts.

Inputs are scaled here (``autodb.fitting.anfis.standardised``): the training range of each is −1 …
1.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, product

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.anfis.memberships import BELL, HALF_HEIGHT, NARROWEST, Membership
from autodb.fitting.anfis.standardised import scaling

Array = NDArray[np.float64]

FUZZINESS = 2.0
"""Exponent of fuzzy c-means (Bezdek 1981, the usual 2)."""
CLUSTER_ROUNDS = 1000
SMALLEST_CHANGE = 1e-6
NEARBY = float(np.sqrt(2.0))
"""Factor between starts: widths and slopes are searched from several, minima being many."""


@dataclass(frozen=True)
class Premises:
    """Fuzzy sets (m_j, count) of every input, and the set of each input that each rule asks for.

    ``rules`` (R, d) holds indices of sets.
    """

    membership: Membership
    sets: tuple[Array, ...]
    rules: NDArray[np.intp]

    @property
    def vector(self) -> Array:
        """Every parameter of every set in one row, (q,)."""
        return np.concatenate([one.ravel() for one in self.sets])

    def at(self, vector: Array) -> "Premises":
        """Return the same rules with other parameters (q,)."""
        ends = accumulate(one.size for one in self.sets)
        sets = tuple(
            vector[end - one.size : end].reshape(one.shape)
            for end, one in zip(ends, self.sets, strict=True)
        )
        return Premises(self.membership, sets, self.rules)


def premise_grid(counts: Sequence[int], membership: Membership = BELL) -> Premises:
    """Return every combination of ``counts`` (d,) sets of each input, equally spaced.

    Neighbouring sets cross at half height, as Jang (1993, section V) starts them; a single set
    lies in the middle and is as wide as the range.
    """
    sets = []
    for count in counts:
        centres = np.linspace(-1.0, 1.0, count) if count > 1 else np.zeros(1)
        half = 1.0 / max(count - 1, 1)
        sets.append(np.array([membership.around(float(c), half) for c in centres]))
    rules = np.array(list(product(*(range(count) for count in counts))), dtype=np.intp)
    return Premises(membership, tuple(sets), rules)


def clusters(inputs: Array, rules: int, membership: Membership = BELL, *, seed: int) -> Premises:
    """Return one rule for each of ``rules`` fuzzy clusters of the inputs (n, d).

    Fuzzy c-means (Bezdek 1981) on scaled inputs. A rule's sets are its own: centred where its
    cluster is, with the standard deviation of its members, weighted by their membership.
    """
    from skfuzzy import cmeans

    x = scaling(inputs, np.zeros(len(inputs))).inputs(inputs)
    began = np.random.default_rng(seed).random((rules, len(x)))
    began /= began.sum(axis=0)
    centres, degrees, *_ = cmeans(
        x.T, rules, FUZZINESS, SMALLEST_CHANGE, CLUSTER_ROUNDS, init=began
    )
    weights = degrees**FUZZINESS / np.sum(degrees**FUZZINESS, axis=1, keepdims=True)
    spread = np.sqrt(np.einsum("rn,rnj->rj", weights, (x[None] - centres[:, None]) ** 2))
    half = np.maximum(HALF_HEIGHT * spread, NARROWEST)
    order = np.lexsort(centres.T[::-1])  # the same clusters in the same order at every seed
    sets = tuple(
        np.array([membership.around(float(centres[r, j]), float(half[r, j])) for r in order])
        for j in range(x.shape[1])
    )
    own = np.repeat(np.arange(rules, dtype=np.intp)[:, None], x.shape[1], axis=1)
    return Premises(membership, sets, own)


def nearby(premises: Premises) -> tuple[Premises, ...]:
    """Return the premises, and the same with each kind of width or slope √2 times larger, smaller.

    Five starts of bells, three of Gaussians; the centres are those given.
    """
    count = premises.membership.count
    kind = np.arange(premises.vector.size) % count
    changed = [
        premises.at(premises.vector * np.where(kind == k, factor, 1.0))
        for k in range(count - 1)
        for factor in (NEARBY, 1.0 / NEARBY)
    ]
    return (premises, *changed)


def premise_limits(premises: Premises, x: Array) -> tuple[Array, Array]:
    """Return the lowest and highest parameters (q,) that scaled inputs (n, d) let be learned.

    No set is narrower, at half height, than the widest gap between neighbouring values of its
    input: what it does there no row could show.
    """
    low, high = [], []
    for j, sets in enumerate(premises.sets):
        gap = float(np.max(np.diff(np.unique(x[:, j]))))
        lowest = np.array(premises.membership.lowest)
        lowest[0] = max(lowest[0], premises.membership.around(0.0, gap)[0])
        low.append(np.tile(lowest, len(sets)))
        high.append(np.tile(premises.membership.highest, len(sets)))
    return np.concatenate(low), np.concatenate(high)


def shares(premises: Premises, x: Array) -> Array:
    """Return each rule's normalised firing strength (R, n) at scaled inputs (n, d); columns sum to
    1.

    Product of the memberships over their sum over all rules (Jang 1993, layers 2 and 3).
    """
    logarithm = np.zeros((len(premises.rules), len(x)))
    for j, sets in enumerate(premises.sets):
        logarithm += premises.membership.logarithm(x[:, j], sets)[premises.rules[:, j]]
    strength = np.exp(logarithm - logarithm.max(axis=0))
    return np.asarray(strength / strength.sum(axis=0))


def rule_columns(premises: Premises, x: Array) -> Array:
    """Return columns (n, R · (d + 1)): each rule's share times (1, x_1 … x_d), rule by rule.

    Times the consequents it is Jang's layers 4 and 5.
    """
    planes = np.vstack([np.ones(len(x)), x.T])
    columns = shares(premises, x)[:, None, :] * planes
    return np.ascontiguousarray(columns.reshape(-1, len(x)).T)


def input_slopes(premises: Premises, x: Array, along: int) -> Array:
    """Return d design / d x_along (n, R · (d + 1)): times the consequents, the output's slope."""
    share = shares(premises, x)
    sets, asked = premises.sets[along], premises.rules[:, along]
    own = -premises.membership.slopes(x[:, along], sets)[-1][asked]
    change = share * (own - np.sum(share * own, axis=0))
    planes = np.vstack([np.ones(len(x)), x.T])
    columns = change[:, None, :] * planes
    columns[:, 1 + along] += share
    return np.ascontiguousarray(columns.reshape(-1, len(x)).T)
