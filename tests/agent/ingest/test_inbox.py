"""An inbox: what comes in is imported once, kept, or refused; nothing counts twice."""

import errno
import hashlib
import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import pandas as pd
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import event, func, select
from sqlalchemy.orm import Session

from autodb.agent.answer import drifted_gains
from autodb.agent.ingest.inbox import Inbox
from autodb.agent.learn import inferred_edges, learning
from autodb.agent.learn.passes import RefreshReport
from autodb.agent.learn.shifted import ForceShift, shifts
from autodb.agent.operate import refreshing
from autodb.agent.operate.refreshing import refresh, watch
from autodb.agent.rows import refresh_cursor
from autodb.agent.rows.posteriors import as_posterior, latest
from autodb.assets import kit
from autodb.errors import UnusableInput
from autodb.pairs.posterior import PairPosterior
from autodb.store import Store, models, open_store
from tests.conftest import Cli, Once

pytestmark = pytest.mark.usefixtures("one_law")

URL = "sqlite:///autodb.sqlite3"
MACHINE = "lathe-1"
WEEK = "shop-week-1.csv"
RECORDINGS = kit("sample_jobs") / "stepped_shaft" / "recordings"
WEEK_ROWS = 16


@pytest.fixture
def calibrated(cli: Cli, once: Once) -> Cli:
    """Return a database whose lathe is calibrated and has learnt nothing, and an empty inbox."""

    def make() -> None:
        standard = pd.read_csv(RECORDINGS / "standard-cuts.csv").drop(columns="tool")
        standard.to_csv("standard.csv", index=False)  # of no tool: nothing is learnt from it
        cli("init")
        cli("machine", "add", MACHINE)
        cli("import", "standard.csv", "--machine", MACHINE)
        cli("calibrate", "--machine", MACHINE)
        assert cli("refresh", "--machine", MACHINE).code == 0
        Path("in").mkdir()

    once(make)
    return cli


def _week(rows: slice = slice(None)) -> pd.DataFrame:
    return pd.read_csv(RECORDINGS / WEEK).iloc[:WEEK_ROWS].iloc[rows]


def _deliver(name: str, table: pd.DataFrame) -> Path:
    path = Path("in") / name
    table.to_csv(path, index=False)
    return path


def _take(store: Store | None = None) -> RefreshReport:
    """Refresh with the inbox; files count as written at once."""
    with _opened() as opened:
        return refresh(store or opened, MACHINE, inbox=Inbox(Path("in"), settled_s=0.0))


@contextmanager
def _opened() -> Iterator[Store]:
    store = open_store(URL)
    try:
        yield store
    finally:
        store.close()


@contextmanager
def _reading() -> Iterator[Session]:
    with _opened() as store, store.reading() as session:
        yield session


def _posterior() -> PairPosterior:
    with _reading() as session:
        row = latest(session, 1, 1)
        assert row is not None
        return as_posterior(row)


def _shifted(posterior: PairPosterior) -> list[ForceShift]:
    """Return what is believed now of as many cuts, where it is not what was believed."""
    with _reading() as session:
        now = latest(session, 1, 1)
        assert now is not None
        assert now.n_cuts == posterior.cuts
        return shifts("pair", posterior, as_posterior(now), now.forces)


def _counting() -> list[tuple[float, str]]:
    """Return the cuts that count, but those of the standard table, by number and content."""
    with _reading() as session:
        cuts = session.scalars(
            select(models.Cut).where(
                models.Cut.superseded_at.is_(None), models.Cut.recording_id > 1
            )
        )
        return sorted((cut.number, json.dumps([cut.conditions, cut.measured])) for cut in cuts)


