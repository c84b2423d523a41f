"""A fleet of machines that cut the same materials with the same tools, each a little otherwise.

Around each material's numbers (as ``power_pairs`` draws them) a tool moves those of the
chip by 8 % and of ploughing by 20 %, a machine (its coolant, its bars, its runout) a pair by 2 %;
all chosen. The gains of a machine's calibrations are off by 5 % a component, common to all that it
cuts, and their scatter and sensing are those of power pairs.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.power_pairs import (
    GAIN,
    ExpectedForces,
    PowerPair,
    draw_power_pair,
)

Array = NDArray[np.float64]

CHIP_SHARE, PLOUGH_SHARE = 0.08, 0.2
MACHINE_SHARE = 0.02
OF_CHIP = ("tangential", "thrust")


@dataclass(frozen=True)
class Fleet:
    """Pairs of ``materials`` with ``tools`` as a machine without errors cuts them, by place."""

    materials: tuple[str, ...]
    tools: tuple[str, ...]
    pairs: dict[tuple[str, str], PowerPair]


def draw_fleet(rng: np.random.Generator, *, materials: int, tools: int) -> Fleet:
    """Draw materials, and tools for each; every tool has one geometry for all materials."""
    names = (
        tuple(f"material {k}" for k in range(materials)),
        tuple(f"tool {k}" for k in range(tools)),
    )
    geometry = [draw_power_pair(rng) for _ in names[1]]
    pairs = {}
    for material in names[0]:
        base = draw_power_pair(rng)
        for tool, shape in zip(names[1], geometry, strict=True):
            of_tool = replace(shape, material=base.material, law=_moved(rng, base.law),
                              plough_mm=base.plough_mm, softening=base.softening,
                              along=base.along, gains=np.ones(4))  # fmt: skip
            pairs[material, tool] = of_tool
    return Fleet(*names, pairs)


def _moved(rng: np.random.Generator, law: ExpectedForces) -> ExpectedForces:
    shares = {
        name: CHIP_SHARE if name in OF_CHIP else PLOUGH_SHARE if name.startswith("plough") else 0.0
        for name in vars(law)
    }
    return ExpectedForces(
        **{n: v * math.exp(shares[n] * rng.standard_normal()) for n, v in vars(law).items()}
    )


def on_machine(
    rng: np.random.Generator, fleet: Fleet, shared: Sequence[tuple[str, str]], *, gain: float = 1.0
) -> dict[tuple[str, str], PowerPair]:
    """Return a machine's pairs of the fleet's; ``gain``: what its calibration is off by beside."""
    gains = gain * (1.0 + GAIN * rng.standard_normal(4))
    made = {}
    for key in shared:
        pair = fleet.pairs[key]
        sizes = {
            name: value * math.exp(MACHINE_SHARE * rng.standard_normal())
            for name, value in vars(pair.law).items()
            if not name.startswith("exponent")
        }
        made[key] = replace(pair, law=replace(pair.law, **sizes), gains=gains)
    return made


def harder_pair(pair: PowerPair, factor: float) -> PowerPair:
    """Return a pair whose work is harder by a factor, chip and edge alike."""
    law = pair.law
    sizes = {n: factor * v for n, v in vars(law).items() if not n.startswith("exponent")}
    return replace(pair, law=replace(law, **sizes))
