"""The state of one effort channel's search, and the linear algebra that judges it."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.explain import search
from autodb.explain.fit import estimate, rms
from autodb.explain.noise import Whitener, autoregression

Array = NDArray[np.float64]


@dataclass
class State:
    """One channel's search: everything at every row; ``active`` keys in order of acceptance."""

    t_s: Array
    difference: Array
    own: dict[str, Array]
    blocks: dict[str, search.Block]
    factor: int
    active: list[str] = field(default_factory=list)
    first_step: search.Step | None = None
    chosen: dict[str, dict[str, float]] = field(default_factory=dict)
    intervals: dict[str, tuple[float, float]] = field(default_factory=dict)
    finer: dict[str, Array] = field(default_factory=dict)
    detail: dict[str, Array] = field(default_factory=dict)

    def own_matrix(self) -> Array:
        return np.column_stack([*self.own.values()]) if self.own else self.none()

    def none(self) -> Array:
        return np.empty((len(self.difference), 0))

    def matrix(self, keys: list[str]) -> Array:
        return np.column_stack([self.none(), *(self.blocks[k].columns for k in keys)])


def work(state: State, values: Array) -> Array:
    return signals.decimate(values, state.factor)


def whitener_of(state: State) -> Whitener:
    """Return the whitener of what the saturated model leaves: noise, whatever is missing."""
    keys = [k for k in state.blocks if k not in state.intervals or k in state.active]
    everything = work(state, np.column_stack([state.own_matrix(), state.matrix(keys)]))
    difference = work(state, state.difference)
    fitted = estimate(everything, difference)
    return autoregression(difference - everything @ fitted.coefficients)


def gram_of(state: State, whitener: Whitener, *, detail: bool) -> search.Gram:
    """Return the white inner products; ``detail`` frees the fine shape of families found so far.

    While further causes are sought, detail takes up what a smooth family gets wrong, so that no
    cause is invented there; for judging the family itself it must be away.
    """
    fixed = [state.own_matrix(), *(state.detail.values() if detail else ())]
    own = whitener(work(state, np.column_stack(fixed)))
    blocks = [replace(b, columns=whitener(work(state, b.columns))) for b in state.blocks.values()]
    return search.Gram(own, blocks, whitener(work(state, state.difference)))


def noise_floor(state: State) -> float:
    """Return the rms that the saturated model leaves at every row."""
    keys = [k for k in state.blocks if k not in state.intervals or k in state.active]
    everything = np.column_stack([state.own_matrix(), state.matrix(keys)])
    return rms(state.difference - everything @ estimate(everything, state.difference).coefficients)
