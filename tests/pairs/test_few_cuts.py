"""Few real cuts: what they scatter by, and which law they speak for."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import stats

from autodb.fitting.gaussian import student_95
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.observed import Observed, X, Y
from autodb.pairs.posterior import USUAL_SCATTER, Scatter, Shared
from autodb.pairs.prior import any_metal
from autodb.pairs.updating import posterior_of_readings
from autodb.proofs.cases.tables.published_tables import DRILLING, published_tables
from autodb.proofs.runs.pairs.published_pairs import (
    ASKED,
    QUANTITIES,
    TURNED_ABOUT,
    foreseen,
    posterior_of_table,
)
from autodb.proofs.runs.pairs.published_summary import published_summary_of
from autodb.proofs.runs.run_file import Finished, Origin

ORIGIN = Origin("pair-tables", "0", "generator", "product")


@pytest.mark.parametrize("freedom", [4.0, 6.0, 10.0, 40.0, 1e6])
def test_student_95(freedom: float) -> None:
    assert_allclose(student_95(np.array(freedom)), stats.t.ppf(0.975, freedom), rtol=3e-3)


def test_how_probable_a_scatter_is() -> None:
    """As scipy has it: variances are inverse gamma, in their logarithm."""
    weight = USUAL_SCATTER.weight
    drawn = stats.invgamma(0.5 * weight, scale=0.5 * weight * USUAL_SCATTER.share**2)

    def said(share: float) -> float:
        variance = np.full(2, share**2)
        return float(np.sum(drawn.logpdf(variance) + np.log(variance)))

    here, there = (Scatter(np.full(2, share), weight) for share in (0.02, 0.3))
    found = USUAL_SCATTER.log_chance(here) - USUAL_SCATTER.log_chance(there)
    assert_allclose(found, said(0.02) - said(0.3), rtol=1e-9)


def test_the_next_cut_is_as_wide_as_the_few_before_tell() -> None:
    none, few, many = (
        Scatter(np.array([0.04, 0.1]), np.full(2, weight)) for weight in (2.0, 4.0, 1e9)
    )
    assert_allclose(few.of_next.share / few.share, 2.776 / 1.960, rtol=4e-3)
    assert_allclose(none.of_next.share, few.of_next.share)
    assert_allclose(many.of_next.share, many.share, rtol=1e-6)


def test_what_published_forces_scatter_by_and_how_they_grow_with_depth() -> None:
    """Figures that the priors of scatter and of a law far off are chosen by."""
    along: list[float] = []
    across: list[float] = []
    exponents: list[float] = []
    for table in published_tables().values():
        if table.name in DRILLING:
            continue
        roles = TURNED_ABOUT.get(table.name, QUANTITIES)
        logs = np.vstack([np.ones(len(table)), np.log([table.feed, table.depth, table.speed])])
        for channel, force in table.forces.items():
            found, *_ = np.linalg.lstsq(logs.T, np.log(force))
            left = np.log(force) - found @ logs
            scatter = float(np.sqrt(left @ left / (len(table) - 4)))
            (along if roles[channel] == 1 else across).append(scatter)
            exponents.append(found[2])
    assert_allclose(np.quantile(along, (0.0, 0.5, 1.0)), (0.04, 0.07, 0.27), atol=0.006)
    assert_allclose(np.quantile(across, (0.0, 0.5, 1.0)), (0.04, 0.17, 0.24), atol=0.006)
    assert_allclose([min(exponents), max(exponents)], [0.6, 1.4], atol=0.05)
    assert np.std(exponents) == pytest.approx(0.23, abs=0.005)


@pytest.mark.parametrize(
    ("name", "seed", "count"), [("mata", [12, 5, 4], 12), ("aouici", [6, 3, 6], 6)]
)
def test_forces_of_few_published_cuts_are_foreseen(name: str, seed: list[int], count: int) -> None:
    """Where only one hill was climbed, these came out 14 and 21, and 0.8 to 1.3 times too large."""
    table = published_tables()[name]
    order = np.random.default_rng(seed).permutation(len(table))
    forces = foreseen(table, order[:count], order[-ASKED:])
    for channel in table.forces:
        own = [one for one in forces if one.component == channel]
        off = [(one.value[0] - one.force) / one.size for one in own]
        assert np.sqrt(np.mean(np.square(off))) < 0.45
        assert sum(one.low[0] < one.force < one.high[0] for one in own) >= 6  # type: ignore[operator]


def test_rows_in_any_order_are_one_table() -> None:
    """Its one component is along the cutting speed: of what is across, no cut says anything."""
    table = published_tables()["lin"]
    order = np.random.default_rng(3).permutation(len(table))[:9]
    one, other = (posterior_of_table(table.rows(rows)) for rows in (order, order[::-1]))
    sd = np.sqrt(np.diag(one.state.covariance))
    off = (one.state.mean - other.state.mean)[sd > 0.0] / sd[sd > 0.0]
    assert np.max(np.abs(off)) < 1e-6
    assert any_metal().scatter == USUAL_SCATTER
    assert_allclose(one.scatter.weight, [9 + 2.0, 2.0], rtol=1e-12)


def test_score_of_published_pairs() -> None:
    """Of one table, whose letters are others, as counted by hand."""
    table = published_tables()["fnides"]
    assert set(table.forces) == set(QUANTITIES)
    order = np.random.default_rng(1).permutation(len(table))
    forces = foreseen(table, order[:12], order[-ASKED:])
    score = published_summary_of([Finished(1, tuple(forces))], ORIGIN)
    assert {(one.component, one.way, one.forces) for one in score.rows} == {
        (channel, way, ASKED)
        for channel in table.forces
        for way in ("autodb", "power law", "Kienzle with speed")
    }
    own = [one for one in forces if one.component == "force.y"]
    row = next(one for one in score.rows if (one.component, one.way) == ("force.y", "autodb"))
    assert row.held == np.mean([one.low[0] <= one.force <= one.high[0] for one in own])  # type: ignore[operator]
    off = [one.value[0] - one.force for one in own]
    assert_allclose(row.error, np.sqrt(np.mean(np.square(off))) / np.mean(table.forces["force.y"]))
    assert row.error < 0.15


@pytest.mark.parametrize("feed", np.linspace(0.05, 0.12, 8))
def test_learning_comes_back_from_a_scatter_that_is_tried_far_off(feed: float) -> None:
    """Mixed rounds may try one of 10^14: rounding must not leave a variance below 0 of the rest."""
    mill = {"diameter_mm": 10.0, "teeth": 4.0, "helix_deg": 30.0, "rake_deg": 8.0}
    cut = {
        "cutting.feed": feed, "cutting.depth": 5.81, "cutting.width": 7.33,
        "spindle.speed": 5377.0,
    }  # fmt: skip
    observed = Observed(
        cuts=(BY_NAME["slot"].cuts(mill, [cut], called="mill"),),
        cut=np.array([0, 0]),
        quantity=np.array([X, Y]),
        value=np.array([-531.0, 299.0]),
        sd=np.array([17.0, 17.0]),
        common=np.eye(2),
        shared=tuple(Shared(f"gain {one}", np.array([[0.03**2]])) for one in (X, Y)),
    )
    far = Scatter(np.array([1.25578755e14, 5.9e-3]), np.full(2, 4.0))
    learnt, come_back = (
        posterior_of_readings(any_metal(), observed, near=near)
        for near in (None, replace(any_metal(), scatter=far))
    )
    assert_allclose(come_back.scatter.share, learnt.scatter.share, rtol=1e-6)
