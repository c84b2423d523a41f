"""A dynamometer that rings: what taps tell of it, and forces that are corrected for it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy import signal

from autodb.records.tables import Recording
from autodb.sensing.table.forces import table_forces
from autodb.sensing.table.identify import identify_table
from autodb.sensing.table.kinematics import Kinematics
from autodb.sensing.table.model import TableModel
from autodb.sensing.table.resonance import BAND, NONE, modes_of, taps
from autodb.terms.table import G_M_S2

Array = NDArray[np.float64]

RATE_HZ = 4000.0
NATURAL_HZ, DAMPING = np.array([520.0, 640.0, 810.0]), np.array([0.03, 0.02, 0.05])
MASS_KG = 25.0
STILL = Kinematics()


def _rings(force_N: Array) -> Array:
    """Return what is read (3, n) of a force (3, n): ÿ + 2ζω ẏ + ω² y = ω² F, in small steps."""
    read = np.zeros_like(force_N)
    for k in range(3):
        w = 2.0 * np.pi * NATURAL_HZ[k]
        whole = ([w**2], [1.0, 2.0 * DAMPING[k] * w, w**2])
        b, a, _ = signal.cont2discrete(whole, 1.0 / (8.0 * RATE_HZ), method="foh")
        read[k] = signal.lfilter(b.ravel(), a, force_N[k])
    return read


def _recorded(force_N: Array, *, noise_N: float = 0.5, angles: bool = True) -> Recording:
    """Return a recording of a force (3, 8 n) on a table that rests upright."""
    read = _rings(force_N)[:, ::8]
    read += noise_N * np.random.default_rng(7).standard_normal(read.shape)
    t = np.arange(read.shape[1]) / RATE_HZ
    channels = {"t": t} | {f"force.{axis}": read[k] for k, axis in enumerate("xyz")}
    still = {"a.angle": np.zeros_like(t), "c.angle": np.zeros_like(t)} if angles else {}
    return Recording(Path("taps.csv"), channels | still)


def _tapped(count: int = 4, *, angles: bool = True) -> Recording:
    """Return taps of 1 ms and 200 N along x, y and z in turn, 0.5 s apart."""
    t = np.arange(0.0, 0.5 * (3 * count + 1), 1.0 / (8.0 * RATE_HZ))
    force = np.zeros((3, len(t)))
    for number in range(3 * count):
        since = t - 0.3 - 0.5 * number
        force[number % 3] += 200.0 * np.sin(np.pi * since / 0.001) * ((since > 0) & (since < 0.001))
    return _recorded(force, angles=angles)


def _forces(recording: Recording) -> Array:
    return np.array([recording[f"force.{axis}"] for axis in "xyz"])


def _moves() -> Recording:
    """Return rests upright and in two tilts."""
    t = np.arange(0.0, 12.0, 1.0 / 200.0)
    a = np.interp(t, [0.0, 2.0, 3.0, 5.0, 6.0, 8.0, 9.0, 12.0], [0, 0, -60, -60, 30, 30, 0, 0])
    c = np.interp(t, [0.0, 2.0, 3.0, 5.0, 6.0, 8.0, 9.0, 12.0], [0, 0, 45, 45, 45, 45, 0, 0])
    s, o = np.radians(a), np.radians(c)
    weight = np.array([np.sin(o) * np.sin(s), -np.cos(o) * np.sin(s), np.cos(s) - 1.0])
    noise = 0.3 * np.random.default_rng(8).standard_normal(weight.shape)
    read = MASS_KG * G_M_S2 * weight + noise
    channels = {"t": t, "a.angle": a, "c.angle": c}
    return Recording(
        Path("moves.csv"), channels | {f"force.{n}": read[k] for k, n in enumerate("xyz")}
    )


@pytest.fixture(scope="module")
def model() -> TableModel:
    """What moves and taps tell."""
    return identify_table([_moves(), _tapped(angles=False)], STILL)


def test_taps_determine_frequency_and_damping(model: TableModel) -> None:
    """Of a hammer whose force nobody measured, in a file without the table's angles."""
    for mode, hz, damping in zip(model.modes, NATURAL_HZ, DAMPING, strict=True):
        assert mode is not None
        assert_allclose(mode.hz, hz, rtol=0.002)
        assert_allclose(mode.damping, damping, rtol=0.03)
        assert abs(mode.hz - hz) < 4.0 * mode.hz_sd + 0.1
    assert_allclose(model.mass_kg, MASS_KG, rtol=0.005)
    kept = TableModel.of_json(model.to_json())
    assert kept.modes == model.modes
    before = {name: one for name, one in model.to_json().items() if name != "modes"}
    assert TableModel.of_json(before).modes == NONE


