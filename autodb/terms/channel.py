"""A channel as a sum of contributions, some of them modified.

``ChannelPart``: one term in a channel's model, with the shape parameters that this instance has.
The parts of a model are a plain tuple; everything here is a pure function of it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from autodb.terms.term import Contribution, Factor, InputChange, OutputChange, Term, TermParameter

Array = NDArray[np.float64]
Inputs = Mapping[str, Array]
EVERY = "*"
OTHER = "other_"
"""Begin of an input that is another axis'."""


@dataclass(frozen=True)
class ChannelPart:
    """One term of a model.

    ``shape`` gives every shape parameter's value by name; ``free`` those that a fit may change.
    ``of`` distinguishes instances of one term (another axis, an edge, a period) and says which
    input ``other_…`` stands for: ``of="y"`` reads `other_acceleration` from input `y.acceleration`.
    """

    term: Term
    shape: Mapping[str, float] = field(default_factory=dict)
    free: tuple[str, ...] = ()
    of: str = ""

    def __post_init__(self) -> None:
        names = {p.name for p in self.term.shape}
        if set(self.shape) != names or not set(self.free) <= names:
            raise ValueError(
                f"{self.term.name}: shape {sorted(self.shape)}, free {self.free}; "
                f"its shape parameters are {sorted(names)}"
            )

    @property
    def key(self) -> str:
        """Name of this instance: the term, its form, and what it is of."""
        return " ".join(word for word in (self.term.name, self.term.form, self.of) if word)

    def with_shape(self, values: Mapping[str, float]) -> "ChannelPart":
        """Return the part with other shape parameters."""
        return ChannelPart(self.term, {**self.shape, **values}, self.free, self.of)


def parts_over(
    term: Term, inputs: Inputs, shape: Mapping[str, float], free: tuple[str, ...]
) -> list[ChannelPart]:
    """Return a term's parts over these inputs: one for each other axis where it takes another's.

    None where an input that it takes is not there.
    """
    others = [name.removeprefix(OTHER) for name in term.inputs if name.startswith(OTHER)]
    axes = {n.split(".")[0]: None for n in inputs if n.partition(".")[2] in others}
    made = [ChannelPart(term, shape, free, of) for of in (axes if others else ("",))]
    return [p for p in made if all(input_name(p, name) in inputs for name in term.inputs)]


def input_name(part: ChannelPart, name: str) -> str:
    """Return what a part reads an input of its term from."""
    return f"{part.of}.{name.removeprefix(OTHER)}" if name.startswith(OTHER) else name


def _arguments(part: ChannelPart, inputs: Inputs) -> tuple[list[Array], dict[str, float]]:
    shape = {p.keyword: part.shape[p.name] for p in part.term.shape}
    return [inputs[input_name(part, name)] for name in part.term.inputs], shape


def channel_columns(parts: Sequence[ChannelPart], inputs: Inputs) -> Array:
    """Return the columns (n, p) of all contributions, modified, ordered as ``linear_parameters``.

    ``inputs``: arrays (n,) by name, at least those that the parts' terms take.
    """
    inputs = changed_inputs(parts, inputs)
    blocks = []
    for part in parts:
        if isinstance(part.term, Contribution):
            arrays, shape = _arguments(part, inputs)
            block = part.term.function(*arrays, **shape)
            block = block.reshape(len(block), -1)
            for factor in factors(parts, part.term, inputs):
                block = block * factor[:, None]
            blocks.append(block)
    return np.column_stack(blocks)


def changed_inputs(parts: Sequence[ChannelPart], inputs: Inputs) -> dict[str, Array]:
    """Return the inputs as the parts' input changes leave them."""
    now = dict(inputs)
    for part in parts:
        if isinstance(part.term, InputChange):
            arrays, shape = _arguments(part, inputs)
            touched = [n for n in now if n in part.term.changes or _is_other(n, part.term.changes)]
            now |= {n: part.term.function(now[n], *arrays, **shape) for n in touched}
    return now


def _is_other(name: str, changes: tuple[str, ...]) -> bool:
    return "." in name and f"{OTHER}{name.split('.', 1)[1]}" in changes


def factors(parts: Sequence[ChannelPart], term: Term, inputs: Inputs) -> list[Array]:
    """Return the factors (n,) by which the parts scale a term's columns."""
    found = []
    for part in parts:
        if isinstance(part.term, Factor) and ({term.name, EVERY} & set(part.term.modifies)):
            arrays, shape = _arguments(part, inputs)
            found.append(part.term.function(*arrays, **shape))
    return found


def linear_parameters(parts: Sequence[ChannelPart]) -> list[tuple[ChannelPart, TermParameter]]:
    """Return the linear parameters in the order of ``columns``."""
    return [
        (part, parameter)
        for part in parts
        if isinstance(part.term, Contribution)
        for parameter in part.term.coefficients
    ]


def free_shape(parts: Sequence[ChannelPart]) -> list[tuple[ChannelPart, TermParameter]]:
    """Return the shape parameters that a fit may change, in the order of ``reshaped``."""
    return [(part, p) for part in parts for p in part.term.shape if p.name in part.free]


def reshaped(parts: Sequence[ChannelPart], values: Array) -> tuple[ChannelPart, ...]:
    """Return the parts with their free shape parameters set to ``values`` (q,)."""
    rest = list(values)
    done = []
    for part in parts:
        names = [p.name for p in part.term.shape if p.name in part.free]
        done.append(part.with_shape({name: float(rest.pop(0)) for name in names}))
    return tuple(done)


def through_outputs(parts: Sequence[ChannelPart], effort: Array, inputs: Inputs) -> Array:
    """Return what is recorded of a sum (n,): clipped, or without its sign."""
    for part in parts:
        if isinstance(part.term, OutputChange):
            arrays, shape = _arguments(part, inputs)
            effort = part.term.function(effort, *arrays, **shape)
    return effort


def predicted_channel(parts: Sequence[ChannelPart], linear: Array, inputs: Inputs) -> Array:
    """Return the channel (n,) that parts with linear parameters (p,) give."""
    return through_outputs(parts, channel_columns(parts, inputs) @ linear, inputs)
