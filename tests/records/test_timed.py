"""A recording's time from its file to the answer: read, said, kept, and given back row by row."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from autodb.errors import UnusableInput
from autodb.records import source as records
from autodb.records.tables import Recording
from autodb.records.timed import on_even_rows
from autodb.reports.figures import broken_line
from autodb.sensing.drives.feed_axis import identify
from autodb.store import models, open_store
from tests.conftest import Cli, shared
from tests.helpers.stamped import effort_A, place_mm, written_mm

RATE = 400.0
T = np.arange(12_000) / RATE
LAW = {"inertia": 0.002, "viscous": 0.01, "coulomb": 1.2}


def _written(folder: Path, stamps: Any, keep: Any = slice(None), name: str = "r") -> Path:
    """Write a recording of moves with these stamps and of these rows."""
    rng = np.random.default_rng(1)
    table = {"x.position": written_mm(T), "x.current": effort_A(T, rng)}
    columns = {"t": stamps} | {channel: values[keep] for channel, values in table.items()}
    path = folder / f"{name}.csv"
    pd.DataFrame(columns).to_csv(path, index=False)
    return path


def test_a_recording_that_nobody_laid_out_is_refused() -> None:
    """Arrays of a caller's own: nothing differentiates them over uneven steps."""
    raw = Recording(Path("own.csv"), {"t": np.round(T, 3), "x.position": written_mm(T)})
    with pytest.raises(UnusableInput, match=r"is not even .*lay its rows out with"):
        _ = raw.rate_hz
    laid = on_even_rows(raw)
    assert_allclose(laid.rate_hz, RATE)
    assert_array_equal(laid["x.position"], raw["x.position"])


def test_what_needs_one_piece_says_where_the_pieces_are(tmp_path: Path) -> None:
    keep = (T < 10.0) | (T > 12.0)
    gapped = records.read(_written(tmp_path, T[keep], keep))
    assert isinstance(gapped, Recording)
    assert len(gapped.pieces) == 2
    with pytest.raises(UnusableInput, match=r"without a gap: .*\(0 to 9.9975 s, 12.0025 to 29.9"):
        _ = gapped.rate_hz


@pytest.mark.parametrize(
    "form", ["%Y-%m-%dT%H:%M:%S.%f", "%d.%m.%Y %H:%M:%S.%f", "%m/%d/%Y %H:%M:%S.%f", "%H:%M:%S.%f"]
)
def test_dates_are_stamps(tmp_path: Path, form: str) -> None:
    """Rounded at most: seconds since 1970 have 0.2 µs left."""
    moments = pd.Timestamp("2026-03-29 00:59:50") + pd.to_timedelta(np.round(1e6 * T), unit="us")
    found = records.read(_written(tmp_path, moments.strftime(form)))
    assert isinstance(found, Recording)
    assert found.timing.kinds in (("even",), ("rounded",))
    assert_allclose(found.timing.rate_hz, RATE, rtol=1e-6)


def test_a_date_that_is_none_names_its_row(tmp_path: Path) -> None:
    moments = pd.Timestamp("2026-03-29 00:59:50") + pd.to_timedelta(T, unit="s")
    texts = list(moments.strftime("%Y-%m-%dT%H:%M:%S.%f"))
    texts[7] = "noon"
    with pytest.raises(UnusableInput, match="column 't', row 8: 'noon' is no moment"):
        records.read(_written(tmp_path, texts))


def test_milliseconds_are_doubted_and_believed_when_stated(cli: Cli, tmp_path: Path) -> None:
    path = _written(tmp_path, 1e3 * T)
    done = cli("identify", path)
    assert done.code == 2
    assert 'as milliseconds 400 Hz (unit = "ms")' in done.err
    assert done.err.count("\n") == 1
    path.with_suffix(".toml").write_text('[channels]\n"t" = {column = "t", unit = "ms"}\n')
    assert cli("identify", path).code == 0


def test_import_says_and_keeps_what_the_time_is(cli: Cli, tmp_path: Path) -> None:
    keep = (T < 10.0) | (T > 12.0)
    path = _written(tmp_path, np.round(T[keep], 3), keep)
    assert cli("init").code == 0
    assert cli("machine", "add", "m").code == 0
    done = cli("import", path, "--machine", "m")
    assert done.code == 0, done.err
    said = "stamps rounded to 1 ms: times rebuilt from the number of rows; gap of 2.005 s after"
    assert f"r.csv: time: {said}" in done.out
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        row = session.get_one(models.StoredRecording, 1)
        assert row.timing is not None
        assert row.timing[""]["kinds"] == ["rounded", "gap"]
        assert row.timing[""]["pieces"] == 2
        assert_allclose(row.timing[""]["rate_hz"], RATE, rtol=1e-6)
    again = cli("import", path, "--machine", "m")
    assert f"time: {said}" in again.out


