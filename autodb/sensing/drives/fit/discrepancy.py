"""What the friction of an identified axis is off its laws, as a version of its model keeps it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.fit.deviation import Inputs, deviating, deviation_groups
from autodb.terms.channel import ChannelPart
from autodb.terms.vocabulary import term_called

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FrictionDiscrepancy:
    """The ``weights`` (m,) of the columns by which an axis of ``parts`` deviates from their laws.

    ``highest_mm_s`` and ``travel_mm``: where it was seen; beyond, it is as at their ends.
    """

    parts: tuple[ChannelPart, ...]
    weights: Array
    highest_mm_s: float
    travel_mm: tuple[float, float]

    def effort(self, parts: tuple[ChannelPart, ...], inputs: Inputs) -> Array:
        """Return what the laws of a model of ``parts`` leave out in any motion, (n,)."""
        groups = deviation_groups(
            self.parts, highest_mm_s=self.highest_mm_s, travel_mm=self.travel_mm
        )
        return np.asarray(np.column_stack(deviating(groups, parts, inputs)) @ self.weights)

    def kept(self) -> dict[str, Any]:
        """Return it as JSON keeps it."""
        return {
            "parts": [
                {"term": p.term.name, "form": p.term.form, "of": p.of, "shape": dict(p.shape)}
                for p in self.parts
            ],
            "weights": self.weights.tolist(),
            "highest_mm_s": self.highest_mm_s,
            "travel_mm": list(self.travel_mm),
        }

    @classmethod
    def of(cls, kept: Mapping[str, Any]) -> "FrictionDiscrepancy":
        """Return what ``kept`` made."""
        low, high = kept["travel_mm"]
        parts = tuple(
            ChannelPart(term_called(one["term"], one["form"]), one["shape"], of=one["of"])
            for one in kept["parts"]
        )
        return cls(parts, np.array(kept["weights"]), kept["highest_mm_s"], (low, high))
