"""Shared fixtures: where the real recordings are, and the command line in-process."""

import gc
import os
import shutil
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # two workers share two cores

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.helpers.servers import Server

# Modules are compiled, and assertions rewritten, once: not in each worker of each run, nor in each
# process that a test starts, also where a container says so
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# Arrays come and go by the thousand: kept, and in large pages, what the C library has from the
# system is not asked for again each time. Workers of xdist are started later, and take it over.
KEEPS = {"mmap_threshold": 2**30, "trim_threshold": 2**30, "top_pad": 2**26, "hugetlb": 1}
os.environ.setdefault(
    "GLIBC_TUNABLES", ":".join(f"glibc.malloc.{name}={value}" for name, value in KEEPS.items())
)

ROOT = Path(__file__).parent.parent
IN_MEMORY, ROOM = Path("/dev/shm"), 4 * 2**30
"""Where files of tests are, and bytes that it has free: a disk that is waited for a thousand times
takes a tenth of all time. Kills of processes are the same there."""

if os.access(IN_MEMORY, os.W_OK) and shutil.disk_usage(IN_MEMORY).free > ROOM:
    os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(IN_MEMORY))


def pytest_collection_finish() -> None:
    """Leave what was imported out of every later collection of garbage, of which there are few.

    As often as Python does by itself they take a twentieth of the time.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)


SHARED = Path(os.environ.get("AUTODB_SHARED", ROOT.parent / "shared"))


def shared(*parts: str) -> Path:
    """Return a file that is shared beside the checkout, or skip saying that it is not here."""
    path = SHARED.joinpath(*parts)
    if not path.exists():
        pytest.skip(f"not here: {path}")
    return path


def _real(*parts: str) -> Path:
    return shared("data", *parts)


@pytest.fixture
def vicomtech() -> Path:
    """Return the Vicomtech table, or skip saying that it is not here."""
    return _real("vicomtech_turning_wear", "Dataset_Machine_tool_wear.csv")


@pytest.fixture
def emps() -> Path:
    """Return the EMPS recording, or skip saying that it is not here."""
    return _real("emps", "DATA_EMPS.mat")


@pytest.fixture
def pulses() -> Path:
    """Return the EMPS recording with load pulses, or skip saying that it is not here."""
    return _real("emps", "DATA_EMPS_PULSES.mat")


@pytest.fixture
def odrive() -> Path:
    """Return the folder of measured cogging maps, or skip saying that it is not here."""
    return _real("odrive_cogging")


@pytest.fixture
def tryout() -> Path:
    """Return the folder of foreign synthetic recordings, or skip saying that it is not here."""
    return _real("tryout")


@pytest.fixture(scope="session")
def sample_jobs() -> Path:
    """Return the sample jobs of this checkout."""
    return ROOT / "sample_jobs"


@pytest.fixture(scope="session")
def server() -> Iterator["Server"]:
    """Return a running PostgreSQL server, or skip saying that its binaries are not here."""
    from tests.helpers.servers import Server

    with tempfile.TemporaryDirectory(prefix="autodb-server-") as name:
        folder = Path(name)
        folder.chmod(0o755)
        started = Server(folder / "server")
        yield started
        started.stop()


@dataclass(frozen=True)
class Ran:
    """What a command did."""

    code: int
    out: str
    err: str


Cli = Callable[..., Ran]


@pytest.fixture
def taught(request: pytest.FixtureRequest) -> str:
    """Return by what pairs are learnt, which holds before any other fixture learns one."""
    if "one_law" not in request.fixturenames:
        return ""
    request.getfixturevalue("one_law")  # pytest sets what a mark uses up last
    return " by one law"


@pytest.fixture(scope="session")
def empty_database(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Return a database of this version in which nothing is."""
    from autodb.store import create_store

    path = tmp_path_factory.mktemp("empty") / "empty.sqlite3"
    create_store(f"sqlite:///{path}")
    return path.read_bytes()


@pytest.fixture
def made_anew() -> None:
    """Have each database made table by table: for what asks how one is made."""


