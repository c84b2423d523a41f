"""Laws that plain rows need: found where noise of any colour hides nothing, and nowhere else."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.stats import wilcoxon

from autodb.explain.axis.look import AxisField
from autodb.explain.axis.signals import AxisSignals, axis_signals
from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.fit import Folds
from autodb.explain.engine.inquiry import inquire
from autodb.explain.engine.plain import founded as laws
from autodb.explain.engine.plain.founded import fitted_laws, founded
from autodb.explain.engine.plain.growing import in_most_blocks
from autodb.explain.engine.plain.odds import SIGNED_RANKS
from autodb.explain.engine.plain.rows import BLOCKS, PlainRows
from autodb.records.tables import Recording
from autodb.terms.friction import stribeck
from tests.helpers.campaigns import first

Array = NDArray[np.float64]
T_S = np.arange(2500) / 100.0
NOISE_A = 0.01


def _motion() -> dict[str, Array]:
    """Return position [mm], velocity and acceleration (n,) of two sines, one of them slow."""
    fast, slow = 2 * np.pi * 0.9, 2 * np.pi * 0.13
    return {
        "x.position": 100 + 8 * np.sin(fast * T_S) + 60 * np.sin(slow * T_S),
        "x.velocity": 8 * fast * np.cos(fast * T_S) + 60 * slow * np.cos(slow * T_S),
        "x.acceleration": -8 * fast**2 * np.sin(fast * T_S) - 60 * slow**2 * np.sin(slow * T_S),
    }


def _bench(missing: Array, *, known: Array | None = None) -> tuple[AxisSignals, WhiteRows]:
    """Return the signals and rows of an axis of whose effort a simulation has friction only."""
    moved = _motion()
    friction = 0.3 * np.sign(moved["x.velocity"]) + 0.002 * moved["x.velocity"]
    simulation = friction if known is None else known
    channels = {"t": T_S, **moved, "x.current": friction + missing}
    recording = Recording(path=Path("r.csv"), channels=channels)
    signals = axis_signals(recording, simulation, "x.current")
    sizes = [signals.had[name] for name in signals.own]
    difference = channels["x.current"] - simulation
    return signals, WhiteRows(difference, dict(signals.own), 1, own_sizes=sizes, gap=25)


def _founded(signals: AxisSignals, bench: WhiteRows) -> tuple[Choice, ...]:
    field = AxisField(signals, bench)
    return founded(bench, field.standing(), field)


def _slow_noise(seed: int, sd: float) -> Array:
    """Return noise that forgets in half a second, (n,)."""
    white = np.random.default_rng(seed).normal(0.0, 1.0, len(T_S) + 500)
    noise = np.asarray(lfilter([1.0], [1.0, -0.98], white))[500:]
    return np.asarray(noise * sd / noise.std())


def test_a_mass_is_found_though_its_mismatch_is_smooth_and_its_law_off_by_a_tenth() -> None:
    """An autoregression predicts such a mismatch one step ahead: white rows would hold nothing."""
    acceleration = _motion()["x.acceleration"]
    load = 0.004 * acceleration * (1 + 0.1 * np.sin(2 * np.pi * 0.05 * T_S))
    signals, bench = _bench(load + _slow_noise(1, NOISE_A))
    _, laws = fitted_laws(bench, _founded(signals, bench))
    (mass,) = [law for law in laws if law.choice.candidate.term == "inertia"]
    assert_allclose(mass.coefficients[0], 0.004, rtol=0.1)


def test_a_law_lowers_the_error_in_most_blocks_or_in_many_by_much() -> None:
    """Rms of blocks [N·m] of a robot's joint without viscous friction and with it: in every other
    block the simulation's own terms give what is missing. One block alone says nothing."""
    without = np.array([1.72, 6.54, 1.71, 6.39, 1.69, 6.8, 1.66, 6.56]) ** 2
    with_it = np.array([1.79, 2.06, 2.0, 1.92, 1.95, 2.25, 1.94, 2.19]) ** 2
    every = np.ones(BLOCKS, dtype=np.bool_)
    assert in_most_blocks(without, with_it, every)
    assert not in_most_blocks(with_it, without, every)
    level = np.ones(BLOCKS)
    one, two, six = (level - 0.9 * (np.arange(BLOCKS) < blocks) for blocks in (1, 2, 6))
    assert not in_most_blocks(level, one, every)
    assert not in_most_blocks(level, two, every)
    assert in_most_blocks(level, six, every)
    assert in_most_blocks(level, level - 0.01 * (np.arange(BLOCKS) < 6), every)