def test_what_taps_do_not_determine_is_not_corrected() -> None:
    """Two taps along each, or at 500 Hz, or noise alone, or taps that swing differently."""
    few = _tapped(2)
    assert len(taps(_forces(few), few.timing)) == 6
    assert modes_of([(few, _forces(few))]) == NONE
    whole = _tapped()
    slow = Recording(whole.path, {name: one[::8] for name, one in whole.channels.items()})
    assert modes_of([(slow, _forces(slow))]) == NONE
    noise = _recorded(np.zeros((3, 160000)))
    assert taps(_forces(noise), noise.timing) == []
    swung, rng = _forces(whole), np.random.default_rng(9)
    for peak in taps(_forces(whole), whole.timing):
        decay = np.exp(-np.arange(1200) / 200.0)
        swung[:, peak : peak + 1200] += 300.0 * decay * rng.standard_normal((3, 1200))
    assert modes_of([(whole, swung)]) == NONE


def test_teeth_are_no_taps() -> None:
    t = np.arange(0.0, 8.0, 1.0 / (8.0 * RATE_HZ))
    passing = np.maximum(np.sin(2.0 * np.pi * 85.0 * t), 0.0) * (t > 1.0) * (t < 7.0)
    cut = _recorded(np.array([200.0, 100.0, 50.0])[:, None] * passing)
    assert len(taps(_forces(cut), cut.timing)) < 3


def test_forces_below_the_resonance_are_corrected(model: TableModel) -> None:
    """Teeth pass at 85 Hz; their harmonics near the resonance are read many times too large."""
    rng = np.random.default_rng(10)
    t = np.arange(0.0, 6.0, 1.0 / (8.0 * RATE_HZ))
    size = np.where((t > 1.5) & (t < 4.5), 1.0, 0.0)
    teeth = np.maximum(np.sin(2.0 * np.pi * 85.0 * t), 0.0) ** 3 * size
    teeth *= 1.0 + 0.05 * rng.standard_normal(len(t) // 3000 + 1)[np.arange(len(t)) // 3000]
    force = np.array([200.0, 150.0, 60.0])[:, None] * teeth
    recording, cutting = _recorded(force), size[::8] > 0.0
    found = table_forces(model, recording, cutting, cutoff_hz=700.0)
    plain = table_forces(replace(model, modes=NONE), recording, cutting, cutoff_hz=700.0)
    sos = signal.butter(4, 700.0, fs=8.0 * RATE_HZ, output="sos")
    truth = signal.sosfiltfilt(sos, force, axis=1)[:, ::8]
    inside = cutting & (np.arange(len(cutting)) % 2 == 0)
    off, before = (
        np.sqrt(np.mean((one.force_N - truth)[:, inside] ** 2, axis=1)) for one in (found, plain)
    )
    assert np.all(off < 0.25 * before)
    assert np.all(off < 1.5)
    held = np.abs(found.force_N - truth)[:, inside] <= 1.96 * found.sd_N[:, inside]
    assert held.mean() > 0.95
    # The noise of air up to the cutoff, and not that of rests scaled up to it
    quiet = ~cutting & (np.arange(len(cutting)) < RATE_HZ)
    assert np.all(plain.sd_N[:, quiet].mean(axis=1) < 2.0 * plain.force_N[:, quiet].std(axis=1))


def test_beyond_its_band_a_component_says_nothing(model: TableModel) -> None:
    """At 1.8 times the first natural frequency: x is low-passed at 1.5 times it."""
    t = np.arange(0.0, 3.0, 1.0 / (8.0 * RATE_HZ))
    quick = 100.0 * np.sin(2.0 * np.pi * 1.8 * NATURAL_HZ[0] * t) * (t > 1.0) * (t < 2.0)
    recording = _recorded(np.array([quick, 0.0 * quick, 0.0 * quick]))
    cutting = (t > 1.0)[::8] & (t < 2.0)[::8]
    made = table_forces(model, recording, cutting, cutoff_hz=1500.0)
    inner = slice(round(1.2 * RATE_HZ), round(1.8 * RATE_HZ))
    assert BAND * NATURAL_HZ[0] < 1.8 * NATURAL_HZ[0]
    assert np.abs(made.force_N[0, inner]).max() < 35.0
