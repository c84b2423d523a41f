"""Files with several time bases: each read by itself, in blocks, or all at one rate."""

import builtins
import resource
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from asammdf import MDF, Signal
from nptdms import ChannelObject, TdmsWriter
from numpy.testing import assert_allclose, assert_array_equal
from scipy.io import savemat
from sqlalchemy import select

from autodb.errors import UnusableInput
from autodb.readers import BLOCK_ROWS, _base, open_bases
from autodb.records import source as records
from autodb.records.resample import common_times_s, read_at
from autodb.records.summary import summarise
from autodb.records.tables import Recording
from autodb.store import models, open_store
from tests.conftest import Cli
from tests.helpers.files import write, write_groups

FAST_HZ, SLOW_HZ, END_S = 1000.0, 10.0, 12.0
FAST = np.arange(int(END_S * FAST_HZ)) / FAST_HZ
SLOW = np.arange(int(END_S * SLOW_HZ)) / SLOW_HZ
GROUPS = {
    "drive": {"t": FAST, "x.position": 40 * np.sin(FAST), "x.current": np.cos(FAST)},
    "climate": {"t": SLOW, "spindle.temperature": 20.0 + SLOW},
}
SEVERAL = [".h5", ".tdms", ".mf4"]


@pytest.mark.parametrize("suffix", SEVERAL)
def test_each_rate_keeps_its_own_time_base(tmp_path: Path, suffix: str) -> None:
    path = write_groups(tmp_path / f"a{suffix}", GROUPS)
    for name, columns in GROUPS.items():
        table = records.read(path, group=name)
        assert isinstance(table, Recording)
        assert set(table.channels) == set(columns)
        for channel, values in columns.items():
            assert_allclose(table[channel], values, rtol=1e-12)


@pytest.mark.parametrize("suffix", SEVERAL)
def test_several_time_bases_are_not_joined_unasked(tmp_path: Path, suffix: str) -> None:
    path = write_groups(tmp_path / f"a{suffix}", GROUPS)
    with pytest.raises(UnusableInput, match=r"several time bases.*--group"):
        records.read(path)
    with pytest.raises(UnusableInput, match="did you mean drive"):
        records.read(path, group="drives")


