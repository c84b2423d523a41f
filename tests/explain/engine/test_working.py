"""Rows of several pieces: what is filtered within a piece has nothing of the next."""

import numpy as np
from numpy.testing import assert_allclose

from autodb.explain.engine.noise import Whitener, fitted_whitener
from autodb.explain.engine.working import EDGE_S, WorkingRate
from autodb.timing import Timing

ORDER, FACTOR, RATE = 5, 2, 500.0
PIECES = (slice(0, 1000), slice(1000, 1801), slice(1801, 3000))
TIMING = Timing(1.0 / RATE, PIECES, 3000)


def test_means_are_taken_within_a_piece() -> None:
    values = np.repeat([1.0, 2.0, 3.0], [1000, 801, 1199])
    assert set(WorkingRate(FACTOR, TIMING).reduced(values)) == {1.0, 2.0, 3.0}


def test_white_rows_are_those_of_each_piece_by_itself() -> None:
    """But for the edges, where what is derived has one side only."""
    rng = np.random.default_rng(1)
    rate, values = WorkingRate(FACTOR, TIMING), rng.normal(size=3000)
    reduced, taps = rate.reduced(values), rng.normal(size=ORDER)
    white = Whitener(taps, rate.linked(ORDER))(reduced)
    edge = int(np.ceil(EDGE_S * RATE / FACTOR))
    alone, begin = [], 0
    for number, piece in enumerate(PIECES):
        rows = (piece.stop - piece.start) // FACTOR
        own = reduced[begin : begin + rows]
        begin += rows
        cut = slice(edge if number else 0, len(own) - (edge if number < 2 else 0))
        alone.append(Whitener(taps)(own[cut]))
    assert_allclose(white, np.concatenate(alone))


def test_adjoint_and_places_leave_out_what_is_not_linked() -> None:
    rng = np.random.default_rng(2)
    rate = WorkingRate(FACTOR, TIMING)
    rows = len(rate.reduced(np.zeros(3000)))
    whitener = Whitener(rng.normal(size=ORDER), rate.linked(ORDER))
    one, other = rng.normal(size=rows), rng.normal(size=len(whitener.places(rows)))
    assert_allclose(whitener(one) @ other, one @ whitener.adjoint(other, rows))
    assert len(whitener.unbroken(one)) == rows - ORDER


def test_a_jump_between_pieces_is_no_noise() -> None:
    rng = np.random.default_rng(3)
    rate = WorkingRate(1, TIMING)
    jumps = np.repeat([0.0, 50.0, -50.0], [1000, 801, 1199]) + rng.normal(size=3000)
    found = fitted_whitener(jumps - np.repeat([0.0, 50.0, -50.0], [1000, 801, 1199]), ORDER)
    linked = fitted_whitener(jumps, ORDER, linked=rate.linked(ORDER))
    assert np.std(linked(jumps)) < 1.5
    assert np.std(found(jumps)) > 1.5
