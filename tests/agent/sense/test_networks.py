"""The commands that train and use a machine's network, on a virtual axis of its own physics."""

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy import signal

from tests.conftest import Cli, Once, Ran

torch = pytest.importorskip("torch")

Array = NDArray[np.float64]

RATE_HZ = 250.0
FILES = tuple(Path(f"cut-{seed}.csv") for seed in range(8))


def _table(seed: int, *, cuts: bool, seconds: float) -> pd.DataFrame:
    """Draw an axis that goes there and back; its drive shows 0.8 of a cut's force."""
    rng = np.random.default_rng([seed, 20])
    t = np.arange(0.0, seconds, 1.0 / RATE_HZ)
    turn = 2.0 * np.pi * np.cumsum(rng.uniform(0.2, 0.5) * (1.0 + 0.5 * np.sin(0.9 * t))) / RATE_HZ
    x = 40.0 + 20.0 * np.sin(turn)
    v = np.gradient(x, t)
    moving_N = 0.1 * np.gradient(v, t) + 0.5 * v + 60.0 * np.tanh(v / 0.05) + 12.0
    rough = signal.filtfilt(*signal.butter(2, 10.0, fs=RATE_HZ), rng.standard_normal(len(t)))
    inside = (t > 0.7) & (t < seconds - 0.7)
    force_N = (rng.uniform(60.0, 160.0) + 120.0 * rough) * inside * cuts
    effort_N = moving_N - 0.8 * force_N + 3.0 * rng.standard_normal(len(t))
    columns = {"t": t, "x.position": x, "x.velocity": v, "x.acceleration": np.gradient(v, t)}
    return pd.DataFrame(columns | {"x.drive_force": effort_N, "force.x": force_N})


def _write(path: Path, table: pd.DataFrame) -> Path:
    table.to_csv(path, index=False, float_format="%.6f")
    return path


@pytest.fixture
def trained(cli: Cli, once: Once, monkeypatch: pytest.MonkeyPatch) -> Cli:
    """Return the command line on a machine with a network that was trained shortly."""
    from autodb.sensing.network import learning

    monkeypatch.setattr(learning, "STEPS", 70)
    before_threads = torch.get_num_threads()

    def make() -> None:
        torch.set_num_threads(1)
        cli("init")
        cli("machine", "add", "mill-1")
        air = _table(99, cuts=False, seconds=40.0).drop(columns="force.x")
        made = cli("identify", _write(Path("air.csv"), air), "--machine", "mill-1")
        assert made.code == 0, made.err
        for seed, path in enumerate(FILES):
            _write(path, _table(seed, cuts=True, seconds=6.0))
        before = cli("reconstruct", FILES[0], "--machine", "mill-1", "--estimator", "lstm")
        assert before.code == 2
        assert "mill-1' has no network" in before.err
        done = cli("calibrate", *FILES, "--machine", "mill-1", "--network")
        assert done.code == 0, done.err
        assert "Network 1 of mill-1" in done.out
        assert not Path(".autodb-training").exists()

        torch.set_num_threads(before_threads)

    once(make)
    return cli


def _errors(ran: Ran, truth: pd.DataFrame) -> tuple[float, float]:
    """Return RMSE and the share of rows within 95 % intervals."""
    assert ran.code == 0, ran.err
    told = pd.read_csv("new-load.csv")
    off = told["force.x"] - truth["force.x"]
    held = np.mean(np.abs(off) <= 1.96 * told["x.load.sd"])
    return float(np.sqrt(np.mean(off**2))), float(held)


def test_a_network_is_nearer_than_its_drive_model(trained: Cli) -> None:
    """The drive shows four fifths of a force, which no move in air tells."""
    new = _table(50, cuts=True, seconds=12.0)
    path = _write(Path("new.csv"), new.drop(columns="force.x"))
    drive, _ = _errors(
        trained("reconstruct", path, "--machine", "mill-1", "--bandwidth", "50"), new
    )
    ran = trained(
        "reconstruct", path, "--machine", "mill-1", "--estimator", "lstm", "--page", "page.html"
    )
    network, held = _errors(ran, new)
    assert network < 0.7 * drive
    assert held > 0.8
    assert "network 1 of machine 'mill-1'" in ran.out
    assert Path("page.html").exists()