@pytest.fixture
def copied(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have new files be copies of one that was made: it takes a tenth of the time."""
    if "made_anew" in request.fixturenames:
        return
    from autodb import store

    empty, make = request.getfixturevalue("empty_database"), store._make

    def copy(url: str) -> None:
        if store.on_server(url) or ((path := store.file_of(url)).exists() and path.stat().st_size):
            make(url)
        else:
            path.write_bytes(empty)

    monkeypatch.setattr(store, "_make", copy)


@pytest.fixture
def cli(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    taught: str,
    copied: None,
) -> Cli:
    """Return a function that runs a command in-process, in a fresh working folder."""
    del taught, copied
    from autodb.cli import run

    monkeypatch.chdir(tmp_path)
    for name in ("AUTODB_DB", "AUTODB_LANGUAGE", "AUTODB_UNITS"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("COLUMNS", "200")

    def call(*arguments: object) -> Ran:
        capsys.readouterr()
        code = run([str(a) for a in arguments])
        text = capsys.readouterr()
        return Ran(code, text.out, text.err)

    return call


def learn_by_one_law(patch: pytest.MonkeyPatch) -> None:
    """Have the agent learn pairs by the law that is near alone, which takes a quarter of the time,
    and wear by fewer bends.

    For tests that ask what becomes of cuts and versions, not how well they are learnt: that laws
    near and far off are averaged, and all bends tried, is asked of sample jobs, pages, and in
    tests/pairs.
    """
    from autodb.agent.learn import learning, states
    from autodb.pairs import worn
    from autodb.pairs.updating import posterior_of_readings

    for room in (learning, states):
        patch.setattr(room, "learn_averaging", posterior_of_readings)
    patch.setattr(worn, "POWERS", worn.POWERS[::2])
    patch.setattr(worn, "BETWEEN", worn.BETWEEN[1:2])


@pytest.fixture
def one_law(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the agent learn pairs by one law, in the test and in what is made for it."""
    learn_by_one_law(monkeypatch)


Once = Callable[..., Path]


@pytest.fixture(scope="session")
def filled() -> dict[str, Path]:
    """Return the folders that ``once`` has had filled in this process, by what filled them."""
    return {}


@pytest.fixture
def once(
    taught: str,
    filled: dict[str, Path],
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
) -> Once:
    """Return a function that goes to a working folder as something left it that runs only once.

    The folder is the same each time, so that paths kept in a database hold; it is set back first.
    """

    def call(fill: Callable[[], None]) -> Path:
        name = f"{fill.__module__}.{fill.__qualname__}{taught}"
        if name not in filled:
            filled[name] = tmp_path_factory.mktemp("once")
            (filled[name] / "folder").mkdir()
            monkeypatch.chdir(filled[name] / "folder")
            fill()
            shutil.copytree(filled[name] / "folder", filled[name] / "as-left")
            return filled[name] / "folder"
        folder = filled[name] / "folder"
        shutil.rmtree(folder)
        shutil.copytree(filled[name] / "as-left", folder)
        monkeypatch.chdir(folder)
        return folder

    return call


@pytest.fixture
def standard_learnt(cli: Cli, sample_jobs: Path, once: Once) -> Cli:
    """Return the command line on a lathe that has learnt the cuts that it is calibrated on."""

    def learn() -> None:
        recordings = sample_jobs / "stepped_shaft" / "recordings"
        cli("init")
        cli("machine", "add", "lathe-1")
        cli("import", recordings / "standard-cuts.csv", "--machine", "lathe-1")
        cli("calibrate", "--machine", "lathe-1")
        assert cli("refresh", "--machine", "lathe-1").code == 0

    once(learn)
    return cli


@pytest.fixture
def refused(cli: Cli) -> Callable[..., str]:
    """Return a function that runs a command, checks that it refuses in one line, and returns it."""

    def call(*arguments: object) -> str:
        done = cli(*arguments)
        assert done.code == 2
        lines = done.err.strip().splitlines()
        assert len(lines) == 1
        assert lines[0].startswith("autodb: ")
        return lines[0]

    return call
