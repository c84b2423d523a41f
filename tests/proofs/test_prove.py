"""Proofs: killed and gone on they end the same, changed generators begin anew, and the table."""

import ast
import json
import os
import signal
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.stats import binom

import autodb
from autodb.errors import UnusableInput
from autodb.proofs import catalogue
from autodb.proofs.carrying_out import begin_runs, begin_worker, carry_out
from autodb.proofs.catalogue import PROOFS, Proof
from autodb.proofs.machines.axis.axes import draw_run
from autodb.proofs.machines.axis.quantities import NAMES, quantities
from autodb.proofs.runs.axis import axis_intervals
from autodb.proofs.runs.found import markdown
from autodb.proofs.runs.oracle import oracle
from autodb.proofs.runs.proof_summary import COLUMNS, IntervalsSummary, row_cells
from autodb.proofs.runs.run_file import digest
from autodb.proofs.runs.score import LEVEL, POOLED, Judged, Z, scored_quantities
from tests.conftest import Cli
from tests.helpers.campaigns import first

RUNS = 12


def _right(seed: int) -> list[Judged]:
    """Right intervals of a standard normal estimate, as if identified."""
    value = float(np.random.default_rng(seed).standard_normal())
    ends = (value - Z, value + Z)
    return [Judged("a", "N", 0.0, value, *ends, *ends)]


def _slowly(seed: int) -> list[Judged]:
    time.sleep(0.05)
    return _right(seed)


def _narrow(seed: int) -> list[Judged]:
    (one,) = _right(seed)
    assert one.value is not None
    return [replace(one, low=one.value - 0.1, high=one.value + 0.1)]


def _made(run: Callable[[int], list[Judged]]) -> Proof[Judged]:
    return replace(PROOFS[0], run=run)


def _carried_out(proof: Proof[Judged], folder: Path, runs: int = RUNS) -> IntervalsSummary:
    found = carry_out(begin_runs(proof, folder), runs, progress=lambda _: None)
    assert isinstance(found, IntervalsSummary)
    return found


def _files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def undisturbed(tmp_path: Path) -> Path:
    """Return the folder of a proof of RUNS runs that nothing interrupted."""
    _carried_out(_made(_right), tmp_path / "undisturbed")
    return tmp_path / "undisturbed"


@pytest.mark.parametrize("after", [0, 1, 7])
def test_an_interrupted_proof_goes_on_and_ends_the_same(
    undisturbed: Path, tmp_path: Path, after: int
) -> None:
    called: list[int] = []

    def interrupted(seed: int) -> list[Judged]:
        if len(called) == after:
            raise KeyboardInterrupt
        called.append(seed)
        return _right(seed)

    folder = tmp_path / "again"
    with pytest.raises(KeyboardInterrupt):
        _carried_out(_made(interrupted), folder)
    kept = begin_runs(_made(_right), folder)
    assert sorted(kept.finished) == called == list(range(1, after + 1))
    assert kept.note == ""
    _carried_out(_made(_right), folder)
    assert _files(folder) == _files(undisturbed)


@pytest.mark.parametrize("cut", [1, 30, 200, 400])
def test_a_line_that_a_kill_left_unfinished_is_run_again(
    undisturbed: Path, tmp_path: Path, cut: int
) -> None:
    whole = (undisturbed / "axis-intervals.jsonl").read_bytes()
    folder = tmp_path / "cut"
    folder.mkdir()
    (folder / "axis-intervals.jsonl").write_bytes(whole[:-cut])
    assert len(begin_runs(_made(_right), folder).finished) < RUNS
    _carried_out(_made(_right), folder)
    assert _files(folder) == _files(undisturbed)


def test_a_killed_process_leaves_runs_that_are_gone_on_with(tmp_path: Path) -> None:
    path = tmp_path / "killed" / "axis-intervals.jsonl"
    child = os.fork()
    if child == 0:
        try:
            _carried_out(_made(_slowly), path.parent, 1000)
        finally:
            os._exit(0)
    while not path.exists() or path.read_bytes().count(b"\n") < 4:
        time.sleep(0.01)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    done = len(begin_runs(_made(_right), path.parent).finished)
    assert 3 <= done < 1000
    _carried_out(_made(_right), path.parent, done + 2)
    _carried_out(_made(_right), tmp_path / "whole", done + 2)
    assert _files(path.parent) == _files(tmp_path / "whole")


