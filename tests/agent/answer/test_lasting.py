"""How long an edge lasts: the life of pairs whose wear is known, drawn by a law of its own."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.agent.answer.bounds.lasting import ToolLife, tool_life
from autodb.agent.answer.prediction_basis import PredictionBasis
from autodb.agent.learn.known import Behind, KnownPair
from autodb.errors import UnusableInput
from autodb.files.job import Job, JobProgram
from autodb.files.job_cut import JobCut
from autodb.files.machine import AxisLimits
from autodb.forward.job_cuts import predict
from autodb.forward.prediction import ToolOf
from autodb.forward.programs import follow
from autodb.forward.tool_life import PartCut, passing_ages_s, whole_parts
from autodb.pairs.posterior import WEAR, PairPosterior
from tests.helpers.turned_pairs import prior
from tests.helpers.worn_pairs import WEARS, worn_posterior

ROUGH = JobCut(
    name="rough", diameter_mm=60.0, depth_mm=2.0, feed_mm_rev=0.2, speed_m_min=150.0,
    length_mm=100.0,
)  # fmt: skip
FINISH = ROUGH.model_copy(update={"name": "finish", "depth_mm": 0.5, "length_mm": 50.0})
TOOL = ToolOf("insert", {})


def basis(posterior: PairPosterior, *, spindle: AxisLimits | None = None) -> PredictionBasis:
    known = KnownPair(posterior, TOOL, Behind(1, 1, 36, None), None)
    limits = {"spindle": spindle or AxisLimits()}
    return PredictionBasis("lathe-1", limits, "C45", known, None, ())


def job(*cuts: JobCut) -> Job:
    return Job(name="shaft", material="C45", tool="insert", cut=cuts)


def life_of(
    posterior: PairPosterior, *cuts: JobCut, limit_N: float, sure: float = 0.95
) -> ToolLife:
    return tool_life(basis(posterior), job(*cuts), limits={"force.z": limit_N}, sure=sure)


def surely(posterior: PairPosterior) -> PairPosterior:
    """Return it with a law, scatter and discrepancy that are as good as known."""
    state = replace(posterior.state, covariance=1e-6 * posterior.state.covariance)
    scatter = replace(posterior.scatter, share=1e-3 * posterior.scatter.share)
    return replace(posterior, state=state, scatter=scatter)


def of_fresh(posterior: PairPosterior) -> tuple[float, float]:
    """Return force z of the rough cut with a fresh edge: mean and standard deviation, N."""
    (one,) = predict(posterior, TOOL, [ROUGH])
    return one.force_z_N.value, (one.force_z_N.high - one.force_z_N.low) / 3.92


def at_reference(posterior: PairPosterior) -> float:
    """Return what wear has added to it at the reference's age, N."""
    at = ROUGH.model_copy(update={"cutting_time_s": WEARS.reference_s})
    return predict(posterior, TOOL, [at])[0].force_z_N.value - of_fresh(posterior)[0]


def test_a_life_is_that_of_a_law_that_is_drawn() -> None:
    """Edges drawn one by one, each with its force, wear and power: T = T_r ((L - F)/w)^(1/p)."""
    wear = replace(WEARS, power_sd=0.15)
    posterior = worn_posterior(wear)
    fresh_N, sd_N = of_fresh(posterior)
    added_N = at_reference(posterior)
    limit_N = fresh_N + 5.0 * sd_N
    rng, count = np.random.default_rng(4), 400_000
    # Of w across the edge the sd is 15 of 90 N/mm; edges differ by a fifth of it besides
    w = added_N * (1.0 + np.hypot(15.0 / 90.0, wear.between) * rng.standard_normal(count))
    power = wear.power * np.exp(wear.power_sd * rng.standard_normal(count))
    room = limit_N - fresh_N - sd_N * rng.standard_normal(count)
    drawn_s = wear.reference_s * (room / np.maximum(w, 1e-9)) ** (1.0 / power)
    (one,) = life_of(posterior, ROUGH, limit_N=limit_N, sure=0.9).lives
    ends = np.quantile(drawn_s / 60.0, [0.5, 0.025, 0.975, 0.1])
    found = [one.minutes.value, one.minutes.low, one.minutes.high, one.sure_min]
    inside = ends < 3.0 * wear.reference_s / 60.0
    assert inside.sum() >= 3
    assert_allclose(np.array(found, np.float64)[inside], ends[inside], rtol=0.05)


