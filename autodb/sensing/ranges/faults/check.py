"""A check of a calibration's data: its figure, the limit, and what it says where it fails.

The arm at which a cut's tangential force turns the spindle.
"""

from dataclasses import dataclass
from operator import ge, gt, le, lt

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import effective_radius_mm
from autodb.errors import UnusableInput
from autodb.records import CutTable

Array = NDArray[np.float64]


OPERATORS = {"<": lt, "<=": le, ">": gt, ">=": ge}


@dataclass(frozen=True)
class DataCheck:
    """``statistic`` ``operator`` ``threshold`` is what sound data give; else ``sentence`` holds.

    ``name``: what was tested; ``sentence``: what is wrong, with the remedy.
    """

    name: str
    statistic: float
    operator: str
    threshold: float
    sentence: str

    @property
    def passed(self) -> bool:
        """Whether the data are sound in this respect."""
        return bool(OPERATORS[self.operator](self.statistic, self.threshold))


def refuse(path: object, checks: "list[DataCheck]") -> None:
    """Raise UnusableInput with the file and the sentence of the first check that failed."""
    for check in checks:
        if not check.passed:
            raise UnusableInput(f"{path}: {check.sentence}")


def torque_arm_mm(table: CutTable) -> Array | None:
    """Return the torque arm (n,) of every cut, mm; None where diameter or depth is not known."""
    if "work.diameter" not in table or "cutting.depth" not in table:
        return None
    facing = np.array([o == "face" for o in table.texts.get("operation", [""] * len(table))])
    return effective_radius_mm(table["work.diameter"], table["cutting.depth"], facing=facing)
