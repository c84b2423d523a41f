"""A check of a calibration's data: its figure, the limit, and what it says where it fails."""

from dataclasses import dataclass
from operator import ge, gt, le, lt

from autodb.errors import UnusableInput, behind_name

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
            raise UnusableInput(behind_name(path, check.sentence))