@cache
def _undisturbed() -> tuple[list[tuple[float, str]], PairPosterior]:
    """Return the cuts and the posterior of a database that the whole week came to, once."""
    before = Path("autodb.sqlite3").read_bytes()
    _deliver(WEEK, _week())
    _take()
    known = _counting(), _posterior()
    for one in Path().glob("autodb.sqlite3*"):
        one.unlink()
    Path("autodb.sqlite3").write_bytes(before)
    shutil.rmtree("in/kept")
    return known


def test_what_comes_in_is_kept_and_reported(calibrated: Cli) -> None:
    _deliver(WEEK, _week())
    Path("in/note.txt").write_text("not a recording", encoding="utf-8")
    (Path("in") / "half.csv.part").write_text("cut,t", encoding="utf-8")
    done = calibrated("refresh", "--machine", MACHINE, "--inbox", "in")
    assert done.code == 0, done.err
    assert f"{WEEK}: recording 2, {WEEK_ROWS} new cuts" in done.out
    assert "note.txt: refused: " in done.out
    assert f"version 1 from {WEEK_ROWS} cuts" in done.out
    left = {str(path.relative_to("in")) for path in Path("in").rglob("*") if path.is_file()}
    kept = next(Path("in/kept").rglob(WEEK))
    assert left == {"note.txt", "half.csv.part", str(kept.relative_to("in"))}
    with _reading() as session:
        row = session.get_one(models.StoredRecording, 2)
        assert row.path == str(kept.resolve())
        assert row.delivered_as == str(Path("in", WEEK).resolve())

    # Another look finds nothing new; the report of the pass stays
    again = calibrated("refresh", "--machine", MACHINE, "--inbox", "in").out
    assert "nothing new" in again
    assert "refused" not in again
    report = calibrated("refresh", "--machine", MACHINE, "--report").out
    assert done.out in report
    told = json.loads(calibrated("refresh", "--machine", MACHINE, "--report", "--json").out)
    assert [one["file"] for one in told["came_in"]] == ["note.txt", WEEK]
    assert calibrated("doctor").code == 0


@pytest.mark.usefixtures("calibrated")
def test_a_refused_file_is_read_again_once_its_side_file_says_more() -> None:
    foreign = _week()[["cut", "t", "operation", "z.current.range"]]
    _deliver("foreign.csv", foreign.rename(columns={"z.current.range": "I_Z"}))
    (one,) = _take().came_in
    assert "nothing was measured in its cuts" in str(one.reason)
    assert not _take().came_in
    Path("in/foreign.toml").write_text('[channels]\n"z.current.range" = "I_Z"\n', encoding="utf-8")
    (one,) = _take().came_in
    assert (one.status, one.cuts) == ("imported", WEEK_ROWS)
    assert (next(Path("in/kept").rglob("foreign.csv")).parent / "foreign.toml").is_file()


@pytest.mark.usefixtures("calibrated")
def test_a_file_that_comes_twice_counts_once() -> None:
    known, posterior = _undisturbed()
    for name in (WEEK, "copy.csv", WEEK):
        _deliver(name, _week())
        _take()
    assert _counting() == known
    assert_allclose(_posterior().state.mean, posterior.state.mean, rtol=0, atol=0)
    assert [path.name for path in Path("in").rglob("*.csv")] == [WEEK]


@pytest.mark.usefixtures("calibrated")
def test_a_table_that_grows_adds_what_is_new() -> None:
    known, posterior = _undisturbed()
    for rows in (6, 12, WEEK_ROWS, 10):  # the last is cut off
        _deliver(WEEK, _week(slice(0, rows)))
        done = _take()
        assert [one.status for one in done.came_in] == ["imported"]
    assert _counting() == known
    assert not _shifted(posterior)


@pytest.mark.usefixtures("calibrated")
def test_a_mended_row_takes_the_place_of_the_damaged_one() -> None:
    known, posterior = _undisturbed()
    damaged = _week()
    damaged.loc[damaged.index[7], "z.current.range"] *= 1.9
    _deliver(WEEK, damaged)
    _take()
    _deliver(WEEK, _week())
    (one,) = _take().came_in
    assert (one.status, one.cuts) == ("imported", 1)
    assert _counting() == known
    assert_allclose(_posterior().state.mean, posterior.state.mean, rtol=1e-6)


