"""Networks that remember: training that goes on, streams, refused inputs, what a grey box adds."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy import signal

from autodb.errors import UnusableInput
from autodb.sensing.drives.fit.axis_model import IdentifiedTerm, predicted_effort
from autodb.sensing.drives.fit.drive_errors import DriveErrors
from autodb.sensing.drives.reconstruct import DriveModel
from autodb.sensing.fusion import independent
from autodb.sensing.network.drive_loads import AxisLoad, AxisTables, LoadedDrive, SeenAxis
from autodb.terms.friction import direction

torch = pytest.importorskip("torch")

from autodb.sensing.network import kept, learning, stream  # noqa: E402
from autodb.sensing.network.coherent import coherent_hz, low_pass  # noqa: E402
from autodb.sensing.network.fused import FusedStream  # noqa: E402
from autodb.sensing.network.greybox import GreyBox, KnownForceRecording  # noqa: E402
from autodb.sensing.network.network import Shape, Stacked, ran, side_by_side  # noqa: E402
from autodb.sensing.network.training import TrainingPlan, TrainingRows, trained  # noqa: E402

Array = NDArray[np.float64]
Channels = dict[str, Array]

RATE_HZ = 250.0
TERMS = (
    IdentifiedTerm("inertia", "coefficient", 0.002, 0.0, "A·s²/mm"),
    IdentifiedTerm("viscous", "coefficient", 0.01, 0.0, "A·s/mm"),
    IdentifiedTerm("coulomb", "level", 1.5, 0.0, "A"),
    IdentifiedTerm("spring", "rest", 20.0, 0.0, "mm"),
    IdentifiedTerm("spring", "stiffness", 0.004, 0.0, "A/mm"),
    IdentifiedTerm("presliding", "distance", 0.05, 0.0, "mm"),
)
NEWTONS = 100.0
ERRORS = DriveErrors(((0.05,) * 3,) * 6, 1.0, 100.0, 1000.0, (0.0, 100.0))
MODEL = DriveModel("x", "x.current", "A", TERMS, np.zeros((0, 0)), ERRORS)
DRIVES = {"x": LoadedDrive(MODEL, NEWTONS)}
TINY = TrainingPlan(epochs=10, rate=1e-2, window=250, lead=50, batch=8, seed=3)


@pytest.fixture(autouse=True)
def _one_thread() -> Iterator[None]:
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def _recorded(seed: int, *, cuts: bool = True, seconds: float = 6.0) -> KnownForceRecording:
    """Draw a recording: moves there and back, a load in the middle of which the motor shows 0.8."""
    rng = np.random.default_rng([seed, 10])
    t = np.arange(0.0, seconds, 1.0 / RATE_HZ)
    hz = rng.uniform(0.15, 0.3)
    x = 40.0 + 20.0 * np.sin(2.0 * np.pi * hz * t + rng.uniform(0.0, 6.0))
    v = np.gradient(x, t)
    a = np.gradient(v, t)
    slow = signal.filtfilt(*signal.butter(2, 15.0, fs=RATE_HZ), rng.standard_normal(len(t)))
    force_N = (rng.uniform(80.0, 200.0) + 150.0 * slow) * ((t > 1.0) & (t < seconds - 1.0)) * cuts
    channels = {"x.position": x, "x.velocity": v, "x.acceleration": a}
    sense = direction(v, standstill_mm_s=0.01)
    moving = predicted_effort(
        TERMS, {"position": x, "velocity": v, "acceleration": a, "direction": sense}
    )
    rubs_more = 0.4 * sense * (x > 45.0)
    load_A = -0.8 * force_N / NEWTONS
    noise_A = 0.03 * rng.standard_normal(len(t))
    channels["x.current"] = moving + rubs_more + load_A + noise_A
    return KnownForceRecording(channels, {"x": force_N})


@pytest.fixture(scope="module")
def box() -> GreyBox:
    """One grey box, trained on 16 recordings."""
    torch.set_num_threads(1)
    return learning.train_grey_box(
        [_recorded(seed) for seed in range(16)], DRIVES, rate_hz=RATE_HZ, plan=TINY
    )


def _weights(network: Stacked) -> Array:
    return np.concatenate([one.detach().numpy().ravel() for one in network.parameters()])


class KilledError(Exception):
    """A kill between two epochs."""


def _train(folder: Path | None, seed: int = 3, *, killed_after: int = 99) -> Stacked:
    rng = np.random.default_rng(5)
    rows = [
        TrainingRows(rng.standard_normal((300, 2)), rng.standard_normal((300, 1))) for _ in range(3)
    ]

    def progress(epoch: int, _loss: float) -> None:
        if epoch == killed_after:
            raise KilledError

    plan = replace(TINY, epochs=4, seed=seed)
    shape = Shape(2, 1, cells=6, layers=2, dropout=0.3)
    return trained(
        rows, shape, plan, lambda made, wanted: (made - wanted) ** 2,
        folder=folder, progress=progress,
    )  # fmt: skip


def test_a_killed_training_goes_on_and_ends_as_if_nothing_had_happened(tmp_path: Path) -> None:
    whole = _weights(_train(None))
    with pytest.raises(KilledError):
        _train(tmp_path, killed_after=2)
    assert len(list(tmp_path.iterdir())) == 1
    assert np.array_equal(_weights(_train(tmp_path)), whole)
    assert not np.array_equal(_weights(_train(None, seed=4)), whole)


def test_p0s_network_has_three_layers_of_twenty_cells() -> None:
    published = pytest.importorskip("autodb.proofs.runs.mill.published_lstm")
    rng = np.random.default_rng(1)
    rows = [np.column_stack([rng.uniform(3.0, 9.0, 50), rng.uniform(-4.0, 2.0, 50)])]
    scaled = published.ScaledChannels.of(rows)(rows[0])
    assert scaled[:, 0].min() == 0.0
    assert scaled[:, 0].max() == 1.0
    assert scaled[:, 1].min() == -1.0
    assert scaled[:, 1].max() == 1.0
    network = Stacked(Shape(14, 1, cells=20, layers=3))
    gates = sum(4 * 20 * (inputs + 20 + 2) for inputs in (14, 20, 20))  # torch adds two biases
    assert sum(one.numel() for one in network.parameters()) == gates + 20 + 1


def test_networks_side_by_side_tell_what_each_tells() -> None:
    torch.manual_seed(2)
    shape = Shape(3, 2, cells=5, layers=2)
    members = [Stacked(shape).eval() for _ in range(3)]
    rows = np.random.default_rng(3).standard_normal((40, 3))
    both = np.concatenate([ran(one, rows)[0] for one in members], axis=1)
    assert_allclose(ran(side_by_side(members), rows)[0], both, atol=1e-6)


def test_the_load_in_blocks_is_that_of_the_whole_and_of_the_model() -> None:
    made = _recorded(3)
    tables = AxisTables(DRIVES["x"], SeenAxis.of("x", [made.channels]))
    whole = AxisLoad(tables).step(made.channels)
    axis, parts = AxisLoad(tables), []
    cuts = np.cumsum(np.random.default_rng(4).integers(0, 40, 200))
    for begin, end in zip([0, *cuts], [*cuts, len(whole)], strict=True):
        parts.append(axis.step({n: one[begin:end] for n, one in made.channels.items()}))
    assert_allclose(np.concatenate(parts), whole, atol=1e-9)
    sense = direction(made.channels["x.velocity"], standstill_mm_s=tables.standstill_mm_s)
    inputs = {n.removeprefix("x."): one for n, one in made.channels.items()}
    model = predicted_effort(TERMS, inputs | {"direction": sense})
    assert_allclose(whole, NEWTONS * (made.channels["x.current"] - model), atol=0.5)


@pytest.mark.parametrize("rows", [1, 7, 12, 64])
def test_loads_in_blocks_are_those_of_the_whole(rows: int) -> None:
    """Wherever blocks end, also where the axis turns: ten recordings of reversals."""
    seen = SeenAxis.of("x", [_recorded(seed).channels for seed in range(50, 60)])
    tables = AxisTables(DRIVES["x"], seen)
    for seed in range(50, 60):
        channels = _recorded(seed).channels
        whole = AxisLoad(tables).step(channels)
        running = AxisLoad(tables)
        parts = [
            running.step({n: one[begin : begin + rows] for n, one in channels.items()})
            for begin in range(0, len(whole), rows)
        ]
        assert_allclose(np.concatenate(parts), whole, atol=1e-6)


def test_a_model_that_remembers_time_is_refused() -> None:
    warm = (*TERMS[:3], IdentifiedTerm("backlash", "level", 0.1, 0.0, "A"),
            IdentifiedTerm("backlash", "gap", 0.1, 0.0, "mm"))  # fmt: skip
    seen = SeenAxis.of("x", [_recorded(1).channels])
    with pytest.raises(UnusableInput, match=r"x\.current: backlash needs a longer history"):
        AxisTables(LoadedDrive(replace(MODEL, terms=warm), 1.0), seen)


def test_a_grey_box_learns_what_the_drive_leaves_and_says_how_sure_it_is(box: GreyBox) -> None:
    """The motor shows 0.8 of each load, and friction rises half way; 30 recordings not seen."""
    tables = box.tables(DRIVES)
    off, drive, held = [], [], []
    for seed in range(100, 130):
        made = _recorded(seed)
        sensed = stream.network_forces(box, tables, made.channels)
        error = sensed.force_N[:, 0] - made.force_N["x"]
        off.append(np.mean(error**2))
        load = AxisLoad(tables["x"]).step(made.channels)
        drive.append(np.mean((-load - made.force_N["x"]) ** 2))
        held.append(np.mean(np.abs(error) <= 1.96 * sensed.sd_N[:, 0]))
    assert np.sqrt(np.mean(off)) < 0.4 * np.sqrt(np.mean(drive))
    assert 0.85 < np.mean(held) < 0.99


def test_a_stream_in_blocks_tells_what_the_whole_recording_tells(box: GreyBox) -> None:
    tables, channels = box.tables(DRIVES), _recorded(50).channels
    whole = stream.network_forces(box, tables, channels)
    running = stream.Stream(box, tables)
    count = len(channels["x.position"])
    parts = [
        running.step({n: one[begin : begin + 12] for n, one in channels.items()})
        for begin in range(0, count, 12)
    ]
    parts.append(running.finish())
    assert len(whole.force_N) == count
    assert_allclose(np.concatenate([p.force_N for p in parts]), whole.force_N, atol=1e-3)
    assert_allclose(np.concatenate([p.sd_N for p in parts]), whole.sd_N, rtol=1e-4)
    assert len(stream.Stream(box, tables).finish().force_N) == 0


def test_drive_model_and_network_are_put_together_as_rows_come(box: GreyBox) -> None:
    """In blocks as of the whole; given nothing else, it is the inverse-variance mean of both."""
    tables, channels = box.tables(DRIVES), _recorded(51).channels
    whole = stream.network_forces(box, tables, channels)
    alike = replace(independent(("drive model", "network")), size_N=np.array([20.0, 1.0]))
    running = FusedStream(box, tables, {"x": alike})
    count = len(channels["x.position"])
    parts = [
        running.step({n: one[begin : begin + 12] for n, one in channels.items()})
        for begin in range(0, count, 12)
    ]
    parts.append(running.finish())
    made = np.concatenate([part.force_N for part in parts])
    weight = whole.sd_N**-2.0 / (whole.sd_N**-2.0 + 20.0**-2.0)
    expected = weight * whole.force_N + (1.0 - weight) * whole.drive_N
    assert_allclose(made, expected, atol=2e-3)
    load = -AxisLoad(tables["x"]).step(channels)
    slow = low_pass(box.cutoff_hz, rate_hz=RATE_HZ)
    begun, _ = slow.step(load[:, None], load[:, None])
    assert_allclose(whole.drive_N[: len(begun)], begun, atol=1e-6)


def test_nothing_is_sensed_above_the_coherent_band(box: GreyBox) -> None:
    """Forces end at 15 Hz: what is sensed above the band is less than the current's own noise."""
    (cutoff_hz,) = box.cutoff_hz
    assert 8.0 < cutoff_hz < 60.0
    channels = _recorded(60).channels
    sensed = stream.network_forces(box, box.tables(DRIVES), channels).force_N[:, 0]
    load = AxisLoad(box.tables(DRIVES)["x"]).step(channels)
    hz, of_sensed = signal.welch(sensed, fs=RATE_HZ, nperseg=256)
    _, of_load = signal.welch(load, fs=RATE_HZ, nperseg=256)
    above = hz > cutoff_hz + 15.0
    assert of_sensed[above].max() < 0.1 * of_load[above].max()


