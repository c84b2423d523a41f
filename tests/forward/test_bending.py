"""Work and tool give way as beams do, and the part is off by what that leaves."""

from math import hypot, pi

import pytest
from numpy.testing import assert_allclose

from autodb.files.job import Job
from autodb.forward.bending import CutBending, bending_in_words, bending_of_job
from autodb.forward.prediction import Interval, PredictedCut

FORCE = Interval(300.0, 200.0, 400.0)
STEEL = 210_000.0
BAR = {"diameter_mm": 20.0, "length_mm": 100.0, "modulus_MPa": STEEL, "share": 0.0}
SHANK = {"diameter_mm": 16.0, "length_mm": 60.0, "modulus_MPa": STEEL, "share": 0.0}


def _cut(operation: str) -> PredictedCut:
    across = Interval(-400.0, -500.0, -300.0)
    return PredictedCut("a", operation, 1000.0, 100.0, FORCE, across, FORCE, FORCE, FORCE)


def _bent(operation: str, **stated: object) -> CutBending:
    job = {"name": "j", "material": "C45", "tool": "t", **stated}
    cut = {"diameter_mm": 20, "depth_mm": 1, "feed_mm_rev": 0.2, "speed_rpm": 1000}
    (found,) = bending_of_job(Job.model_validate({**job, "cut": [cut]}), (_cut(operation),))
    return found


def _beam(force: float, bar: dict[str, float], by: float = 3.0) -> float:
    """Return the deflection of a cantilever, or with 48 of a bar between centres."""
    inertia = pi * bar["diameter_mm"] ** 4 / 64.0
    return force * bar["length_mm"] ** 3 / (by * bar["modulus_MPa"] * inertia)


def test_a_turned_diameter_is_off_by_twice_what_both_give_way() -> None:
    found = _bent("turn", bar=BAR, shank=SHANK)
    assert found.work_mm is not None
    assert found.tool_mm is not None
    assert found.error_mm is not None
    assert_allclose(found.work_mm.value, _beam(300.0, BAR))
    assert_allclose(found.tool_mm.high, _beam(400.0, SHANK))
    assert_allclose(found.error_mm.low, 2.0 * (_beam(200.0, BAR) + _beam(200.0, SHANK)))


def test_a_bar_between_centres_is_sixteen_times_as_stiff() -> None:
    found = _bent("turn", bar=BAR | {"held": "centres"})
    assert found.work_mm is not None
    assert_allclose(found.work_mm.value, _beam(300.0, BAR, by=48.0))


def test_a_bore_is_off_by_its_bar_and_a_mill_by_both_forces() -> None:
    bored, milled = (_bent(name, bar=BAR, shank=SHANK) for name in ("bore", "side-down"))
    assert bored.work_mm is None
    assert bored.error_mm is not None
    assert_allclose(bored.error_mm.value, 2.0 * _beam(300.0, SHANK))
    assert milled.tool_mm is not None
    assert_allclose(milled.tool_mm.value, _beam(hypot(300.0, 400.0), SHANK))
    assert milled.error_mm == milled.tool_mm
    assert _bent("slot", shank=SHANK).error_mm is None


def test_what_is_open_of_the_bar_widens_and_a_face_does_not_bend() -> None:
    found = _bent("turn", bar=BAR | {"share": 0.2})
    assert found.work_mm is not None
    assert_allclose(found.work_mm.high, _beam(300.0 + hypot(100.0, 1.96 * 60.0), BAR), rtol=1e-4)
    assert _bent("face", bar=BAR, shank=SHANK) == CutBending(None, None, None)


@pytest.mark.parametrize(("stated", "lines"), [({}, 0), ({"bar": BAR}, 1)])
def test_only_what_is_stated_is_said(stated: dict[str, object], lines: int) -> None:
    job = {"name": "j", "material": "C45", "tool": "t", **stated}
    cut = {"diameter_mm": 20, "depth_mm": 1, "feed_mm_rev": 0.2, "speed_rpm": 1000}
    cuts = (_cut("turn"),)
    bending = bending_of_job(Job.model_validate({**job, "cut": [cut]}), cuts)
    said = list(bending_in_words(cuts, bending))
    assert len(said) == lines
    assert all("work 60.6 µm (40.4 to 80.8), error of the part 121 µm" in one for one in said)
