"""A feed axis whose simulation has the same laws: Coulomb, viscous, inertia, on some axes weight.

Current A, position mm, speed mm/s. All ranges are *chosen*; noise as in ``machines.axis.axes``,
whose docstring says which real axis its ranges surround.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from autodb.proofs.cases.base.disturbance import ChannelNoise
from autodb.proofs.cases.base.moves import Array, Moves, log_uniform

STATED_MM_S = 150.0  # speed at which the viscous share is 1
Law = Callable[[Array], Array]


@dataclass(frozen=True)
class CaseAxis:
    """Sizes and laws of an axis, A; ``scale_A`` is its Coulomb friction as it was drawn.

    ``direction``: velocity to -1..1, 0 at standstill; ``rise``: speed >= 0 to the viscous share.
    """

    scale_A: float
    coulomb_A: float
    direction: Law
    viscous_A: float
    rise: Law
    inertia_A_s2_mm: float
    weight_A: float
    weighs: bool  # whether it has weight, of whatever size

    def parts(self, moves: Moves) -> dict[str, Array]:
        """Contributions (n,) of the terms that this axis has, by their identifiers."""
        way = self.direction(moves.v)
        parts = {
            "coulomb": self.coulomb_A * way,
            "viscous": self.viscous_A * way * self.rise(np.abs(moves.v)),
            "inertia": self.inertia_A_s2_mm * moves.a,
        }
        if self.weighs:
            parts["gravity"] = np.full_like(moves.t, self.weight_A)
        return parts


def draw_machine(rng: np.random.Generator) -> CaseAxis:
    """An axis, with weight on every second one."""
    scale_A = log_uniform(rng, 0.25, 1.5)
    weight_A = float(rng.choice([-1.0, 1.0])) * log_uniform(rng, 0.3, 2.0)
    return CaseAxis(
        scale_A=scale_A,
        coulomb_A=scale_A,
        direction=_direction(rng),
        viscous_A=scale_A * log_uniform(rng, 0.15, 0.8),
        rise=_rise(rng),
        inertia_A_s2_mm=log_uniform(rng, 0.0002, 0.0012),
        weight_A=weight_A,
        weighs=bool(rng.random() < 0.5),
    )


def draw_disturbance(rng: np.random.Generator, scale_A: float) -> ChannelNoise:
    """Noise of sd 0.03 to 0.13 of the scale, correlation 0 to 0.99; on a fourth partly white."""
    sd, rho = scale_A * log_uniform(rng, 0.03, 0.13), 1.0 - log_uniform(rng, 0.01, 1.0)
    share = rng.uniform(0.3, 0.9) if rng.random() < 0.25 else 0.0
    return ChannelNoise(float(sd * np.sqrt(1.0 - share)), rho, float(sd * np.sqrt(share)))


def _direction(rng: np.random.Generator) -> Law:
    """Reverse smoothly over 0.05 to 0.5 mm/s: hyperbolic tangent, arc tangent, or algebraic."""
    width = log_uniform(rng, 0.05, 0.5)
    laws: tuple[Law, ...] = (
        lambda v: np.tanh(v / width),
        lambda v: np.arctan(v / width) / (0.5 * np.pi),
        lambda v: v / np.hypot(v, width),
    )
    return laws[rng.integers(len(laws))]


def _rise(rng: np.random.Generator) -> Law:
    """Viscous share: straight, or bending down (inverse hyperbolic sine, saturating)."""
    bend = log_uniform(rng, 40.0, 300.0)
    laws: tuple[Law, ...] = (
        lambda speed: speed / STATED_MM_S,
        lambda speed: np.arcsinh(speed / bend) / np.arcsinh(STATED_MM_S / bend),
        lambda speed: np.expm1(-speed / bend) / np.expm1(-STATED_MM_S / bend),
    )
    return laws[rng.integers(len(laws))]
