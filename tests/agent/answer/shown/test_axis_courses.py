"""An axis over the weeks: a drift that was put in is seen, with what was done marked."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from autodb.agent.answer.shown.axis_courses import AxisCourse, machine_course
from autodb.agent.answer.shown.due_lines import due_on
from autodb.agent.rows.calibration_records import as_calibration
from autodb.errors import NotThere
from autodb.reports.axis_course import plot_of_axis
from autodb.store import Store, models, open_store
from tests.conftest import Cli, Once

pytestmark = pytest.mark.usefixtures("one_law")

WEEKS, STEP_A, SHARE = 3, 0.02, 0.05
"""Air current of z grows by a step a week; in the second the spindle's rise by a share."""


@pytest.fixture
def weeks(cli: Cli, sample_jobs: Path, once: Once) -> Iterator[Store]:
    """Give a lathe's database after some weeks, each with a recording; the last not learnt."""
    recordings = sample_jobs / "stepped_shaft/recordings"

    def fill() -> None:
        for line in (
            ("init",),
            ("machine", "add", "lathe-1"),
            ("import", recordings / "standard-cuts.csv"),
            ("calibrate",),
        ):
            assert cli(*line).code == 0
        table = pd.read_csv(recordings / "shop-week-1.csv").iloc[:8]
        for week in range(WEEKS):
            assert cli("import", _written(table, week)).code == 0
            if week == 1:
                assert cli("refresh").code == 0

    once(fill)
    store = open_store("sqlite:///autodb.sqlite3")
    yield store
    store.close()


def _written(table: pd.DataFrame, week: int) -> Path:
    """Write a week's cuts and when they were made."""
    made = table.assign(cut=range(1, len(table) + 1))
    for name in ("z.current.air", "z.current.range"):
        made[name] += week * STEP_A
    if week == 1:
        rise = made["spindle.current.range"] - made["spindle.current.air"]
        made["spindle.current.range"] += SHARE * rise
    path = Path(f"week-{week}.csv")
    made.to_csv(path, index=False)
    start = f'[recording]\nstart = "2026-10-{1 + 7 * week:02d}T08:00:00+00:00"\n'
    path.with_suffix(".toml").write_text(start, "utf-8")
    return path


def _axis(store: Store, name: str) -> AxisCourse:
    with store.reading() as session:
        return next(a for a in machine_course(session, "lathe-1").axes if a.axis == name)


def test_what_drifted_is_seen_at_its_weeks(weeks: Store) -> None:
    z = _axis(weeks, "z")
    own = [one for one in z.air if one.at.startswith("2026-10")]
    assert [one.at[:10] for one in own] == ["2026-10-01", "2026-10-08", "2026-10-15"]
    assert_allclose(np.diff([one.value for one in own]), STEP_A, rtol=1e-6)
    assert [one.evidence for one in own] == [2, 3, 4]


def test_gain_is_that_of_the_calibration_within_its_interval(weeks: Store) -> None:
    with weeks.reading() as session:
        row = session.query(models.CalibrationVersion).filter_by(axis="x").one()
        slope = as_calibration(row).coefficients[1]
    (gain,) = _axis(weeks, "x").gain
    assert gain.low is not None
    assert gain.high is not None
    assert gain.low < gain.value < gain.high
    assert gain.value == pytest.approx(abs(slope), rel=0.15)


def test_force_above_expectation_is_that_which_came_in(weeks: Store) -> None:
    shares = {one.evidence: one.value for one in _axis(weeks, "spindle").residual}
    assert set(shares) == {2, 3}
    assert shares[3] - shares[2] == pytest.approx(100.0 * SHARE, abs=2.0)


def test_what_waits_is_said_and_decisions_are_marked(weeks: Store) -> None:
    with weeks.reading() as session:
        said = due_on(session, "lathe-1")
        assert said[-1].words == "1 recording came since the last refresh"
        with pytest.raises(NotThere):
            due_on(session, "lathe-9")
    with weeks.writing() as session:
        row = models.Mismatch(
            recording_id=3, channel="force.z", term="gain", kind="mistuned", confidence=0.9,
            parameters={}, statement="Force Z reads too high.",
        )  # fmt: skip
        session.add(row)
        session.flush()
        taken = {"status": "confirmed", "term": "gain", "decided_at": "2026-10-09T00:00:00+00:00"}
        session.add(models.MismatchDecision(mismatch_id=row.id, **taken))
        waits = [one for one in due_on(session, "lathe-1") if one.kind == "mismatch"]
        assert [one.words for one in waits] == ["Decide on mismatch 1: a changed scale"]
    z, x = _axis(weeks, "z"), _axis(weeks, "x")
    assert [one.kind for one in z.marks] == ["mismatch", "calibration"]
    assert [one.kind for one in x.marks] == ["calibration"]
    plot = plot_of_axis(z)
    assert plot is not None
    assert str(plot).count('"type":"line"') == 3 * len(z.marks)
