"""How forces answer to a tool that gives way: the chip is as thick as it moves off the surface.

An element of an edge whose tool moves by u towards the work cuts a chip thicker by n·u, n the
normal of the edge towards the work; what the tool had moved a tooth before is already gone. So

    dF = B (u(t) - u(t - T)),    B = sum over elements of dF/dh n^T

B (3, 3) in N/mm, of the force on the tool in machine axes. Of a mill the sum is the mean over a
turn, which is the zero-order term of Altintas and Budak 1995: with coefficients K_t and K_r K_t of
a plain edge B is their a K_t N/(4 pi) [alpha]. Beyond them it has the corner, and the direction up
the tool's axis.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.elements import Elements, element_forces, summed_forces

Array = NDArray[np.float64]

STEP = 1e-3
"""Share of a chip's thickness over which its force's slope is taken. Chosen: within 10⁻⁵."""


def directional_stiffness(
    theta: Array, elements: Elements, *, along: float = 1.0, across: float = 1.0
) -> Array:
    """Return B (n, 3, 3), N/mm, of cuts for the law's coordinates (p,).

    ``along`` and ``across``: factors on the law's forces along and across the cutting speed. Raises
    TypeError for elements that are moments of a turn.
    """
    if elements.of is not None:
        raise TypeError("a turn's mean regenerates, not one moment of it")
    thick, thin = (_pushed(theta, elements, sign * STEP) for sign in (0.5, -0.5))
    step_mm = STEP * elements.edge.thickness_mm
    slope = np.divide(thick - thin, step_mm, out=np.zeros_like(thick), where=step_mm > 0.0)
    slope *= np.array([along, across, across]).reshape(3, *(1,) * (slope.ndim - 1))

    # The normal towards the work, in the tool's frame
    (sin, cos), (sin_phi, cos_phi) = elements.kappa, elements.phi
    normal = (sin * sin_phi, sin * cos_phi, -cos)
    each = np.stack([slope * one for one in normal], axis=1)
    by_tool = summed_forces(elements, each)[:, :3]
    return np.asarray(by_tool @ elements.frames)


def _pushed(theta: Array, elements: Elements, share: float) -> Array:
    edge = replace(elements.edge, thickness_mm=(1.0 + share) * elements.edge.thickness_mm)
    return element_forces(theta, replace(elements, edge=edge))
