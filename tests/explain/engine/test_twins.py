"""A shift that gives most of a law which was found takes what that leaves, unless it is whole."""

from typing import cast

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Candidate, CandidateForm, near_one
from autodb.explain.engine.plain.founded import Proposals, fitted_laws, founded

Array = NDArray[np.float64]

ROWS, OWN_OF_IT = 4000, 0.2
"""How much of a shift its twin does not give."""


class _Nothing:
    def beside(self, *_: object) -> list[Candidate]:
        return []

    def scanned(self, *_: object) -> list[Candidate]:
        return []


def _sizes(mass: float, share: float) -> dict[str, float]:
    """Return the size of each law found in a mass and a share of a shift, beside noise."""
    rng = np.random.default_rng(20261129)
    t = np.linspace(0.0, 100.0, ROWS)
    accelerated, jumps = np.sin(t), np.sign(np.cos(t + 0.1)) - np.sign(np.cos(t))
    jumps -= accelerated * (jumps @ accelerated) / (accelerated @ accelerated)
    shifted = accelerated + OWN_OF_IT * jumps / np.std(jumps)
    difference = mass * accelerated + share * shifted + rng.normal(0.0, 0.05, ROWS)
    law = Candidate(
        "inertia", "inertia", (CandidateForm(lambda: accelerated, names=("size",)),), static=True
    )
    shift = CandidateForm(
        lambda: shifted, names=("share",), allowed=near_one, through=lambda columns: columns
    )
    bench = WhiteRows(difference, {"coulomb": np.sign(np.cos(t))}, 1)
    laws = founded(bench, [law, Candidate("lag", "lag", (shift,))], cast(Proposals, _Nothing()))
    return {
        law.choice.candidate.term: float(law.coefficients[0]) for law in fitted_laws(bench, laws)[1]
    }


def test_what_is_no_whole_shift_leaves_a_mass_its_size() -> None:
    assert _sizes(0.3, 0.7) == pytest.approx({"inertia": 1.0, "lag": 0.7}, abs=0.02)


def test_a_whole_shift_stands_beside_the_mass_that_is_there() -> None:
    assert _sizes(0.3, 1.0) == pytest.approx({"inertia": 0.3, "lag": 1.0}, abs=0.02)
