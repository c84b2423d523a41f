"""The oracle of the proof of explanations: what a case's evidence decides."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose

from autodb.proofs.cases.base.case import Hidden, Rival
from autodb.proofs.cases.plan import PlannedCase, draw_concealed
from autodb.proofs.runs.explain.explain_oracle import SURE, oracle_recovery, oracle_verdict
from tests.helpers.explained_cases import T, hand_made, scored


def test_the_oracle_finds_evidence_of_what_no_rival_can_do() -> None:
    """Against rivals at right angles the margin is d^2 and noise; against its double nothing."""
    slope = T - np.mean(T)
    slope *= 20.0 / np.linalg.norm(slope)
    across = np.cos(2.0 * np.pi * np.arange(T.size) * 40 / T.size)
    far = oracle_verdict(hand_made(slope, [Rival("ripple", across[None])]))
    assert far.margin is not None
    assert_allclose(far.margin, 400.0, atol=4.0 * 20.0 + 20.0)
    assert far.decidable
    double = oracle_verdict(hand_made(slope, [Rival("double", -3.0 * slope[None] + 5.0)]))
    assert double.margin is not None
    assert abs(double.margin) < 0.01
    assert not double.decidable


def test_the_oracle_weighs_likeness_by_its_angle() -> None:
    """A rival that shares a part c of the effect's direction leaves (1 - c^2) d^2 of evidence."""
    slope = T - np.mean(T)
    slope /= np.linalg.norm(slope)
    across = np.cos(2.0 * np.pi * np.arange(T.size) * 40 / T.size)
    across -= np.mean(across) + slope * (slope @ across)
    across /= np.linalg.norm(across)
    alike = 0.8 * slope + 0.6 * across
    judged = oracle_verdict(hand_made(60.0 * slope, [Rival("alike", alike[None])], noise=0.01))
    assert judged.margin is not None
    assert_allclose(judged.margin, 0.36 * 3600.0, rtol=1e-3)


def test_the_oracle_combines_rivals_for_two_hidden_effects() -> None:
    """Two of three directions are hidden: the best wrong pair has the larger, not the smaller."""
    waves = np.array([np.cos(2.0 * np.pi * np.arange(T.size) * k / T.size) for k in (3, 5, 9)])
    waves /= np.linalg.norm(waves, axis=1)[:, None]
    one = hand_made(30.0 * waves[0], [], noise=1e-3)
    hidden = (
        Hidden("a", 1.0, 30.0, 30.0 * waves[0]),
        Hidden("b", 1.0, 10.0, 10.0 * waves[1]),
    )
    whole = np.sum([h.part for h in hidden], axis=0)
    case = replace(
        one,
        hidden=hidden,
        truth=2.0 + whole,
        measured=one.measured - one.truth + 2.0 + whole,
        rivals=lambda: iter([Rival("c", waves[2:]), Rival("a", waves[:1])]),
    )
    judged = oracle_verdict(case)
    assert judged.margin is not None
    assert_allclose(judged.margin, 100.0, rtol=1e-2)


def test_the_oracle_recovers_to_its_degrees_of_freedom() -> None:
    """Two free sizes leave an error of sd sqrt(2/n) on average, beside an effect of known rms."""
    case = hand_made(np.sin(2.0 * np.pi * T), [])
    left = oracle_recovery(case)
    assert left is not None
    assert 0.0 < left < 4.0 * np.sqrt(2.0 / T.size) / np.sqrt(0.5)


def test_nothing_hidden_has_no_margin_and_no_error() -> None:
    case = draw_concealed(3, asked=PlannedCase((), 8.0))
    judged = oracle_verdict(replace(case, simulated=case.truth))
    assert judged.margin is None
    assert judged.decidable
    assert judged.recovery is None


def test_margins_are_what_decides() -> None:
    assert not replace(scored(("lag",)), decidable=False).decidable
    for margin, sure in ((SURE + 1.0, True), (SURE - 1.0, False)):
        slope = T - np.mean(T)
        slope *= np.sqrt(margin) / np.linalg.norm(slope)
        assert (
            oracle_verdict(
                hand_made(slope, [Rival("none", np.ones((1, T.size)))], noise=0.0)
            ).decidable
            is sure
        )
