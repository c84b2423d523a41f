"""Pairs of three other laws: the generator's physics, least squares, one pair, the limits."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.proofs.machines.lathe import law_pairs
from autodb.proofs.machines.lathe.edge_laws import EDGE_LAWS, KIENZLE, SHEAR, EdgeLaw, Slants
from autodb.proofs.machines.lathe.law_pairs import (
    LAW_LEVELS,
    TWO_LEVELS,
    EdgeTool,
    LawPair,
    draw_law_pair,
    law_forces_N,
)
from autodb.proofs.machines.lathe.power_pairs import TurnedCut
from autodb.proofs.machines.lathe.process import SCATTER_TANGENTIAL, SCATTER_THRUST
from autodb.proofs.runs.pairs.laws_case import LawsCase, draw_laws_case
from autodb.proofs.runs.pairs.laws_groups import EVERYWHERE, INSIDE, OUTSIDE
from autodb.proofs.runs.pairs.laws_nominal import nominal_sd_N
from autodb.proofs.runs.pairs.laws_peers import kienzle_squares
from autodb.proofs.runs.pairs.laws_run import DrawnLaw, ForeseenForce, run_laws
from autodb.proofs.runs.pairs.laws_summary import LawsSummary, holm_adjusted, laws_summary_of
from autodb.proofs.runs.run_file import Finished, Origin

Array = NDArray[np.float64]

FLAT = Slants(0.0, 0.0)
STRAIGHT = EdgeTool(0.0, 90.0, 80.0, 0.0, 0.0)
SEED = 104
"""A pair with a stated tool and a dynamometer."""
CUT = TurnedCut(feed_mm=0.2, depth_mm=2.0, speed_m_min=150.0)


def _plain(law: EdgeLaw, m_c: float = 0.25, edge: tuple[float, float] = (0.0, 0.0)) -> LawPair:
    """A law as it is expected, on a straight edge across the feed."""
    numbers = dict(zip(law.names, law.expected, strict=True))
    numbers |= {"m_c": m_c, "K_te": edge[0], "K_re": edge[1]}
    return LawPair(law, numbers, STRAIGHT, any(edge), True, True, 150.0, np.ones(3))


@pytest.mark.parametrize("law", EDGE_LAWS, ids=lambda law: law.name)
@pytest.mark.parametrize("m_c", [0.35, 0.1])
def test_specific_forces_rise_as_the_size_exponent_says(law: EdgeLaw, m_c: float) -> None:
    """From chips of 0.08 to 0.4 mm; a law that saturates below has its power above 0.02 mm."""
    pair = _plain(law, m_c)
    thin, thick = (law_forces_N(pair, replace(CUT, feed_mm=feed))[1] / feed for feed in (0.08, 0.4))
    off = 0.15 * m_c if law.name == "linear edge" else 1e-9
    assert_allclose(np.log(thin / thick) / np.log(5.0), m_c, atol=off)


@pytest.mark.parametrize("law", EDGE_LAWS, ids=lambda law: law.name)
def test_a_chip_of_no_thickness_leaves_the_edge_force(law: EdgeLaw) -> None:
    thinnest = replace(CUT, feed_mm=1e-9)
    assert_allclose(law_forces_N(_plain(law), thinnest), 0.0, atol=0.01)
    held = law_forces_N(_plain(law, edge=(25.0, 40.0)), thinnest)
    assert_allclose(held, [0.0, 2.0 * 25.0, 2.0 * 40.0], atol=0.01)


@pytest.mark.parametrize("law", EDGE_LAWS, ids=lambda law: law.name)
def test_forces_are_in_newtons_and_of_the_usual_size(law: EdgeLaw) -> None:
    """0.4 mm² of a steel: some 2500 N/mm² along the speed, 0.3 to 0.7 of it against the feed."""
    _, tangential, feed = law_forces_N(_plain(law), CUT)
    assert_allclose(tangential, 0.4 * 2500.0, rtol=0.2)
    assert 0.3 < feed / tangential < 0.7
    deeper = law_forces_N(_plain(law), replace(CUT, depth_mm=4.0))
    assert_allclose(deeper, 2.0 * law_forces_N(_plain(law), CUT), atol=1e-9)


def test_a_straight_edges_chip_is_thinner_and_wider_by_its_entering_angle() -> None:
    """h = f sin κ over b = a_p / sin κ; its thrust is split as the edge lies."""
    pair = replace(_plain(KIENZLE), tool=replace(STRAIGHT, kappa_deg=45.0, included_deg=90.0))
    sin = np.sqrt(0.5)
    across = law_forces_N(_plain(KIENZLE), replace(CUT, feed_mm=0.2 * sin, depth_mm=2.0 / sin))
    passive, tangential, feed = law_forces_N(pair, CUT)
    assert_allclose(tangential, across[1], rtol=1e-12)
    assert_allclose([passive, feed], [across[2] * sin] * 2, rtol=1e-12)


def test_a_nose_takes_the_area_of_the_chip_and_pushes_off_the_work(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    nose = replace(_plain(SHEAR, 0.0), tool=replace(STRAIGHT, nose_mm=0.8))
    flat = _plain(SHEAR, 0.0)
    assert_allclose(law_forces_N(nose, CUT)[1], law_forces_N(flat, CUT)[1], rtol=1e-3)
    shallow = replace(CUT, depth_mm=0.5)
    assert law_forces_N(nose, shallow)[0] > law_forces_N(nose, shallow)[2] > 0.0
    few = law_forces_N(nose, shallow)
    monkeypatch.setattr(law_pairs, "PLACES", 2 * law_pairs.PLACES)
    assert_allclose(few, law_forces_N(nose, shallow), rtol=1e-3)


@pytest.mark.parametrize("law", EDGE_LAWS, ids=lambda law: law.name)
def test_an_edge_inclined_below_its_tip_is_pushed_off_the_work(law: EdgeLaw) -> None:
    """Negative inclination: the tip meets the work last; the passive force of 90° is all its."""
    passive = [
        law_forces_N(replace(_plain(law), tool=replace(STRAIGHT, inclination_deg=i)), CUT)[0]
        for i in (-6.0, 0.0, 6.0)
    ]
    assert passive[0] > 20.0
    assert_allclose(passive[1], 0.0, atol=1e-9)
    assert passive[2] < -20.0


def test_the_oblique_shear_law_is_merchants_where_nothing_is_inclined() -> None:
    """A power balance by hand: φ = 45° - (β - α)/2, R = τ b h / (sin φ cos(φ + β - α))."""
    numbers = _plain(SHEAR, 0.0).numbers
    alpha = np.radians(5.0)
    beta = np.arctan(0.4 + 0.35 * np.exp(-150.0 / 120.0))
    phi = np.pi / 4.0 - 0.5 * (beta - alpha)
    whole = 650.0 * 0.2 / (np.sin(phi) * np.cos(phi + beta - alpha))
    found = SHEAR.per_width(numbers, np.array([0.2]), 150.0, Slants(float(alpha), 0.0))
    expected = whole * np.array([np.cos(beta - alpha), np.sin(beta - alpha), 0.0])
    got = np.concatenate([found.tangential, found.thrust, found.along])
    assert_allclose(got, expected, atol=1e-9)


def test_faces_and_tapers_turn_the_forces_of_the_path() -> None:
    """A square edge that faces at 90° meets the work as in turning, mirrored."""
    pair = replace(_plain(KIENZLE), tool=replace(STRAIGHT, included_deg=90.0, inclination_deg=-6.0))
    turned, faced = (law_forces_N(pair, replace(CUT, inward_deg=a)) for a in (0.0, 90.0))
    assert_allclose(faced, turned[[2, 1, 0]], atol=1e-9)
    taper = law_forces_N(pair, replace(CUT, inward_deg=20.0))
    assert_allclose(np.hypot(taper[0], taper[2]), np.hypot(turned[0], turned[2]), rtol=0.1)


def test_levels_are_crossed_by_blocks_of_seeds() -> None:
    pairs = [draw_law_pair(seed, np.random.default_rng(seed)) for seed in range(1, 28)]
    crossed = {(p.law.name, p.numbers["m_c"], p.tool.kappa_deg) for p in pairs}
    assert len(crossed) == len(LAW_LEVELS) == 27
    two = {(p.tool.nose_mm > 0.0, p.edge, p.measured, p.stated) for p in pairs[:16]}
    assert len(two) == len(TWO_LEVELS) == 16


def _case(seed: int, pair: LawPair) -> LawsCase:
    """A seed's cuts of another pair, read without noise."""
    case = draw_laws_case(seed)
    read = np.array([law_forces_N(pair, cut) for cut in case.cuts])
    asked = np.array([law_forces_N(pair, cut) for cut in case.asked])
    return replace(case, pair=pair, read_N=read, mean_N=asked, next_N=asked)