@pytest.mark.usefixtures("calibrated")
def test_a_logger_that_uses_one_name_brings_other_cuts() -> None:
    _deliver("cut.csv", _week(slice(0, 8)))
    _take()
    later = _week(slice(8, 16))
    later["cut"] = _week(slice(0, 8))["cut"].to_numpy()
    _deliver("cut.csv", later)
    (one,) = _take().came_in
    assert one.cuts == 8
    assert len(_counting()) == 16
    assert len(list(Path("in/kept").rglob("cut*.csv"))) == 2


def _raw(rows: slice) -> pd.DataFrame:
    return pd.read_parquet(RECORDINGS / "standard-cut-raw.parquet").iloc[rows]


@pytest.mark.usefixtures("calibrated")
def test_a_recording_over_time_that_comes_whole_takes_the_place_of_the_cut_off_one() -> None:
    side = (RECORDINGS / "standard-cut-raw.toml").read_text(encoding="utf-8")
    rows = len(_raw(slice(None)))
    for number, end in enumerate((int(0.9 * rows), rows, int(0.8 * rows))):
        _raw(slice(0, end)).to_parquet("in/raw.parquet", index=False)
        Path("in/raw.toml").write_text(side, encoding="utf-8")
        (one,) = _take().came_in
        assert (one.status, one.cuts) == ("imported", 1 if number < 2 else 0)
    assert len(_counting()) == 1


