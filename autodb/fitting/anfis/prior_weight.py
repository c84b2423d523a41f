"""How much the priors weigh against the rows: as much as the noise says, found from the rows.

A normal prior of variance τ² on what the consequents are off the plane is a ridge σ²/τ², σ² the
variance of the noise. Both follow from the rows by MacKay's fixed point (1992, Neural Computation
4:415, section 4): with G = ΦᵀΦ and γ = tr(G (G + λ1)⁻¹) consequents that the rows determine,

    σ² = |residual|²/(n − γ),    τ² = |consequents|²/γ,    λ = σ²/τ².

Rows without noise so get next to no ridge, and noisy ones planes no wilder than they support.
The premises' prior is not estimated: one unit in the logarithm of a width or slope and half the
training range for a centre, hence a leash σ², at least LEAST_NOISE.
"""

from dataclasses import replace

import numpy as np

from autodb.fitting.anfis.premises import Premises, rule_columns
from autodb.fitting.anfis.standardised import LearnerRows
from autodb.fitting.anfis.sums import consequent_sums

ROUNDS = 2000
SETTLED = 1e-11
LEAST_RIDGE, MOST_RIDGE = 1e-12, 1e2
"""For each row: what keeps ΦᵀΦ + λ1 invertible in double precision, and the plane alone."""
LEAST_NOISE = 1e-6
"""Variance of the noise that the leash takes for granted, of the output's own: 0.1 % of its spread.
Chosen: rows without noise leave premises open that double precision cannot settle."""


def rows_weighed(rows: LearnerRows, premises: Premises) -> LearnerRows:
    """Return the rows with the weights that they imply at these premises."""
    tallied = consequent_sums(rule_columns(premises, rows.x), rows.left)
    size, vectors = np.linalg.eigh(tallied.gram)
    size, seen = np.maximum(size, 0.0), vectors.T @ tallied.right
    low, high = LEAST_RIDGE * tallied.rows, MOST_RIDGE * tallied.rows
    ridge, noise = float(np.sqrt(low * high)) * 1e-3, 0.0
    for _ in range(ROUNDS):
        found = seen / (size + ridge)
        determined = float(np.sum(size / (size + ridge)))
        left = tallied.total - 2.0 * float(seen @ found) + float(size @ found**2)
        noise = max(left, 0.0) / max(tallied.rows - determined, 1.0)
        spread = float(found @ found) / max(determined, 1e-300)
        before, ridge = ridge, float(np.clip(noise / max(spread, 1e-300), low, high))
        if abs(np.log(ridge / before)) < SETTLED:
            break
    return replace(rows, ridge=ridge, leash=max(noise, LEAST_NOISE))