def test_a_block_in_which_a_law_is_silent_says_nothing_of_it() -> None:
    """Rms of blocks [N·m] of an arm's joint without viscous friction and with it: it rests at both
    ends of the recording. Of four blocks that are left, all count."""
    without = np.array([1.75, 2.39, 1.66, 0.97, 2.2, 1.57, 0.97, 1.0]) ** 2
    with_it = np.array([1.84, 1.34, 0.99, 1.36, 1.54, 1.06, 0.98, 1.14]) ** 2
    moves = np.array([False, True, True, True, True, True, True, False])
    assert not in_most_blocks(without, with_it, np.ones(BLOCKS, dtype=np.bool_))
    assert in_most_blocks(without, with_it, moves)
    assert not in_most_blocks(with_it, without, moves)
    few = np.arange(BLOCKS) < 4
    assert not in_most_blocks(np.ones(BLOCKS), 1.0 - 0.9 * few + 0.5 * ~few, few)


def test_a_law_acts_where_what_it_is_of_moves() -> None:
    moved = _motion()
    stands = T_S > 18.75
    viscous = 0.01 * np.where(stands, 0.0, moved["x.velocity"])
    _, bench = _bench(viscous + _slow_noise(3, NOISE_A))
    law = Candidate("viscous", "viscous", (CandidateForm(lambda: viscous, names=("level",)),))
    rows = PlainRows(bench, [law])
    assert rows.acts_in([Choice(law, 0)], 0).tolist() == [True] * 6 + [False] * 2


def test_rows_are_completed_with_what_laws_add() -> None:
    """A dip of friction beside dry friction in another size is nearly the same: one fit decides."""
    dip = stribeck(
        np.sign(_motion()["x.velocity"]), _motion()["x.velocity"], speed_mm_s=20.0, exponent=2.0
    )
    signals, bench = _bench(0.15 * dip + _slow_noise(3, NOISE_A))
    found = inquire(bench, AxisField(signals, bench))
    assert [law.choice.candidate.term for law in found.laws] == ["stribeck"]
    assert_allclose(found.bench.difference + found.laws[0].effect, bench.difference, atol=1e-12)


@pytest.mark.parametrize(("recordings", "most"), first(1, [(10, 4), (20, 6), (40, 9)]))
def test_slow_noise_hardly_founds_anything(recordings: int, most: int) -> None:
    """Noise that forgets in half a second, of 25 s, holds a law by chance in one of 13 recordings.

    Of 10, more than 4 have one with a probability of 5e-4 then, of 20 more than 6; of 40, more
    than 9 below 1e-3.
    """
    held = [_founded(*_bench(_slow_noise(seed, NOISE_A))) for seed in range(recordings)]
    assert sum(bool(found) for found in held) <= most


def test_friction_takes_no_sign_but_its_own() -> None:
    signals, bench = _bench(-0.05 * np.sign(_motion()["x.velocity"]) + _slow_noise(2, NOISE_A))
    found = {choice.candidate.term for choice in _founded(signals, bench)}
    assert not found & {"coulomb", "viscous", "stribeck"}


def test_a_load_in_one_block_is_found_where_it_acts() -> None:
    """It is as long as a third of a block: whole blocks left out would show nothing of it."""
    load = 0.2 * ((T_S > 8.0) & (T_S < 9.0))
    signals, bench = _bench(load + _slow_noise(3, NOISE_A))
    (choice,) = _founded(signals, bench)
    assert choice.candidate.term == "external_load"
    assert_allclose([choice.shape.shape[end] for end in ("start", "end")], [8.0, 9.0], atol=0.1)


