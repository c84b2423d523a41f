"""What a term is, and the four ways in which one enters a channel's sum.

A channel is modelled as

    effort = output( Σ factors · columns(input changes(signals)) · coefficients ),

linear in the coefficients; shape parameters are everything else. Every function is pure and takes
arrays of one length; its arrays are named by ``inputs``, its shape parameters by their keywords.

The step of a clock, for terms that remember.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Channel = Literal["axis", "rotary", "spindle", "cuts", "table"]


@dataclass(frozen=True)
class ParameterPrior:
    """What is known of a parameter before any recording: a normal distribution and its source."""

    mean: float
    sd: float
    source: str


@dataclass(frozen=True)
class TermParameter:
    """One named parameter: its unit in terms of the channel's unit ``U``, and its meaning.

    ``lower`` and ``upper`` bound it. A shape parameter also has the ``keyword`` that its term's
    function takes it by, and ``starts``: the values that a search for it begins from.
    """

    name: str
    unit: str
    meaning: str
    lower: float = -math.inf
    upper: float = math.inf
    prior: ParameterPrior | None = None
    keyword: str = ""
    starts: tuple[float, ...] = ()


@dataclass(frozen=True)
class Term:
    """One physical effect that a channel can contain.

    ``name`` is an identifier of the vocabulary, ``form`` distinguishes terms of one name
    (`periodic`); ``channels`` the kinds of channel it acts on;
    ``modifies`` the terms that it changes (empty: it stands by itself); ``needs`` what must be
    recorded to see it; ``statement`` a sentence in shop words; ``excited_by`` the move or cut that
    shows it best; ``alike`` the effects that one recording can never distinguish it from,
    ``distinguished_by`` what could.

    ``inputs`` name the arrays that ``function`` takes, ``coefficients`` its linear parameters (one
    a column), ``shape`` the others.
    """

    name: str
    channels: tuple[Channel, ...]
    inputs: tuple[str, ...]
    function: Callable[..., Array]
    needs: tuple[str, ...]
    statement: str
    excited_by: str
    source: str
    form: str = ""
    coefficients: tuple[TermParameter, ...] = ()
    shape: tuple[TermParameter, ...] = ()
    modifies: tuple[str, ...] = ()
    alike: tuple[str, ...] = ()
    distinguished_by: str | None = None

    @property
    def parameters(self) -> tuple[TermParameter, ...]:
        """All parameters, the linear ones first."""
        return (*self.coefficients, *self.shape)


class Contribution(Term):
    """Adds columns: ``function(*inputs, **shape)`` gives (n,) or (n, len(coefficients))."""


class Factor(Term):
    """Scales the columns of the terms that it modifies by ``function(*inputs, **shape)``, (n,)."""


@dataclass(frozen=True)
class InputChange(Term):
    """Replaces each input named in ``changes`` by ``function(input, *inputs, **shape)``, (n,)."""

    changes: tuple[str, ...] = ()


class OutputChange(Term):
    """Acts on the sum: ``function(effort, *inputs, **shape)``, (n,); its slope lies in [−1, 1]."""


LONE_STEP_S = 1.0
"""Step of a clock of one row: nothing is remembered from one row, so that any would do."""


def step_s(t_s: NDArray[np.float64]) -> float:
    """Return the step of an evenly sampled clock (n,), ascending, in s."""
    return float(np.median(np.diff(t_s))) if len(t_s) > 1 else LONE_STEP_S
