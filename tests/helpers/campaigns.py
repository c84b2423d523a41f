"""Parameters of which a few are tried in every run and all of them in `make campaigns`."""

from collections.abc import Iterable
from typing import Any

import pytest


def first(kept: int, values: Iterable[Any]) -> list[Any]:
    """Return parameters, marked as a campaign but for the ``kept`` first of them.

    A tuple holds the values of several arguments.
    """
    found = list(values)
    later = (one if isinstance(one, tuple) else (one,) for one in found[kept:])
    return [*found[:kept], *(pytest.param(*one, marks=pytest.mark.campaign) for one in later)]