def test_least_squares_finds_a_line_of_kienzle_and_knows_how_sure_it_is() -> None:
    pair = replace(_plain(KIENZLE), tool=replace(STRAIGHT, kappa_deg=75.0, included_deg=120.0))
    case = _case(1, pair)
    told = kienzle_squares(case, speed=True)
    turned = np.array([cut.inward_deg == 0.0 for cut in case.asked])
    assert_allclose(told.value[turned], case.mean_N[turned], rtol=1e-6)
    assert_allclose(told.high[turned], told.low[turned], rtol=1e-6)
    noisy = replace(
        case, read_N=case.read_N * np.exp(0.1 * np.random.default_rng(1).normal(size=(24, 3)))
    )
    told = kienzle_squares(noisy, speed=False)
    half = 0.5 * np.log(told.high / told.low)[turned].mean()
    assert_allclose(half, 2.07 * 0.1 * np.sqrt(1.0 + 3.0 / 24.0), rtol=0.2)


def test_least_squares_tells_only_what_was_read() -> None:
    """Sensed are y and z of turning: no x, no force of a taper that holds a passive part."""
    seed = next(s for s in range(1, 17) if not draw_laws_case(s).pair.measured)
    case = draw_laws_case(seed)
    told = kienzle_squares(case, speed=False)
    kinds = np.array(case.kinds)
    assert np.isnan(told.value[kinds == INSIDE, 0]).all()
    assert np.isfinite(told.value[kinds == "faces"][:, [0, 1]]).all()
    assert np.isnan(told.value[kinds == "faces", 2]).all()
    tapers = told.value[kinds == "tapers of 20°"]
    assert np.isfinite(tapers[:, 1]).all()
    assert np.isnan(tapers[:, [0, 2]]).all()


