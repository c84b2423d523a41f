"""Forward over time: a pair's posterior becomes a mill's forces at every angle of its spindle."""

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import endmill, tools
from autodb.cutting.elements import Elements
from autodb.errors import UnusableInput
from autodb.forward.prediction import ToolOf
from autodb.pairs.engaged import BANDS, BY_NAME, Conditions, Stated, stated_milling
from autodb.pairs.forecast import expected_means
from autodb.pairs.observed import PairCuts, Variant
from autodb.pairs.posterior import PairPosterior
from autodb.wording import listed, phrase

Array = NDArray[np.float64]

SLICE_MM = 0.05
"""Height of slices. Chosen: of ones of 0.2 mm each that leaves the work shows as a step."""
MOMENTS = 2048
"""Moments that are worked out together."""


def waves_N(
    posterior: PairPosterior, tool: ToolOf, operation: str, conditions: Conditions, angle_rad: Array
) -> Array:
    """Return force x, y, z [N], (n, 3), of one milled cut at angles (n,) of tooth 0's tip.

    All of the arc is in the work, the edge is fresh. With what the posterior has learnt of the
    law's error in the operation and of what is assumed of its tool.

    Raises UnusableInput where the operation does not mill, or the cut lacks what it needs.
    """
    if operation not in BANDS:
        raise UnusableInput(
            phrase(
                "operation '{operation}': use {names}", operation=operation, names=", ".join(BANDS)
            )
        )
    lacking = BY_NAME[operation].lacking(conditions)
    if lacking:
        raise UnusableInput(
            phrase(
                "operation '{operation}' without {names}",
                operation=operation,
                names=listed(lacking, phrase(" and ")),
            )
        )
    assumed = tools.end_mill_of(tool.numbers)
    cut = stated_milling(assumed.tool, Stated([conditions]), BANDS[operation])

    def some(angles: Array) -> Array:
        def at(mill: endmill.EndMill) -> Elements:
            return endmill.at_angles(mill, cut, angles, slice_mm=SLICE_MM)

        variants = tuple(
            Variant(f"{tool.name}: {usual.name}", at(other)) for usual, other in assumed.variants
        )
        return expected_means(posterior, PairCuts(operation, at(assumed.tool), variants))[:, :3]

    return np.concatenate(
        [some(angle_rad[k : k + MOMENTS]) for k in range(0, len(angle_rad), MOMENTS)]
    )
