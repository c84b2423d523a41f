"""Other methods get of a real axis what they should, and are read fairly."""

from pathlib import Path

import numpy as np
from numpy.testing import assert_allclose

from autodb.proofs.cases.real.real_columns import REAL_TERMS
from autodb.proofs.runs.real.real_score import peer_score
from benchmarks.peers.real_given import RealGiven
from benchmarks.peers.real_peer_run import fitted_answer, given_of
from tests.helpers.laid_axis import hand_case

CASE = hand_case()
GIVEN = given_of(CASE)


def test_a_method_gets_every_name_that_is_not_included() -> None:
    absent = {"cross_coupling", *CASE.includes}
    assert set(GIVEN.names) == set(REAL_TERMS) - absent
    assert GIVEN.columns.shape == (len(GIVEN.names), len(CASE.axis))
    assert_allclose(GIVEN.error, CASE.axis.effort - CASE.simulated)


def test_own_terms_stay_free() -> None:
    columns, error = GIVEN.beside_own()
    scale = np.linalg.norm(GIVEN.own, axis=1, keepdims=True)
    assert np.max(np.abs(columns @ (GIVEN.own / scale).T)) < 1e-6
    assert np.max(np.abs(error @ (GIVEN.own / scale).T)) < 1e-6 * np.linalg.norm(error)


def test_what_is_picked_is_fitted_and_named_once() -> None:
    picked = [GIVEN.names.index("coulomb"), *np.flatnonzero(np.array(GIVEN.names) == "cogging")[:2]]
    answer = fitted_answer(GIVEN, picked)
    assert list(answer.sizes) == ["coulomb", "cogging"]
    scored = peer_score(CASE, answer)
    assert scored.named
    assert scored.fit is not None
    assert scored.fit < 1.05
    assert fitted_answer(GIVEN, []).sizes == {}


def test_a_case_comes_back_from_its_file(tmp_path: Path) -> None:
    GIVEN.save(tmp_path / "given.npz")
    back = RealGiven.load(tmp_path / "given.npz")
    assert back.names == GIVEN.names
    assert_allclose(back.columns, GIVEN.columns)
    assert_allclose(back.inputs, GIVEN.inputs)