def test_a_nominal_interval_holds_scatter_and_what_the_gain_leaves() -> None:
    """With many cuts and no gain it is the scatter; the gain of 24 cuts adds its own square."""
    case = draw_laws_case(next(s for s in range(1, 17) if not draw_laws_case(s).pair.measured))
    forces = np.array([law_forces_N(case.pair, cut) for cut in case.asked])
    share = (nominal_sd_N(case) / np.abs(forces))[np.array(case.kinds) == INSIDE]
    along, feed = share[:, 1], share[:, 2]
    assert np.all(along > np.hypot(SCATTER_TANGENTIAL, 0.9 * case.pair.gain_share))
    assert np.all(along < 1.5 * np.hypot(SCATTER_TANGENTIAL, case.pair.gain_share))
    assert np.all(feed > np.hypot(SCATTER_THRUST, 0.8 * case.pair.gain_share))


def test_one_pair_is_learnt_and_judged() -> None:
    """A stated tool, forces measured: the mean force inside is near, and within its interval."""
    judged = run_laws(SEED)
    (pair,) = [one for one in judged if isinstance(one, DrawnLaw)]
    forces = [one for one in judged if isinstance(one, ForeseenForce) and one.kind == INSIDE]
    assert (pair.measured, pair.stated, len(forces)) == (True, True, 30)
    error = [abs((one.value[0] or 0.0) - one.mean) / one.size for one in forces]
    assert np.median(error) < 0.05
    found = laws_summary_of([Finished(SEED, tuple(judged))], Origin("pair-laws", "0", "g", "p"))
    assert LawsSummary.from_json(found.to_json()) == found
    assert all(len(row) == len(t.heads) for t in found.tables() for row in t.rows)


