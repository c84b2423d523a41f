"""Foreign units become ours at the edge; inside, a float is in the unit of its name."""

from functools import cache
from typing import TYPE_CHECKING

from autodb.errors import UnusableInput

if TYPE_CHECKING:
    from pint import UnitRegistry

RAW = "raw"


@cache
def _registry() -> "UnitRegistry[float]":
    from pint import UnitRegistry

    return UnitRegistry()


def _plain(unit: str) -> str:
    return unit.replace("·", "*").replace("²", "**2").replace("°C", "degC").replace("1", "")


def factor(unit: str, *, to: str, where: str) -> float:
    """Return what a value in ``unit`` is multiplied by to be in ``to``.

    Raises UnusableInput, naming ``where``, for an unknown unit or one of another dimension.

    >>> factor("m", to="mm", where="doc")
    1000.0
    """
    from pint.errors import DimensionalityError

    if unit in (RAW, to):
        return 1.0
    try:
        return float(_registry().Quantity(1.0, _plain(unit)).to(_plain(to)).magnitude)
    except DimensionalityError:
        raise UnusableInput(
            f"{where}: unit '{unit}' cannot become {to}; {to}, or a unit of its kind, would work"
        ) from None
    except Exception:  # pint's parser fails on nonsense in any way, assertions included
        raise UnusableInput(f"{where}: unknown unit '{unit}'; {to} would work") from None
