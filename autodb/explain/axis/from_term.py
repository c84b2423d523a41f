"""Candidates of a term that none is written for: its own law, looked for from its starts."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.signals import AxisSignals
from autodb.explain.engine.candidates import Candidate, CandidateForm, near_one
from autodb.terms.channel import EVERY, OTHER, ChannelPart, channel_columns, input_name, parts_over
from autodb.terms.term import Contribution, Factor, InputChange, Term, TermParameter
from autodb.terms.vocabulary import term_called

Array = NDArray[np.float64]

BEYOND = 4.0
"""Factor by which a shape may be tuned beyond the first and the last of its starts. Chosen."""
FINER = 2.0
"""Factor between shapes that are tried where the shape fixes the size. Chosen."""
LINEAR = 1e-9
"""Share of itself by which a change differs from one in proportion to a parameter: rounding."""


def candidates_from_term(term: Term, s: AxisSignals) -> list[Candidate]:
    """Return the candidates that a term's own law gives, one for each other axis that it takes.

    A contribution adds its columns; a factor or a change of inputs what it does to those terms that
    it modifies, as far as they are known. None where what it takes is not recorded, nothing that it
    modifies is known, or no search for its shape can begin.
    """
    if not all(p.starts for p in term.shape):
        return []
    inputs = {
        "t": s.t_s,
        "position": s.position,
        "velocity": s.velocity,
        "acceleration": s.acceleration,
        "direction": s.sense,
        **s.others,
    }
    start = {p.name: p.starts[0] for p in term.shape}
    return [
        Candidate(
            part.key,
            term.name,
            tuple(_forms(part, s, inputs)),
            tuple(_channel(name, part, s) for name in term.inputs),
            static=isinstance(term, Contribution | Factor) and not term.remembers,
            needs=frozenset(term.modifies) - {EVERY},
            coarse=True,
            holds=_held(term, s),
        )
        for part in parts_over(term, inputs, start, ())
    ]


def _held(term: Term, s: AxisSignals) -> frozenset[str]:
    """Return the terms that were found and that a factor's columns scale."""
    if not isinstance(term, Factor):
        return frozenset()
    return s.joined if EVERY in term.modifies else s.joined & set(term.modifies)


def _channel(name: str, part: ChannelPart, s: AxisSignals) -> str:
    """Return the channel that an input of a term is."""
    if name.startswith(OTHER):
        return input_name(part, name)
    return name if name == "t" else s.channel(name)


def _forms(
    part: ChannelPart, s: AxisSignals, inputs: Mapping[str, Array]
) -> Iterator[CandidateForm]:
    """Return a form of a part's law for each combination of its starts."""
    term = part.term
    if isinstance(term, Contribution):

        def columns(**shape: float) -> Array:
            return channel_columns([part.with_shape(shape)], inputs)

        yield from _over_grid(columns, term.shape, term.coefficients)
        return
    change = _change_by(part, s, inputs)
    if change is None:
        return
    strength = next((p for p in term.shape if _in_proportion(change, part.shape, p)), None)
    if strength is None:
        shares = (TermParameter("share", "1", "of what the shape says"),)
        finer = [replace(p, starts=_finer(p)) for p in term.shape]
        yield from _over_grid(change, finer, shares, near_one)
        return
    unit = {strength.name: strength.starts[0]}

    def of_unit_strength(**shape: float) -> Array:
        return change(**shape, **unit) / unit[strength.name]

    rest = [p for p in term.shape if p is not strength]
    yield from _over_grid(of_unit_strength, rest, (strength,))


