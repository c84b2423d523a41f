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
    """One channel's search: everything at every row; ``active`` keys in order of acceptance.

    ``own``: columns of the simulation's own terms · ``blocks``: candidates · ``detail``: fine shape
    of families found so far · ``chosen``: evidence of all candidates when a key was accepted ·
    ``intervals``: where the loads are · ``reduced``: columns at the working rate, by key.
    """

    t_s: Array
    difference: Array
    own: dict[str, Array]
    blocks: dict[str, search.Block]
    factor: int
    finer: dict[str, Array] = field(default_factory=dict)
    active: list[str] = field(default_factory=list)
    first_step: search.Step | None = None
    chosen: dict[str, dict[str, float]] = field(default_factory=dict)
    intervals: dict[str, tuple[float, float]] = field(default_factory=dict)
    detail: dict[str, Array] = field(default_factory=dict)
    reduced: dict[str, Array] = field(default_factory=dict)

    def add(self, block: search.Block) -> None:
        """Add a candidate, in the place of an earlier one of its key."""
        self.blocks[block.key] = block
        self.reduced.pop(block.key, None)

    def named(self) -> list[str]:
        """Return the accepted blocks that have a name."""
        return [k for k in self.active if self.blocks[k].term != "unknown"]

    def shapes(self) -> list[str]:
        """Return the accepted families without a name."""
        return [k for k in self.active if self.blocks[k].term == "unknown"]

    def own_matrix(self) -> Array:
        """Return the own columns at every row, (n, k)."""
        return np.column_stack([self.none(), *self.own.values()])

    def none(self) -> Array:
        """Return no column, (n, 0)."""
        return np.empty((len(self.difference), 0))

    def matrix(self, keys: list[str]) -> Array:
        """Return the columns of blocks at every row, (n, p)."""
        return np.column_stack([self.none(), *(self.blocks[k].columns for k in keys)])

    def working(self, keys: list[str]) -> Array:
        """Return the columns of blocks at the working rate."""
        for key in keys:
            if key not in self.reduced:
                self.reduced[key] = work(self, self.blocks[key].columns)
        return np.column_stack([work(self, self.none()), *(self.reduced[k] for k in keys)])


def work(state: State, values: Array) -> Array:
    """Return values at the working rate."""
    return signals.decimate(values, state.factor) if values.size else values[:: state.factor]


def whitener_of(state: State) -> Whitener:
    """Return the whitener of what the saturated model leaves: noise, whatever is missing."""
    everything = np.column_stack(
        [work(state, state.own_matrix()), state.working(list(state.blocks))]
    )
    difference = work(state, state.difference)
    return autoregression(difference - everything @ estimate(everything, difference).coefficients)


def accepted_whitener(state: State) -> Whitener:
    """Return the whitener of what the accepted columns leave, slow noise and misfit included."""
    accepted = np.column_stack([work(state, state.own_matrix()), state.working(state.active)])
    difference = work(state, state.difference)
    return autoregression(difference - accepted @ estimate(accepted, difference).coefficients)


def gram_of(state: State, whitener: Whitener, *, detail: bool) -> search.Gram:
    """Return the white inner products; ``detail`` frees the fine shape of families found so far.

    While further causes are sought, detail takes up what a smooth family gets wrong, so that no
    cause is invented there; for judging the family itself it must be away.
    """
    fixed = [state.own_matrix(), *(state.detail.values() if detail else ())]
    own = whitener(work(state, np.column_stack(fixed)))
    blocks = [replace(b, columns=whitener(state.working([b.key]))) for b in state.blocks.values()]
    return search.Gram(own, blocks, whitener(work(state, state.difference)))


def noise_floor(state: State) -> float:
    """Return the rms that the saturated model leaves at every row."""
    everything = np.column_stack([state.own_matrix(), state.matrix(list(state.blocks))])
    return rms(state.difference - everything @ estimate(everything, state.difference).coefficients)