def test_a_life_that_is_known_counts_whole_parts_and_the_way_of_the_feed() -> None:
    posterior = surely(worn_posterior(replace(WEARS, between=0.0)))
    limit_N = of_fresh(posterior)[0] + 0.4 * at_reference(posterior)
    found = life_of(posterior, ROUGH, FINISH, limit_N=limit_N)
    (one,) = found.lives
    age_s = 0.4**0.5 * WEARS.reference_s
    per_rev_s = 60.0 / (150.0 / (np.pi * 0.06))
    part_s = (100.0 + 50.0) / 0.2 * per_rev_s
    assert one.parts is not None and one.path_m is not None
    assert found.part_s == pytest.approx(part_s)
    # The last rough cut that begins before that age is of the last good part
    assert one.parts.value == np.ceil(age_s / part_s)
    assert one.minutes.value == pytest.approx(age_s / 60.0, rel=0.01)
    assert one.path_m.value == pytest.approx(0.15 * age_s / part_s, rel=0.01)
    assert one.cut == 1
    older = life_of(
        posterior, ROUGH.model_copy(update={"cutting_time_s": 600.0}), limit_N=limit_N
    ).lives[0]
    assert older.minutes.value == pytest.approx((age_s - 600.0) / 60.0, rel=0.1)
    assert "until force z of cut 1 'rough' passes" in found.lines[0]
    assert "even by the edge as it is" in found.lines[1]  # the law in turning is open by more


def test_a_lower_limit_a_surer_change_and_a_faster_wear_end_a_life_earlier() -> None:
    posterior = worn_posterior()
    high_N = of_fresh(posterior)[0] + at_reference(posterior)
    ends = [life_of(posterior, ROUGH, limit_N=share * high_N).lives[0] for share in (0.9, 1.0)]
    assert (ends[0].minutes.value or 0.0) < (ends[1].minutes.value or np.inf)
    some = [
        life_of(posterior, ROUGH, limit_N=high_N, sure=sure).lives[0].sure_min
        for sure in (0.6, 0.9, 0.99)
    ]
    assert some == sorted(some, key=lambda one: -(one or 0.0))
    assert some[0] != some[2]
    assert posterior.columns(WEAR)


def test_limits_of_the_machine_count_and_the_first_to_end_is_said_first() -> None:
    posterior = worn_posterior()
    found = tool_life(
        basis(posterior, spindle=AxisLimits(torque_N_m=60.0, power_W=5100.0)), job(ROUGH)
    )
    assert [one.channel for one in found.lives] == ["torque.spindle", "spindle.power"]
    assert (found.lives[0].minutes.value or 0.0) < (found.lives[1].minutes.value or np.inf)
    assert "passes 60 N·m" in found.lines[0]
    both = basis(posterior, spindle=AxisLimits(torque_N_m=60.0, power_W=5000.0))  # at 83.33 rad/s
    assert [one.channel for one in tool_life(both, job(ROUGH)).lives] == [
        "torque.spindle", "spindle.power",
    ]  # fmt: skip


def test_beyond_what_was_seen_is_said_and_not_searched_for_ever() -> None:
    found = life_of(worn_posterior(), ROUGH, limit_N=1e5)
    (one,) = found.lives
    assert (one.minutes.value, one.minutes.low, one.minutes.high) == (None, None, None)
    assert "longer than was searched" in found.lines[0]
    assert "no edge was seen beyond 20 min" in " ".join(found.notes)
    assert found.searched_s == 3.0 * WEARS.reference_s