def _change_by(
    part: ChannelPart, s: AxisSignals, inputs: Mapping[str, Array]
) -> Callable[..., Array] | None:
    """Return what a factor or a change of inputs does to what is known, as a function of its shape.

    None where nothing is known that it modifies.
    """
    term = part.term
    if isinstance(term, Factor):
        acted = s.effort if EVERY in term.modifies else sum(map(s.part, term.modifies), start=0.0)
        takes = [inputs[name] for name in term.inputs]

        def scaled(**shape: float) -> Array:
            keywords = {p.keyword: shape[p.name] for p in term.shape}
            return np.asarray(acted * (term.function(*takes, **keywords) - 1.0))

        return scaled if np.any(acted) else None
    known = {n: s.had[n] for n in s.own.keys() & s.had.keys() if {n, EVERY} & set(term.modifies)}
    laws = {n: term_called(n) for n in known}
    own = [ChannelPart(laws[n]) for n in known if _is_plain(laws[n])]
    if not isinstance(term, InputChange) or not own:
        return None
    sizes = np.array([known[one.term.name] for one in own])
    without = channel_columns(own, inputs) @ sizes

    def changed(**shape: float) -> Array:
        return np.asarray(channel_columns([*own, part.with_shape(shape)], inputs) @ sizes - without)

    return changed


def _is_plain(term: Term) -> bool:
    """Whether a term has one column and no shape, as those that a simulation is read off with."""
    return isinstance(term, Contribution) and not term.shape and len(term.coefficients) == 1


def _in_proportion(
    change: Callable[..., Array], shape: Mapping[str, float], parameter: TermParameter
) -> bool:
    """Whether a change is in proportion to a parameter, which then is its coefficient."""
    start = parameter.starts[0]
    once = change(**shape)
    twice = change(**{**shape, parameter.name: 2.0 * start})
    size = float(np.max(np.abs(once)))
    return size > 0.0 and float(np.max(np.abs(twice - 2.0 * once))) <= LINEAR * size


def _over_grid(
    law: Callable[..., Array],
    shape: tuple[TermParameter, ...] | list[TermParameter],
    coefficients: tuple[TermParameter, ...],
    allowed: Callable[[Array], bool] | None = None,
) -> Iterator[CandidateForm]:
    """Return a form for each combination of starts, tuned up to the next ones."""
    lower = np.array([p.lower for p in coefficients])
    upper = np.array([p.upper for p in coefficients])

    def bounded(values: Array) -> bool:
        return bool(np.all((values >= lower) & (values <= upper)))

    grid = list(product(*(p.starts[:1] if p.given else p.starts for p in shape)))
    for point in grid:
        limits = {p.name: _limits(p, at) for p, at in zip(shape, point, strict=True) if not p.given}
        yield CandidateForm(
            law,
            shape={p.name: at for p, at in zip(shape, point, strict=True)},
            within={name: pair for name, pair in limits.items() if pair[0] < pair[1]},
            names=tuple(p.name for p in coefficients),
            tries=len(grid),
            allowed=allowed or bounded,
        )


def _limits(parameter: TermParameter, start: float) -> tuple[float, float]:
    """Return the values between which a shape is tuned: from the start before to the next one."""
    ends = start / BEYOND, start * BEYOND
    low = max((at for at in parameter.starts if at < start), default=min(ends))
    high = min((at for at in parameter.starts if at > start), default=max(ends))
    return max(low, parameter.lower), min(high, parameter.upper)


def _finer(parameter: TermParameter) -> tuple[float, ...]:
    """Return starts of one sign, filled up to a factor of FINER and beyond both ends."""
    starts = sorted(parameter.starts)
    if parameter.given or starts[0] * starts[-1] <= 0.0:
        return parameter.starts
    edges = sorted((starts[0] / BEYOND, *starts, starts[-1] * BEYOND), key=abs)
    filled = [edges[0]]
    for low, high in pairwise(edges):
        steps = max(1, int(np.ceil(np.log(high / low) / np.log(FINER))))
        filled += list(low * (high / low) ** (np.arange(1, steps + 1) / steps))
    inside = [at for at in filled if parameter.lower <= at <= parameter.upper]
    return tuple(float(at) for at in inside) or parameter.starts
