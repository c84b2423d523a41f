"""Cuts of a power-law pair as a shop makes and senses them: to learn from, and to predict."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.power_pairs import (
    MATERIALS,
    SENSING_N,
    Factors,
    PowerMilledCut,
    PowerPair,
    TurnedCut,
    draw_power_pair,
    milled_N,
    scattered,
    turned_N,
)

Array = NDArray[np.float64]
Cut = TurnedCut | PowerMilledCut

KNOWN = 12
"""Cuts that are learnt from. Chosen: an afternoon's."""
TAPER_DEG = 20.0
TURNED_FEED_MM = (0.1, 0.4)
TURNED_DEPTH_MM = (0.8, 3.0)
TURNED_SPEED_M_MIN = (80.0, 250.0)
UNITS = ("N", "N", "N", "N·m")
COMPONENTS = ("force.x", "force.y", "force.z", "torque.spindle")


@dataclass(frozen=True)
class DrawnOperation:
    """An operation: how a cut of it is drawn, and what of its forces is judged.

    ``sensed``: components that the machine senses in it; a passive force is not among them.
    """

    name: str
    draw: Callable[[np.random.Generator, PowerPair], Cut]
    sensed: tuple[int, ...]
    judged: tuple[int, ...]


@dataclass(frozen=True)
class OperationFamily:
    """One operation that is learnt from, and those that are predicted, itself first."""

    known: DrawnOperation
    predicted: tuple[DrawnOperation, ...]


@dataclass(frozen=True)
class ReadCuts:
    """Cuts, and what was read of each (n, k) of ``sensed``."""

    operation: DrawnOperation
    cuts: tuple[Cut, ...]
    read: Array


def true_forces(pair: PowerPair, cut: Cut, factors: Factors = (1.0, 1.0)) -> Array:
    """Return force x, y, z and, of a mill, torque."""
    if isinstance(cut, TurnedCut):
        return turned_N(pair, cut, factors)
    return milled_N(pair, cut, factors)


def sensing(pair: PowerPair) -> Array:
    """Return the sd of sensing by component; of torque: the tangential force's at the rim."""
    return np.array([*SENSING_N, SENSING_N[1] * 0.5 * pair.diameter_mm / 1000.0])


def draw_read_cuts(
    rng: np.random.Generator, pair: PowerPair, operation: DrawnOperation, count: int
) -> ReadCuts:
    """Draw cuts, make them and read what the machine senses of them."""
    cuts = tuple(operation.draw(rng, pair) for _ in range(count))
    return made(rng, pair, operation, cuts)


def made(
    rng: np.random.Generator, pair: PowerPair, operation: DrawnOperation, cuts: tuple[Cut, ...]
) -> ReadCuts:
    """Make cuts and read what the machine senses of them."""
    real = np.array([true_forces(pair, cut, scattered(rng)) for cut in cuts])[
        :, list(operation.sensed)
    ]
    gains, noise = pair.gains[list(operation.sensed)], sensing(pair)[list(operation.sensed)]
    return ReadCuts(operation, cuts, real * gains + noise * rng.standard_normal(real.shape))


def draw_pair(seed: int) -> tuple[np.random.Generator, PowerPair]:
    """Return a seed's pair, and the generator for its cuts."""
    rng = np.random.default_rng(seed)
    return rng, draw_power_pair(rng)


def _turned(inward_deg: float) -> Callable[[np.random.Generator, PowerPair], TurnedCut]:
    def one(rng: np.random.Generator, _: PowerPair) -> TurnedCut:
        return TurnedCut(
            feed_mm=float(rng.uniform(*TURNED_FEED_MM)),
            depth_mm=float(rng.uniform(*TURNED_DEPTH_MM)),
            speed_m_min=float(rng.uniform(*TURNED_SPEED_M_MIN)),
            inward_deg=inward_deg,
        )

    return one


def _milled(
    arc: Callable[[float], tuple[float, float]],
) -> Callable[[np.random.Generator, PowerPair], PowerMilledCut]:
    def one(rng: np.random.Generator, pair: PowerPair) -> PowerMilledCut:
        speed = float(rng.uniform(80.0, 200.0))
        begins, ends = arc(float(np.degrees(np.arccos(1.0 - 2.0 * rng.uniform(0.1, 0.6)))))
        return PowerMilledCut(
            feed_mm=float(rng.uniform(0.03, 0.12)),
            depth_mm=float(rng.uniform(1.0, 4.0)),
            speed_rpm=speed * 1000.0 / (np.pi * pair.diameter_mm),
            begins_deg=begins,
            ends_deg=ends,
        )

    return one


TURN = DrawnOperation("turn", _turned(0.0), sensed=(1, 2), judged=(0, 1, 2))
FACE = DrawnOperation("face", _turned(90.0), sensed=(0, 1), judged=(0, 1, 2))
TAPER = DrawnOperation("taper", _turned(TAPER_DEG), sensed=(0, 1, 2), judged=(0, 1, 2))
SLOT = DrawnOperation(
    "slot", _milled(lambda _: (0.0, 180.0)), sensed=(0, 1, 3), judged=(0, 1, 2, 3)
)
UP = DrawnOperation(
    "side-up", _milled(lambda arc: (0.0, arc)), sensed=(0, 1, 3), judged=(0, 1, 2, 3)
)
DOWN = DrawnOperation(
    "side-down", _milled(lambda arc: (180.0 - arc, 180.0)), sensed=(0, 1, 3), judged=(0, 1, 2, 3)
)
FAMILIES = (OperationFamily(TURN, (TURN, FACE, TAPER)), OperationFamily(SLOT, (SLOT, UP, DOWN)))


def as_expected(material: str) -> PowerPair:
    """Return the pair that a shop expects of a material, nothing drawn."""
    return PowerPair(
        material, MATERIALS[material], plough_mm=0.03, softening=0.0, along=0.45, gains=np.ones(4)
    )


def number_of_cuts(cuts: Sequence[Cut], name: str) -> Array:
    """Return a number of every cut (n,)."""
    return np.array([getattr(cut, name) for cut in cuts])
