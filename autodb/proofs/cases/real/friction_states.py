"""Friction that remembers: how it rises after a reversal, and where play keeps it away."""

import numpy as np

from autodb.proofs.cases.real.real_axis import Array, RealAxis

STILL = 0.02
"""Share of the top speed below which an axis stands, for the moment of a reversal."""


def rising_after_reversals(axis: RealAxis, distance: float) -> Array:
    """Return friction (n,), −1 to 1, that rises over ``distance`` (mm) after each reversal.

    It is held at standstill. Source: Dahl 1968, the form whose slope falls off linearly:
    dz/dx = (1 − sgn(v)·z)/distance, fitted_sizes from row to row.
    """
    moved = np.diff(axis.position, prepend=axis.position[0])
    moved[np.abs(axis.v) < STILL * axis.top_speed] = 0.0
    kept = np.exp(-np.abs(moved) / max(distance, 1e-12))
    states = np.empty(len(axis))
    state = float(_first_direction(axis))
    for row, (step, share) in enumerate(zip(moved.tolist(), kept.tolist(), strict=True)):
        if step:
            towards = 1.0 if step > 0.0 else -1.0
            state = towards + (state - towards) * share
        states[row] = state
    return states


def gone_at_reversals(axis: RealAxis, distance: float) -> Array:
    """Return −sgn(v) (n,) within ``distance`` (mm) after each reversal, else 0."""
    sign = np.where(np.abs(axis.v) < STILL * axis.top_speed, 0.0, np.sign(axis.v))
    gone = np.zeros(len(axis))
    turned, before = -np.inf, float(_first_direction(axis))
    for row, (now, place) in enumerate(zip(sign.tolist(), axis.position.tolist(), strict=True)):
        if now and now != before:
            turned, before = place, now
        if abs(place - turned) < distance:
            gone[row] = -now
    return gone


def _first_direction(axis: RealAxis) -> float:
    moving = np.flatnonzero(np.abs(axis.v) >= STILL * axis.top_speed)
    return float(np.sign(axis.v[moving[0]])) if len(moving) else 1.0
