"""Forces of an end mill on its tool: orders of the spindle's revolution, from chip and edge forces.

Tool and work of P0 section 2.1: four teeth, diameter 10 mm, helix 38 and 35 degrees, C45 steel. The
force coefficients are *chosen* so that the ramp of P0's Table 2 has about its peak forces (206 N
normal to the feed, 116 N along it); they are no material constants. Angles as in the contract: from
the normal of the feed towards the feed.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.process import Array

Complex = NDArray[np.complex128]

TEETH, RADIUS_MM = 4, 5.0  # P0 section 2.1
HELIX_DEG = (38.0, 35.0, 38.0, 35.0)  # P0 section 2.1: variable helix; which tooth has which chosen
ORDERS = 12  # of the revolution: three of tooth passing
GRID, SLICES = 720, 12
DRILL_N = 55.0  # axial force of plunging at the feed of the pockets; chosen


@dataclass(frozen=True)
class TeethLaw:
    """What a work's teeth take: of the chip N/mm2 and of the edge N/mm, tangential, radial, axial.

    An edge pushes in no axial direction.
    """

    name: str
    chip_N_mm2: tuple[float, float, float]
    edge_N_mm: tuple[float, float]


C45 = TeethLaw("C45", (2150.0, 850.0, 300.0), (20.0, 17.0))  # chosen
ALUMINIUM = TeethLaw("a softer work", (800.0, 220.0, 90.0), (9.0, 5.0))  # chosen: of another ratio
STRONGER = TeethLaw("a stronger work", (2700.0, 1300.0, 420.0), (28.0, 30.0))  # chosen: likewise


@dataclass(frozen=True)
class MillEngagement:
    """How a cut's tool is engaged: depth, width and feed per tooth mm, up or down, run-out mm."""

    depth_mm: float
    width_mm: float
    feed_mm: float
    up: bool
    runout_mm: float
    runout_rad: float
    work: TeethLaw = C45

    def limits(self) -> tuple[float, float]:
        """Angles of entry and exit."""
        covered = math.acos(1.0 - self.width_mm / RADIUS_MM)
        return (0.0, covered) if self.up else (math.pi - covered, math.pi)


def orders(cut: MillEngagement) -> Complex:
    """Fourier coefficients (3, ORDERS + 1) of the force along feed, normal, axis over a revolution.

    Force(theta) = Re sum c_k exp(i k theta). Chips are h = f sin(phi), and what the tooth runs out
    more than the one before; thickness below 0 cuts nothing.
    """
    theta = 2.0 * math.pi * np.arange(GRID) / GRID
    low, high = cut.limits()
    total = np.zeros((3, GRID))
    out = cut.runout_mm * np.cos(2.0 * math.pi * np.arange(TEETH) / TEETH + cut.runout_rad)
    for tooth in range(TEETH):
        for height in (np.arange(SLICES) + 0.5) * cut.depth_mm / SLICES:
            lag = 2.0 * math.pi * tooth / TEETH
            lag += height * math.tan(math.radians(HELIX_DEG[tooth])) / RADIUS_MM
            phi = (theta - lag) % (2.0 * math.pi)
            chip = cut.feed_mm * np.sin(phi) + out[tooth] - out[tooth - 1]
            in_cut = (phi >= low) & (phi <= high) & (chip > 0.0)
            total += _of_tooth(cut.work, phi, chip) * (in_cut * cut.depth_mm / SLICES)
    found = np.fft.rfft(total, axis=1)[:, : ORDERS + 1] / GRID
    found[:, 1:] *= 2.0
    return np.asarray(found, dtype=np.complex128)


def _of_tooth(work: TeethLaw, phi: Array, chip: Array) -> Array:
    """Force a mm of depth (3, n): F_x = -F_t cos - F_r sin, F_y = F_t sin - F_r cos."""
    tangential = work.chip_N_mm2[0] * chip + work.edge_N_mm[0]
    radial = work.chip_N_mm2[1] * chip + work.edge_N_mm[1]
    return np.array(
        [
            -tangential * np.cos(phi) - radial * np.sin(phi),
            tangential * np.sin(phi) - radial * np.cos(phi),
            work.chip_N_mm2[2] * chip,
        ]
    )


def waves(coefficients: Complex, theta: Array, gain: Complex) -> Array:
    """The force (3, n) at angles (n,) of the spindle, each order (ORDERS + 1,) through a gain."""
    turned = np.exp(1j * np.multiply.outer(np.arange(ORDERS + 1), theta))
    return np.asarray(((coefficients * gain) @ turned).real)