def test_drive_model_and_network_together_are_no_worse_than_the_network(trained: Cli) -> None:
    new = _table(52, cuts=True, seconds=12.0)
    path = _write(Path("new.csv"), new.drop(columns="force.x"))
    use = ("--machine", "mill-1", "--estimator")
    network, _ = _errors(trained("reconstruct", path, *use, "lstm"), new)
    ran = trained("reconstruct", path, *use, "fused")
    both, held = _errors(ran, new)
    assert both <= 1.05 * network
    assert held > 0.8
    assert "by weight" in ran.out
    told = pd.read_csv("new-load.csv")
    whole = told["x.weight.drive_model"] + told["x.weight.network"]
    np.testing.assert_allclose(whole, 1.0)


def test_several_axes_are_reconstructed_at_once(trained: Cli) -> None:
    """A file with another axis' current needs no --axis where the machine says what it has."""
    new = _table(53, cuts=True, seconds=8.0).drop(columns="force.x")
    two = new.assign(**{"y.position": 0.0 * new["t"], "y.current": 0.1 + 0.0 * new["t"]})
    path = _write(Path("two.csv"), two)
    done = trained("reconstruct", path, "--machine", "mill-1", "--estimator", "lstm")
    assert done.code == 0, done.err
    assert list(pd.read_csv("two-load.csv"))[-1] == "force.x"


def test_the_same_recordings_again_are_already_there(trained: Cli) -> None:
    again = trained("calibrate", *reversed(FILES), "--machine", "mill-1", "--network")
    assert again.code == 0
    assert "already there" in again.out
    assert "Network 1" in again.out


def test_sensors_lists_what_a_machine_feels_and_what_it_does_not(trained: Cli) -> None:
    done = trained("sensors", "mill-1")
    assert done.code == 0
    drive, network, together = (ln for ln in done.out.splitlines() if "force.x " in ln)
    assert "drive model and network" in together
    assert "drive model" in drive
    assert "x.drive_force" in drive
    assert "8 recordings" in network
    assert "force.y, force.z: not sensed, and never taken as 0" in done.out
    trained("machine", "add", "mill-2")
    assert "force.x, force.y, force.z: not sensed" in trained("sensors", "mill-2").out
    assert "no machine 'mill-9'" in trained("sensors", "mill-9").err


def test_what_a_network_cannot_take_is_refused_in_one_line(trained: Cli) -> None:
    def refused(*arguments: str | os.PathLike[str]) -> str:
        ran = trained(*arguments)
        assert ran.code == 2
        assert len(ran.err.strip().splitlines()) == 1
        return ran.err

    use = ("--machine", "mill-1", "--estimator", "lstm")
    other = _table(51, cuts=True, seconds=6.0)
    slow = _write(Path("slow.csv"), other.iloc[::2])
    assert "125 Hz, and the network was trained at 250 Hz" in refused("reconstruct", slow, *use)
    far = _write(Path("far.csv"), other.assign(**{"x.drive_force": 9.0 * other["x.drive_force"]}))
    assert "was trained from" in refused("reconstruct", far, *use)
    mute = _write(Path("mute.csv"), other.drop(columns="x.drive_force"))
    assert "x.drive_force" in refused("reconstruct", mute, *use)
    assert "--machine" in refused(
        "reconstruct", FILES[0], "--estimator", "lstm", "--moves", FILES[0]
    )
    assert "--observer" in refused("reconstruct", FILES[0], *use, "--observer")
    train = ("--machine", "mill-1", "--network")
    assert "has 250 Hz" in refused("calibrate", FILES[0], slow, *train)
    lacks = _write(Path("lacks.csv"), other.drop(columns="force.x"))
    assert "lacks.csv: no channel 'force.x'" in refused("calibrate", FILES[0], lacks, *train)
    short = _write(Path("short.csv"), other.iloc[:900])
    assert "too short to train on" in refused("calibrate", short, *train)
    assert "--machine NAME" in refused("calibrate", FILES[0], "--network")
    assert "--protocol" in refused("calibrate", FILES[0], *train, "--protocol", "x")


def test_sensors_lists_calibrated_ranges_and_why_one_is_not_used(
    cli: Cli, sample_jobs: Path
) -> None:
    recordings = sample_jobs / "stepped_shaft" / "recordings"
    cli("init")
    cli("machine", "add", "lathe-1")
    cli("import", recordings / "standard-cuts.csv", "--machine", "lathe-1")
    cli("calibrate", "--machine", "lathe-1")
    lines = [line for line in cli("sensors", "lathe-1").out.splitlines() if "force." in line]
    assert [line.split()[0] for line in lines] == ["force.x", "force.y", "force.z"]
    assert all("current range" in line for line in lines)