def test_corrected_has_every_row_of_the_file(cli: Cli, tmp_path: Path) -> None:
    """With the stamps as written, also where a row is in no piece, or stands twice."""
    rng = np.random.default_rng(2)
    keep = np.sort(np.r_[np.flatnonzero((T < 10.0) | (T > 11.0)), rng.choice(3000, 20)])
    path = _written(tmp_path, np.round(T[keep], 3), keep)
    simulated = effort_A(T, rng, noise_A=0.0) - 1.2 * np.tanh(_speed() / 0.5)
    pd.DataFrame({"t": np.round(T[keep], 3), "x.current": simulated[keep]}).to_csv(
        tmp_path / "s.csv", index=False
    )
    done = cli("explain", path, "--simulation", tmp_path / "s.csv", "--out", "out")
    assert done.code == 0, done.err
    assert "stamps rounded to 1 ms" in done.err
    corrected = pd.read_csv("out/corrected.csv")
    assert_allclose(corrected["t"], np.round(T[keep], 3))
    measured = pd.read_csv(path)["x.current"]
    assert np.std(corrected["x.current"] - measured) < 0.05
    answer = json.loads(Path("out/explanation.json").read_text())["channels"]["x.current"]
    assert [cause["term"] for cause in answer["missing"]] == ["coulomb"]
    assert "stamps rounded to 1 ms" in Path("out/report.html").read_text()


@pytest.mark.parametrize(("band_mm", "code"), [(0.03, 0), (0.3, 2)])
def test_a_coarse_dead_band_is_refused(cli: Cli, tmp_path: Path, band_mm: float, code: int) -> None:
    """Of 190 mm/s at 400 Hz 0.03 mm are 6 % of the way in a row: all but creeping is seen."""
    places, said = written_mm(T), [0]
    for row, place in enumerate(places):
        if abs(place - places[said[-1]]) >= band_mm:
            said.append(row)
    done = cli("identify", _written(tmp_path, T[said], np.array(said)))
    assert done.code == code
    if code:
        assert "too coarse to derive velocity and acceleration" in done.err
    else:
        found = {w[0]: float(w[2]) for w in map(str.split, done.out.splitlines()) if w[:1] and
                 w[0] in ("viscous", "coulomb")}  # fmt: skip
        assert_allclose([found["viscous"], found["coulomb"]], [0.01, 1.2], rtol=0.03)


def test_a_line_breaks_where_nothing_was_recorded() -> None:
    x = np.r_[np.arange(5000.0), 6000.0 + np.arange(5000.0)]
    drawn = broken_line(x, np.sin(x), np.array([4999]), tone="recording", name="recording")
    breaks = np.flatnonzero(np.isnan(drawn.y))
    assert drawn.x[breaks].tolist() == [4999.0]
    assert np.all(np.diff(drawn.x) >= 0)


def _speed() -> np.ndarray:
    return (place_mm(T + 1e-4) - place_mm(T - 1e-4)) / 2e-4


@pytest.mark.parametrize(
    ("name", "group"), [("ms400.csv", None), ("gap.csv", None), ("restart2.tdms", "AI")]
)
def test_logs_that_failed_give_the_axis_that_they_are_of(name: str, group: str | None) -> None:
    moves = records.read(shared("failures", "logs", name), group=group)
    assert isinstance(moves, Recording)
    assert not moves.timing.is_even
    found = {one.term: one.value for one in identify(moves).terms}
    for term, value in LAW.items():
        assert_allclose(found[term], value, rtol=0.03)


def test_runs_that_were_appended_lie_at_their_own_times() -> None:
    runs = records.read(shared("failures", "logs", "restart2.tdms"), group="AI")
    assert isinstance(runs, Recording)
    assert [(runs.t_s[p.start], runs.t_s[p.stop - 1]) for p in runs.pieces] == [
        (pytest.approx(0.0), pytest.approx(3.998)),
        (pytest.approx(30.0), pytest.approx(33.998)),
    ]
