"""How far two accounts of a recording differ on something that follows it, and how that is said.

Their difference d there counts as far as the coefficients of either cannot take it up within what
the recording leaves them: with X the columns of both, Σ the covariance of their coefficients, all
rows white,

    minimise over δ:  |d − X δ|² + δᵀ Σ⁻¹ δ.

The minimum is 2·ln of the odds that it is expected to give. Source: Atkinson, Fedorov 1975
(experiments that discriminate between two models: the true one's lack of fit to the other); there
one model is true, here neither is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.search import CandidateSearch, FoundSet
from autodb.wording import significant, stored_msgid

Array = NDArray[np.float64]

SEPARATES = 20.0
"""2·ln of the odds that a trial must be expected to give: those from which on a rival is none."""
NEAREST = 2
"""Alternatives that a trial is looked for."""
LOOSEST = 1e-9
"""Share of the best held direction of the coefficients below which one counts as held so well: what
the recording does not hold at all is free elsewhere."""

TELLS = stored_msgid("{move}: there {one} and {other} would differ by up to {size}, {noise}.")
TELLS_IN = stored_msgid(
    "{move}: there {one} and {other} would differ by up to {size} in {channel}, {noise}."
)


@dataclass(frozen=True)
class Separation:
    """A trial and how far two accounts differ on it.

    ``odds``: 2·ln of those expected; ``distance``: rms over white rows in noise sds; ``peak`` in
    the channel's unit; ``words`` the trial in the imperative.
    """

    words: str
    odds: float
    distance: float
    peak: float


def held_coefficients(white: Array, right: Array, *, variance: float) -> tuple[Array, Array]:
    """Return coefficients (p,) of white columns (n, p) for rows (n,), and a root of their spread.

    root·rootᵀ (p, p) is their covariance where a white row has ``variance``.
    """
    norm = np.linalg.norm(white, axis=0)
    norm[norm == 0] = 1.0
    white = white / norm
    values, vectors = np.linalg.eigh(white.T @ white)
    there = values > LOOSEST * values[-1]
    along = np.where(there, vectors.T @ (white.T @ right) / np.where(there, values, 1.0), 0.0)
    spread = np.sqrt(variance / np.maximum(values, LOOSEST * values[-1]))
    return np.asarray(vectors @ along / norm), np.asarray(vectors * spread / norm[:, None])


def odds(free: Array, difference: Array) -> tuple[float, Array]:
    """Return 2·ln of the odds expected of a white difference (n,), and what the free take of it.

    ``free`` (n, q): white columns of both accounts times the roots of their covariances. What they
    take (q,) is worked out with all rows counted as one: only what the recording leaves open.
    """
    inner, along = free.T @ free, free.T @ difference
    one_each = np.eye(len(inner))
    found = float(difference @ difference - along @ np.linalg.solve(inner + one_each, along))
    taken = np.linalg.solve(inner + len(difference) * one_each, along)
    return max(0.0, found), np.asarray(taken)


def sentence(
    best: Separation, names: tuple[str, str], unit: str, noise: str, *, channel: str = ""
) -> str:
    """Return what to do, by how much the two would differ there, and what that compares with.

    ``channel``: in which of several.
    """
    said = TELLS_IN if channel else TELLS
    return said.format(
        move=best.words, one=names[0], other=names[1], noise=noise, channel=channel,
        size=f"{significant(best.peak, 2)} {unit}",
    )  # fmt: skip


def called(search: CandidateSearch, name: str, *, but: str) -> list[Candidate]:
    """Return the candidates of a term, but the one with a key."""
    return [s for s in search.candidates if s.term == name and s.key != but]


def stand_in(
    search: CandidateSearch, found: FoundSet, key: str, instead: Sequence[Candidate]
) -> tuple[FoundSet, Choice] | None:
    """Return the best set with one of some candidates in place of a found effect, and which."""
    others = found.without(key)
    offers = search.offers(others, instead) if instead else []
    if not offers:
        return None
    best = max(offers, key=lambda offer: offer.worth)
    return search.settled((*others, best.choice)), best.choice
