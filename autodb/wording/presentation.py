"""For whom something is said: the language, and the units of the shop.

It holds for what one request, or one block, says. Nothing else knows it, so that what is stored
and what programs get is in English and in SI units.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field


@dataclass(frozen=True)
class ShopUnit:
    """A unit of the shop in place of one of ours, and how many of it one of ours is."""

    name: str
    factor: float


@dataclass(frozen=True)
class Presentation:
    """A language by its code, and units of the shop by ours; those that are not named stay."""

    language: str = "en"
    units: Mapping[str, ShopUnit] = field(default_factory=dict)


ENGLISH = Presentation()
"""What holds where nobody chose: English, SI."""
_CURRENT: ContextVar[Presentation] = ContextVar("presentation", default=ENGLISH)


def presentation() -> Presentation:
    """Return for whom something is said now."""
    return _CURRENT.get()


def present_for(shown: Presentation) -> None:
    """Say everything that this task still says for somebody."""
    _CURRENT.set(shown)


@contextmanager
def presented(shown: Presentation) -> Iterator[None]:
    """Say everything in a block for somebody."""
    token = _CURRENT.set(shown)
    try:
        yield
    finally:
        _CURRENT.reset(token)