def _judged(seed: int, *, ours: float, half: float, peer: float = 0.03) -> list[ForeseenForce]:
    """Forces of 1000 N, a nominal half-width of 100 N; errors differ a little by the seed."""
    little = 1.0 + 0.1 * float(np.random.default_rng(seed).standard_normal())

    def one(kind: str) -> ForeseenForce:
        value = (1000.0 * (1.0 + ours * little), *(1000.0 * (1.0 + peer),) * 2)
        halves = (half, 150.0, 150.0)
        ends = [tuple(v + s * h for v, h in zip(value, halves, strict=True)) for s in (-1, 1)]
        return ForeseenForce(kind, 1, 0.2, 1000.0, 1000.0, 1000.0, 100.0, value, *ends)

    return [one(INSIDE), one("faces")]


def _summed(
    *, ours: float = 0.01, half: float = 120.0, peer: float = 0.03, lost: int = 0
) -> LawsSummary:
    pair = DrawnLaw("shear", 0.25, True, 0.8, 90.0, True, True)
    runs: list[Finished[DrawnLaw | ForeseenForce]] = []
    for seed in range(1, 21):
        forces = _judged(seed, ours=ours, half=half, peer=peer)
        if seed <= lost:
            none = (None, *forces[0].low[1:])
            forces = [replace(one, low=none, high=(None, *one.high[1:])) for one in forces]
        runs.append(Finished(seed, (pair, *forces)))
    return laws_summary_of(runs, Origin("pair-laws", "0", "g", "p"))


def test_the_limits_of_width_and_coverage_can_fail() -> None:
    good = _summed()
    assert good.passed
    row = good.rows[0]
    assert (row.region, row.pairs, row.share) == (INSIDE, 20, 1.0)
    assert row.half == pytest.approx(0.12)
    assert row.over_nominal == pytest.approx(1.2)
    assert_allclose([row.share_low, row.share_high], [0.8316, 1.0], atol=1e-4)
    wide = _summed(half=131.0)
    assert {one.region for one in wide.rows if one.passed} == {OUTSIDE}
    assert not any(one.passed for one in _summed(ours=0.05, half=20.0).rows)


def test_an_interval_that_is_not_given_holds_nothing() -> None:
    assert_allclose(_summed(lost=5).rows[0].share, 0.75)
    most = _summed(lost=15)
    assert most.rows[0].half is None
    assert not most.passed
    assert LawsSummary.from_json(most.to_json()) == most


def test_least_squares_that_is_nearer_in_every_pair_fails_the_row() -> None:
    worse = _summed(ours=0.05, peer=0.03)
    inside = next(one for one in worse.beside if one.region == INSIDE)
    assert inside.worse[0] < 0.01
    assert not inside.passed
    assert not any(one.passed for one in worse.beside if one.region == EVERYWHERE)
    alike = _summed(ours=0.03, half=150.0, peer=0.03)
    assert all(one.passed for one in alike.beside if not one.pooled)
    assert not any(one.passed for one in alike.beside if one.pooled), "as good is not better"


def test_holms_adjustment_steps_down() -> None:
    """By hand: 4 · 0.01, 3 · 0.02, then no less than before: 2 · 0.03, 1 · 0.5."""
    found = holm_adjusted(np.array([0.03, 0.01, 0.5, 0.02]))
    assert_allclose(found, [0.06, 0.04, 0.5, 0.06])
