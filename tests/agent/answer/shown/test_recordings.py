"""What is said of stored recordings: their cuts, their quality, and what is drawn of them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from autodb.agent.answer.shown.recorded import MOST, course_of
from autodb.agent.answer.shown.recordings import recording_said, recordings_seen, stored_recording
from autodb.errors import NotThere, SetAside
from autodb.records.source import read
from autodb.records.tables import Recording
from autodb.sensing.ranges.recorded.raw import cut_stretch
from autodb.store import models, open_store
from tests.conftest import Cli

pytestmark = pytest.mark.usefixtures("one_law")

RAW = "stepped_shaft/recordings/standard-cut-raw.parquet"


def test_the_cut_of_a_recording_is_where_its_force_is(sample_jobs: Path) -> None:
    recording = read(sample_jobs / RAW)
    assert isinstance(recording, Recording)
    low, high = cut_stretch(recording)
    force, t_s = recording["force.y"], recording.t_s
    level = np.median(force[(t_s > low + 0.5) & (t_s < high - 0.5)])
    inside = force > 0.5 * level
    assert low == pytest.approx(t_s[inside][0], abs=0.15)
    assert high == pytest.approx(t_s[inside][-1], abs=0.15)
    air = replace(
        recording, channels={k: v[t_s < low - 0.6] for k, v in recording.channels.items()}
    )
    with pytest.raises(SetAside):
        cut_stretch(air)


def test_recordings_are_seen_said_and_drawn(standard_learnt: Cli, sample_jobs: Path) -> None:
    raw = Path("raw.parquet")
    raw.write_bytes((sample_jobs / RAW).read_bytes())
    Path("raw.toml").write_bytes((sample_jobs / RAW).with_suffix(".toml").read_bytes())
    assert standard_learnt("import", raw, "--machine", "lathe-1").code == 0
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        over_time, table = recordings_seen(session, "lathe-1", most=5)
        assert (over_time.name, over_time.length_s, over_time.rate_hz) == (raw.name, 11.4, 1000.0)
        assert (over_time.cuts, over_time.learnt_from, over_time.flags) == (1, False, ())
        assert (table.length_s, table.learnt_from, table.cuts) == (None, True, 32)
        said = recording_said(session, "lathe-1", over_time.id)
        assert said.findings[0] == "Time stamps: even, 1000 Hz."
        assert any("spindle.speed" in one for one in said.findings if "same number" in one)
        kinds = [one.kind for one in recording_said(session, "lathe-1", table.id).resting]
        assert kinds == ["calibration"] * 3 + ["parameters"]
        course = course_of(session.get_one(models.StoredRecording, over_time.id))
        assert course.over_time
        assert list(course.channels)[:3] == ["force.x", "force.y", "force.z"]
        assert len(course.channels) == MOST
        assert len(course.cuts) == 1
        cuts = course_of(session.get_one(models.StoredRecording, table.id))
        assert (cuts.over_time, len(cuts.x), cuts.units["force.y"]) == (False, 32, "N")
        with pytest.raises(NotThere, match="has no recording 99"):
            stored_recording(session, "lathe-1", 99)
    raw.unlink()
    with store.reading() as session:
        (gone, _) = recordings_seen(session, "lathe-1", most=5)
        assert gone.flags == ("file missing",)
    store.close()
