"""What a turning tool does in each step of a program, and where such steps are kept as they come.

A program of 300 000 lines may have millions of steps, so that they are kept as bare numbers.
"""

from array import array
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import speed_m_min

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ContourEngagement:
    """What the tool does in the middle of every step at a feed, each (n,).

    ``step_mm`` its length, ``x_mm`` radius and ``z_mm`` of the tip, ``along_x`` and ``along_z``
    unit feed, ``depth_mm`` (0: in air), ``outer_mm`` the largest radius cut, ``feed_mm_rev``,
    ``speed_rpm``, ``line`` of the program.
    """

    step_mm: Array
    x_mm: Array
    z_mm: Array
    along_x: Array
    along_z: Array
    depth_mm: Array
    outer_mm: Array
    feed_mm_rev: Array
    speed_rpm: Array
    line: NDArray[np.int_]

    @property
    def step_s(self) -> Array:
        """How long each step takes, s."""
        return np.asarray(60.0 * self.step_mm / (self.feed_mm_rev * self.speed_rpm))

    @property
    def path_mm(self) -> Array:
        """Way at feed from the first step's start to the middle of each, mm."""
        return np.asarray(np.cumsum(self.step_mm) - self.step_mm / 2)

    @property
    def time_s(self) -> Array:
        """Time at feed from the first step's start to the middle of each, s: rests take none."""
        return np.asarray(np.cumsum(self.step_s) - self.step_s / 2)

    @property
    def speed_m_min(self) -> Array:
        """Cutting speed at the largest radius cut, m/min."""
        return speed_m_min(2.0 * self.outer_mm, self.speed_rpm)

    def removed_mm3(self) -> Array:
        """Return the volume that each step removes: V = 2π r a ds, (n,), mm³."""
        return np.pi * (np.maximum(self.x_mm, 0.0) + self.outer_mm) * self.depth_mm * self.step_mm


class EngagedSteps:
    """Steps as they come, 88 bytes each, with the width of what is cut in each (n,), mm.

    The width is that of a groove's chip and the height of a thread; 0 else.
    """

    def __init__(self) -> None:
        self._columns = {
            one.name: array("q" if one.name == "line" else "d") for one in fields(ContourEngagement)
        }
        self._width_mm = array("d")

    def __len__(self) -> int:
        """Return how many steps there are."""
        return len(self._width_mm)

    def add(self, steps: ContourEngagement, width_mm: Array | None = None) -> None:
        """Keep steps (k,) behind the others; ``width_mm`` (k,), None: 0."""
        for name, column in self._columns.items():
            column.frombytes(np.ascontiguousarray(getattr(steps, name)).tobytes())
        width = np.zeros(steps.x_mm.size) if width_mm is None else width_mm
        self._width_mm.frombytes(np.ascontiguousarray(width).tobytes())

    def since(self, first: int = 0) -> tuple[ContourEngagement, Array]:
        """Return the steps from one on, and their widths; none is added while they are in use."""
        return ContourEngagement(**dict(self._views(first))), _view(self._width_mm)[first:]

    def _views(self, first: int) -> Iterator[tuple[str, NDArray[Any]]]:
        for name, column in self._columns.items():
            yield name, _view(column)[first:]


def _view(column: "array[float] | array[int]") -> NDArray[Any]:
    return np.frombuffer(column, dtype=column.typecode)
