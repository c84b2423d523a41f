"""Chatter as one vibration: each component feels it by its own share and phase, no more."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.search import FoundSet
from autodb.explain.waves.bench import WhitenedNoise, WhiteWaves
from autodb.explain.waves.fit import BesideWaves
from autodb.explain.waves.scans import on_each
from autodb.explain.waves.world import SimulatedWaves, form

Array = NDArray[np.float64]

COST = 2.0
"""What a coefficient costs that is to predict: Akaike 1974."""


def as_as_one(
    world: SimulatedWaves, bench: WhiteWaves, found: FoundSet, quiet: WhitenedNoise
) -> tuple[Choice, ...]:
    """Return what was found, each chatter with one slow course of size and phase for all.

    A tone's slow courses a_j(t) in the components j are w_j e(t), w_j complex: the matrix of their
    coefficients is of rank one. Of the ladder's courses that one is taken that would predict best.
    """
    return tuple(
        _as_one(
            world,
            BesideWaves(bench, found.without(choice.candidate.key), quiet),
            bench,
            choice,
            quiet,
        )
        if choice.candidate.term == "chatter"
        else choice
        for choice in found.choices
    )


def _as_one(
    world: SimulatedWaves,
    beside: BesideWaves,
    bench: WhiteWaves,
    choice: Choice,
    quiet: WhitenedNoise,
) -> Choice:
    candidate, made = choice.candidate, []
    for number, shape in enumerate(candidate.forms):
        columns = bench.columns((candidate.key, number), shape)
        course = shared_course(columns, beside.fitted(columns)[0], np.array(quiet.sd))
        both = on_each(world, course)
        freedom = columns.shape[-1] // len(columns) + 2 * (len(columns) - 1)
        made.append((beside.gain(both) - COST * freedom, form(both, shape.shape)))
    return Choice(_steadied(candidate, max(made, key=lambda one: one[0])[1]), 0)


def _steadied(candidate: Candidate, shape: CandidateForm) -> Candidate:
    return Candidate(f"{candidate.key} as one", candidate.term, (shape,), candidate.variables)


def shared_course(columns: Array, coefficients: Array, sd: Array) -> Array:
    """Return the course that all components share, and the same a quarter turn on (n, 2).

    ``columns`` (C, n, C · 2 K) of cosines, then sines, by K slow functions, ``coefficients``
    (C · 2 K,) fitted to them, ``sd`` (C,) of white rows.
    """
    count = len(columns)
    cosine, sine = np.moveaxis(coefficients.reshape(count, 2, -1), 1, 0)
    slow = np.linalg.svd((cosine - 1j * sine) / sd[:, None])[2][0]
    mixed = np.block([[slow.real[:, None], slow.imag[:, None]],
                      [-slow.imag[:, None], slow.real[:, None]]])  # fmt: skip
    return np.asarray(columns[0, :, : 2 * len(slow)] @ mixed)