@pytest.mark.usefixtures("calibrated")
def test_a_file_that_is_not_what_its_checksum_says_waits_for_a_better_one() -> None:
    path = _deliver(WEEK, _week())
    good = path.read_bytes()
    said = path.with_name(f"{WEEK}.sha256")
    said.write_text(f"{hashlib.sha256(good).hexdigest()}  {WEEK}\n", encoding="utf-8")
    flipped = bytearray(good)
    flipped[len(flipped) // 2] ^= 1
    path.write_bytes(flipped)
    (one,) = _take().came_in
    assert one.status == "refused"
    assert f"does not agree with {WEEK}.sha256" in str(one.reason)
    path.write_bytes(good)
    (one,) = _take().came_in
    assert (one.status, one.cuts) == ("imported", WEEK_ROWS)
    assert not list(Path("in").glob("*"))[1:]
    assert (next(Path("in/kept").rglob(WEEK)).parent / said.name).is_file()


def test_a_file_that_is_being_written_waits(
    calibrated: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = _deliver(WEEK, _week(slice(0, 8)))

    def sleep(_seconds: float) -> None:
        _week().to_csv(path, index=False)

    monkeypatch.setattr("autodb.agent.ingest.inbox.time.sleep", sleep)
    done = calibrated("refresh", "--machine", MACHINE, "--inbox", "in").out
    assert "still being written" in done
    assert path.is_file()
    monkeypatch.setattr("autodb.agent.ingest.inbox.time.sleep", lambda _s: None)
    assert (
        f"{WEEK_ROWS} new cuts" in calibrated("refresh", "--machine", MACHINE, "--inbox", "in").out
    )


@pytest.mark.usefixtures("calibrated")
def test_older_recordings_come_first() -> None:
    for name, start, rows in (
        ("a", "2026-03-02", slice(8, 16)),
        ("b", "2026-03-01", slice(0, 8)),
    ):
        _deliver(f"{name}.csv", _week(rows))
        Path(f"in/{name}.toml").write_text(f'[recording]\nstart = "{start}"\n', encoding="utf-8")
    assert [one.file for one in _take().came_in] == ["b.csv", "a.csv"]


@pytest.mark.usefixtures("calibrated")
def test_passes_that_go_on_learn_what_one_would(monkeypatch: pytest.MonkeyPatch) -> None:
    """New cuts change a posterior that many are behind; old ones are not even read."""
    known, posterior = _undisturbed()
    monkeypatch.setattr(learning, "AT_ONCE", 3)
    monkeypatch.setattr(refreshing, "AT_ONCE", 3)
    monkeypatch.setattr(inferred_edges, "NEWEST", 4)  # as many of all cuts are looked at anew
    monkeypatch.setattr(drifted_gains, "NEWEST", 1)  # and as many recordings
    loaded: set[int] = set()

    def count(target: models.Cut, _context: object) -> None:
        loaded.add(target.id)

    event.listen(models.Cut, "load", count)
    try:
        for begin in range(0, WEEK_ROWS, 4):
            _deliver(f"{begin}.csv", _week(slice(begin, begin + 4)))
            loaded.clear()
            done = _take()
            assert [one.cuts for one in done.came_in] == [4]
            assert loaded == set(range(33 + begin, 37 + begin))
    finally:
        event.remove(models.Cut, "load", count)
    assert _counting() == known
    assert not _shifted(posterior)


@pytest.mark.usefixtures("calibrated")
def test_many_cuts_are_several_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(refresh_cursor, "CUTS_A_PASS", 6)
    _deliver(WEEK, _week())
    _take()
    with _reading() as session:
        assert session.scalar(select(func.count()).select_from(models.RefreshPass)) == 1 + 3
        marked = session.scalars(select(models.RefreshPass.last_cut_id)).all()
    assert len(_counting()) == WEEK_ROWS
    assert list(marked)[1:] == [32 + 6, 32 + 12, 32 + 16]


@pytest.mark.usefixtures("calibrated")
def test_watching_takes_files_as_they_come_and_outlives_a_locked_database() -> None:
    told: list[RefreshReport] = []
    said: list[str] = []
    steps = iter(range(5))
    broken = [False]

    def goes_on() -> bool:
        step = next(steps)
        if step == 1:
            _deliver("1.csv", _week(slice(0, 8)))
            broken[0] = True
        if step == 2:
            broken[0] = False
        if step == 3:
            _deliver("2.csv", _week(slice(8, 16)))
        return step < 4

    @contextmanager
    def opens() -> Iterator[Store]:
        if broken[0]:
            raise UnusableInput("the database is away")
        with _opened() as store:
            yield store

    watch(
        opens,
        MACHINE,
        Inbox(Path("in"), settled_s=0.0),
        tell=told.append,
        say=said.append,
        excuse=lambda error: str(error) if isinstance(error, UnusableInput) else None,
        every_s=0.01,
        goes_on=goes_on,
    )
    assert [sum(one.cuts for one in done.came_in) for done in told] == [0, 8, 8]
    assert said == ["the database is away; trying again every 0.01 s"]


@pytest.mark.usefixtures("calibrated")
def test_an_inbox_that_cannot_be_written_is_read_in_place(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    _deliver(WEEK, _week())
    monkeypatch.setattr(Path, "mkdir", refuse)
    done, again = _take(), _take()
    assert [one.cuts for one in done.came_in] == [WEEK_ROWS]
    assert any("cannot be written (Permission denied)" in note for note in done.set_aside)
    assert not again.anything
    assert Path("in", WEEK).is_file()


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--watch",), "--columns and --watch go with --inbox DIR"),
        (("--inbox", "nowhere"), "nowhere: no such folder; create it or name another"),
        (("--inbox", "autodb.sqlite3"), "autodb.sqlite3: is a file; name a folder"),
        (("--inbox", "in", "--report"), "--report only prints what was done; leave out --inbox"),
    ],
)
def test_what_does_not_go_together_is_said(
    calibrated: Cli, options: tuple[str, ...], line: str
) -> None:
    done = calibrated("refresh", "--machine", MACHINE, *options)
    assert done.code == 2
    assert line in done.err