def test_a_group_of_a_file_with_one_time_base_is_an_error(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", GROUPS["drive"])
    with pytest.raises(UnusableInput, match="one time base"):
        records.read(path, group="drive")


def test_all_rates_come_onto_one_where_asked(tmp_path: Path) -> None:
    """A slow cosine survives, an oscillation above the new Nyquist frequency does not fold down."""
    fast = {**GROUPS["drive"], "y.current": np.sin(2 * np.pi * 260.0 * FAST)}
    path = write_groups(tmp_path / "a.h5", {"drive": fast, "climate": GROUPS["climate"]})
    source = records.open_source(path)
    t_s = common_times_s(source, 100.0)
    table = read_at(source, t_s)
    assert_allclose(np.diff(table.t_s), 0.01, rtol=1e-9)
    assert table.t_s[-1] <= SLOW[-1]
    inner = slice(50, -50)
    assert_allclose(table["x.current"][inner], np.cos(t_s)[inner], atol=1e-4)
    assert_allclose(table["spindle.temperature"], 20.0 + t_s, rtol=1e-9)
    assert np.abs(table["y.current"][inner]).max() < 0.01


def test_a_channel_in_two_time_bases_is_not_resampled(tmp_path: Path) -> None:
    path = write_groups(tmp_path / "a.h5", {name: {"t": FAST, "x.current": FAST} for name in "ab"})
    source = records.open_source(path)
    with pytest.raises(UnusableInput, match="stands in two time bases"):
        read_at(source, common_times_s(source, 100.0))


def test_a_simulation_is_brought_to_the_times_of_its_recording(tmp_path: Path, cli: Cli) -> None:
    """The recording's slow base starts later; the simulation has one base of its own rate."""
    rng = np.random.default_rng(3)
    t = np.arange(0, 40, 0.004)
    x = 100 * np.sin(2 * np.pi * 0.2 * t)
    v = np.gradient(x, t)
    current = 1.5 * np.sign(v) + 0.01 * v
    moves = {"t": t, "x.position": x, "x.velocity": v}
    climate = {"t": np.arange(1.0, 38.0), "x.temperature": np.full(37, 20.0)}
    path = write_groups(
        tmp_path / "rec.h5",
        {"moves": {**moves, "x.current": current + rng.normal(0, 0.05, len(t))}, "clima": climate},
    )
    simulation = write(tmp_path / "sim.csv", {**moves, "x.current": current})
    done = cli("explain", path, "--simulation", simulation, "--resample", "100", "--out", "answer")
    assert done.code == 0, done.err
    assert "no mismatch" in done.out
    corrected = records.read(Path("answer/corrected.csv"))
    assert corrected["t"][0] == pytest.approx(1.0)
    assert len(corrected) == 3601
    assert cli("explain", path, "--simulation", simulation, "--group", "moves").code == 0


def test_hdf5_datasets_share_a_base_by_folder_or_length(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["time"] = FAST
        file["axis/pos"] = FAST[:, None]
        file["other"] = SLOW
        file["table"] = np.zeros(50, dtype=[("t", "f8"), ("x.position", "f8")])
        file["text"] = "a remark"
        file["matrix"] = np.zeros((3, 3))
    columns = {base.name: set(base.columns) for base in open_bases(path)}
    assert columns == {
        f"{len(FAST)} rows": {"time", "axis/pos"},
        f"{len(SLOW)} rows": {"other"},
        "table": {"t", "x.position"},
    }


def test_tdms_waveforms_carry_their_clock(tmp_path: Path) -> None:
    path = tmp_path / "a.tdms"
    start = np.datetime64("2026-01-01T06:00:00", "us")
    clock = {"wf_increment": 0.001, "wf_start_time": start}
    later = {"wf_increment": 0.1, "wf_start_time": start + np.timedelta64(250, "ms")}
    with TdmsWriter(path) as file:
        file.write_segment(
            [
                ChannelObject("log", "x.current", FAST, clock),
                ChannelObject("log", "x.temperature", SLOW, later),
            ]
        )
    fast, slow = (base.read() for base in records.open_source(path).usable())
    assert_allclose(fast["t"], FAST, atol=1e-12)
    assert_allclose(slow["t"], 0.25 + SLOW, atol=1e-12)


def test_a_channel_without_a_clock_shares_the_one_of_its_group(tmp_path: Path) -> None:
    path = tmp_path / "a.tdms"
    with TdmsWriter(path) as file:
        file.write_segment(
            [
                ChannelObject("log", "x.position", FAST, {"wf_increment": 0.001}),
                ChannelObject("log", "x.current", FAST, {"unit_string": "mA"}),
            ]
        )
    table = records.read(path)
    assert_allclose(table["t"], FAST, atol=1e-12)
    assert_allclose(table["x.current"], FAST / 1000.0, rtol=1e-12)


def test_invalid_samples_are_a_gap_and_stated_units_are_taken(tmp_path: Path) -> None:
    path = tmp_path / "a.mf4"
    invalid = np.zeros(len(FAST), dtype=bool)
    invalid[5:8] = True
    with MDF() as file:
        file.append(
            [
                Signal(FAST, FAST, name="x.current", unit="mA"),
                Signal(FAST, FAST, name="y.current", invalidation_bits=invalid),
                Signal(-FAST, FAST, name="x.current"),
                Signal(1000 * FAST, FAST, name="t"),
            ]
        )
        file.save(path)
    table = records.read(path)
    assert_allclose(table["x.current"], FAST / 1000.0, rtol=1e-9)
    assert_allclose(table["t"], FAST, rtol=1e-9)
    with pytest.raises(UnusableInput, match=r"y\.current, row 6: no finite number \(3 such"):
        table["y.current"]


def test_an_hdf5_file_may_hold_what_is_no_channel(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["t"], file["x.current"] = FAST, FAST
        file["x.current"].attrs["unit"] = "mA"
        file["empty"] = h5py.Empty("f")
        file["operator"] = np.array([b"\xfc"] * len(FAST))
    assert_allclose(records.read(path)["x.current"], FAST / 1000.0, rtol=1e-12)


def test_a_mat_file_in_hdf5_reads_alike(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["t"], file["qm"] = FAST[None, :], FAST[None, :] ** 2
        file["note"] = np.frombuffer(b"r\0u\0n\0", dtype=np.uint16)[:, None]
        file["note"].attrs["MATLAB_class"] = np.bytes_("char")
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file".ljust(128))
    (tmp_path / "a.toml").write_text('[channels]\n"x.position" = {column = "qm", unit = "m"}\n')
    assert_allclose(records.read(path)["x.position"], 1000.0 * FAST**2, rtol=1e-12)


def test_mat_vectors_of_two_lengths_are_two_time_bases(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    savemat(path, {"t": FAST, "a": FAST, "slow": SLOW})
    (tmp_path / "a.toml").write_text('[channels]\n"x.current" = "a"\n')
    assert set(records.read(path).channels) == {"t", "x.current"}


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".h5", ".tdms", ".mf4"])
def test_blocks_join_to_the_whole(tmp_path: Path, suffix: str) -> None:
    """Rows counted, edges and values go on over the border of two blocks."""
    n = BLOCK_ROWS + 1000
    t = np.arange(n) * 0.001
    path = write(tmp_path / f"a{suffix}", {"t": t, "x.current": np.sin(t), "group": t // 50})
    side = tmp_path / "side.toml"
    side.write_text(
        '[channels]\n"tool.cutting_time" = {row_in = "group", step_s = 0.5}\n'
        '"x.position" = {row_in = "*", step_s = 0.001}\n'
    )
    table = records.read(path, columns=side)
    assert_allclose(table["x.current"], np.sin(t), rtol=1e-12)
    assert_allclose(table["x.position"], t, rtol=1e-12)
    expected = 0.5 * np.concatenate([np.arange((t // 50 == k).sum()) for k in np.unique(t // 50)])
    assert_array_equal(table["tool.cutting_time"], expected)


def test_a_csv_of_many_blocks_names_the_row_at_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autodb.readers.text.source.BLOCK_BYTES", 1 << 12)
    lines = [f"{i},{i}" for i in range(5000)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["t,x.position", *lines]))
    assert_array_equal(records.read(path)["x.position"], np.arange(5000.0))
    for row, line, says in ((4001, "4000,x", "row 4001: 'x'"), (4500, "1,2,3", "row 4500 has 3")):
        path.write_text("\n".join(["t,x.position", *lines[: row - 1], line, *lines[row:]]))
        with pytest.raises(UnusableInput, match=says):
            records.read(path)
    path.write_text("\n".join(["t,x.position", *lines[:3000], "7,7", *lines[3001:]]))
    (base,) = summarise(records.open_source(path))
    assert base.timing is not None
    assert "1 row without a stamp, or with one far off" in str(base.timing)


def test_a_summary_takes_the_memory_of_a_block(tmp_path: Path) -> None:
    """128 MB of numbers (zeros that HDF5 does not store) pass through; what stays is a few MB."""
    rows = 4_000_000
    path = tmp_path / "long.h5"
    with h5py.File(path, "w") as file:
        chunks = (1 << 20,)
        for name in ("x.current", "y.current", "z.current"):
            file.create_dataset(name, (rows,), dtype="f8", chunks=chunks)
        steps = file.create_dataset("t", (rows,), dtype="f8", chunks=chunks, compression="gzip")
        for start in range(0, rows, 1 << 20):
            stop = min(start + (1 << 20), rows)
            steps[start:stop] = np.arange(start, stop, dtype=float)
    summarise(records.open_source(write(tmp_path / "warm.h5", {"t": FAST, "x.current": FAST})))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    (base,) = summarise(records.open_source(path))
    grown_mib = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    assert base.rows == rows
    assert base.channels["x.current"].mean == 0.0
    assert grown_mib < 100


def test_a_summary_agrees_with_the_whole(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    values = 1e6 + rng.normal(size=2 * BLOCK_ROWS + 17)
    values[[7, 200_000]] = np.nan
    t = np.arange(len(values)) * 0.5
    path = write(tmp_path / "a.parquet", {"t": t, "x.current": values})
    (base,) = summarise(records.open_source(path))
    channel = base.channels["x.current"]
    assert channel.first_gap == 8
    assert channel.rows - channel.finite == 2
    assert_allclose(channel.mean, np.nanmean(values), rtol=1e-14)
    assert_allclose(channel.sd, np.nanstd(values), rtol=1e-9)
    assert (channel.minimum, channel.maximum) == (np.nanmin(values), np.nanmax(values))
    assert base.rate_hz == pytest.approx(2.0)


def test_import_without_a_machine_only_looks(cli: Cli, tmp_path: Path) -> None:
    path = write_groups(tmp_path / "a.tdms", GROUPS)
    done = cli("import", path)
    assert done.code == 0
    for part in ("drive: 12000 rows, 0 to 11.999 s; time: even, 1000 Hz", "climate: 120 rows, ",
                 "time: even, 10 Hz", "spindle.temperature", "not stored"):  # fmt: skip
        assert part in done.out
    assert list(Path().glob("*.sqlite3")) == []


def test_a_file_with_several_rates_enters_the_database_whole(cli: Cli, tmp_path: Path) -> None:
    path = write_groups(tmp_path / "a.mf4", GROUPS)
    cli("init")
    cli("machine", "add", "m")
    assert "12000 rows" in cli("import", path, "--machine", "m").out
    assert "already there" in cli("import", path, "--machine", "m").out
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        kept = {
            (c.time_base, c.name): (c.rows, c.rate_hz, c.minimum, c.maximum)
            for c in session.scalars(select(models.RecordingChannel))
        }
    store.close()
    assert set(kept) == {(base, name) for base, columns in GROUPS.items() for name in columns}
    rows, rate_hz, low, high = kept["climate", "spindle.temperature"]
    assert (rows, low, high) == (120, 20.0, 20.0 + SLOW[-1])
    assert rate_hz == pytest.approx(SLOW_HZ)


def test_without_the_base_the_line_says_how_to_get_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refused: Callable[..., str]
) -> None:
    path = write_groups(tmp_path / "a.tdms", GROUPS)

    def absent(name: str) -> Any:
        raise ImportError(name)

    monkeypatch.setattr(_base, "import_module", absent)
    assert "autodb[formats]" in refused("import", path)
    assert builtins.__import__("nptdms")