def test_what_was_kept_tells_the_same(box: GreyBox) -> None:
    found = kept.of_bytes(kept.to_bytes(box, ["a1", "b2"]))
    assert found.trained_on == ("a1", "b2")
    channels = _recorded(70).channels
    before, after = (
        stream.network_forces(one, one.tables(DRIVES), channels) for one in (box, found.box)
    )
    assert np.array_equal(before.force_N, after.force_N)
    assert np.array_equal(before.sd_N, after.sd_N)


def test_what_was_not_trained_on_is_refused_by_name(box: GreyBox) -> None:
    tables, channels = box.tables(DRIVES), dict(_recorded(80).channels)

    def refused(other: Channels, rate_hz: float = RATE_HZ) -> str:
        with pytest.raises(UnusableInput) as error:
            stream.check(box, tables, other, rate_hz=rate_hz, where="cut.csv")
        return str(error.value)

    stream.check(box, tables, channels, rate_hz=RATE_HZ, where="cut.csv")
    lacking = {n: one for n, one in channels.items() if n != "x.velocity"}
    assert "cut.csv: no channel 'x.velocity'" in refused(lacking)
    assert "500 Hz, and the network was trained at 250 Hz" in refused(channels, 500.0)
    faster = channels | {"x.velocity": 3.0 * channels["x.velocity"]}
    assert "load of x goes to" in refused(faster) or "x.velocity goes to" in refused(faster)
    stronger = channels | {"x.current": 9.0 * channels["x.current"]}
    assert "load of x goes to" in refused(stronger)


