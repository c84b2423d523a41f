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
Home = Literal["machine", "pair", "lot", "tool", "calibration", "recording"]
"""Where a confirmed effect is kept: the drive model of an axis; the parameters of a work-tool pair,
or of one lot of its material; the tool as it is clamped; the calibration of a force; or nowhere but
its recording."""


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
    function takes it by, and ``starts``: the values that a search for it begins from; it may be
    ``given``: taken as it is stated, because the moves of one recording hardly show it.
    """

    name: str
    unit: str
    meaning: str
    lower: float = -math.inf
    upper: float = math.inf
    prior: ParameterPrior | None = None
    keyword: str = ""
    starts: tuple[float, ...] = ()
    given: bool = False


@dataclass(frozen=True, kw_only=True)
class NamedEffect:
    """What is said of a physical effect wherever it is found.

    ``name`` is an identifier of the vocabulary; ``title`` the same in shop words; ``check`` one
    sentence of what to check on the machine, and ``check_source`` where that is from; ``sits``
    where it may sit by its physics (machine, tool, material, sensor, calibration, or the pair of
    tool and material), the likeliest first. ``belongs_to``: where it is kept once a person has
    confirmed it, so that the next prediction contains it; what belongs to its recording is noted
    alone.
    """

    name: str
    title: str = ""
    check: str = ""
    check_source: str = ""
    sits: tuple[str, ...] = ("machine",)
    belongs_to: Home = "recording"


@dataclass(frozen=True, kw_only=True)
class Term(NamedEffect):
    """One physical effect that a channel can contain, with its law.

    ``form`` distinguishes terms of one name (`periodic`), of which the first says the effect's
    words; ``channels`` the kinds of channel it acts on;
    ``modifies`` the terms that it changes (empty: it stands by itself); ``needs`` what must be
    recorded to see it; ``statement`` a sentence in shop words; ``excited_by`` the move or cut that
    shows it best; ``alike`` the effects that one recording can never distinguish it from,
    ``distinguished_by`` what could.

    ``inputs`` name the arrays that ``function`` takes, ``coefficients`` its linear parameters (one
    a column), ``shape`` the others.

    ``belongs_to``: a machine's terms are identified from its moves. ``in_law``: names of the
    numbers of the law of cutting (``autodb.cutting.shear``) that hold an effect of a pair; none: it
    stands beside the law. ``any_moves``: every move excites it, so that it is identified unless
    other terms are named. ``friction``: it rubs. ``remembers``: its value depends on earlier rows
    too.
    """

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
    in_law: tuple[str, ...] = ()
    any_moves: bool = False
    friction: bool = False
    remembers: bool = False

    @property
    def parameters(self) -> tuple[TermParameter, ...]:
        """All parameters, the linear ones first."""
        return (*self.coefficients, *self.shape)

    def prior_sd(self, parameter: str) -> float:
        """Return the standard deviation of a parameter's prior; infinite where it has none."""
        priors = [one.prior for one in self.parameters if one.name == parameter]
        return next((prior.sd for prior in priors if prior is not None), math.inf)


class Contribution(Term):
    """Adds columns: ``function(*inputs, **shape)`` gives (n,) or (n, len(coefficients))."""


class Factor(Term):
    """Scales the columns of the terms that it modifies by ``function(*inputs, **shape)``, (n,)."""


@dataclass(frozen=True, kw_only=True)
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
