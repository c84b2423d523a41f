"""One virtual lathe's hidden truth, and the drawing of others like it.

Slopes and the X line are P1's Table 1, the noise its Table 2; the rest is *chosen*.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from autodb.proofs.machines.lathe.drives import FeedAxis, Spindle

GAIN_SPREAD = 0.15  # machine to machine, uniform +- this share
WORK_SPREAD = 0.04  # sd of the same pair's force machine to machine (assumed)
LOAD_LOSS = 1.22  # N on the screw per N at the tool near P1's repeated cut: friction, screw loss


@dataclass(frozen=True)
class Lathe:
    """One machine's hidden truth."""

    # X: F = 258 - 198.45 I (P1 Table 1), so weight - friction = 258 N at the tool
    x: FeedAxis = field(
        default_factory=lambda: FeedAxis(
            force_per_A_N=LOAD_LOSS * 198.45,
            friction_N=150.0,
            weight_N=150.0 + LOAD_LOSS * 258.0,
            noise_A=25.0 / 198.45,  # chosen for P1's RMSE of 29 N (Table 1)
            standing_A=0.90,
        )
    )
    z: FeedAxis = field(
        default_factory=lambda: FeedAxis(
            force_per_A_N=LOAD_LOSS * 215.9,  # P1 Table 1
            friction_N=380.0,
            weight_N=0.0,
            noise_A=math.sqrt(260.0) / 215.9,  # P1 Table 2, row 3: 580 - 320 N^2
            standing_A=0.35,
        )
    )
    spindle: Spindle = field(default_factory=Spindle)
    work_factor: float = 1.0  # the same cut's force on this machine over the pair's

    @classmethod
    def draw(cls, seed: int) -> "Lathe":
        """Another machine of the kind: gains +- 15 %, friction and weight 5 %, work factor 4 % sd.

        The sensing noise keeps its size in newtons, so in amperes it follows the gain.
        """
        rng = np.random.default_rng([seed, 1])
        nominal = cls()
        gain_x, gain_z, gain_s = 1.0 + GAIN_SPREAD * rng.uniform(-1.0, 1.0, 3)
        loads = 1.0 + 0.05 * rng.uniform(-1.0, 1.0, 3)
        spindle = nominal.spindle
        return cls(
            x=replace(
                nominal.x,
                force_per_A_N=float(nominal.x.force_per_A_N * gain_x),
                friction_N=float(nominal.x.friction_N * loads[0]),
                weight_N=float(nominal.x.weight_N * loads[1]),
                noise_A=float(nominal.x.noise_A / gain_x),
            ),
            z=replace(
                nominal.z,
                force_per_A_N=float(nominal.z.force_per_A_N * gain_z),
                friction_N=float(nominal.z.friction_N * loads[2]),
                noise_A=float(nominal.z.noise_A / gain_z),
            ),
            spindle=replace(
                spindle,
                torque_per_A_Nm=float(spindle.torque_per_A_Nm * gain_s),
                noise_A=float(spindle.noise_A / gain_s ** (1.0 / spindle.exponent)),
            ),
            work_factor=float(1.0 + WORK_SPREAD * rng.standard_normal()),
        )