def test_trained_on_air_a_load_stays(box: GreyBox) -> None:
    """Networks that see no load cannot take one away: friction is learnt, the push is sensed."""
    air = learning.train_grey_box(
        [_recorded(seed, cuts=False) for seed in range(12)], DRIVES, rate_hz=RATE_HZ, plan=TINY
    )
    assert box.hears
    assert not air.hears
    tables = air.tables(DRIVES)
    quiet = _recorded(90, cuts=False)
    pushed = dict(quiet.channels)
    pushed["x.current"] = pushed["x.current"] - 150.0 / NEWTONS
    before, after = (stream.network_forces(air, tables, one) for one in (quiet.channels, pushed))
    assert_allclose(after.force_N - before.force_N, 150.0, atol=1e-6)
    load = AxisLoad(tables["x"]).step(quiet.channels)
    assert np.std(before.force_N) < 0.6 * np.std(load)


def test_coherence_ends_where_noise_begins() -> None:
    rng = np.random.default_rng(6)
    pairs = []
    for _ in range(12):
        force = rng.standard_normal(2000)
        slow = signal.filtfilt(*signal.butter(4, 30.0, fs=RATE_HZ), force)
        pairs.append((slow + 0.1 * rng.standard_normal(2000), force))
    assert 25.0 < coherent_hz(pairs, rate_hz=RATE_HZ) < 55.0


def test_a_low_pass_shifts_nothing_and_ends_what_is_fast() -> None:
    t = np.arange(0.0, 2.0, 1.0 / RATE_HZ)
    slow, fast = np.sin(2.0 * np.pi * 3.0 * t), np.sin(2.0 * np.pi * 80.0 * t)
    passed = low_pass(np.array([30.0]), rate_hz=RATE_HZ)
    first, _ = passed.step((slow + fast)[:, None], np.zeros((len(t), 1)))
    rest, _ = passed.finish()
    whole = np.concatenate([first, rest])[:, 0]
    assert len(whole) == len(t)
    assert_allclose(whole[50:-50], slow[50:-50], atol=0.03)
