"""Units that are mixed up: which channels, and what their numbers then have to be multiplied by."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.files.channels import unit_of
from autodb.files.units import conversion
from autodb.wording import listed, phrase

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Mistake:
    """Channels that are in ``unit`` though their name says another; all of them together."""

    channels: tuple[str, ...]
    unit: str

    @property
    def factor(self) -> float:
        """What the numbers must be multiplied by to be in the unit of the channels' name."""
        return conversion(self.unit, to=unit_of(self.channels[0]) or "1", where=self.channels[0])[0]

    def mended(self, channels: Mapping[str, Array]) -> dict[str, Array]:
        """Return the channels (n,) with the mistaken ones as they would be in our units."""
        return {**channels, **{name: channels[name] * self.factor for name in self.channels}}

    @property
    def remedy(self) -> str:
        """What to state in the side file."""
        return phrase(
            'state unit = "{unit}" for {channels} in the side file',
            unit=self.unit,
            channels=_listed(self.channels),
        )

    def __str__(self) -> str:
        return phrase("{channels} in {unit}", channels=_listed(self.channels), unit=self.unit)


class Radius(Mistake):
    """A diameter that is given as a radius."""

    @property
    def factor(self) -> float:
        """A diameter is two radii."""
        return 2.0

    @property
    def remedy(self) -> str:
        """What to state in the side file."""
        return phrase(
            "set scale = 2 for {channels} in the side file", channels=_listed(self.channels)
        )

    def __str__(self) -> str:
        return phrase("{channels} as a radius", channels=_listed(self.channels))


class MistakenPerMinute(Mistake):
    """A feed a minute that stands for a feed a revolution."""

    def mended(self, channels: Mapping[str, Array]) -> dict[str, Array]:
        """Divide by the revolutions a minute; without them nothing is mended."""
        speed = channels.get("spindle.speed")
        if speed is None:
            return dict(channels)
        return {**channels, **{name: channels[name] / speed for name in self.channels}}

    @property
    def remedy(self) -> str:
        """What to change."""
        return phrase("give the feed in millimetres per revolution")


def _listed(channels: tuple[str, ...]) -> str:
    return listed(filter(None, (", ".join(channels[:-1]), channels[-1])), phrase(" and "))


FORCES = ("force.x", "force.y", "force.z")
FEED_AND_DEPTH = ("cutting.feed", "cutting.depth")
SPEEDS = (
    *(Mistake(("spindle.speed",), unit) for unit in ("rev/s", "rad/s", "deg/s")),
    *(Mistake(("cutting.speed",), unit) for unit in ("m/s", "ft/min", "mm/min")),
    *(Mistake(("work.diameter",), unit) for unit in ("inch", "m")),
    Radius(("work.diameter",), "radius"),
)
"""What makes π · diameter · spindle speed differ from the cutting speed."""
CONDITIONS = (
    *SPEEDS,
    *(Mistake((name,), unit) for name in FEED_AND_DEPTH for unit in ("inch", "um", "m")),
    MistakenPerMinute(("cutting.feed",), "mm/min"),
    Mistake(FEED_AND_DEPTH, "inch"),
    Mistake((*FEED_AND_DEPTH, "work.diameter"), "inch"),
)
LOADS = tuple(
    Mistake(channels, unit)
    for channels in (FORCES, *((name,) for name in FORCES))
    for unit in ("kN", "daN", "lbf")
)
