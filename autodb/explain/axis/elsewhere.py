"""A set of effects, fitted on a recording, on another move."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.effects import candidates_of_effect
from autodb.explain.axis.moves import AxisPath
from autodb.explain.axis.read_off import own_terms
from autodb.explain.axis.reading import AxisReading
from autodb.explain.axis.signals import AxisSignals, acting_terms, simulated_friction
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.telling import held_coefficients
from autodb.terms.friction import since_reversal

Array = NDArray[np.float64]


@dataclass(frozen=True)
class AxisAccount:
    """A set of effects and the simulation's own terms, fitted together on a recording.

    ``coefficients`` (p,) of own terms, then of each choice; ``root`` (p, p) with root·rootᵀ their
    covariance.
    """

    own: tuple[str, ...]
    choices: tuple[Choice, ...]
    widths: tuple[int, ...]
    coefficients: Array
    root: Array

    def of(self, number: int) -> Array:
        """Return the coefficients of a choice."""
        start = len(self.own) + sum(self.widths[:number])
        return self.coefficients[start : start + self.widths[number]]


def fit_axis_account(reading: AxisReading, choices: Sequence[Choice]) -> AxisAccount:
    """Fit a set to the recording's white rows; its own terms are free."""
    bench, whitener = reading.whole, reading.inquiry.whitener
    built = [bench.reduce(bench.built(choice.shape)) for choice in choices]
    white = whitener(np.column_stack([bench.chosen(()), *built]))
    right = whitener(bench.reduced_difference)
    coefficients, root = held_coefficients(white, right, variance=reading.inquiry.variance)
    return AxisAccount(
        own=tuple(bench.own),
        choices=tuple(choices),
        widths=tuple(block.shape[1] for block in built),
        coefficients=coefficients,
        root=root,
    )


def signals_on(
    path: AxisPath, other: AxisPath, recorded: AxisSignals, *, begin_s: float
) -> AxisSignals:
    """Return the signals of a move of the recorded axis, while the other axes run ``other``.

    The move begins at ``begin_s`` on the recording's clock. The simulation is the sum of the terms
    that were read off it.
    """
    last, way = since_reversal(path.direction, path.position)
    columns = own_terms(
        path.direction, vars(path), rotary=recorded.rotary, phase_deg=recorded.phase_deg
    )
    own = {name: column for name, column in columns.items() if name in recorded.own}
    terms = [recorded.had[name] * column for name, column in own.items() if name in recorded.had]
    simulation = sum(terms, start=np.full_like(path.t_s, recorded.constant))
    return AxisSignals(
        axis=recorded.axis,
        t_s=begin_s + path.t_s,
        position=path.position,
        velocity=path.velocity,
        acceleration=path.acceleration,
        direction=path.direction,
        sense=path.direction,
        simulation=simulation,
        effort=simulation,
        friction=simulated_friction(path.direction, own, recorded.had),
        last_sense=last,
        way=way,
        others={name: _of_other(other, name) for name in recorded.others},
        own=own,
        had=recorded.had,
        phase_deg=recorded.phase_deg,
        constant=recorded.constant,
        like=recorded,
        shaped=recorded.shaped,
    )


def _of_other(path: AxisPath, name: str) -> Array:
    what = name.partition(".")[2]
    if what == "velocity":
        return path.velocity
    return path.acceleration if what == "acceleration" else path.position


def account_columns(of: AxisAccount, signals: AxisSignals) -> Array:
    """Return an account's columns on another move, (n, p), in the order of its coefficients.

    A choice that does not repeat there, and what was kept of a simulation without a term, are 0.
    """
    zero = np.zeros_like(signals.t_s)
    own = np.column_stack([zero, *(signals.own.get(name, zero) for name in of.own)])[:, 1:]
    acting = acting_terms()
    blocks = {
        number: _columns(choice, signals, of.widths[number])
        for number, choice in enumerate(of.choices)
        if choice.candidate.term not in acting
    }
    parts = [(of.choices[i].candidate.term, b @ of.of(i)) for i, b in blocks.items()]
    now = signals.beside(own @ of.coefficients[: len(of.own)], parts)
    for number, choice in enumerate(of.choices):
        if number not in blocks:
            blocks[number] = _columns(choice, now, of.widths[number])
    return _recorded(of, own, [blocks[n] for n in range(len(of.choices))], now)


def _recorded(of: AxisAccount, own: Array, blocks: list[Array], now: AxisSignals) -> Array:
    """Return all columns as what clips, shifts or signs them lets them be recorded."""
    through = [(n, _shape(c, now)) for n, c in enumerate(of.choices) if c.shape.through is not None]
    for at, form in through:
        if form is not None:
            own = form.seen(own)
            blocks = [b if n == at else form.seen(b) for n, b in enumerate(blocks)]
    return np.column_stack([own, *blocks])


def _columns(choice: Choice, signals: AxisSignals, width: int) -> Array:
    form = _shape(choice, signals)
    return np.zeros((len(signals.t_s), width)) if form is None else form.build()


def _shape(choice: Choice, signals: AxisSignals) -> CandidateForm | None:
    """Return a choice's shape over other signals, with its values; None where it has none."""
    candidate = _anew(choice.candidate, signals)
    if candidate is None:
        return None
    law = _formula(choice.shape)
    same = next((form for form in candidate.forms if _formula(form) == law), None)
    return None if same is None else replace(same, shape=choice.shape.shape)


def _anew(candidate: Candidate, signals: AxisSignals) -> Candidate | None:
    if candidate.scanned:
        return None if candidate.anew is None else candidate.anew(signals)
    made = candidates_of_effect(signals, candidate.term)
    return next((one for one in made if one.key == candidate.key), None)


def _formula(form: CandidateForm) -> tuple[object, tuple[object, ...]]:
    """Return what two shapes have in common whose law is the same function of other signals.

    A law that is less than a function, such as what others leave of a shift, is that of no other.
    """
    law = form.law
    fixed = law.args if isinstance(law, partial) else ()
    function = law.func if isinstance(law, partial) else law
    return getattr(function, "__code__", function), fixed
