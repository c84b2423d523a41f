"""What can be known of a case at best: the generator's own forms, its true noise, least squares.

The oracle knows every form that could be hidden and the noise' size and correlation; sizes are
unknown to it, and of what is not hidden the shapes.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.cases.base.case import Case, Rival, Yardstick

Array = NDArray[np.float64]
Single = NDArray[np.float32]
BEAM = 8
SEEN = 1e-6  # share of a column's norm that must be left beside own columns for it to count
SURE = 20.0


@dataclass(frozen=True)
class OracleVerdict:
    """``margin``: 2 (log L of the true set - that of the best wrong set), None of nothing hidden.

    ``recovery``: rms error of the true set's fit over that of the simulation, None without error.
    """

    margin: float | None
    recovery: float | None

    @property
    def decidable(self) -> bool:
        """Say whether the truth stands out from every other explanation."""
        return self.margin is None or self.margin > SURE


@dataclass(frozen=True)
class RivalRows:
    """A rival in whitened rows, beside own columns: orthonormal rows (k, m)."""

    term: str
    rows: Single


def oracle_verdict(case: Case) -> OracleVerdict:
    """Judge a case.

    Wrong sets have at most as many terms as the true one, each term once, at any shape of the
    grid, a true one also at its true shape; sizes and own terms are free, so a mistuned simulation
    costs nothing. They are searched term by term, going on from the BEAM best sets of different
    terms; a fit is linear, so a gain is a projection. The nothing-at-all is one of them.
    """
    if not case.hidden:
        return OracleVerdict(None, oracle_recovery(case))
    yardstick = Yardstick.beside(case.own, case.whitened)
    target = yardstick.left((case.measured - case.simulated)[None])[0].astype(np.float32)
    parts = [Rival(one.term, one.part[None]) for one in case.hidden]
    true = _orthonormal(yardstick.left(np.array([one.part for one in case.hidden])), 0.0)
    gained = float(np.sum((true @ target).astype(np.float64) ** 2))
    blocks = list(_blocks(case, yardstick, [*parts, *case.rivals()]))
    best = _best_wrong(blocks, target, case.terms, most=len(case.hidden))
    return OracleVerdict(gained - best, oracle_recovery(case))


def oracle_recovery(case: Case) -> float | None:
    """Error that is left when own columns and the true parts are fitted, as a share."""
    before = oracle_rms(case.simulated - case.truth)
    if before == 0.0:
        return None
    acting = [one.part for one in case.hidden if np.any(one.part)]
    columns = np.array([*case.own, *acting])
    white = case.whitened(columns).reshape(len(columns), -1)
    scale = np.linalg.norm(white, axis=1)
    target = case.whitened(case.measured - case.simulated).ravel()
    sizes = np.linalg.lstsq((white / scale[:, None]).T, target, rcond=None)[0] / scale
    corrected = case.simulated + np.tensordot(sizes, columns, axes=1)
    return oracle_rms(corrected - case.truth) / before


def oracle_rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def _blocks(case: Case, yardstick: Yardstick, rivals: Iterable[Rival]) -> Iterable[RivalRows]:
    for rival in (one for one in rivals if len(one.columns)):
        whole = np.linalg.norm(case.whitened(rival.columns).reshape(len(rival.columns), -1))
        rows = _orthonormal(yardstick.left(rival.columns), SEEN * float(whole))
        if len(rows):
            yield RivalRows(rival.term, rows)


def _orthonormal(rows: Array, least: float) -> Single:
    """Orthonormal rows that span those given, less those with a norm of ``least`` or smaller."""
    kept = rows[np.linalg.norm(rows, axis=1) > least]
    q, r = np.linalg.qr((kept / np.linalg.norm(kept, axis=1)[:, None]).T)
    return np.asarray(q[:, np.abs(np.diag(r)) > SEEN].T, dtype=np.float32)


def _best_wrong(
    blocks: list[RivalRows], target: Single, truth: frozenset[str], *, most: int
) -> float:
    """Return the largest gain of a set of terms other than the truth."""
    seen = [(block.rows @ target).astype(np.float64) for block in blocks]
    every = np.concatenate([block.rows for block in blocks])
    ends = np.cumsum([len(block.rows) for block in blocks])[:-1]
    best = 0.0
    beam: dict[frozenset[str], tuple[float, Single]] = {
        frozenset(): (0.0, np.zeros((0, target.size), dtype=np.float32))
    }
    for _ in range(most):
        found: dict[frozenset[str], tuple[float, Single, RivalRows]] = {}
        for terms, (gain, basis) in beam.items():
            inside = np.split((every @ basis.T).astype(np.float64), ends)
            held = (basis @ target).astype(np.float64)
            for block, own, shared in zip(blocks, seen, inside, strict=True):
                wider = terms | {block.term}
                more = gain + _gain(own - shared @ held, shared)
                if block.term not in terms and more > found.get(wider, (-1.0,))[0]:
                    found[wider] = more, basis, block
        best = max([best, *(gain for terms, (gain, *_) in found.items() if terms != truth)])
        kept = sorted(found.items(), key=lambda item: -item[1][0])[:BEAM]
        beam = {terms: (gain, _joined(basis, block.rows)) for terms, (gain, basis, block) in kept}
    return best


def _gain(left: Array, shared: Array) -> float:
    """Gain of a block beside a basis, z' (1 - s s')^-1 z; s is what it shares with the basis."""
    if not shared.shape[1]:
        return float(left @ left)
    values, vectors = np.linalg.eigh(np.eye(len(left)) - shared @ shared.T)
    own = values > SEEN**0.5
    return float(np.sum((vectors[:, own].T @ left) ** 2 / values[own]))


def _joined(basis: Single, rows: Single) -> Single:
    left = rows - (rows @ basis.T) @ basis
    return np.concatenate([basis, _orthonormal(left.astype(np.float64), SEEN**0.5)])
