"""What really happens, for every term, in another functional form than the term's: numpy only.

Each truth is a measured channel with the effect, the other terms it must be distinguished from, and
coloured noise; what has to be recovered is the effect as a curve and, where it means the same in
both forms, its main parameter. No truth imports a term.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MEMORY = 0.8
"""Correlation of the noise from one row to the next: chosen, as a current controller's is."""


@dataclass(frozen=True)
class Truth:
    """A measured channel whose contributions are known.

    ``key`` the term and form that has to be found; ``others`` those beside it, `key@of` for an
    instance; ``effect`` (n,) the channel with it less the channel without it; ``within`` the
    largest relative rms of its recovered curve, after whatever the terms ``modulo`` could say
    equally well is taken out of both; ``sd`` (n,) the noise of each row; ``main`` name, true value
    and relative tolerance of its main parameter; ``begin_at`` where a search begins that the term
    cannot know without the recording.
    """

    key: str
    inputs: Mapping[str, Array]
    others: tuple[str, ...]
    effect: Array
    measured: Array
    sd: Array
    within: float
    main: tuple[str, float, float] | None = None
    of: str = ""
    modulo: tuple[str, ...] = ()
    begin_at: Mapping[str, tuple[float, ...]] = field(default_factory=dict)


def truth(
    key: str, inputs: Mapping[str, Array], others: Mapping[str, Array], effect: Array,
    *, within: float, noise: float, scatter: float = 0.0, **rest: Any,
) -> Truth:  # fmt: skip
    """Return the truth of an effect (n,) beside others (n,): their sum and noise are measured.

    The noise has the standard deviation ``noise`` times the channel's rms, and ``scatter`` times
    the row's own value.
    """
    clean = total({**others, key: effect})
    sd = np.hypot(noise * np.sqrt(np.mean(clean**2)), scatter * clean)
    return Truth(
        key=key, inputs=inputs, others=tuple(others), effect=effect, sd=sd,
        measured=clean + sd * coloured(len(clean)), within=within, **rest,
    )  # fmt: skip


def total(loads: Mapping[str, Array]) -> Array:
    """All loads together, (n,)."""
    return np.asarray(np.sum(list(loads.values()), axis=0))


def coloured(n: int, *, seed: int = 7) -> Array:
    """Return noise (n,) of standard deviation 1 and correlation MEMORY from row to row."""
    kernel = MEMORY ** np.arange(40)
    white = np.random.default_rng(seed).normal(size=n + len(kernel) - 1)
    return np.convolve(white, kernel, "valid") / float(np.linalg.norm(kernel))


def motion(legs: list[tuple[float, float]], *, rate_hz: float, ramp_s: float) -> dict[str, Array]:
    """Return t, position, velocity and acceleration of legs (velocity, duration) with soft ramps.

    Each change of velocity takes ``ramp_s``; position starts at 0.
    """
    speed = np.concatenate([np.full(round(d * rate_hz), v) for v, d in legs])
    width = max(3, round(ramp_s * rate_hz))
    window = np.hanning(width + 2)[1:-1]
    padded = np.concatenate([np.full(width, 0.0), speed, np.full(width, 0.0)])
    v = np.convolve(padded, window / window.sum(), "same")
    step = 1.0 / rate_hz
    x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * step)])
    t = np.arange(len(v), dtype=np.float64) * step
    return {"t": t, "position": x, "velocity": v, "acceleration": np.gradient(v, step)}
