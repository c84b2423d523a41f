"""Whether the gain of one sensing axis has drifted: what several pairs share, told from their own.

Of every cut the logarithm of its sensed force over the expected one is known, for each component
sensed. Three accounts of how these move from recording to recording are compared with none:

    axis   one component of every pair, from a recording on, by one share, whatever the edge's age
    pair   one pair, from a recording on, each component by its own share: its material, its edges
    both   every component of every pair, each by its share: coolant, all work, or both axes

Where every component shifts, no axis is named.
"""

from dataclasses import dataclass

import numpy as np

from autodb.pairs.changes.shared_shifts import (
    AFTER,
    PAIRS,
    Account,
    Fit,
    SensedShares,
    ShareCells,
    accounts_of,
    cells_of,
    fitted,
)

BEATS = 3.0
"""Log score by which an account must beat those without it. Chosen: odds of 20."""
CLEAR = 3.0
"""Standard deviations that a shift must be."""
HALF = 0.5
"""Of one component's shift, what others may shift by and it is that one's. Chosen."""
APART = 2.0
"""Standard deviations by which components shift apart where only one does."""
LEAST = 0.03
"""Smaller shares are within what calibrations are good for. Chosen."""
MOST = 3
"""Accounts that are put together at most."""


@dataclass(frozen=True)
class GainDrift:
    """One component of ``pairs`` reads by a share too much ``since`` a recording, with its sd.

    ``others``: other accounts that are not ruled out (of OTHERS); ``probability`` of this one.
    """

    component: int
    since: int
    share: float
    sd: float
    pairs: tuple[int, ...]
    others: tuple[str, ...]
    probability: float


OTHERS = ("pair", "both")


def drifted_gain(readings: SensedShares) -> GainDrift | None:
    """Return the gain that has drifted; None where no account of one axis is clearly the best."""
    cells = cells_of(readings)
    if cells is None:
        return None
    found = _selected(cells)
    axes = [one for one in found if one.kind == "axis"]
    if not axes:
        return None
    account, rest = axes[0], [one for one in found if one is not axes[0]]
    fit = fitted(cells, found)
    at = found.index(account)
    column = sum(one.columns(cells).shape[1] for one in found[:at])
    share, sd = float(fit.shift[column]), _sd(cells, account, fit, column)
    if abs(share) < max(LEAST, CLEAR * sd) or not _alone(cells, found, fit, account.which):
        return None
    pairs = _sharing(cells, account, fit, share)
    if len(pairs) < PAIRS:
        return None
    rivals = _rivals(cells, rest, account)
    odds = sum(float(np.exp(score - fit.score)) for score in rivals.values())
    if any(score >= fit.score for score in rivals.values()):
        return None
    return GainDrift(
        component=account.which,
        since=account.since,
        share=share,
        sd=sd,
        pairs=pairs,
        others=tuple(k for k in OTHERS if k in rivals and fit.score - rivals[k] < BEATS),
        probability=1.0 / (1.0 + odds),
    )


def _selected(cells: ShareCells) -> list[Account]:
    """Return the accounts that predict cells left out, the best first, one after the other."""
    found: list[Account] = []
    score = fitted(cells, found).score
    every = list(accounts_of(cells))
    while len(found) < MOST:
        known = {(one.kind, one.which) for one in found}
        rest = [one for one in every if (one.kind, one.which) not in known]
        tried = [(fitted(cells, [*found, one]).score, k) for k, one in enumerate(rest)]
        best, k = max(tried, default=(-np.inf, 0))
        if best < score + BEATS:
            break
        axes = [one for one in tried if rest[one[1]].kind == "axis"]
        if rest[k].kind == "both" and axes and max(axes)[0] > best - BEATS:
            best, k = max(axes)  # the plainer account, unless the other is clearly the better one
        found.append(rest[k])
        score = best
    return found


def _rivals(cells: ShareCells, rest: list[Account], axis: Account) -> dict[str, float]:
    """Return the best score of each kind of account in place of an axis' shift, beside ``rest``.

    That of all components is none where the others clearly shift by less: it then says the same.
    """
    scores = {"none": fitted(cells, rest).score}
    for one in accounts_of(cells):
        if one.kind == "axis":
            continue
        fit = fitted(cells, [one, *rest])
        if one.kind == "both" and _shift_apart(cells, fit, axis.which):
            continue
        scores[one.kind] = max(fit.score, scores.get(one.kind, -np.inf))
    return scores


def _alone(cells: ShareCells, accounts: list[Account], fit: Fit, component: int) -> bool:
    """Say whether what all pairs share of other components, in the end, is under half as much."""
    total = dict.fromkeys(cells.component.tolist(), 0.0)
    column = 0
    for one in accounts:
        which = [one.which] if one.kind == "axis" else sorted(total)
        for k, name in enumerate(which):
            total[name] += float(fit.shift[column + k]) if one.kind != "pair" else 0.0
        column += len(which)
    own = abs(total.pop(component))
    return all(abs(other) < HALF * own for other in total.values())


def _shift_apart(cells: ShareCells, fit: Fit, component: int) -> bool:
    """Say whether a component clearly shifts by more than every other, in a fit of all of them."""
    own = int(np.searchsorted(np.unique(cells.component), component))
    count = len(np.unique(cells.component))
    for other in set(range(count)) - {own}:
        apart = np.zeros(len(fit.shift))
        apart[own], apart[other] = 1.0, -1.0
        sd = float(np.sqrt(apart @ fit.covariance @ apart))
        if abs(apart @ fit.shift) < APART * sd or abs(fit.shift[other]) > abs(fit.shift[own]):
            return False
    return True


def _sd(cells: ShareCells, account: Account, fit: Fit, column: int) -> float:
    """Return the sd of an axis' shift: of its cells, and of what its days differ by."""
    own = cells.component == account.which
    days = np.unique(cells.recording[own])
    left = np.array([np.median(fit.residual[own & (cells.recording == day)]) for day in days])
    before = days < account.since
    each = float(np.sum(left**2)) / max(len(days) - 2, 1)
    of_days = each * (1.0 / max(before.sum(), 1) + 1.0 / max((~before).sum(), 1))
    return float(np.sqrt(fit.covariance[column, column] + of_days))


def _sharing(cells: ShareCells, account: Account, fit: Fit, share: float) -> tuple[int, ...]:
    """Return the pairs whose own cells show the shift: nearer to it than to none."""
    come = account.columns(cells)[:, 0]
    found = []
    for pair in np.unique(cells.pair):
        rows = (cells.pair == pair) & (come > 0.0)
        own = [] if rows.sum() < AFTER else fit.residual[rows] / come[rows] / share
        if len(own) and float(np.median(own)) > -0.5:
            found.append(int(pair))
    return tuple(found)