def test_where_no_wear_was_learnt_a_line_says_what_teaches_it() -> None:
    found = tool_life(basis(prior(), spindle=AxisLimits(power_W=5000.0)), job(ROUGH))
    assert found.lives == ()
    assert found.why is not None
    assert "tool.cutting_time" in found.why
    assert "C45 / insert" in found.lines[0]


def test_what_cannot_be_answered_is_said_in_a_line() -> None:
    posterior = worn_posterior()
    for given, said in (
        ({"force.q": 1.0}, "is nothing that is predicted"),
        ({"force.z": 0.0}, "state a number above 0"),
    ):
        with pytest.raises(UnusableInput, match=said):
            tool_life(basis(posterior), job(ROUGH), limits=given)
    with pytest.raises(UnusableInput, match="states no limit"):
        tool_life(basis(posterior), job(ROUGH))
    with pytest.raises(UnusableInput, match="state length_mm of cut 2"):
        life_of(posterior, ROUGH, FINISH.model_copy(update={"length_mm": None}), limit_N=900.0)


def test_a_program_wears_as_its_cut_does(tmp_path: Path) -> None:
    """One pass along the bar, as a line of a program and as a cut of a job."""
    text = "G21 G99 G97 S795.7747 M3\nG0 X60 Z0\nG1 Z-100 F0.2\nG0 X70\nZ0\nM30\n"
    (tmp_path / "p.nc").write_text(text, "utf-8")
    asked = JobProgram(file=str(tmp_path / "p.nc"), stock_diameter_mm=64.0)
    posterior = surely(worn_posterior(replace(WEARS, between=0.0, power_sd=0.1)))
    limits = {"force.z": of_fresh(posterior)[0] + 0.4 * at_reference(posterior)}
    line = Job(name="nc", material="C45", tool="insert", program=asked)
    program = follow(asked, units="mm", diameter=True)
    (of_line,) = tool_life(basis(posterior), line, limits=limits, program=program).lives
    (of_cut,) = tool_life(basis(posterior), job(ROUGH), limits=limits).lives
    for name in ("value", "high"):
        ends = [getattr(one.minutes, name) for one in (of_line, of_cut)]
        assert_allclose(ends[0], ends[1], rtol=0.02)
    assert of_line.parts is not None and of_cut.parts is not None
    assert of_line.parts.value == of_cut.parts.value
    assert of_line.path_m is None


def test_of_many_lines_those_that_load_most_are_looked_at(tmp_path: Path) -> None:
    """Thirty passes, the deepest among them ends the edge; all together take the same answer."""
    passes = "".join(
        f"G0 X{60 - 0.4 * k:.3f} Z1\nG1 Z-20 F{0.4 if k == 17 else 0.15}\nG0 X70\n"
        for k in range(30)
    )
    (tmp_path / "p.nc").write_text(f"G21 G99 G97 S800 M3\n{passes}M30\n", "utf-8")
    asked = JobProgram(file=str(tmp_path / "p.nc"), stock_diameter_mm=60.4)
    line = Job(name="nc", material="C45", tool="insert", program=asked)
    program = follow(asked, units="mm", diameter=True)
    found = tool_life(
        basis(worn_posterior()), line, limits={"force.y": 160.0}, program=program
    )  # fmt: skip
    assert found.part_s == pytest.approx(program.cutting_s)
    assert "F0.4" in found.lives[0].name


def test_ages_and_parts_by_hand() -> None:
    ages, chances = np.array([0.0, 10.0, 20.0]), np.array([0.1, 0.5, 0.9])
    assert passing_ages_s(ages, chances, (0.05, 0.5, 0.9, 0.95)) == [0.0, 10.0, 20.0, None]
    cut = PartCut(1, "", 30.0)
    counted = [whole_parts(age, start_s=0.0, cut=cut, part_s=100.0) for age in (20, 31, 130, 131)]
    assert counted == [0, 1, 1, 2]