def _working(written: int) -> None:
    begin_worker()
    os.write(written, b"works")
    time.sleep(60.0)


def _parent_of_one(written: int) -> None:
    worker = get_context("fork").Process(target=_working, args=(written,))
    worker.start()
    worker.join()


def test_the_workers_of_a_killed_process_end() -> None:
    read, written = os.pipe()
    parent = get_context("fork").Process(target=_parent_of_one, args=(written,))
    parent.start()
    os.close(written)
    assert os.read(read, 5) == b"works"
    parent.kill()
    parent.join()
    begun = time.monotonic()
    assert os.read(read, 5) == b""  # nobody holds the other end any more
    assert time.monotonic() - begun < 20.0
    os.close(read)


def test_more_runs_add_to_those_there_and_fewer_are_summed_up(undisturbed: Path) -> None:
    called: list[int] = []

    def counted(seed: int) -> list[Judged]:
        called.append(seed)
        return _right(seed)

    assert _carried_out(_made(counted), undisturbed, RUNS + 3).seeds == (1, RUNS + 3)
    assert called == [RUNS + 1, RUNS + 2, RUNS + 3]
    assert _carried_out(_made(counted), undisturbed, 5).rows[0].runs == 5
    assert len(called) == 3


def test_an_end_that_is_no_number_is_not_given_now_and_after_a_resume(tmp_path: Path) -> None:
    def endless(seed: int) -> list[Judged]:
        (one,) = _right(seed)
        return [replace(one, high=float("nan")) if seed % 2 else one]

    first = _carried_out(_made(endless), tmp_path)
    assert first.rows[0].given == 0.5
    assert first.rows[0].share <= 0.5
    assert first.rows[0].score_ratio == 1.0
    assert _carried_out(_made(endless), tmp_path) == first


def test_a_changed_generator_begins_anew_and_says_so(undisturbed: Path) -> None:
    path = undisturbed / "axis-intervals.jsonl"
    path.write_bytes(path.read_bytes().replace(PROOFS[0].origin().generator.encode(), b"0" * 16))
    begun = begin_runs(_made(_right), undisturbed)
    assert begun.finished == {}
    assert f"generator was {'0' * 16} and is {PROOFS[0].origin().generator}" in begun.note
    assert begun.note.endswith("all runs begin anew")
    assert len(path.read_bytes().splitlines()) == 1


def test_digest_changes_with_a_file_or_its_name(tmp_path: Path) -> None:
    one, other = tmp_path / "a.py", tmp_path / "b.py"
    one.write_text("x = 1\n")
    first = digest([one], root=tmp_path)
    assert first == digest([one], root=tmp_path)
    other.write_text("x = 1\n")
    assert digest([other], root=tmp_path) != first
    one.write_text("x = 2\n")
    assert digest([one], root=tmp_path) != first


def test_the_generator_of_every_proof_is_all_of_it() -> None:
    """What a generator's modules import of virtual machines is hashed, but for a name of a type."""
    for proof in PROOFS:
        names = {module.__name__ for module in proof.generator}
        for module in proof.generator:
            others = {name for name in _imported(module) if name.rpartition(".")[0] not in names}
            assert others - names <= {"autodb.proofs.machines.lathe.process.Array"}


def _imported(module: ModuleType) -> Iterator[str]:
    """Yield what a module imports of this program: modules, and names of modules, in full."""
    for node in ast.parse(Path(str(module.__file__)).read_text("utf-8")).body:
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("autodb"):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_what_is_no_proof_is_refused(tmp_path: Path, undisturbed: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UnusableInput, match="is a file"):
        begin_runs(_made(_right), tmp_path / "file")
    path = undisturbed / "axis-intervals.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    for row, line in ((1, b"a,b\n"), (3, b'{"seed": 2}\n')):
        path.write_bytes(b"".join([*lines[: row - 1], line, *lines[row:]]))
        with pytest.raises(UnusableInput, match=f"row {row}: is not a run of a proof"):
            begin_runs(_made(_right), undisturbed)


