"""How long several edges last that make a part: each by itself, and the first to end."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.agent.answer.bounds.lives import AskedLife, ToolLives, tool_lives
from autodb.agent.answer.prediction_basis import PredictionBasis
from autodb.errors import UnusableInput
from autodb.files.job import Job, JobProgram
from autodb.files.job_cut import JobCut
from autodb.forward.job_cuts import predict
from autodb.forward.prediction import ToolOf
from autodb.forward.programs import follow
from autodb.pairs.posterior import PairPosterior
from tests.agent.answer.test_lasting import FINISH, ROUGH, at_reference, basis, of_fresh, surely
from tests.helpers.turned_pairs import prior
from tests.helpers.worn_pairs import WEARS, worn_posterior

PROGRAM = """G21 G99 G97 S795.7747 M3
{first}
G0 X60 Z0
G1 Z-100 F0.2
G0 X70
Z2
{second}
G0 X59 Z0
G1 Z-50 F0.2
G0 X70
Z2
M30
"""


def _asked(known: PredictionBasis, name: str, *cuts: JobCut, tool: str = "insert") -> AskedLife:
    return AskedLife(known, Job(name=name, material="C45", tool=tool, cut=cuts))


def _drawn_min(
    posterior: PairPosterior, cut: JobCut, limit_N: float, seed: int
) -> NDArray[np.float64]:
    """Draw edges one by one, each with its force, wear and power: T = T_r ((L - F)/w)^(1/p)."""
    wear = posterior.wear
    assert wear is not None
    of_cut = [
        predict(posterior, ToolOf("insert", {}), [cut.model_copy(update={"cutting_time_s": age})])[
            0
        ].force_z_N
        for age in (0.0, wear.reference_s)
    ]
    fresh_N, sd_N = of_cut[0].value, (of_cut[0].high - of_cut[0].low) / 3.92
    added_N = of_cut[1].value - fresh_N
    rng, count = np.random.default_rng(seed), 400_000
    w = added_N * (1.0 + np.hypot(15.0 / 90.0, wear.between) * rng.standard_normal(count))
    power = wear.power * np.exp(wear.power_sd * rng.standard_normal(count))
    room = limit_N - fresh_N - sd_N * rng.standard_normal(count)
    age_s = wear.reference_s * (np.maximum(room, 0.0) / np.maximum(w, 1e-9)) ** (1.0 / power)
    return np.asarray(age_s)


def test_the_first_of_two_edges_ends_as_drawn_ones_do() -> None:
    """Parts until any of two edges ends, against edges of a law that are drawn apart."""
    limit_N = {"rough": 0.0, "finish": 0.0}
    worn = {
        "rough": (worn_posterior(replace(WEARS, power_sd=0.15)), ROUGH),
        "finish": (worn_posterior(replace(WEARS, between=0.3)), FINISH),
    }
    drawn = []
    for seed, (name, (posterior, cut)) in enumerate(worn.items()):
        (one,) = predict(posterior, ToolOf("insert", {}), [cut])
        sd_N = (one.force_z_N.high - one.force_z_N.low) / 3.92
        limit_N[name] = one.force_z_N.value + 5.0 * sd_N
        age_s = _drawn_min(posterior, cut, limit_N[name], seed)
        drawn.append(np.ceil(age_s / 150.0))
    long = {  # each cuts for 150 s of a part
        name: cut.model_copy(update={"length_mm": 2.5 * _mm_min(cut)})
        for name, (_, cut) in worn.items()
    }
    found = tool_lives(
        [
            _asked(basis(posterior), name, long[name], tool=name)
            for name, (posterior, _) in worn.items()
        ],
        limits={f"{name}:force.z": limit for name, limit in limit_N.items()},
        sure=0.9,
    )
    assert found.first is not None
    ends = np.quantile(np.minimum(*drawn), [0.5, 0.025, 0.975, 0.1])
    parts = found.first.parts
    alone = [one.lives[0].parts for one in found.edges]
    said = [parts.value, parts.low, parts.high, found.first.sure_parts]
    known = [k for k, one in enumerate(said) if one is not None]
    assert len(known) >= 3
    assert_allclose(np.array(said, np.float64)[known], ends[known], rtol=0.06, atol=1.0)
    assert parts.value is not None
    assert all(one is not None and (one.value or np.inf) > parts.value for one in alone)


def _mm_min(cut: JobCut) -> float:
    return (cut.feed_mm_rev or 0.0) * 1000.0 * (cut.speed_m_min or 0.0) / np.pi / 60.0


def _of_program(path: Path, first: str, second: str, limit_N: float) -> ToolLives:
    path.write_text(PROGRAM.format(first=first, second=second), "utf-8")
    asked = JobProgram(file=str(path), stock_diameter_mm=64.0)
    program = follow(asked, units="mm", diameter=True)
    job = Job(name="nc", material="C45", tool="insert", program=asked)
    known = basis(surely(worn_posterior(replace(WEARS, between=0.0, power_sd=0.1))))
    return tool_lives([AskedLife(known, job, program)], limits={"force.z": limit_N})


def test_each_tool_of_a_program_ages_in_its_own_lines_alone(tmp_path: Path) -> None:
    """A long pass by one tool and a short one by another; the same by one tool ends sooner."""
    posterior = worn_posterior(replace(WEARS, between=0.0, power_sd=0.1))
    limit_N = of_fresh(posterior)[0] + 0.4 * at_reference(posterior)
    two = _of_program(tmp_path / "two.nc", "T0101", "T0202", limit_N)
    one = _of_program(tmp_path / "one.nc", "T0101", "T0101", limit_N)
    assert [edge.edge for edge in two.edges] == ["0101", "0202"]
    assert [edge.edge for edge in one.edges] == [""]
    long, short = (edge.part_s for edge in two.edges)
    assert long is not None and short is not None
    assert long == pytest.approx(2.0 * short)
    assert one.edges[0].part_s == pytest.approx(3.0 * short)
    minutes = [edge.lives[0].minutes.value for edge in (*two.edges, *one.edges)]
    assert minutes[0] == pytest.approx(minutes[2], rel=0.02)
    assert [edge.lives[0].cut for edge in two.edges] == [1, 2]
    first = two.first
    assert first is not None
    assert first.edge == "0101"
    alone = two.edges[0].lives[0].parts
    # The other edge has cut half as long by then, and hardly ever ends first
    assert alone is not None
    assert first.parts.value == pytest.approx(alone.value, abs=1)
    said = "\n".join(two.lines)
    assert "0101: an edge lasts" in said
    assert "the first edge to end is that of 0101" in said
    assert "cuts with tools 0101, 0202: all by what is known of insert" in said
    assert one.first is None
    assert "the first edge" not in "\n".join(one.lines)


def test_an_edge_whose_wear_nobody_learnt_is_said_and_not_counted() -> None:
    worn = worn_posterior()
    limits = {"force.z": of_fresh(worn)[0] + at_reference(worn)}
    some = [_asked(basis(worn), "a", ROUGH), _asked(basis(prior()), "b", ROUGH, tool="other")]
    found = tool_lives(some, limits=limits)
    alone = tool_lives(some[:1], limits=limits)
    assert found.first is not None
    assert found.first.edge == "insert"
    assert alone.edges[0].lives[0].parts is not None
    assert found.first.parts == alone.edges[0].lives[0].parts
    assert "other: no wear was learnt" in "\n".join(found.lines)
    assert "not counted" in "\n".join(found.lines)


def test_what_cannot_be_asked_of_several_is_said_in_a_line() -> None:
    known = basis(worn_posterior())
    two = [_asked(known, "a", ROUGH), _asked(known, "b", FINISH)]
    found = tool_lives(two, limits={"force.z": 900.0, "b, insert:force.z": 700.0})
    assert [one.edge for one in found.edges] == ["a, insert", "b, insert"]
    assert [one.lives[0].limit for one in found.edges] == [900.0, 700.0]
    with pytest.raises(UnusableInput, match="no edge is called so"):
        tool_lives(two, limits={"c:force.z": 1.0})
    with pytest.raises(UnusableInput, match="is nothing that is predicted"):
        tool_lives(two, limits={"b, insert:force.q": 1.0})
    with pytest.raises(UnusableInput, match="two jobs are called 'a, insert'"):
        tool_lives([two[0], two[0]], limits={"force.z": 900.0})
    open_end = ROUGH.model_copy(update={"length_mm": None})
    with pytest.raises(UnusableInput, match="job 'c': state length_mm"):
        tool_lives([two[0], _asked(known, "c", open_end)], limits={"force.z": 900.0})