def test_an_account_is_none_for_a_load_that_a_curve_takes_the_place_of(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A swinging joint: a late log and a push did more than viscous friction and a late log; the
    push went then, as a curve did more, and of both accounts the late log was left."""
    signals, bench = _bench(0.004 * _motion()["x.acceleration"])
    friction, late, push = (
        Choice(Candidate(key, key, (CandidateForm(lambda: T_S),)), 0)
        for key in ("viscous", "lag", "external_load")
    )
    for name, choices in {"_first": [friction, late], "_alone": [late, push]}.items():
        monkeypatch.setattr(laws, name, lambda *_, found=choices: list(found))
    monkeypatch.setattr(laws, "_continued", lambda _bench, _named, found, _field: found)
    monkeypatch.setattr(laws, "_likelier", lambda _bench, _named, found, _field: found)
    monkeypatch.setattr(
        laws, "_surer_than_curves", lambda _bench, found, _: [c for c in found if c is not push]
    )
    monkeypatch.setattr(
        laws, "_better_account", lambda _, found, rival: rival if push in rival else found
    )
    monkeypatch.setattr(laws, "only_of_their_kind", lambda _, found: found)
    assert _founded(signals, bench) == (friction, late)


def test_a_lost_sign_comes_before_what_soaks_it_up() -> None:
    moved = _motion()
    effort = 0.3 * np.sign(moved["x.velocity"]) + 0.002 * moved["x.velocity"]
    signals, bench = _bench(np.abs(effort) - effort + _slow_noise(4, NOISE_A))
    assert [choice.candidate.term for choice in _founded(signals, bench)] == ["lost_sign"]


@pytest.mark.parametrize("limit", [0.41, 0.44])
def test_what_is_clipped_is_found_with_its_limit(limit: float) -> None:
    moved = _motion()
    effort = 0.3 * np.sign(moved["x.velocity"]) + 0.002 * moved["x.velocity"]
    clipped = np.clip(effort, -limit, limit) - effort
    signals, bench = _bench(clipped + _slow_noise(5, 0.1 * NOISE_A))
    (choice,) = _founded(signals, bench)
    assert choice.candidate.term == "saturation"
    assert_allclose(choice.shape.shape["limit"], limit, rtol=0.03)


def test_blocks_left_out_are_predicted_by_a_fit_to_the_others() -> None:
    rng = np.random.default_rng(6)
    rows = rng.normal(size=(800, 4))
    squares = Folds(rows, 5, blocks=BLOCKS, folds=BLOCKS).by_fold([1, 2, 3], np.zeros(3))
    for block in range(BLOCKS):
        start, end = 100 * block, 100 * (block + 1)
        others = np.r_[0 : max(0, start - 5), min(800, end + 5) : 800]
        fitted = np.linalg.lstsq(rows[others, 1:], rows[others, 0], rcond=None)[0]
        left = rows[start:end, 0] - rows[start:end, 1:] @ fitted
        assert_allclose(squares[block], left @ left, rtol=1e-6)


def test_a_law_that_the_others_give_is_none() -> None:
    moved = _motion()
    signals, bench = _bench(_slow_noise(7, NOISE_A))
    same = Candidate("same", "spring", (CandidateForm(lambda: 2.0 * moved["x.velocity"]),))
    other = Candidate("other", "spring", (CandidateForm(lambda: moved["x.position"]),))
    rows = PlainRows(bench, (same, other), [Choice(same, 0), Choice(other, 0)])
    assert signals.own.keys() >= {"viscous"}
    assert not rows.physical([Choice(same, 0)])
    assert rows.physical([Choice(other, 0)])


def test_signed_ranks_are_wilcoxon_s() -> None:
    differences = np.array([3.0, -1.0, 4.0, 1.5, -0.5, 9.0, 2.6, 5.3])
    ranks = np.argsort(np.argsort(np.abs(differences))) + 1
    total = int(ranks[differences > 0].sum())
    expected = wilcoxon(differences, alternative="greater", method="exact").pvalue
    assert_allclose(SIGNED_RANKS.sum(), 1.0)
    assert_allclose(SIGNED_RANKS[total:].sum(), expected, rtol=1e-12)
