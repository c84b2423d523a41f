"""The answer of explain: what `explanation.json` holds, and the traces that its report draws."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

Array = NDArray[np.float64]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class IntervalValue(_Part):
    """A parameter with its 95 % interval."""

    value: float
    low: float
    high: float
    unit: str


class Regime(_Part):
    """The range of a signal in which the mismatch sits.

    ``share`` of the squared error in the ``rows``, a share of all, whose signal lies in the range;
    None: of an answer from before version 0.2, which does not say.
    """

    signal: str
    low: float
    high: float
    share: float
    rows: float | None = None


class Where(_Part):
    """Stretches (s, or cut numbers) and regimes."""

    intervals: tuple[tuple[float, float], ...] = ()
    regime: tuple[Regime, ...] = ()


class Cause(_Part):
    """One cause: a term of the vocabulary, or `unknown` with the variables it depends on."""

    term: str
    kind: Literal["missing", "mistuned"]
    confidence: float
    statement: str
    parameters: dict[str, IntervalValue]
    alternatives: tuple[str, ...] = ()
    variables: tuple[str, ...] = ()
    to_tell_apart: str | None = None


class FitQuality(_Part):
    """Root mean square error before and after, also on blocks that the fit did not see."""

    rms_before: float
    rms_after: float
    heldout_before: float
    heldout_after: float
    noise_floor: float


class ChannelAnswer(_Part):
    """What was found in one channel."""

    unit: str
    mismatch: bool
    where: Where
    missing: tuple[Cause, ...]
    fit: FitQuality
    unexplained: str | None = None


class Explanation(_Part):
    """The whole answer."""

    recording: str
    channels: dict[str, ChannelAnswer]


@dataclass(frozen=True)
class Considered:
    """One candidate: its evidence 2·ΔlogL less its penalties when added alone, and its verdict.

    Strong evidence alone does not name it: sets of candidates are compared as wholes. One that
    shows only beside others has its evidence beside them.
    """

    name: str
    evidence: float
    verdict: str


@dataclass(frozen=True)
class ChannelTrace:
    """The arrays behind a channel's answer: x is time [s] or cut number, all of shape (n,).

    ``close_up``: of a waveform, from when to when some turns are shown enlarged. ``takes``: the
    share of the squared error that each entry of ``missing`` takes away, in their order.
    """

    x_name: Literal["t", "cut"]
    x: Array
    recording: Array
    simulation: Array
    corrected: Array
    regime_signals: dict[str, Array] = field(default_factory=dict)
    considered: tuple[Considered, ...] = ()
    close_up: tuple[float, float] | None = None
    takes: tuple[float, ...] = ()


@dataclass(frozen=True)
class Explained:
    """The answer, its traces by channel, and lines about what was ignored.

    ``rows``: time or cut number, and each corrected channel, at every row of the file, (N,).
    """

    explanation: Explanation
    traces: dict[str, ChannelTrace]
    notes: tuple[str, ...] = ()
    rows: dict[str, Array] = field(default_factory=dict)
