"""What a fit of a channel's parts recovered, as the tests compare it with a truth."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.terms.channel import (
    ChannelPart,
    Inputs,
    channel_columns,
    linear_parameters,
    predicted_channel,
)
from autodb.terms.fit import fit_parts

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Recovered:
    """Parts with their shape found, and their linear parameters (p,)."""

    parts: tuple[ChannelPart, ...]
    linear: Array

    def value(self, key: str, name: str) -> float:
        """Return a parameter of the part ``key``."""
        for (part, parameter), value in zip(
            linear_parameters(self.parts), self.linear, strict=True
        ):
            if (part.key, parameter.name) == (key, name):
                return float(value)
        return next(part.shape[name] for part in self.parts if part.key == key)

    def effect(self, key: str, inputs: Inputs) -> Array:
        """Return the channel with the part ``key`` less the channel without it, (n,)."""
        rest = tuple(part for part in self.parts if part.key != key)
        keep = [part.key != key for part, _ in linear_parameters(self.parts)]
        without = predicted_channel(rest, self.linear[keep], inputs)
        return predicted_channel(self.parts, self.linear, inputs) - without


@dataclass(frozen=True)
class Seen:
    """A channel (n,), its inputs and the standard deviation of each row (n,)."""

    inputs: Inputs
    measured: Array
    sd: Array


def recover(
    parts: Sequence[ChannelPart], seen: Seen, begin_at: Mapping[str, tuple[float, ...]]
) -> Recovered:
    """Return the fit of parts to what was seen; ``begin_at`` adds starts by parameter name."""
    fit = fit_parts(parts, seen.inputs, seen.measured, sd=seen.sd, begin_at=begin_at)
    return Recovered(fit.parts, fit.linear)


def without_columns(of: Array, parts: Sequence[ChannelPart], inputs: Inputs) -> Array:
    """Return a curve (n,) less what the columns of parts could say of it."""
    if not parts:
        return of
    matrix = channel_columns(parts, inputs)
    norm = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
    weights = np.linalg.lstsq(matrix / norm, of, rcond=1e-12)[0]
    return np.asarray(of - matrix @ (weights / norm), dtype=np.float64)