def test_the_command_lists_runs_goes_on_and_fails(
    cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "axis-intervals" in cli("prove").out
    monkeypatch.setattr(catalogue, "PROOFS", (_made(_right),))
    done = cli("prove", "axis-intervals", "--runs", 40)
    assert done.code == 0
    assert f"seeds 1 to 40, autodb {autodb.__version__}" in done.out
    again = cli("prove", "axis-intervals", "--runs", 50)
    assert "40 of 50 runs are already there" in again.out
    written = json.loads(Path("axis-intervals-proof/axis-intervals.json").read_text("utf-8"))
    assert written["seeds"] == [1, 50]
    monkeypatch.setattr(catalogue, "PROOFS", (_made(_narrow),))
    failed = cli("prove", "axis-intervals", "--runs", 40, "--out", "narrow")
    assert failed.code == 1
    assert "FAILED" in failed.out


def test_the_command_interrupted_keeps_what_is_done(
    cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(seed: int) -> list[Judged]:
        if seed == 4:
            raise KeyboardInterrupt
        return _right(seed)

    monkeypatch.setattr(catalogue, "PROOFS", (_made(interrupted),))
    assert cli("prove", "axis-intervals", "--runs", 9).code == 130
    lines = Path("axis-intervals-proof/axis-intervals.jsonl").read_text("utf-8").splitlines()
    assert [json.loads(line)["seed"] for line in lines[1:]] == [1, 2, 3]


def test_the_command_refuses_what_changes_nothing(refused: Callable[..., str]) -> None:
    assert "go with the name of a proof" in refused("prove", "--runs", 3)
    assert "did you mean axis-intervals" in refused("prove", "axis-interval")
    assert "is a file" in refused("prove", "axis-intervals", "--runs", 1, "--out", __file__)


def test_a_summary_comes_back_from_json_and_prints_every_row(tmp_path: Path) -> None:
    found = _carried_out(_made(_narrow), tmp_path)
    assert IntervalsSummary.from_json(found.to_json()) == found
    page = markdown(found)
    assert page.startswith(f"axis-intervals: {RUNS} runs, seeds 1 to {RUNS}, autodb ")
    table = [line for line in page.splitlines() if line.startswith("|")]
    assert len(table) == 2 + len(found.rows)
    assert {line.count("|") for line in table} == {len(COLUMNS) + 1}
    assert [row.name for row in found.rows] == ["a", POOLED]
    assert all(len(row_cells(row)) == len(COLUMNS) for row in found.rows)


@pytest.mark.parametrize("runs", first(1, [20, 40]))
def test_the_oracle_passes_its_own_proof(runs: int) -> None:
    """Generator, truths and score agree: who is given the laws is right as often as stated."""
    judged = []
    for seed in range(1001, 1001 + runs):
        run = draw_run(seed)
        best = oracle(run)
        for asked in quantities(run.axis, run.motion):
            ends = best.interval(asked)
            middle = 0.5 * (ends[0] + ends[1])
            judged.append(Judged(asked.name, asked.unit, asked.truth, middle, *ends, *ends))
    rows = scored_quantities(judged, runs=runs)
    assert {row.name for row in rows} == {*NAMES, POOLED}
    assert [row.name for row in rows if not row.passed] == []
    assert abs(rows[-1].share - LEVEL) < 0.03


def test_what_is_given_is_value_and_interval_of_quantities_that_are_asked_for() -> None:
    for one in axis_intervals.run_axis_intervals(2):
        assert one.name in NAMES
        if one.value is not None:
            assert one.low is not None
            assert one.high is not None
            assert one.low < one.value < one.high


@pytest.mark.campaign
def test_intervals_of_twenty_axes_hold() -> None:
    """The first 20 axes of the proof; 15 quantities, all of them together at 1 in 1000.

    A quantity fails whose share lies below the 0.001/15 point of the binomial of its own n at 95 %.
    """
    runs = [axis_intervals.run_axis_intervals(seed) for seed in range(1, 21)]
    for name in NAMES:
        held = [one.holds for judged in runs for one in judged if one.name == name]
        fewest = binom.ppf(0.001 / len(NAMES), len(held), LEVEL)
        assert sum(held) >= fewest, f"{name}: {sum(held)} of {len(held)}"
    widths = [
        (one.high - one.low) / (one.oracle_high - one.oracle_low)
        for judged in runs
        for one in judged
        if one.low is not None and one.high is not None
    ]
    assert np.median(widths) < 2.0
