"""The answer of explain: what `explanation.json` holds, the largest cause first, and its traces.

Causes overlap, and what one takes away depends on which are corrected before it. Its share is the
mean over all orders in which the causes may be corrected one after the other. With d = recording −
simulation and e_j the contributions, c = Σ e_j, the squares fall by 2 e_jᵀ(d − s) − |e_j|² where s
is what was corrected before; s is on average half of the others, so that

    share_j = e_jᵀ (2 d − c) / |d|²,    Σ share_j = 1 − |d − c|² / |d|².

A contribution that mostly undoes another has a negative one: it takes nothing away. What own terms
change beside the causes, which they would else stand in for, goes with these in proportion to their
squares: what thin chips take more is little of an error that is made up for by a lower pressure of
all chips. The shares are scaled to what the whole correction takes away. Source: Shapley 1953 (A
value for n-person games), of a quadratic game.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from autodb.wording import msgid, significant

Array = NDArray[np.float64]

TINY = 1e-300


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class IntervalValue(_Part):
    """A parameter with its 95 % interval."""

    value: float
    low: float
    high: float
    unit: str

    @classmethod
    def around(cls, middle: float, half: float, unit: str) -> "IntervalValue":
        """Return a value with an interval that reaches as far as ``half`` to both sides."""
        return cls(value=middle, low=middle - half, high=middle + half, unit=unit)


class Regime(_Part):
    """The range of a signal in which the mismatch sits.

    ``share`` of the squared error in the ``rows``, a share of all, whose signal lies in the range;
    None: of an answer from before version 0.3, which does not say.
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
    share of the squared error that each entry of ``missing`` takes away, in their order;
    ``cutoff_hz``: of the filter that an axis' motion was derived with, where it was, and
    ``lowered`` why it is lower than the recording alone asks for; ``remark``: a line about the
    recording, or none.
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
    cutoff_hz: float | None = None
    lowered: str = ""
    remark: str = ""


@dataclass(frozen=True)
class Explained:
    """The answer, its traces by channel, and lines about what was ignored.

    ``rows``: time or cut number, and each corrected channel, at every row of the file, (N,).
    """

    explanation: Explanation
    traces: dict[str, ChannelTrace]
    notes: tuple[str, ...] = ()
    rows: dict[str, Array] = field(default_factory=dict)


def shares_taken(difference: Array, correction: Array, parts: Sequence[Array]) -> Array:
    """Return the share of |d|² that each of the parts of a correction takes away, (p,)."""
    twice_left = 2.0 * difference - correction
    square = max(float(difference @ difference), TINY)
    whole = max(float(correction @ twice_left) / square, 0.0)
    squares = np.array([float(part @ part) for part in parts])
    own = (correction - np.sum(parts, axis=0)) / max(float(squares.sum()), TINY)
    with_own = [part + of_all * own for part, of_all in zip(parts, squares, strict=True)]
    kept = np.array([max(float(part @ twice_left), 0.0) for part in with_own])
    return np.asarray(kept * (whole / max(float(kept.sum()), TINY)))


def largest_first(
    causes: Sequence[Cause], parts: Sequence[Array], *, correction: Array, difference: Array
) -> tuple[tuple[Cause, ...], tuple[float, ...]]:
    """Return the causes, that with the largest share first, and their shares.

    ``parts`` (n,): what each adds to the simulation; ``correction`` (n,): what is added in all.
    """
    shares = shares_taken(difference, correction, parts)
    order = np.argsort(-shares, kind="stable")
    return tuple(causes[k] for k in order), tuple(float(shares[k]) for k in order)


def unnamed_cause(
    variables: tuple[str, ...],
    course: str,
    *,
    difference: Array,
    part: Array,
    size: IntervalValue,
    confidence: float,
    alternatives: tuple[str, ...],
    apart: str | None = None,
) -> Cause:
    """Return the entry of an effect without a name: what it depends on, and for how much of it.

    ``course``: how it goes with its ``variables``, in words; ``part`` (n,) what it takes off the
    ``difference`` (n,); ``apart``: what would tell it from its alternatives.
    """
    share = 1.0 - float(np.sum((difference - part) ** 2) / np.sum(difference**2))
    return Cause(
        term="unknown",
        kind="missing",
        confidence=confidence,
        statement=(
            f"{100 * max(0.0, share):.0f} % of the error depends on {' and '.join(variables)}"
            f"{course} No law that is known here fits it. It reaches {significant(size.value)} "
            f"{size.unit}."
        ),
        parameters={"size": size},
        alternatives=alternatives,
        variables=variables,
        to_tell_apart=apart,
    )


def considered(alone: Mapping[str, float], taken: Collection[str]) -> tuple[Considered, ...]:
    """Return every candidate by its key, the strongest first.

    ``alone``: the evidence of each when added alone; ``taken``: the keys of those that were found.
    """
    return tuple(
        Considered(key, evidence, msgid("accepted") if key in taken else msgid("not needed"))
        for key, evidence in sorted(alone.items(), key=lambda item: -item[1])
    )
