"""Time, removal rate, specific force and energy of cuts, by sums that are done by hand."""

from math import pi
from typing import Any

import pytest
from numpy.testing import assert_allclose

from autodb.files.job_cut import JobCut
from autodb.forward.cut_figures import cut_figures, job_totals
from autodb.forward.job_cuts import predict
from autodb.forward.prediction import ToolOf
from tests.helpers.known_pairs import INSERT, known

MILL = ToolOf("mill", {"diameter_mm": 12.0, "teeth": 3, "helix_deg": 30.0, "corner_radius_mm": 0.0})
DRILL = ToolOf("drill", {"diameter_mm": 8.0})
TURNED: Any = {"diameter_mm": 40.0, "depth_mm": 2.0, "feed_mm_rev": 0.2, "speed_rpm": 1500.0}
MILLED: Any = {"depth_mm": 3.0, "feed_mm_tooth": 0.05, "speed_rpm": 3000.0}
CUTS = [
    (INSERT, JobCut(operation="turn", length_mm=60.0, **TURNED), pi * 42 * 2 * 0.2 * 1.5, 12.0),
    (INSERT, JobCut(operation="bore", length_mm=60.0, **TURNED), pi * 38 * 2 * 0.2 * 1.5, 12.0),
    (
        INSERT,
        JobCut(operation="face", end_diameter_mm=20.0, **TURNED),
        pi * 30 * 2 * 0.2 * 1.5,
        2.0,
    ),
    (MILL, JobCut(operation="slot", length_mm=90.0, **MILLED), 12 * 3 * 0.45, 12.0),
    (MILL, JobCut(operation="side-down", width_mm=4.0, **MILLED), 4 * 3 * 0.45, None),
    (
        DRILL,
        JobCut(operation="drill", feed_mm_rev=0.1, speed_rpm=2000.0, length_mm=20.0),
        pi * 16 * 0.2,
        6.0,
    ),
]  # fmt: skip


@pytest.mark.parametrize(("tool", "cut", "cm3_min", "time_s"), CUTS)
def test_figures_are_those_of_the_hand(
    tool: ToolOf, cut: JobCut, cm3_min: float, time_s: float | None
) -> None:
    """What is swept in a minute, the way over the feed, power over removal, power times time."""
    (made,) = predict(known(), tool, [cut])
    found = cut_figures(made)
    assert found.removal_cm3_min is not None
    assert found.specific_N_mm2 is not None
    assert_allclose(found.removal_cm3_min, cm3_min, rtol=2e-3)
    assert_allclose(found.specific_N_mm2.value, 60.0 * made.power_W.value / found.removal_cm3_min)
    assert (found.time_s is None) == (found.energy_kJ is None) == (time_s is None)
    if found.energy_kJ is not None and time_s is not None and found.time_s is not None:
        assert_allclose(found.time_s, time_s)
        assert_allclose(found.energy_kJ.high, made.power_W.high * time_s / 1000.0)


def test_a_job_s_totals_are_known_where_all_of_its_cuts_are() -> None:
    made = predict(known(), INSERT, [cut for tool, cut, _, _ in CUTS if tool is INSERT])
    figures = [cut_figures(cut) for cut in made]
    totals = job_totals(figures)
    assert totals.time_s == 26.0
    assert totals.removed_cm3 is not None
    assert_allclose(totals.removed_cm3, pi * (42 + 38 + 30 / 6) * 2 * 0.2 * 1.5 / 5, rtol=2e-3)
    open_ended = predict(known(), INSERT, [JobCut(operation="turn", **TURNED)])
    assert job_totals([*figures, cut_figures(open_ended[0])]).time_s is None


def test_forces_are_called_what_they_are() -> None:
    """Fp, Fc, Ff by their axes, of a bore the passive one too; none of a mill's."""
    for cut, roles, passive in (
        (CUTS[0][1], {"Fp": "force.x", "Fc": "force.y", "Ff": "force.z"}, "x"),
        (CUTS[1][1], {"Fp": "force.x", "Fc": "force.y", "Ff": "force.z"}, "x"),
        (CUTS[2][1], {"Ff": "force.x", "Fc": "force.y", "Fp": "force.z"}, "z"),
    ):
        (made,) = predict(known(), INSERT, [cut])
        assert cut_figures(made).roles == roles
        assert made.passive == passive
    (milled,) = predict(known(), MILL, [CUTS[3][1]])
    assert cut_figures(milled).roles == {}
