"""The nominal interval of a next cut's force: what the right law leaves open, fitted to the cuts.

The law of the generator, linear in its numbers about the truth, with the spreads that they are
drawn by as prior, all sizes of noise and the tool known:

    P = (Λ + Jᵀ S⁻¹ J)⁻¹    variance = g P gᵀ + scatter

J and g are derivatives of the readings and of the force by the numbers; S holds noise, what a cut
scatters by (one factor on what is along the cutting speed, one on what is across it: its components
share the latter), and the gain that all readings of a component share. It is the information bound
(Cramér and Rao, with a prior), so that no fit of the right law, least squares neither, does better
on average: it depends on no noise that was drawn.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.law_pairs import law_forces_N
from autodb.proofs.machines.lathe.power_pairs import TurnedCut
from autodb.proofs.machines.lathe.process import SCATTER_TANGENTIAL, SCATTER_THRUST
from autodb.proofs.runs.pairs.laws_case import LawsCase

Array = NDArray[np.float64]

STEP_OF_SPREAD = 1e-3
"""Step of a derivative, in spreads."""


def nominal_sd_N(case: LawsCase) -> Array:
    """Return the standard deviation (m, 3) of the next cut's force x, y, z that is nominal."""
    read = list(case.read)
    names = list(case.pair.spread)
    slopes = _slopes(case, names, case.cuts)[:, read].reshape(-1, len(names))
    noise = _noise(case)
    left = np.linalg.inv(np.eye(len(names)) + slopes.T @ np.linalg.solve(noise, slopes))
    asked = _slopes(case, names, case.asked)
    known = np.einsum("nci,ij,ncj->nc", asked, left, asked)
    scatter = np.sum(_scatter(case, case.asked) ** 2, axis=2)
    return np.asarray(np.sqrt(known + scatter))


def _slopes(case: LawsCase, names: list[str], cuts: tuple[TurnedCut, ...]) -> Array:
    """Return derivatives (n, 3, k) of forces by the numbers, each in spreads of it."""
    pair = case.pair

    def forces(name: str, by: float) -> Array:
        moved = {**pair.numbers, name: pair.numbers[name] + by * pair.spread[name]}
        return np.array([law_forces_N(pair, cut, numbers=moved) for cut in cuts])

    each = [forces(name, STEP_OF_SPREAD) - forces(name, -STEP_OF_SPREAD) for name in names]
    return np.stack(each, axis=-1) / (2.0 * STEP_OF_SPREAD)


def _scatter(case: LawsCase, cuts: tuple[TurnedCut, ...]) -> Array:
    """Return what one sd of either factor of a cut moves its forces by (n, 3, 2)."""
    pair = case.pair
    sds = ((1.0 + SCATTER_TANGENTIAL, 1.0), (1.0, 1.0 + SCATTER_THRUST))
    plain = np.array([law_forces_N(pair, cut) for cut in cuts])
    moved = [np.array([law_forces_N(pair, cut, sd) for cut in cuts]) - plain for sd in sds]
    return np.stack(moved, axis=-1)


def _noise(case: LawsCase) -> Array:
    """Return the covariance of the readings, cut by cut, the components of each beside another."""
    pair, read = case.pair, list(case.read)
    count, width = len(case.cuts), len(read)
    covariance = np.diag(np.tile(pair.noise_N[read] ** 2, count))
    for k, moved in enumerate(_scatter(case, case.cuts)[:, read]):
        rows = slice(k * width, (k + 1) * width)
        covariance[rows, rows] += moved @ moved.T
    forces = np.array([law_forces_N(pair, cut) for cut in case.cuts])[:, read]
    for c in range(width):
        gain = np.zeros_like(forces)
        gain[:, c] = pair.gain_share * forces[:, c]
        covariance += np.outer(gain.ravel(), gain.ravel())
    return covariance
